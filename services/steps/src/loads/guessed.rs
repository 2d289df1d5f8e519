//! Texts about numbers that a machine file leaves open and that cause a common error of all loads.

use config::{Description, Excavator, Loader};
use estimation::HALF_WIDTH_95;
use estimation::loads::{Load, Witness};

/// Share of a load below which the place of a loader's tilt cylinder does not matter.
const NO_MATTER: f64 = 0.02;
/// Mean weight of emptied buckets, as a share of a full load, above which the bucket may be heavier than described. Soil that stays is
/// half of it. Least number of emptied buckets for this mean: [`EMPTIED`].
const SHOWN_EMPTY: f64 = 0.03;
const EMPTIED: usize = 2;

/// Names the open numbers, the width that they give the loads, and what to state; `None` where all are stated.
pub fn guessed(description: &Description) -> Option<String> {
    match description {
        Description::Excavator(d) => guessed_lengths(d),
        Description::Loader(d) => match (guessed_masses(d), tilt_cylinder(d)) {
            (Some(masses), Some(tilt)) => Some(format!("{masses} {tilt}")),
            (masses, tilt) => masses.or(tilt),
        },
    }
}

/// Names the masses and distances of a loader's lift arm that are guessed from the size of the machine.
fn guessed_masses(d: &Loader) -> Option<String> {
    let (arm, cylinder) = (&d.lift_arm, &d.lift_cylinder);
    let is_used = arm.length > 0.0 && cylinder.head_area > 0.0;
    let is_calibrated = cylinder.span_std > 0.0 || cylinder.force_offset_std > 0.0;
    let numbers = [
        ("bucket_mass", arm.bucket_mass),
        ("mass", arm.mass),
        ("mass_distance", arm.mass_distance),
        ("payload_distance", arm.payload_distance),
    ];
    let open = numbers.iter().filter(|(_, value)| *value == 0.0);
    let open: Vec<&str> = open.map(|(key, _)| *key).collect();
    (is_used && !is_calibrated && !open.is_empty()).then(|| {
        format!(
            "All loads may be too heavy or too light alike: heft guesses {} of machine.lift_arm from the machine's size. Weigh or measure \
             them, and state them in the machine file.",
            open.join(", ")
        )
    })
}

/// Asks for the place of a loader's tilt cylinder, where it is not stated and matters.
fn tilt_cylinder(d: &Loader) -> Option<String> {
    let share = d.tilt_cylinder_share();
    let by = match d.lift_arm.payload_distance {
        0.0 => String::new(),
        _ if share < NO_MATTER => return None,
        _ => format!(", by {:.0} %", 100.0 * share),
    };
    d.leaves_tilt_cylinder_open().then(|| {
        format!(
            "All loads may be too heavy or too light alike{by}: nothing says where the tilt cylinder sits, on the arm or on the frame. State \
             machine.lift_arm.bucket_turn in the machine file, or lift a weighed load (heft calibrate)."
        )
    })
}

/// Reports emptied buckets of a loader with rated payload `rated` [kg] that weigh more than soil does.
pub fn shown_empty<'a>(loads: impl Iterator<Item = &'a Load>, rated: f64) -> Option<String> {
    let (mut count, mut sum) = (0, 0.0);
    for load in loads.filter(|load| load.is_emptied && load.witness == Witness::Pressure) {
        count += 1;
        sum += load.carry_back.kg;
    }
    let mean = sum / count as f64;
    (count >= EMPTIED && mean > SHOWN_EMPTY * rated).then(|| {
        format!(
            "{count} emptied buckets show {mean:.0} kg on average: soil that stays in them, or a bucket heavier than \
             machine.lift_arm.bucket_mass, and loads too heavy by a part of it. Clean the bucket, or weigh it."
        )
    })
}

/// Names the guessed lengths of an excavator.
fn guessed_lengths(d: &Excavator) -> Option<String> {
    let of_class = of_class(d).geometry;
    // A stated tolerance covers the lengths.
    let tolerance = d.of_its_size().machine.geometry_tolerance;
    let is_doubted = tolerance > Excavator::default().machine.geometry_tolerance
        && d.machine.geometry_tolerance == tolerance;
    let lengths = [
        (
            is_doubted && d.geometry.boom_length == of_class.boom_length,
            "machine.geometry.boom_length (boom foot to arm pin)",
        ),
        (
            is_doubted && d.geometry.arm_length == of_class.arm_length,
            "machine.geometry.arm_length (arm pin to bucket pin)",
        ),
        (
            d.guessed_radius_std() > 0.0,
            "machine.geometry.boom_pin (swing axis to boom foot, horizontal)",
        ),
        (
            d.geometry.payload_centre_std.is_none() && d.load_centre_share() > 0.0,
            "machine.geometry.payload_centre (bucket pin to the middle of a load)",
        ),
        (
            d.guessed_form_std() > 0.0,
            "boom_centre, boom_rise, bucket_centre, bucket_rise (centres of mass along and beside the lines of the pins)",
        ),
    ];
    let keys: Vec<&str> = lengths
        .iter()
        .filter(|(is_guessed, _)| *is_guessed)
        .map(|(_, key)| *key)
        .collect();
    let full = d.prior.full_load();
    let percent = 100.0 * HALF_WIDTH_95 * d.loads_common().std(full) / full;
    (!keys.is_empty()).then(|| {
        format!(
            "All loads may be too heavy or too light alike, up to {percent:.0} % of a full one (95 %): lengths are guessed from the \
             operating mass. Measure and state in the machine file: {}; or weigh one load (heft calibrate).",
            keys.join(", ")
        )
    })
}

/// The machine with only the operating mass stated.
fn of_class(d: &Excavator) -> Excavator {
    let mut class = Excavator::default();
    class.machine.operating_mass = d.machine.operating_mass;
    class.of_its_size()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(keys: &str) -> Option<String> {
        let text = format!("[machine]\nkind = \"excavator\"\n{keys}");
        let description = Description::parse(&text, "test", None).expect("a description");
        let written = Description::parse(&description.to_toml(), "test", None).expect("the same");
        assert_eq!(guessed(&written), guessed(&description));
        guessed(&description)
    }

    const FIVE: &str = "operating_mass = 21500\nrated_payload = 1900\nswing_torque = 68000\n\
        [machine.geometry]\nboom_length = 5.7\narm_length = 2.9\n";

    #[test]
    fn five_numbers_leave_the_boom_pin_to_a_guess_and_six_the_load_s_centre() {
        let words = of(FIVE).expect("a guess");
        assert!(
            words.contains("machine file: machine.geometry.boom_pin"),
            "{words}"
        );
        let six = of(&format!("{FIVE}boom_pin = 0.2\n")).expect("a guess");
        assert!(
            !six.contains("boom_pin") && six.contains("payload_centre"),
            "{six}"
        );
        let seven = format!("{FIVE}boom_pin = 0.2\npayload_centre = 0.9\n");
        let open = of(&seven).expect("a guess");
        assert!(open.contains("file: boom_centre, boom_rise"), "{open}");
        let drawing = "boom_centre = 2.7\nboom_rise = 0.4\n";
        assert_eq!(of(&format!("{seven}{drawing}")), None);
        assert_eq!(of(""), None, "the reference machine");
    }

    #[test]
    fn a_loader_s_tilt_cylinder_is_asked_for_where_an_arm_is_described() {
        let of = |keys: &str| {
            let text = format!("[machine]\nkind = \"loader\"\n{keys}");
            guessed(&Description::parse(&text, "test", None).expect("a description"))
        };
        assert_eq!(of(""), None, "no arm");
        let arm = "[machine.lift_arm]\nlength = 2.6\n";
        assert!(of(arm).is_some_and(|words| words.contains("bucket_turn")));
        assert_eq!(of(&format!("{arm}bucket_turn = 0.2\n")), None);
        let words = of(&format!("{arm}payload_distance = 0.6\n"));
        assert!(words.is_some_and(|words| words.contains("alike, by 9 %: nothing")));
        let drawn = format!(
            "{arm}bucket_turn = 0.2\npayload_distance = 0.6\nmass = 700\nmass_distance = 1.4\n[machine.lift_arm.cylinder]\nhead_area = 0.004\n"
        );
        let words = of(&drawn).unwrap_or_default();
        assert!(
            words.contains("guesses bucket_mass of machine.lift_arm"),
            "{words}"
        );
        let at_the_pin = format!("{arm}payload_distance = 0.1\n");
        assert_eq!(of(&at_the_pin), None, "it is all the same");
    }

    #[test]
    fn emptied_buckets_that_show_more_than_soil_may_be_heavier_ones() {
        let reported = |kg: &[f64]| {
            let loads: Vec<Load> = kg
                .iter()
                .map(|kg| {
                    let mut load = Load {
                        is_emptied: true,
                        witness: Witness::Pressure,
                        ..Load::default()
                    };
                    load.carry_back.kg = *kg;
                    load
                })
                .collect();
            shown_empty(loads.iter(), 4000.0)
        };
        let heavier = reported(&[170.0, 160.0, 110.0]);
        assert!(heavier.is_some_and(|words| words.contains("3 emptied buckets show 147 kg")));
        assert_eq!(reported(&[50.0, 20.0]), None, "soil");
        assert_eq!(reported(&[300.0]), None, "once is no machine");
    }

    #[test]
    fn a_class_alone_names_all_three_lengths_and_a_stated_tolerance_answers_for_two() {
        let words = of("operating_mass = 21500\n").expect("a guess");
        for key in ["boom_length", "arm_length", "boom_pin"] {
            assert!(words.contains(key), "{key}: {words}");
        }
        let words = of("operating_mass = 21500\ngeometry_tolerance = 0.01\n").expect("a guess");
        assert!(!words.contains("boom_length"), "{words}");
    }
}
