//! Fit of cylinders whose pressures weigh, for both machines, and its keys in the description.
//!
//! ```text
//! r F = (1 + s) tau + missed + r (z + F_c d + f)        tau: the moment of the described machine with the known load
//! ```
//! A description has no span: its areas and its zero are divided by 1 + s, and the missed moment grows by missed / (1 + s).

use config::Tables;
use estimation::Quantity;

use crate::lasting::Solution;
use crate::output::Pen;

/// Indices of the unknowns in an equation: span, zero, friction, then the moments missing in the drawing.
pub const SPAN: usize = 0;
/// Index of the zero \[N\].
pub const ZERO: usize = 1;
/// Index of the friction of the seals \[N\].
pub const FRICTION: usize = 2;
/// Index of the first of the moments missing in the drawing [N m].
pub const CURVE: usize = 3;

/// Least duration of rising, and of sinking, of the load \[s\].
pub const LEAST_MOTION: f64 = 3.0;
/// Ratio of the standard deviation to its prior above which a quantity counts as not identified.
pub const IDENTIFIED: f64 = 0.7;
/// Standard deviation of the slope of ground that is called level \[rad\].
pub const LEVEL: f64 = 0.01;
/// Least standard deviation of a load \[kg\].
pub const LEAST_STD: f64 = 1e-3;

/// Fit of the cylinders of a machine with `N` moments missing in the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderFit<const N: usize> {
    /// Relative error of the described moment.
    pub span: Quantity,
    /// Excess force of the pressures \[N\].
    pub zero: Quantity,
    /// Correlation of the errors of span and zero.
    pub correlation: f64,
    /// Friction of the seals \[N\].
    pub friction: Quantity,
    /// Moments missing in the drawing, with cosine and sine of the angle of each link to the horizontal [N m].
    pub missed: [Quantity; N],
    /// Force of all cylinders at the pressure for which friction is stated \[N\].
    full_force: f64,
}

impl<const N: usize> CylinderFit<N> {
    /// Result of a solution; its friction is relative to the described one \[N\].
    pub(crate) fn of(
        solution: &Solution,
        before: &Solution,
        described_friction: f64,
        full_force: f64,
    ) -> Self {
        let of = |i: usize| solution.quantity(i, before);
        Self {
            span: of(SPAN),
            zero: of(ZERO),
            correlation: solution.correlation(SPAN, ZERO),
            friction: Quantity {
                value: (described_friction + of(FRICTION).value).max(0.0),
                ..of(FRICTION)
            },
            missed: std::array::from_fn(|i| of(CURVE + i)),
            full_force,
        }
    }

    /// Writes the keys of the cylinders' table and of the moments missing in the drawing.
    pub(crate) fn write<D: Tables + Default>(
        &self,
        pen: &mut Pen<D>,
        table: &str,
        curves: &[&str; N],
        least_span_std: f64,
    ) {
        let span = 1.0 + self.span.value;
        let key = |name: &str| format!("{table}.{name}");
        let scaled = |value: f64, std: f64| Quantity {
            value: value / span,
            std,
        };
        for area in ["head_area", "rod_area"].map(key) {
            let was = pen.description.number(&area).unwrap_or(0.0);
            pen.value(&area, scaled(was, was * self.span.std));
        }
        let offset = key("force_offset");
        let was = pen.description.number(&offset).unwrap_or(0.0);
        pen.value(&offset, scaled(was + self.zero.value, self.zero.std));
        pen.std(&key("force_offset_std"), self.zero.std);
        let span_std = self.span.std.max(least_span_std);
        pen.std(&key("span_std"), span_std);
        pen.correlation(
            &key("span_offset_correlation"),
            self.correlation * (self.span.std / span_std),
        );
        let friction = Quantity {
            value: self.friction.value / self.full_force,
            std: self.friction.std / self.full_force,
        };
        pen.value(&key("friction"), friction);
        pen.std(&key("friction_std"), friction.std);
        for (key, missed) in curves.iter().zip(self.missed) {
            let was = pen.description.number(key).unwrap_or(0.0);
            let more = scaled(missed.value, missed.std);
            pen.value(
                key,
                Quantity {
                    value: was + more.value,
                    ..more
                },
            );
        }
    }

    /// The fit as text.
    pub(crate) fn words(&self, cylinders: &str) -> String {
        let way = if self.span.value < 0.0 {
            "smaller"
        } else {
            "larger"
        };
        format!(
            "{cylinders}: the moment is {:.1} ± {:.1} % {way} than the drawing says, zero {:.0} ± {:.0} N, friction {:.0} ± {:.0} N",
            100.0 * self.span.value.abs(),
            100.0 * self.span.std,
            self.zero.value,
            self.zero.std,
            self.friction.value,
            self.friction.std
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_written_keys_weigh_as_the_fit_does() {
        let known = |value: f64| Quantity { value, std: 1e-6 };
        let (span, zero, missed) = (0.1, 500.0, [300.0, -80.0, 0.0, 40.0]);
        let fit = CylinderFit {
            span: known(span),
            zero: known(zero),
            correlation: 0.0,
            friction: known(0.0),
            missed: missed.map(known),
            full_force: 1e6,
        };
        let mut before = config::Loader::default();
        before.lift_cylinder.head_area = 0.02;
        before.lift_cylinder.force_offset = 100.0;
        before.lift_arm.arm_cos = 1000.0;
        let mut pen = Pen::new(before.clone());
        let curves = ["arm_cos", "arm_sin", "bucket_cos", "bucket_sin"];
        let curves = curves.map(|name| format!("machine.lift_arm.{name}"));
        let curves = curves.each_ref().map(String::as_str);
        fit.write(&mut pen, "machine.lift_arm.cylinder", &curves, 0.0);
        // Level, at rest: r F = (1 + s) tau + missed + r z, and as written r F = tau.
        let (lever, drawn) = (0.4, 9000.0);
        let force = |d: &config::Loader, pressure: f64| {
            d.lift_cylinder.head_area * pressure - d.lift_cylinder.force_offset
        };
        let tau = |d: &config::Loader| drawn + d.lift_arm.arm_cos + d.lift_arm.bucket_cos;
        let moment = (1.0 + span) * tau(&before) + missed[0] + missed[2] + lever * zero;
        let pressure = (moment / lever + before.lift_cylinder.force_offset) / 0.02;
        let after = &pen.description;
        let left = lever * force(after, pressure) - tau(after);
        assert!(left.abs() < 1e-6 * moment, "{left} of {moment} N m");
    }
}
