//! Pressures of cylinders whose names leave open which cylinder or which side they are of: lines of a map as comments, to be decided.

use std::fmt::Write;

use super::languages::english;
use super::names::{is_pressure, may_be, wanted};
use crate::signal::Sensors;
use crate::unit;

/// Beginnings of the signals of a cylinder, the words of its link, and whether its head side carries the load.
const CYLINDERS: [(&str, &[&str], bool); 3] = [
    ("boom", &["boom"], true),
    ("arm", &["arm", "stick", "dipper"], false),
    ("lift", &["lift", "hoist", "boom"], true),
];

/// Words of other pressures.
const OTHERS: &[&str] = &[
    "swing",
    "pump",
    "travel",
    "track",
    "steer",
    "brake",
    "tilt",
    "bucket",
    "supply",
    "tank",
    "system",
    "engine",
    "oil",
    "fuel",
    "air",
    "atmospheric",
    "ambient",
    "boost",
    "fan",
    "difference",
    "diff",
    "delta",
];

/// A column that may be a pressure of a cylinder.
struct Candidate {
    at: usize,
    words: Vec<String>,
}

impl Candidate {
    fn has(&self, words: &[&str]) -> bool {
        self.words.iter().any(|word| words.contains(&word.as_str()))
    }
}

/// Lines for signals that were not found and may be among the free columns. `usual` is the usual pressure of a column, `column`
/// its text in a map.
pub(super) fn sides<S: Sensors>(
    (names, taken, found): (&[&str], &[usize], &[String]),
    usual: impl Fn(usize) -> f64,
    column: impl Fn(usize) -> String,
) -> String {
    let wanted = wanted::<S>();
    let free = (0..names.len()).filter(|at| !taken.contains(at));
    let mut free: Vec<Candidate> = free
        .filter(|at| is_pressure(names[*at]) && may_be("pressure", names[*at]))
        .map(|at| Candidate {
            at,
            words: words(names[at]),
        })
        .filter(|column| !column.has(OTHERS))
        .collect();
    let mut out = String::new();
    for (cylinder, link, carries) in CYLINDERS {
        let missing: Vec<String> = ["head", "rod"]
            .map(|side| format!("{cylinder}_{side}_pressure"))
            .into_iter()
            .filter(|signal| wanted.contains(signal) && !found.contains(signal))
            .collect();
        let of_link = |column: &&Candidate| column.has(link);
        let named: Vec<usize> = free.iter().filter(of_link).map(|c| c.at).collect();
        let mut line = |signal: &String, at: usize, why: &str| {
            let _ = writeln!(out, "# {signal} = {}  # {why}", column(at));
        };
        match (&missing[..], &named[..]) {
            ([head, rod], [a, b]) => {
                let is_second = carries && usual(*b) > usual(*a);
                let [first, second] = if is_second { [*b, *a] } else { [*a, *b] };
                let why = match carries {
                    true => {
                        "which side? The head carries the load: it has the larger pressure at rest, as here"
                    }
                    false => {
                        "which side? See the drawing of the cylinder: the head is the side without the rod"
                    }
                };
                line(head, first, why);
                line(rod, second, "the other side of this cylinder");
            }
            ([one], [at]) => line(one, *at, "the other side of this cylinder?"),
            ([head, _], [at]) => line(
                head,
                *at,
                "which side? The head is the side without the rod",
            ),
            _ => {}
        }
        free.retain(|column| !named.contains(&column.at));
        // A side without a link is of the cylinder that carries the load, if of any.
        let links: Vec<&str> = CYLINDERS.iter().flat_map(|c| c.1).copied().collect();
        for signal in missing.iter().filter(|_| carries && named.is_empty()) {
            let side = if signal.contains("head") {
                "head"
            } else {
                "rod"
            };
            let mut bare = free.iter().filter(|c| c.has(&[side]) && !c.has(&links));
            if let (Some(only), None) = (bare.next(), bare.next()) {
                line(signal, only.at, &format!("of the {cylinder} cylinder?"));
            }
        }
    }
    out
}

/// The words of a name, in English.
fn words(name: &str) -> Vec<String> {
    let name = english(&unit::words(name).join(" "));
    let words = unit::words(&name).into_iter();
    words.map(str::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorSensors, LoaderSensors};

    fn said<S: Sensors>(names: &[&str], found: &[&str]) -> String {
        let found: Vec<String> = found.iter().map(|f| (*f).to_owned()).collect();
        let column = |at: usize| names[at].to_owned();
        // The later column has the larger pressure.
        sides::<S>((names, &[], &found), |at| at as f64, column)
    }

    #[test]
    fn two_ports_of_a_cylinder_are_offered_and_the_larger_pressure_as_its_head() {
        let text = said::<ExcavatorSensors>(&["boom_cyl_A_bar", "boom_cyl_B_bar"], &[]);
        for line in [
            "# boom_head_pressure = boom_cyl_B_bar  # which side?",
            "# boom_rod_pressure = boom_cyl_A_bar  # the other side",
        ] {
            assert!(text.contains(line), "{text}");
        }
        let text = said::<ExcavatorSensors>(&["arm_cyl_A_bar", "arm_cyl_B_bar"], &[]);
        assert!(
            text.contains("# arm_head_pressure = arm_cyl_A_bar"),
            "{text}"
        );
        let text = said::<LoaderSensors>(&["LiftCylPrs_bar"], &["lift_rod_pressure"]);
        assert!(
            text.starts_with("# lift_head_pressure = LiftCylPrs_bar"),
            "{text}"
        );
    }

    #[test]
    fn a_side_of_no_named_cylinder_is_asked_for() {
        let text = said::<ExcavatorSensors>(&["p_head_bar", "p_rod_bar"], &[]);
        for line in [
            "# boom_head_pressure = p_head_bar  # of the boom cylinder?",
            "# boom_rod_pressure = p_rod_bar  # of the boom cylinder?",
        ] {
            assert!(text.contains(line), "{text}");
        }
        assert_eq!(text.lines().count(), 2, "{text}");
        let text = said::<LoaderSensors>(&["p_head_bar"], &[]);
        assert!(
            text.starts_with("# lift_head_pressure = p_head_bar"),
            "{text}"
        );
        let others = ["Pump F press. (MPa)", "tilt_head_bar", "boom_cmd_bar"];
        assert_eq!(said::<LoaderSensors>(&others, &[]), "");
        let found = ["boom_head_pressure", "boom_rod_pressure"];
        assert_eq!(said::<ExcavatorSensors>(&["p_head_bar"], &found), "");
    }
}
