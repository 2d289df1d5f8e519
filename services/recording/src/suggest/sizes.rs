//! Units by the largest values, for pressures and torques whose columns name none.

use crate::time_unit::rounded;
use crate::unit::{self, Unit};

/// Ranges of the largest pressure of a recording, each up to the limit, with the unit of the data: pumps of excavators and loaders give
/// 20 to 40 MPa, and work needs a part of it. Values of the last range are in Pa; below the first limit no pressure was measured. No
/// machine has more than 70 MPa: relief valves open at 35 to 42.
pub const LARGEST_PRESSURES: [(f64, Option<&str>); 6] = [
    (1.0, None),
    (47.0, Some("MPa")),
    (560.0, Some("bar")),
    (6e3, Some("psi")),
    (1e5, Some("kPa")),
    (7e7, None),
];

/// Largest torques of swing drives are 1.5 kN m (1 t) to 700 kN m (100 t). Below the first limit, torques in N m would move no machine;
/// above the second one, torques in kN m exceed any machine's. Between the limits both units are possible.
const TORQUES: [f64; 2] = [200.0, 1000.0];

/// Rows per disturbance: a share of 1/100 may be disturbed.
const DISTURBED: usize = 100;

/// No number of a machine is as large in any unit: a logger's mark of a missing sample.
const MARK: f64 = 1e15;

/// The largest value that is no disturbance and no mark of a missing sample.
pub(super) fn largest<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(|x| x.abs()).filter(|x| *x < MARK).collect();
    sizes.sort_by(f64::total_cmp);
    let at = sizes.len().saturating_sub(1 + sizes.len() / DISTURBED);
    sizes.get(at).copied().unwrap_or(0.0)
}

/// The unit of pressures whose largest is this, and why.
pub(super) fn pressure(largest: f64) -> (Option<&'static Unit>, String) {
    let place = LARGEST_PRESSURES.iter().find(|(end, _)| largest < *end);
    let size = rounded(largest);
    match place {
        Some((_, Some(unit))) => (unit::find(unit), format!("pressures up to {size}: {unit}?")),
        Some(_) if largest >= 1.0 => (None, format!("pressures up to {size}: Pa?")),
        _ => (
            None,
            format!("pressures up to {size}, of which no unit is likely: taken as Pa, check it"),
        ),
    }
}

/// The unit of torques whose largest is this, and why.
pub(super) fn torque(largest: f64) -> (Option<&'static Unit>, String) {
    let size = rounded(largest);
    let [few, many] = TORQUES;
    match largest {
        x if x > 0.0 && x < few => (unit::find("kN m"), format!("up to {size}: kN m?")),
        x if x < many => (None, format!("up to {size}: N m or kN m? Check it")),
        _ => (None, format!("up to {size}: N m?")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_missing_samples_are_no_sizes_however_many_there_are() {
        let values = [30.0, -33.2, 1e308, 1e30, f64::INFINITY, f64::NAN];
        assert_eq!(largest(values.iter()), 33.2);
    }

    #[test]
    fn the_largest_pressure_identifies_its_unit() {
        let of = |largest: f64| pressure(largest).0.map_or("Pa", |unit| unit.name);
        // 21 MPa in each unit.
        for (factor, unit) in [
            (1.0, "Pa"),
            (1e3, "kPa"),
            (6894.76, "psi"),
            (1e5, "bar"),
            (1e6, "MPa"),
        ] {
            assert_eq!(of(21e6 / factor), unit);
        }
        assert!(pressure(0.3).1.contains("no unit is likely"));
        assert!(pressure(3e8).1.contains("no unit is likely"));
    }

    #[test]
    fn the_largest_torque_identifies_kilonewton_metres_where_it_can() {
        let of = |largest: f64| torque(largest).0.map_or("N m", |unit| unit.name);
        assert_eq!([9.8, 150.0, 9800.0].map(of), ["kN m", "kN m", "N m"]);
        assert!(torque(400.0).1.contains("N m or kN m"));
        assert_eq!(of(0.0), "N m");
    }

    #[test]
    fn one_value_in_a_hundred_is_no_size() {
        let values: Vec<f64> = (0..1000)
            .map(|k| if k % 200 == 0 { 1e9 } else { -3.0 })
            .collect();
        assert_eq!(largest(values.iter()), 3.0);
        assert_eq!(largest([].iter()), 0.0);
    }
}
