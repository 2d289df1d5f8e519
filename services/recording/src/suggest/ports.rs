//! Two pressures of the swing motor, in a table, on a bus or in topics: their difference times the displacement is the torque.

use super::languages::english;
use super::names::{is_pressure, may_be, wanted};
use crate::signal::Sensors;

/// Two free `names` that are such pressures, if no signal is the torque.
pub(crate) fn pair<S: Sensors>(
    names: &[&str],
    taken: &[usize],
    found: &[String],
) -> Option<[usize; 2]> {
    let is_torque = |signal: &String| signal == "swing_torque";
    let is_open = wanted::<S>().iter().any(is_torque) && !found.iter().any(is_torque);
    let is_port = |at: &usize| {
        let name = english(names[*at]);
        name.contains("swing") && is_pressure(&name) && may_be("swing_pressure", &name)
    };
    let free = (0..names.len()).filter(|at| is_open && !taken.contains(at));
    let ports: Vec<usize> = free.filter(is_port).collect();
    ports.try_into().ok()
}

/// A line of a map as a comment, if two free `names` are such pressures and no signal is the torque.
/// `term` gives a name's place as a term of a map, with this text in its braces.
pub(crate) fn ports<S: Sensors>(
    (names, taken, found): (&[&str], &[usize], &[String]),
    term: impl Fn(usize, &str) -> String,
) -> String {
    let Some([a, b]) = pair::<S>(names, taken, found) else {
        return String::new();
    };
    let (a, b) = (term(a, ""), term(b, ", sign = -1"));
    format!(
        "# swing_torque = {{ terms = [{a}, {b}], scale = SCALE }}  # SCALE by the motor's displacement and gear: docs/map.md\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorSensors, LoaderSensors};

    #[test]
    fn two_pressures_of_the_swing_motor_are_its_torque_where_no_torque_is() {
        let bus = ["Swing.MotorPressA", "Swing.MotorPressB", "Boom.HeadPress"];
        let term = |at: usize, sign: &str| format!("{{ {}{sign} }}", bus[at]);
        let line = ports::<ExcavatorSensors>((&bus, &[2], &[]), term);
        assert!(
            line.starts_with(
                "# swing_torque = { terms = [{ Swing.MotorPressA }, { Swing.MotorPressB, sign = -1 }], scale = SCALE }"
            ),
            "{line}"
        );
        let topics = ["/swing/a fluid_pressure", "/swing/b fluid_pressure"];
        assert!(!ports::<ExcavatorSensors>((&topics, &[], &[]), term).is_empty());
        let found = ["swing_torque".to_owned()];
        assert_eq!(ports::<ExcavatorSensors>((&bus, &[], &found), term), "");
        assert_eq!(ports::<ExcavatorSensors>((&bus, &[0], &[]), term), "");
        assert_eq!(ports::<LoaderSensors>((&bus, &[], &[]), term), "");
    }
}
