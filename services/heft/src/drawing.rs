//! Checks a machine file for geometric contradictions: each number is in its range, and two of them exclude each other.

use core::f64::consts::PI;

use config::Description;

/// Key of the smaller number, key of the larger number, and why. An unstated number is 0 or that of the machine's size.
const ORDERS: &[(&str, &str, &str)] = &[
    (
        "machine.boom_cylinder.rod_area",
        "machine.boom_cylinder.head_area",
        ROD,
    ),
    (
        "machine.lift_arm.cylinder.rod_area",
        "machine.lift_arm.cylinder.head_area",
        ROD,
    ),
    (
        "machine.geometry.arm_length",
        "machine.geometry.boom_length",
        "a boom is longer than its arm",
    ),
    (
        "machine.geometry.boom_centre",
        "machine.geometry.boom_length",
        CENTRE,
    ),
    (
        "machine.geometry.arm_centre",
        "machine.geometry.arm_length",
        CENTRE,
    ),
    (
        "machine.lift_arm.mass_distance",
        "machine.lift_arm.length",
        CENTRE,
    ),
];

const ROD: &str = "the rod takes a part of the bore";
const CENTRE: &str = "the centre of mass lies between the pins";

/// Keys of an area, and of the distance of its cylinder's base from the pivot.
const BORES: &[(&str, &str)] = &[
    (
        "machine.boom_cylinder.head_area",
        "machine.boom_cylinder.base_distance",
    ),
    (
        "machine.lift_arm.cylinder.head_area",
        "machine.lift_arm.cylinder.base_distance",
    ),
];

/// Largest ratio of a bore to the distance from the pivot to the cylinder's base: .03 to .10 on independent recordings, .19 in the
/// example of the documents.
const WIDEST: f64 = 0.5;

/// Contradictions and implausible numbers of a machine file.
pub fn contradictions(description: &Description) -> Vec<String> {
    let stated = |key: &str| description.number(key).filter(|number| *number > 0.0);
    let orders = ORDERS.iter().filter_map(|(small, large, why)| {
        let (low, high) = (stated(small)?, stated(large)?);
        (low > high).then(|| format!("{small} is {low} and {large} {high}, but {why}: check both"))
    });
    let bores = BORES.iter().filter_map(|(area, base)| {
        let (area_m2, base_m) = (stated(area)?, stated(base)?);
        let bore = (4.0 * area_m2 / PI).sqrt();
        (bore > WIDEST * base_m).then(|| {
            format!(
                "{area} is {area_m2}, a bore of {:.0} mm, and {base} {base_m}: check both; the area is that of one cylinder, \
                 π D²/4 of the bore D",
                1e3 * bore
            )
        })
    });
    orders.chain(bores).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Machine;

    fn said(machine: Machine, text: &str) -> String {
        let description = Description::parse(text, "x", Some(machine)).expect("in their ranges");
        contradictions(&description).join("\n")
    }

    #[test]
    fn a_drawing_that_cannot_be_is_named_and_one_that_can_is_not() {
        let excavator = |rest: &str| {
            let text = format!("[machine]\noperating_mass = 17000\n{rest}");
            said(Machine::Excavator, &text)
        };
        let sound = "[machine.geometry]\nboom_length = 5.2\narm_length = 2.6\n[machine.boom_cylinder]\n\
                     base_distance = 0.62\nrod_distance = 1.35\nhead_area = 0.01039\nrod_area = 0.0054\n";
        assert_eq!(excavator(sound), "");
        assert_eq!(excavator(""), "");
        for (right, wrong, key) in [
            (
                "head_area = 0.01039",
                "head_area = 0.0039",
                "boom_cylinder.rod_area",
            ),
            (
                "head_area = 0.01039",
                "head_area = 0.115",
                "a bore of 383 mm",
            ),
            (
                "boom_length = 5.2",
                "boom_length = 2.2",
                "geometry.arm_length",
            ),
            (
                "arm_length = 2.6",
                "arm_length = 2.6\narm_centre = 9.0",
                "geometry.arm_centre",
            ),
        ] {
            let said = excavator(&sound.replace(right, wrong));
            assert!(said.contains(key), "{wrong}: {said}");
        }
        let arm = "[machine.lift_arm]\nlength = 2.68\nmass_distance = 3.1\n";
        assert!(said(Machine::Loader, arm).contains("mass_distance"));
        for machine in Machine::ALL {
            assert_eq!(contradictions(&Description::default_of(machine)), [""; 0]);
        }
    }
}
