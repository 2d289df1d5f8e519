//! Do the boom's pressures carry boom, arm and bucket while the machine swings? They must: nothing else holds them up.

use estimation::excavator::{Cylinder, Geometry, Lifts, Sample};

/// Swinging from this velocity on, the bucket is in the air [rad/s].
const SWINGS: f64 = 0.1;
/// Swinging rows, and moments of blocks of .2 s, that tell: some ten seconds.
const FEWEST_ROWS: u32 = 1000;
const FEWEST: u32 = 50;
/// The least share of the empty front's moment that is carried where unit and drawing are right. Drawings are off by a tenth or two;
/// psi that are read as kPa leave a seventh, and a third with a load.
const LEAST: f64 = 0.5;
/// Where the cylinder is not described: pumps give 20 MPa and more, and no boom is carried by so little of it \[Pa\]. Recorded while
/// machines of 5 to 36 t swing: 12 to 23 MPa in the highest row of a hundred, 14 MPa without any load. The other end is a line without
/// pressure.
const LOW: [f64; 2] = [1e5, 3.5e6];
/// One row in so many may be a disturbance.
const DISTURBED: u32 = 100;

const REMEDY: &str =
    "check the unit of both in the signal map (psi that are read as kPa are 6.9 times too small)";

/// Looks at the pressures of swinging rows.
pub(super) struct Carries {
    rows: u32,
    /// Rows beyond each end of what is too low.
    beyond: [u32; 2],
    lifts: Option<Lifts>,
    moments: u32,
    /// Sums of the moments that the cylinders have, and that the empty machine needs [N m].
    measured: f64,
    needed: f64,
}

impl Carries {
    pub(super) fn new(described: &config::Excavator) -> Self {
        let lifts = Cylinder::of_boom(described)
            .map(|cylinder| Lifts::new(Geometry::of(described), cylinder));
        Self {
            rows: 0,
            beyond: [0; 2],
            lifts,
            moments: 0,
            measured: 0.0,
            needed: 0.0,
        }
    }

    pub(super) fn see(&mut self, sample: &Sample) {
        let swings = sample.velocity.is_some_and(|v| v.abs() > SWINGS);
        if let Some(head) = sample.boom_head_pressure.filter(|_| swings) {
            self.rows += 1;
            for (beyond, end) in self.beyond.iter_mut().zip(LOW) {
                *beyond += u32::from(head > end);
            }
        }
        let moment = self.lifts.as_mut().and_then(|lifts| lifts.step(sample));
        if let Some(moment) = moment.filter(|moment| swings && !moment.touches) {
            self.moments += 1;
            self.measured += moment.measured;
            self.needed += moment.empty;
        }
    }

    /// That they do not, and what to do.
    pub(super) fn fault(&self) -> Option<String> {
        let share = self.measured / self.needed;
        if self.moments >= FEWEST && self.needed > 0.0 {
            return (share < LEAST).then(|| {
                format!(
                    "boom_head_pressure and boom_rod_pressure carry {:.0} % of the weight of the described boom, arm and empty bucket while \
                     the machine swings\n  what to do: {REMEDY}, their sides, and machine.boom_cylinder",
                    100.0 * share
                )
            });
        }
        let [some, enough] = self.beyond.map(|rows| DISTURBED * rows > self.rows);
        (self.rows >= FEWEST_ROWS && some && !enough).then(|| {
            format!(
                "boom_head_pressure is hardly ever above {:.0} bar while the machine swings: too little to carry boom, arm and bucket\n  \
                 what to do: {REMEDY}",
                LOW[1] / 1e5
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of a machine that swings with its boom held by these pressures, read in a unit of this size.
    fn said(unit: f64, is_described: bool) -> String {
        let mut described = config::Excavator::default();
        if is_described {
            let cylinder = &mut described.boom_cylinder;
            (cylinder.count, cylinder.head_area, cylinder.rod_area) = (1.0, 0.0095, 0.0063);
            (cylinder.base_distance, cylinder.rod_distance) = (0.5, 1.1);
            cylinder.angle = 0.9;
        }
        let mut carries = Carries::new(&described);
        let mut by_drawing = Carries::new(&described);
        let row = |k: u32, head: f64| Sample {
            time: 0.01 * f64::from(k),
            velocity: Some(0.8 * (0.01 * f64::from(k)).sin()),
            posture: [0.6, -1.6, -0.6].map(Some),
            boom_head_pressure: Some(head),
            boom_rod_pressure: Some(0.0),
            ..Sample::default()
        };
        // What the drawing needs, by the moment of one pascal.
        (0..3000).for_each(|k| by_drawing.see(&row(k, 1.0)));
        let needed = match is_described {
            true => by_drawing.needed / by_drawing.measured,
            false => 12e6,
        };
        (0..3000).for_each(|k| carries.see(&row(k, 1.2 * needed / unit)));
        carries.fault().unwrap_or_default()
    }

    #[test]
    fn pressures_that_cannot_carry_the_boom_are_named_and_those_that_do_are_not() {
        let psi_as_kpa = 6.894_76;
        for is_described in [true, false] {
            assert_eq!(said(1.0, is_described), "");
            assert!(said(psi_as_kpa, is_described).contains("psi that are read as kPa"));
        }
        assert!(
            said(psi_as_kpa, true)
                .starts_with("boom_head_pressure and boom_rod_pressure carry 17 %")
        );
        // A sensor that shows nothing is another fault.
        assert_eq!(said(1e9, false), "");
    }
}
