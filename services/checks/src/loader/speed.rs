//! Checks the speed against the wheel speeds, in driving blocks: it must have a sign, and must not be computed from them.

use recording::Finding;

/// Fewest blocks of a direction for a verdict.
const ENOUGH: u32 = 20;
/// Relative standard deviation of speed over wheel speed below which the speed is computed from the wheels. A machine that pulls slips
/// by .1 to 2 %, and an independent speed has noise. A bus rounds to 1/256 km/h.
const SAME: f64 = 3e-4;
/// Share of the other axle's torque below which an axle rolls freely: the speed may come from its wheels.
const PULLS: f64 = 0.1;

/// Mean of a ratio, and sum of squared deviations.
#[derive(Clone, Copy, Default)]
struct Ratio {
    mean: f64,
    squares: f64,
}

/// Accumulates blocks.
#[derive(Default)]
pub(super) struct Speed {
    rows: f64,
    /// Blocks by direction: both forwards; speed forwards and wheels backwards; speed backwards and wheels forwards; both backwards.
    ways: [u32; 4],
    /// Ratio of the speed to the speed of the front wheels, of the rear wheels, and of their mean.
    ratios: [Ratio; 3],
    /// Sums of the absolute torques.
    torques: [f64; 2],
}

impl Speed {
    /// Takes a driving block.
    pub(super) fn see(&mut self, speed: f64, wheels: [f64; 2], torques: [f64; 2]) {
        let mean = 0.5 * (wheels[0] + wheels[1]);
        if mean == 0.0 || wheels[0] * wheels[1] <= 0.0 {
            return;
        }
        self.rows += 1.0;
        let way = usize::from(mean < 0.0) + 2 * usize::from(speed < 0.0);
        self.ways[way] += 1;
        let all = [wheels[0], wheels[1], mean].map(|wheel| (speed / wheel).abs());
        for (ratio, now) in self.ratios.iter_mut().zip(all) {
            let away = now - ratio.mean;
            ratio.mean += away / self.rows;
            ratio.squares += away * (now - ratio.mean);
        }
        for (sum, torque) in self.torques.iter_mut().zip(torques) {
            *sum += torque.abs();
        }
    }

    /// The fault of the speed and its remedy.
    pub(super) fn fault(&self) -> Option<Finding> {
        let [forwards, speed_alone, wheels_alone, backwards] = self.ways;
        if forwards < ENOUGH {
            return None;
        }
        if speed_alone >= ENOUGH && wheels_alone + backwards == 0 {
            return Some(Finding::new(
                "speed has no sign: it is positive while the wheels turn backwards",
                "give it the sign of the wheel speeds, or of the gear, before heft reads it (CCVS1 on a J1939 bus has none)",
            ));
        }
        if wheels_alone >= ENOUGH && speed_alone + backwards == 0 {
            return Some(Finding::new(
                "front_wheel_speed and rear_wheel_speed have no sign: they are positive while the machine drives backwards",
                "give them the sign of the speed, or of the gear, before heft reads them",
            ));
        }
        self.made_of_wheels()
    }

    fn made_of_wheels(&self) -> Option<Finding> {
        let [front, rear] = self.torques;
        let pulls = [front > PULLS * rear, rear > PULLS * front, true];
        let same = |ratio: &Ratio| (ratio.squares / self.rows).sqrt() < SAME * ratio.mean;
        let mut all = self.ratios.iter().zip(pulls);
        (self.rows >= f64::from(5 * ENOUGH) && all.any(|(ratio, pulls)| pulls && same(ratio)))
            .then(|| Finding::new(
                    "speed seems to be made from the wheel speeds: their ratio never changes, and slip would change it",
                    "map a speed that no driven wheel makes (radar, satellites, a free wheel); or weigh by lift pressures",
                ),
            )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    /// The fault of a machine that drives in both directions and slips, with these sensors of speed and front wheels.
    fn said(speed: impl Fn(f64, f64) -> f64, wheel: impl Fn(f64) -> f64) -> String {
        let mut seen = Speed::default();
        for k in 0..600 {
            let time = f64::from(k) / 5.0;
            let (v, torque) = (4.0 * (0.2 * time).sin(), 3e3 * time.cos());
            let slipped = v / 0.7 * (1.0 + 1e-6 * torque);
            if v.abs() > 1.0 {
                let wheels = [wheel(slipped), wheel(slipped * 1.001)];
                seen.see(speed(v, slipped), wheels, [torque; 2]);
            }
        }
        text(seen.fault())
    }

    #[test]
    fn a_speed_without_a_sign_is_named_and_one_with_is_not() {
        assert_eq!(said(|v, _| v, |w| w), "");
        assert!(said(|v, _| v.abs(), |w| w).starts_with("speed has no sign"));
        assert!(said(|v, _| v, f64::abs).starts_with("front_wheel_speed and rear"));
        // The opposite sign in both directions is another fault.
        assert_eq!(said(|v, _| -v, |w| w), "");
    }

    #[test]
    fn a_speed_that_a_driven_wheel_makes_is_named() {
        assert!(said(|_, w| 0.71 * w, |w| w).starts_with("speed seems to be made"));
    }
}
