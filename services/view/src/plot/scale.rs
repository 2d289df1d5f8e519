//! Scales from values to pixels: ranges, ticks and their labels.

use crate::number;

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal ratios.
    Logarithmic,
}

impl Scale {
    fn forward(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.log10(),
        }
    }
}

/// The range of the values.
pub(super) struct Extent {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Extent {
    pub(super) fn new(scale: Scale) -> Self {
        Self {
            scale,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        }
    }

    pub(super) fn add(&mut self, value: f64) {
        let usable = value.is_finite() && (self.scale == Scale::Linear || value > 0.0);
        if usable {
            // Clamped, so that no difference or ratio of two of them is infinite.
            let value = match self.scale {
                Scale::Linear => value.clamp(-1e150, 1e150),
                Scale::Logarithmic => value.clamp(1e-150, 1e150),
            };
            self.low = self.low.min(value);
            self.high = self.high.max(value);
        }
    }

    /// A requested range, widened if it is a single value.
    pub(super) fn of(scale: Scale, (low, high): (f64, f64)) -> (f64, f64) {
        let mut extent = Self::new(scale);
        extent.add(low);
        extent.add(high);
        extent.plain()
    }

    /// The range: 0 to 1 (or 1 to 10) if nothing was added, widened if it is a single value.
    pub(super) fn plain(&self) -> (f64, f64) {
        let single = (self.high - self.low) <= 1e-12 * self.high.abs().max(self.low.abs());
        match self.scale {
            Scale::Linear if self.low > self.high => (0.0, 1.0),
            Scale::Logarithmic if self.low > self.high => (1.0, 10.0),
            Scale::Logarithmic if single => (
                (self.low / 2.0).max(f64::MIN_POSITIVE),
                (self.high * 2.0).clamp(2.0 * f64::MIN_POSITIVE, f64::MAX),
            ),
            Scale::Linear if single => {
                let half = if self.low == 0.0 {
                    1.0
                } else {
                    (0.05 * self.low.abs()).max(f64::MIN_POSITIVE)
                };
                (
                    (self.low - half).max(f64::MIN),
                    (self.high + half).min(f64::MAX),
                )
            }
            _ => (self.low, self.high),
        }
    }

    /// The range with a margin of 5 % at both ends. An end at zero, and an end at the least or largest `possible` value, gets no
    /// margin.
    pub(super) fn padded(&self, possible: (f64, f64)) -> (f64, f64) {
        let (low, high) = self.plain();
        match self.scale {
            Scale::Linear => {
                let room = 0.05 * (high - low);
                let from = if low == 0.0 { 0.0 } else { low - room };
                // Values beyond the possible range are still shown.
                (
                    from.max(possible.0.min(low)),
                    (high + room).min(possible.1.max(high)),
                )
            }
            Scale::Logarithmic => (low, high * (high / low).powf(0.05)),
        }
    }
}

/// An axis: a range of values on a range of pixels.
pub(super) struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    pub(super) fn new(scale: Scale, (low, high): (f64, f64), from: f64, to: f64) -> Self {
        Self {
            scale,
            low,
            high,
            from,
            to,
        }
    }

    /// Pixel of `value`; NaN for a value that the scale cannot show. Clamped to some plot widths around the plot, so that no
    /// value is too large for a viewer.
    pub(super) fn place(&self, value: f64) -> f64 {
        let (low, high) = (self.scale.forward(self.low), self.scale.forward(self.high));
        let share = (self.scale.forward(value) - low) / (high - low);
        if share.is_finite() {
            self.from + share.clamp(-3.0, 4.0) * (self.to - self.from)
        } else {
            f64::NAN
        }
    }

    /// About `count` ticks with labels.
    pub(super) fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => linear_ticks(self.low, self.high, count),
            Scale::Logarithmic => decade_ticks(self.low, self.high, count),
        }
    }
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<(f64, String)> {
    let raw = (high - low) / count.max(1) as f64;
    // The multiples of the step must be representable as integers.
    if !raw.is_normal() || raw <= 0.0 || low.abs().max(high.abs()) / raw > 1e12 {
        let ends = [low, high].into_iter().filter(|v| v.is_finite());
        return ends.map(|v| (v, number::significant(v, 4))).collect();
    }
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|s| *s >= raw * 0.7)
        .unwrap_or(10.0 * power);
    let places = (-(step * 1.001).log10().floor()).max(0.0) as i32;
    let (first, last) = (
        (low / step - 1e-9).ceil() as i64,
        (high / step + 1e-9).floor() as i64,
    );
    (first..=last)
        .take(50)
        .map(|i| (i as f64 * step, number::grouped(i as f64 * step, places)))
        .collect()
}

/// Ticks at powers of ten, and at 2 and 5 times them where there are few decades.
fn decade_ticks(low: f64, high: f64, count: usize) -> Vec<(f64, String)> {
    if !(low.is_normal() && low > 0.0 && high.is_finite() && high > low) {
        return Vec::new();
    }
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let decades = usize::try_from(last.saturating_sub(first))
        .unwrap_or(1)
        .max(1);
    let steps: &[f64] = if decades <= 2 || decades * 3 <= count {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let every = decades.div_ceil(count.max(6));
    (first..=last)
        .step_by(every)
        .flat_map(|d| steps.iter().map(move |s| (s * 10f64.powi(d), (-d).max(0))))
        .filter(|(v, _)| *v >= low * 0.999 && *v <= high * 1.001)
        .map(|(v, places)| (v, number::grouped(v, places)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: Vec<(f64, String)>) -> Vec<String> {
        ticks
            .into_iter()
            .map(|t| t.1.replace(number::GROUP, " "))
            .collect()
    }

    #[test]
    fn ticks_are_round_numbers_with_the_places_they_need() {
        assert_eq!(
            labels(linear_ticks(4380.0, 9761.0, 5)),
            ["5 000", "6 000", "7 000", "8 000", "9 000"]
        );
        assert_eq!(
            labels(linear_ticks(-0.11, 0.1, 4)),
            ["−0.10", "−0.05", "0.00", "0.05", "0.10"]
        );
        assert_eq!(
            labels(linear_ticks(0.0, 1.0, 5)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            labels(decade_ticks(1e-4, 1.0, 6)),
            ["0.0001", "0.001", "0.01", "0.1", "1"]
        );
    }

    #[test]
    fn no_range_makes_a_tick_that_is_no_number() {
        let ends = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            f64::MIN_POSITIVE,
            5e-324,
            f64::MAX,
            f64::MIN,
            1e16,
            1e16 + 2.0,
            f64::NAN,
            f64::INFINITY,
        ];
        for scale in [Scale::Linear, Scale::Logarithmic] {
            for (low, high) in ends.iter().flat_map(|a| ends.iter().map(move |b| (*a, *b))) {
                let range = Extent::of(scale, (low, high));
                assert!(range.0 < range.1, "{scale:?} {low} {high}: {range:?}");
                for range in [range, (low, high)] {
                    let axis = Axis::new(scale, range, 0.0, 100.0);
                    for (value, label) in axis.ticks(7) {
                        assert!(
                            value.is_finite() && label.len() < 60,
                            "{low} {high} {label}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_range_of_one_value_is_widened() {
        let mut extent = Extent::new(Scale::Linear);
        extent.add(5.0);
        assert_eq!(extent.plain(), (4.75, 5.25));
    }
}
