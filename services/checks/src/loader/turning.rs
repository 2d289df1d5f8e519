//! Checks articulation against yaw rate: yaw rate = speed times articulation over a length.

use estimation::loader::Sample;
use recording::Finding;

use super::pair::Pair;

/// Speed below which it may turn on the spot [m/s].
const DRIVES: f64 = 1.0;
/// Least articulation of a turn \[rad\].
const TURNS: f64 = 0.05;
/// Fewest rows for a verdict, and least correlation of the two: .95 and more was recorded.
const ENOUGH: u32 = 200;
const TOGETHER: f64 = 0.7;
/// Plausible lengths \[m\]: some wheelbases.
const LENGTHS: [f64; 2] = [0.5, 12.0];
/// Where a yaw rate fits in two units, the one that makes the length more like this \[m\].
const USUAL: f64 = 2.5;
/// Degrees, and thousandths, in a radian.
const DEGREES: f64 = 180.0 / core::f64::consts::PI;
const THOUSANDTHS: f64 = 1e3;

/// Accumulates rows in turns.
#[derive(Default)]
pub(super) struct Turning {
    rows: u32,
    both: Pair,
}

impl Turning {
    pub(super) fn see(&mut self, s: &Sample) {
        let (Some(speed), Some(articulation), Some(yaw)) = (s.speed, s.articulation, s.yaw_rate)
        else {
            return;
        };
        if speed.abs() > DRIVES && articulation.abs() > TURNS {
            self.rows += 1;
            self.both.see(speed * articulation, yaw);
        }
    }

    /// The fault, unit or sign of one of the two columns, and its remedy.
    pub(super) fn fault(&self) -> Option<Finding> {
        let together = self.both.correlation();
        if self.rows < ENOUGH || together.abs() < TOGETHER {
            return None;
        }
        let length = |by: f64| self.both.ratio() * by;
        let within = |by: f64| (LENGTHS[0]..LENGTHS[1]).contains(&length(by));
        let far = |by: f64| (length(by) / USUAL).ln().abs();
        match () {
            () if together < 0.0 => Some(Finding::new(
                "articulation and yaw_rate seem to have opposite signs: both are positive where the machine turns left",
                "in the signal map `sign = -1` for the one that is positive to the right",
            )),
            () if within(1.0) => None,
            () if within(THOUSANDTHS) && far(THOUSANDTHS) < far(DEGREES) => Some(Finding::new(
                "yaw_rate seems to be in mrad/s: the machine turns less than that by its articulation",
                "in the signal map `unit = \"mrad/s\"` for yaw_rate",
            )),
            () if within(DEGREES) => Some(Finding::new(
                "yaw_rate seems to be in deg/s: the machine turns less than that by its articulation",
                "in the signal map `unit = \"deg/s\"` for yaw_rate",
            )),
            () if within(1.0 / DEGREES) => Some(Finding::new(
                "articulation seems to be in degrees: the machine turns less than that by its yaw_rate",
                "in the signal map `unit = \"deg\"` for articulation",
            )),
            () => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    #[test]
    fn signs_and_units_of_turns_are_reported() {
        let said = |by: [f64; 2]| {
            let mut turning = Turning::default();
            for k in 0..1000 {
                let articulation = 0.4 * (0.01 * f64::from(k)).sin();
                turning.see(&Sample {
                    speed: Some(2.0),
                    articulation: Some(by[0] * articulation),
                    yaw_rate: Some(by[1] * 2.0 * articulation / 2.5),
                    ..Sample::default()
                });
            }
            text(turning.fault())
        };
        assert_eq!(said([1.0, 1.0]), "");
        assert!(said([-1.0, 1.0]).contains("opposite signs"));
        assert!(said([1.0, 57.3]).starts_with("yaw_rate seems to be in deg/s"));
        assert!(said([1.0, 1e3]).starts_with("yaw_rate seems to be in mrad/s"));
        assert!(said([57.3, 1.0]).starts_with("articulation seems to be in degrees"));
        assert_eq!(said([57.3, 57.3]), "");
    }
}
