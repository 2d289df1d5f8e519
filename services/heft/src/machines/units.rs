//! What a column alone shows: angles in degrees, pressures in another unit or of the other side.

use core::f64::consts::TAU;

/// Fewest rows that tell.
const FEWEST: u32 = 100;

/// No joint turns further than once [rad], in more than this share of the rows.
const OFTEN: f64 = 0.1;

/// Angles that are meant in radians.
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
            self.beyond[i] += u32::from(angle.is_some_and(|angle| angle.abs() > TAU));
        }
    }

    /// Those that are in degrees.
    pub(super) fn fault(&self) -> Option<String> {
        let is_in_degrees = |i: &usize| {
            self.rows[*i] >= FEWEST && f64::from(self.beyond[*i]) > OFTEN * f64::from(self.rows[*i])
        };
        let names: Vec<_> = (0..N)
            .filter(is_in_degrees)
            .map(|i| self.names[i])
            .collect();
        let seem = if names.len() == 1 { "seems" } else { "seem" };
        let names = names.join(" and ");
        (!names.is_empty()).then(|| {
            format!(
                "{names} {seem} to be in degrees: no joint turns further than once\n  \
                 what to do: write `unit = \"deg\"` for {names} in a signal map"
            )
        })
    }
}

/// Where the largest pressure of a recording lies, in the unit of the data: pumps of excavators and loaders give 20 to 40 MPa, and
/// work needs some of it. Each up to the limit; beyond the last they are in Pa, and below the first nothing was measured.
const LARGEST: [(f64, &str); 5] = [
    (1.0, ""),
    (47.0, "MPa"),
    (560.0, "bar"),
    (6e3, "psi"),
    (1e5, "kPa"),
];
/// A cylinder that carries has this many times more pressure on its head side: here for the other one. And the least pressure that
/// says so [Pa].
const MORE: f64 = 2.0;
const CARRIES: f64 = 2e6;

/// Pressures of a cylinder whose head side carries the weight of what it moves.
pub(super) struct Cylinder {
    /// Of its columns: `boom`.
    name: &'static str,
    rows: u32,
    largest: f64,
    /// Rows in which it carries, and those of them in which the rod side does.
    carries: u32,
    by_rod: u32,
}

impl Cylinder {
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            rows: 0,
            largest: 0.0,
            carries: 0,
            by_rod: 0,
        }
    }

    /// A row, and whether the cylinder carries in it.
    pub(super) fn see(&mut self, head: Option<f64>, rod: Option<f64>, carries: bool) {
        for pressure in [head, rod].into_iter().flatten() {
            self.rows += 1;
            self.largest = self.largest.max(pressure.abs());
        }
        if let (Some(head), Some(rod), true) = (head, rod, carries) {
            self.carries += 1;
            self.by_rod += u32::from(rod > CARRIES && rod > MORE * head);
        }
    }

    pub(super) fn fault(&self) -> Option<String> {
        let name = self.name;
        if self.rows < FEWEST {
            return None;
        }
        let unit = LARGEST.iter().find(|(limit, _)| self.largest < *limit);
        if let Some((_, unit)) = unit.filter(|(_, unit)| !unit.is_empty()) {
            return Some(format!(
                "{name}_head_pressure and {name}_rod_pressure seem to be in {unit}: the largest is {:.3}, and Pa is expected\n  \
                 what to do: write `unit = \"{unit}\"` for both in a signal map",
                self.largest
            ));
        }
        (self.carries >= FEWEST && 2 * self.by_rod > self.carries).then(|| {
            format!(
                "{name}_head_pressure and {name}_rod_pressure seem to be exchanged: the rod side seems to carry the {name}\n  \
                 what to do: exchange the two in the signal map; the head side has the larger area"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_in_degrees_are_named_one_by_one() {
        let mut angles = Angles::new(["boom_angle", "arm_angle"]);
        (0..200).for_each(|_| angles.see([Some(0.8), Some(-103.0)]));
        assert!(
            angles
                .fault()
                .is_some_and(|said| said.starts_with("arm_angle seems"))
        );
        let mut angles = Angles::new(["boom_angle", "arm_angle"]);
        (0..200).for_each(|k| angles.see([(k > 100).then_some(0.8), Some(6.0)]));
        assert_eq!(angles.fault(), None);
    }

    /// What is said of a boom that is raised and lowered.
    fn said(unit: f64, sides: [usize; 2]) -> Option<String> {
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
        assert_eq!(said(1.0, [0, 1]), None);
        for (unit, name) in [(1e5, "bar"), (1e6, "MPa"), (1e3, "kPa"), (6894.76, "psi")] {
            let said = said(unit, [0, 1]).unwrap_or_default();
            assert!(said.contains(&format!("unit = \"{name}\"")), "{said}");
        }
        assert!(said(1.0, [1, 0]).is_some_and(|said| said.contains("exchanged")));
        // No sensor, and an arm that lies.
        assert_eq!(said(1e9, [0, 1]), None);
        assert_eq!(said(10.0, [1, 0]), None);
    }
}
