//! Rejects values that change faster than the measured quantity can.
//!
//! A loose contact, a bus that drops out or a gateway that fills gaps sends 0 or the end of a range for some rows. A value too far from
//! the last accepted one counts as missing, and so do exact repetitions of it. The allowed distance grows with time, so that a shock or a
//! restarted sensor is accepted a moment later.

/// Duration after which a repeated value is accepted [s].
const MEANT: f64 = 2.0;

/// Filter of a signal against leaps.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Leap {
    last: Option<f64>,
    /// Time since `last` changed [s].
    age: f64,
    /// Last refused value since then.
    refused: Option<f64>,
}

impl Leap {
    /// Returns the value, or none where it leaps by more than `change` allows (per second) plus `noise`. Where both are zero every value
    /// passes.
    pub(crate) fn pass(
        &mut self,
        value: Option<f64>,
        change: f64,
        noise: f64,
        period: f64,
    ) -> Option<f64> {
        self.age += period;
        let value = value?;
        let reach = change * self.age + noise;
        let leaps = |last: f64| reach > 0.0 && (value - last).abs() > reach;
        let again = self.refused == Some(value) && self.age < MEANT;
        if again || self.last.is_some_and(leaps) {
            self.refused = Some(value);
            return None;
        }
        self.refused = None;
        if self.last.replace(value) != Some(value) {
            self.age = 0.0;
        }
        Some(value)
    }
}

/// Largest rate of a drive's torque, from zero to its largest torque [1/s]: twice the largest recorded on excavators and loaders.
const RISE: f64 = 30.0;

/// Filter of a torque against leaps.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SteadyTorque {
    leap: Leap,
    /// Largest accepted torque so far [N m].
    largest: f64,
}

impl SteadyTorque {
    /// Returns the torque, or none where it leaps. The drive reaches at least `least`; steps up to `noise` are noise [N m].
    pub(crate) fn pass(
        &mut self,
        torque: Option<f64>,
        [least, noise]: [f64; 2],
        period: f64,
    ) -> Option<f64> {
        let change = RISE * self.largest.max(least);
        let accepted = self.leap.pass(torque, change, noise, period);
        self.largest = self.largest.max(accepted.unwrap_or(0.0).abs());
        accepted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First missing row and number of missing rows, at 100 Hz.
    fn missing(rows: u32, mut passes: impl FnMut(u32) -> bool) -> (u32, u32) {
        let mut missing = (0..rows).filter(|&k| !passes(k));
        let first = missing.next().unwrap_or(rows);
        (first, 1 + missing.count() as u32)
    }

    fn noise(k: u32) -> f64 {
        f64::from(k * 7919 % 13) / 13.0
    }

    #[test]
    fn a_torque_that_drops_out_is_missing_and_one_that_rises_as_drives_do_is_not() {
        let mut sensor = SteadyTorque::default();
        let drops = 150..170;
        let found = missing(400, |k| {
            let rises = f64::from(k.min(20)) * 500.0 + 10.0 * noise(k);
            let value = if drops.contains(&k) { 0.0 } else { rises };
            sensor.pass(Some(value), [2000.0, 10.0], 0.01).is_some()
        });
        assert_eq!(found, (drops.start, drops.len() as u32));
    }

    #[test]
    fn what_stays_elsewhere_is_accepted_soon_with_noise_and_after_two_seconds_without() {
        for (its_noise, rows) in [(0.01, 8..13), (0.0, 198..202)] {
            let mut sensor = Leap::default();
            let (first, count) = missing(400, |k| {
                let value = match k {
                    ..100 => 0.01 * noise(k),
                    _ => 1.0 + its_noise * noise(k),
                };
                sensor.pass(Some(value), 10.0, 0.0, 0.01).is_some()
            });
            assert!(first == 100 && rows.contains(&count), "{first} {count}");
        }
    }
}
