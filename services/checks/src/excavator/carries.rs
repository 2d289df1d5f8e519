//! Checks that the boom's head pressure carries boom, arm and bucket while the machine swings: nothing else holds them up.

use estimation::excavator::Sample;
use recording::Finding;

/// Swing velocity above which the bucket is in the air [rad/s].
const SWINGS: f64 = 0.1;
/// Fewest swinging rows for a verdict: some ten seconds.
const FEWEST: u32 = 1000;
/// Range of head pressures too low to carry a boom \[Pa\]; pumps give 20 MPa and more. Highest row of a hundred while machines of 5 to
/// 36 t swing, as recorded: 12 to 23 MPa, 14 MPa without any load. Pressures in psi that are read as kPa are a seventh of that. Below
/// the range is a line without pressure.
const LOW: [f64; 2] = [1e5, 3.5e6];
/// Rows per disturbance: a share of 1/100 may be disturbed.
const DISTURBED: u32 = 100;

/// Counts head pressures of swinging rows.
#[derive(Default)]
pub(super) struct Carries {
    rows: u32,
    /// Rows above each limit of [`LOW`].
    beyond: [u32; 2],
}

impl Carries {
    pub(super) fn see(&mut self, sample: &Sample) {
        let swings = sample.velocity.is_some_and(|v| v.abs() > SWINGS);
        if let Some(head) = sample.boom_head_pressure.filter(|_| swings) {
            self.rows += 1;
            for (beyond, end) in self.beyond.iter_mut().zip(LOW) {
                *beyond += u32::from(head > end);
            }
        }
    }

    /// The fault and its remedy, if the pressures are too low.
    pub(super) fn fault(&self) -> Option<Finding> {
        let [some, enough] = self.beyond.map(|rows| DISTURBED * rows > self.rows);
        (self.rows >= FEWEST && some && !enough).then(|| {
            Finding::new(
                format!(
                    "boom_head_pressure is hardly ever above {:.0} bar while the machine swings: too little to carry boom, arm and bucket",
                    LOW[1] / 1e5,
                ),
                "check the unit of both pressures in the signal map (psi that are read as kPa are 6.9 times too small)",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    #[test]
    fn pressures_that_cannot_carry_the_boom_are_named_and_those_that_do_are_not() {
        let said = |unit: f64| {
            let mut carries = Carries::default();
            for k in 0..3000 {
                let time = 0.01 * f64::from(k);
                carries.see(&Sample {
                    time,
                    velocity: Some(0.8 * time.sin()),
                    boom_head_pressure: Some((12e6 + 8e6 * (0.3 * time).sin()) / unit),
                    ..Sample::default()
                });
            }
            text(carries.fault())
        };
        assert_eq!(said(1.0), "");
        assert!(said(6.894_76).contains("psi that are read as kPa"));
        // A sensor without output is another fault.
        assert_eq!(said(1e9), "");
    }
}
