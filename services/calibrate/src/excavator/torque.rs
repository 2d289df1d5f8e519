//! Swing torque between its samples: integrals over any interval, separate for driving and
//! braking, since a gear has losses in both.

/// Half width of the window for the sign of the power [s].
const WINDOW: f64 = 0.04;

/// Integrals from the start of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Impulse {
    /// Integral of the torque while it drives the motion [N m s].
    pub driving: f64,
    /// Integral of the torque while it brakes [N m s].
    pub braking: f64,
    /// Duration of driving \[s\].
    pub driving_time: f64,
    /// Duration of braking \[s\].
    pub braking_time: f64,
}

impl Impulse {
    /// Difference to an earlier time.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            driving: self.driving - earlier.driving,
            braking: self.braking - earlier.braking,
            driving_time: self.driving_time - earlier.driving_time,
            braking_time: self.braking_time - earlier.braking_time,
        }
    }

    fn add(&self, driving: bool, impulse: f64, time: f64) -> Self {
        let mut sum = *self;
        if driving {
            sum.driving += impulse;
            sum.driving_time += time;
        } else {
            sum.braking += impulse;
            sum.braking_time += time;
        }
        sum
    }
}

/// A torque that is linear between its samples.
#[derive(Debug, Clone, Default)]
pub struct Torque {
    time: Vec<f64>,
    value: Vec<f64>,
    /// Integrals up to each sample.
    sum: Vec<Impulse>,
    /// Whether the interval after each sample drives.
    drives: Vec<bool>,
}

impl Torque {
    /// Torque from samples `(time, torque)` of increasing time, with the velocity at any time.
    pub fn new(samples: &[(f64, f64)], velocity: impl Fn(f64) -> f64) -> Self {
        let (time, value): (Vec<f64>, Vec<f64>) = samples.iter().copied().unzip();
        let smooth = crate::column::moving_mean(&time, &value, WINDOW);
        let mut torque = Self {
            time,
            value,
            sum: vec![Impulse::default(); samples.len()],
            drives: vec![true; samples.len()],
        };
        for k in 1..samples.len() {
            let (t0, t1) = (torque.time[k - 1], torque.time[k]);
            let power = (smooth[k - 1] + smooth[k]) * velocity(0.5 * (t0 + t1));
            torque.drives[k - 1] = power >= 0.0;
            let impulse = 0.5 * (t1 - t0) * (torque.value[k - 1] + torque.value[k]);
            torque.sum[k] = torque.sum[k - 1].add(power >= 0.0, impulse, t1 - t0);
        }
        torque
    }

    /// Start of a cursor, for integrals from a time on.
    pub fn cursor(&self, time: f64) -> usize {
        let after = self.time.partition_point(|t| *t <= time);
        let last = self.time.len().saturating_sub(2);
        after.saturating_sub(1).min(last)
    }

    /// The integrals up to a time; `cursor` stores the place between calls of increasing time.
    pub fn until(&self, time: f64, cursor: &mut usize) -> Impulse {
        let last = self.time.len().saturating_sub(2);
        while *cursor < last && self.time[*cursor + 1] <= time {
            *cursor += 1;
        }
        while *cursor > 0 && self.time[*cursor] > time {
            *cursor -= 1;
        }
        let k = *cursor;
        let (Some(&t0), Some(&t1)) = (self.time.get(k), self.time.get(k + 1)) else {
            return Impulse::default();
        };
        let s = (time - t0).clamp(0.0, t1 - t0);
        let slope = (self.value[k + 1] - self.value[k]) / (t1 - t0);
        self.sum[k].add(self.drives[k], s * (self.value[k] + 0.5 * s * slope), s)
    }

    /// The largest distance between samples around an interval \[s\]; infinite outside the samples.
    pub fn widest_gap(&self, from: f64, to: f64) -> f64 {
        let first = self.time.partition_point(|t| *t <= from);
        let last = self.time.partition_point(|t| *t < to);
        if first == 0 || last >= self.time.len() {
            return f64::INFINITY;
        }
        let around = &self.time[first - 1..=last];
        around
            .windows(2)
            .fold(0.0, |gap: f64, w| gap.max(w[1] - w[0]))
    }

    /// The torque that 5 % of the samples exceed [N m].
    pub fn size(&self) -> f64 {
        crate::column::percentile(self.value.iter().map(|v| v.abs()).collect(), 0.95)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_between_samples_are_those_of_straight_lines() {
        let samples: Vec<(f64, f64)> = (0..100).map(|i| (i as f64 * 0.1, i as f64)).collect();
        let torque = Torque::new(&samples, |_| 1.0);
        let mut cursor = 0;
        for (time, integral) in [(2.0, 20.0), (2.05, 21.0125), (0.5, 1.25)] {
            let found = torque.until(time, &mut cursor);
            assert!((found.driving - integral).abs() < 1e-9, "{time}: {found:?}");
            assert!((found.driving_time - time).abs() < 1e-12);
        }
        // The start of a cursor has no effect.
        for time in [-1.0, 0.0, 3.03, 9.85, 9.9, 12.0] {
            let far = torque.until(time, &mut 0);
            assert_eq!(far, torque.until(time, &mut torque.cursor(time)), "{time}");
        }
    }

    #[test]
    fn a_torque_against_the_motion_brakes() {
        let samples: Vec<(f64, f64)> = (0..10).map(|i| (i as f64, -2.0)).collect();
        let total = Torque::new(&samples, |_| 1.0).until(9.0, &mut 0);
        assert_eq!((total.driving, total.braking), (0.0, -18.0));
    }

    #[test]
    fn gaps_are_seen() {
        let torque = Torque::new(&[(0.0, 1.0), (0.1, 1.0), (0.9, 1.0), (1.0, 1.0)], |_| 1.0);
        assert!((torque.widest_gap(0.02, 0.95) - 0.8).abs() < 1e-12);
        assert!(torque.widest_gap(0.5, 2.0).is_infinite());
    }
}
