//! Apparent motion of the centre of gravity during acceleration, with the printed sign of the load transfer.
//!
//! Accelerating moves load to the rear axle: the front axle carries m g lam - m h dv/dt / l. The printed (6), (7) and (10), (11)
//! have the opposite sign. A filter with this sign explains the difference by a centre of gravity that moves by -2 h / (l g) =
//! -0.080 of the wheelbase per m/s^2. The plant's is rigid.
//!
//! The height is held at the truth, so that only the ratio can change. JSON:
//! `{"printed": {"accel", "brake"}, "physical": {"accel", "brake"}, "truth"}`: mean estimated ratio while dv/dt is above
//! 0.3 and below -0.3 m/s^2 in the acceleration and deceleration manoeuvre.

use std::fmt::Write;

use calibrate::algebra::inverse;
use estimation::loader::{Estimate, LoadTransfer};
use faer::Mat;
use serde_json::json;
use sim::loader::{GRAVITY, Row, Run, Scenario};

use super::candidate::Candidate;
use super::trial;
use crate::text::{Table, plain, signed, verdict};
use crate::{Error, Options, Report, seeds};

const FILTERS: [Candidate; 2] = [
    Candidate::sign(LoadTransfer::Printed),
    Candidate::sign(LoadTransfer::Physical),
];
/// Least speed [m/s] and least acceleration [m/s^2] of the rows that count.
const FROM_SPEED: f64 = 1.0;
const FROM_ACCELERATION: f64 = 0.3;

/// The manoeuvres, begin of their counted time [s], and the expected means (printed accelerating, braking; physical).
const CASES: [(Scenario, f64, Option<[f64; 4]>); 4] = [
    (
        Scenario::AccelDecel,
        8.0,
        Some([0.4217, 0.4926, 0.4496, 0.4504]),
    ),
    (
        Scenario::WorkCycle,
        30.0,
        Some([0.4097, 0.4904, 0.4494, 0.4499]),
    ),
    (Scenario::ConstantTorque, 6.0, None),
    (Scenario::Bumpy, 4.0, None),
];
/// Tolerance of a mean.
const TOLERANCE: f64 = 0.006;
/// Most runs: further ones do not sharpen the means.
const ENOUGH: usize = 8;

/// Sums over the rows of one filter.
#[derive(Clone, Debug, Default)]
struct Means {
    accelerating: (f64, f64),
    braking: (f64, f64),
    /// Normal equations of the ratio on [1, dv/dt, g sin(slope)], and their right side.
    normal: [[f64; 3]; 3],
    right: [f64; 3],
    truth: (f64, f64),
}

impl Means {
    fn take(&mut self, row: &Row, estimate: &Estimate) {
        let (ratio, a) = (estimate.cg_ratio.value, row.truth.acceleration);
        let add = |sum: &mut (f64, f64), value: f64| *sum = (sum.0 + value, sum.1 + 1.0);
        add(&mut self.truth, row.truth.cg_ratio);
        if a > FROM_ACCELERATION {
            add(&mut self.accelerating, ratio);
        } else if a < -FROM_ACCELERATION {
            add(&mut self.braking, ratio);
        }
        let regressor = [1.0, a, GRAVITY * row.truth.slope.sin()];
        for i in 0..3 {
            self.right[i] += regressor[i] * ratio;
            for j in 0..3 {
                self.normal[i][j] += regressor[i] * regressor[j];
            }
        }
    }

    fn merge(mut self, other: &Self) -> Self {
        let add = |a: &mut (f64, f64), b: (f64, f64)| *a = (a.0 + b.0, a.1 + b.1);
        add(&mut self.accelerating, other.accelerating);
        add(&mut self.braking, other.braking);
        add(&mut self.truth, other.truth);
        for i in 0..3 {
            self.right[i] += other.right[i];
            for j in 0..3 {
                self.normal[i][j] += other.normal[i][j];
            }
        }
        self
    }

    /// Change of the estimated ratio per acceleration [s^2/m].
    fn slope(&self) -> f64 {
        let normal = Mat::from_fn(3, 3, |i, j| self.normal[i][j]);
        inverse(&normal).map_or(f64::NAN, |inverse| {
            (0..3).map(|j| inverse[(1, j)] * self.right[j]).sum()
        })
    }
}

/// The mean of a class; `None` if it is empty.
fn mean((sum, count): (f64, f64)) -> Option<f64> {
    (count > 0.0).then(|| sum / count)
}

pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut table =
        Table::headed("manoeuvre; sign; accelerating; braking; truth; per m/s^2; expected");
    let (mut json, mut met) = (serde_json::Value::Null, true);
    for (scenario, from, expected) in CASES {
        let sums = run(options, scenario, from)?;
        if scenario == Scenario::AccelDecel {
            json = record(&sums);
        }
        met &= expected.is_none_or(|expected| holds(&sums, expected));
        for (k, (filter, sums)) in FILTERS.iter().zip(&sums).enumerate() {
            let show = |class: (f64, f64)| mean(class).map_or("-".to_owned(), |m| plain(m, 4));
            let expected = expected.map(|e| format!("{:.4} {:.4}", e[2 * k], e[2 * k + 1]));
            table.row([
                scenario.name().to_owned(),
                filter.name.to_owned(),
                show(sums.accelerating),
                show(sums.braking),
                show(sums.truth),
                signed(sums.slope(), 4),
                expected.unwrap_or("-".to_owned()),
            ]);
        }
    }
    let mut text =
        "Mean estimated ratio of a rigid centre of gravity, by the sign of the load transfer\n"
            .to_owned();
    let _ = write!(text, "{table}  as expected: {}\n{READING}", verdict(met));
    Ok(Report { text, json, met })
}

const READING: &str = "\
  A rigid centre of gravity does not move; what moves is the load on the axles, by h dv/dt / (l g). The
  motion that the paper reports, backward when accelerating and forward when braking, has the sign and the size
  that the printed equations make up. That is inference: the authors' program is not published.
";

fn run(options: &Options, scenario: Scenario, from: f64) -> Result<[Means; 2], Error> {
    let few = Options {
        seeds: options.seeds.min(ENOUGH),
        ..options.clone()
    };
    let runs = seeds(&few, &format!("sign, {}", scenario.name()), |seed| {
        let mut sums = [Means::default(), Means::default()];
        trial::each_row(
            &Run {
                seed,
                ..Run::new(scenario)
            },
            &FILTERS,
            |k, row, estimate| {
                if row.time > from && row.truth.speed > FROM_SPEED {
                    sums[k].take(row, estimate);
                }
            },
        )?;
        Ok(sums)
    })?;
    let zero = [Means::default(), Means::default()];
    Ok(runs
        .iter()
        .fold(zero, |[a, b], run| [a.merge(&run[0]), b.merge(&run[1])]))
}

fn record([printed, physical]: &[Means; 2]) -> serde_json::Value {
    let means =
        |sums: &Means| json!({"accel": mean(sums.accelerating), "brake": mean(sums.braking)});
    json!({"printed": means(printed), "physical": means(physical), "truth": mean(printed.truth)})
}

fn holds([printed, physical]: &[Means; 2], expected: [f64; 4]) -> bool {
    let all = [
        printed.accelerating,
        printed.braking,
        physical.accelerating,
        physical.braking,
    ]
    .map(mean);
    let [Some(a), Some(b), Some(c), Some(d)] = all else {
        return false;
    };
    let near = [a, b, c, d]
        .iter()
        .zip(expected)
        .all(|(mean, expected)| (mean - expected).abs() <= TOLERANCE);
    near && b - a > 0.05 && (d - c).abs() < 0.01
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_sign_moves_a_rigid_centre_of_gravity_and_the_physical_one_does_not() {
        let options = Options {
            seeds: 4,
            ..Options::default()
        };
        let (scenario, from, expected) = CASES[0];
        let sums = run(&options, scenario, from).unwrap();
        assert!(holds(&sums, expected.unwrap()), "{}", record(&sums));
        let json = record(&sums);
        assert!(
            (json["truth"].as_f64().unwrap() - 0.45).abs() < 1e-12,
            "{json}"
        );
        // -2 h / (l g) = -0.080 for an infinitely fast filter; this one lags.
        assert!((-0.08..-0.04).contains(&sums[0].slope()) && sums[1].slope().abs() < 0.01);
    }
}
