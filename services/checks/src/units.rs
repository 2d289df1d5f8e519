//! Units of angular velocities, and faults that one column shows: angles in degrees, pressures in another unit or exchanged sides.

use core::f64::consts::{PI, TAU};

use recording::{Finding, LARGEST_PRESSURES as LARGEST};

use crate::advice::write_unit;

/// Units of an angular velocity, and their number per rad/s.
pub(super) const TURNING: [(&str, f64); 4] = [
    ("rpm", 60.0 / TAU),
    ("deg/s", 180.0 / PI),
    ("turn/s", 1.0 / TAU),
    ("mrad/s", 1e3),
];

/// Least number of rows for a decision.
const FEWEST: u32 = 100;

/// Share of rows beyond one turn in rad above which an angle is in degrees: no joint turns further. A value beyond one turn in degrees
/// (`TURN`) marks a missing sample.
const OFTEN: f64 = 0.1;
const TURN: f64 = 360.0;

/// Checks of angles that should be in radians.
pub(super) struct Angles<const N: usize> {
    names: [&'static str; N],
    rows: [u32; N],
    beyond: [u32; N],
}

impl<const N: usize> Angles<N> {
    pub(super) fn new(names: [&'static str; N]) -> Self {
        Self {
            names,
            rows: [0; N],
            beyond: [0; N],
        }
    }

    pub(super) fn see(&mut self, angles: [Option<f64>; N]) {
        for (i, angle) in angles.into_iter().enumerate() {
            self.rows[i] += u32::from(angle.is_some());
            self.beyond[i] += u32::from(angle.is_some_and(|q| (TAU..=TURN).contains(&q.abs())));
        }
    }

    /// The fault of angles in degrees.
    pub(super) fn fault(&self) -> Option<Finding> {
        let is_in_degrees = |i: &usize| {
            self.rows[*i] >= FEWEST && f64::from(self.beyond[*i]) > OFTEN * f64::from(self.rows[*i])
        };
        let names: Vec<_> = (0..N)
            .filter(is_in_degrees)
            .map(|i| self.names[i])
            .collect();
        let seem = if names.len() == 1 { "seems" } else { "seem" };
        let names = names.join(", ");
        (!names.is_empty()).then(|| {
            Finding::new(
                format!("{names} {seem} to be in degrees: no joint turns further than once"),
                write_unit("deg", &names),
            )
        })
    }
}

/// Largest index in `LARGEST` at which the unit of one side is judged alone: MPa and bar. Larger values may be the residual
/// pressure of an unloaded line.
const ALONE: usize = 2;
/// Rows per row that may be disturbed.
const DISTURBED: u32 = 100;
/// Least ratio of rod to head pressure, and least rod pressure \[Pa\], at which the sides seem exchanged: a loaded cylinder has the larger
/// pressure on its head side.
const MORE: f64 = 2.0;
const CARRIES: f64 = 2e6;

/// Number of rows of a pressure in each range of `LARGEST`; the last is for rows above all limits.
#[derive(Default)]
struct Sizes([u32; LARGEST.len() + 1]);

impl Sizes {
    fn see(&mut self, pressure: f64) {
        let place = LARGEST
            .iter()
            .position(|(limit, _)| pressure.abs() < *limit);
        self.0[place.unwrap_or(LARGEST.len())] += 1;
    }

    /// Index of the highest range that holds more than disturbances.
    fn highest(&self) -> Option<usize> {
        let rows: u32 = self.0.iter().sum();
        let is_usual = |count: &u32| DISTURBED * count > rows;
        (rows >= FEWEST).then(|| self.0.iter().rposition(is_usual))?
    }
}

/// Checks of the pressures of a cylinder whose head side carries the load.
pub(super) struct Cylinder {
    /// Prefix of its columns, such as `boom`.
    name: &'static str,
    /// Head and rod side.
    sizes: [Sizes; 2],
    /// Rows in which the cylinder is loaded, and those of them in which the rod side carries the load.
    carries: u32,
    by_rod: u32,
}

impl Cylinder {
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            sizes: Default::default(),
            carries: 0,
            by_rod: 0,
        }
    }

    /// Takes a row, and whether the cylinder is loaded in it.
    pub(super) fn see(&mut self, head: Option<f64>, rod: Option<f64>, carries: bool) {
        for (sizes, pressure) in self.sizes.iter_mut().zip([head, rod]) {
            pressure
                .into_iter()
                .for_each(|pressure| sizes.see(pressure));
        }
        if let (Some(head), Some(rod), true) = (head, rod, carries) {
            self.carries += 1;
            self.by_rod += u32::from(rod > CARRIES && rod > MORE * head);
        }
    }

    /// The fault of pressures in another unit than Pa, or of exchanged sides.
    pub(super) fn fault(&self) -> Option<Finding> {
        let [head, rod] = ["head", "rod"].map(|side| format!("{}_{side}_pressure", self.name));
        let both = format!("{head} and {rod}");
        let [of_head, of_rod] = self.sizes.each_ref().map(Sizes::highest);
        if let Some(unit) = of_head.max(of_rod).and_then(|place| LARGEST.get(place)?.1) {
            // Of a cylinder that never carries much, bar are as few.
            let other = if unit == "MPa" {
                ", or \"bar\" if the sensors are in bar"
            } else {
                ""
            };
            return Some(Finding::new(
                format!("{both} seem to be in {unit}: no pump works at so few Pa"),
                format!("{}{other}", write_unit(unit, "both")),
            ));
        }
        let too_large = |place: Option<usize>| place == Some(LARGEST.len());
        let large = [(&head, of_head), (&rod, of_rod)];
        if let Some((name, _)) = large.into_iter().find(|(_, place)| too_large(*place)) {
            return Some(Finding::new(
                format!("{name} seems to be in another unit: no machine has more than 700 bar"),
                "check the unit of both in the signal map (psi that are read as bar are 14.5 times too large)",
            ));
        }
        let is_alone =
            |place: Option<usize>| place.is_some_and(|place| (1..=ALONE).contains(&place));
        let alone = [(&head, of_head), (&rod, of_rod)]
            .into_iter()
            .find(|(_, place)| is_alone(*place));
        if let Some((name, _)) = alone {
            return Some(Finding::new(
                format!("{name} seems to be in another unit than the other side, bar or MPa"),
                format!("write `unit = \"bar\"`, or MPa, for {name} in a signal map"),
            ));
        }
        (self.carries >= FEWEST && 2 * self.by_rod > self.carries).then(|| {
            Finding::new(
                format!("{both} seem to be exchanged: the rod side seems to carry the weight"),
                "exchange the two in the signal map; or they are those of another cylinder",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    #[test]
    fn angles_in_degrees_are_named_one_by_one() {
        let mut angles = Angles::new(["boom_angle", "arm_angle"]);
        (0..200).for_each(|_| angles.see([Some(0.8), Some(-103.0)]));
        assert!(
            angles
                .fault()
                .is_some_and(|fault| fault.what.starts_with("arm_angle seems"))
        );
        let mut angles = Angles::new(["boom_angle", "arm_angle"]);
        (0..200).for_each(|k| angles.see([(k > 100).then_some(0.8), Some(6.0)]));
        assert_eq!(angles.fault(), None);
    }

    /// The fault of a boom cylinder with these units and sides.
    fn boom_fault(unit: f64, sides: [usize; 2]) -> Option<Finding> {
        let mut cylinder = Cylinder::new("boom");
        for k in 0..1000 {
            let pressures = [12e6 + 1e4 * f64::from(k), 0.7e6].map(|pressure| pressure / unit);
            let [head, rod] = sides.map(|side| Some(pressures[side]));
            cylinder.see(head, rod, true);
        }
        cylinder.fault()
    }

    #[test]
    fn another_unit_of_pressures_and_the_other_side_are_named() {
        assert_eq!(boom_fault(1.0, [0, 1]), None);
        for (unit, name) in [(1e5, "bar"), (1e6, "MPa"), (1e3, "kPa"), (6894.76, "psi")] {
            let text = text(boom_fault(unit, [0, 1]));
            assert!(text.contains(&format!("unit = \"{name}\"")), "{text}");
        }
        assert!(boom_fault(1.0, [1, 0]).is_some_and(|fault| fault.what.contains("exchanged")));
        // One side in another unit than the other.
        let alone = |units: [f64; 2]| {
            let mut cylinder = Cylinder::new("lift");
            (0..1000)
                .for_each(|_| cylinder.see(Some(12e6 / units[0]), Some(0.7e6 / units[1]), true));
            text(cylinder.fault())
        };
        assert!(alone([1e5, 1.0]).starts_with("lift_head_pressure seems to be in another unit"));
        assert!(alone([1.0, 1e5]).starts_with("lift_rod_pressure seems to be in another unit"));
        assert_eq!(alone([1.0, 10.0]), "");
        for unit in [0.1, 1.0 / 14.5] {
            assert!(boom_fault(unit, [0, 1]).is_some_and(|fault| fault.what.contains("700 bar")));
        }
        assert_eq!(boom_fault(1e9, [0, 1]), None);
        assert_eq!(boom_fault(10.0, [1, 0]), None);
    }
}
