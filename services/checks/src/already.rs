//! Advice on a signal map that already contains the advised line.

use recording::Map;

/// The remedy of a fault, where the map already contains the advised line.
pub fn advised(fault: String, map: Option<&Map>) -> String {
    let Some((map, (said, names))) = map.zip(advice(&fault)) else {
        return fault;
    };
    let has = |name: &str| map.said(name).iter().any(|line| line == said);
    let is_sign = said.starts_with("sign");
    let write = format!("write `{said}`");
    if names.iter().all(|name| has(name)) {
        let instead = match is_sign {
            true => format!("remove `{said}`"),
            false => format!("find the unit of the column, which is not `{said}`, and write it"),
        };
        return fault.replace(&write, &instead);
    }
    // Torque and velocity are compared with each other.
    if is_sign && names == ["swing_torque"] && has("swing_velocity") {
        return format!("{fault}; or remove it for swing_velocity");
    }
    fault
}

/// The line that a fault advises, and the signals for which.
fn advice(fault: &str) -> Option<(&str, Vec<&str>)> {
    let (_, advice) = fault.split_once("write `")?;
    let (said, after) = advice.split_once("` for ")?;
    let (names, _) = after.split_once(" in a signal map")?;
    let names = names.split(", ").flat_map(|names| names.split(" and "));
    Some((said, names.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(map: &str, fault: &str) -> String {
        let map = Map::parse(&format!("[columns]\n{map}\n"), "map.toml").expect("a map");
        advised(fault.into(), Some(&map))
    }

    const SIGN: &str = "x\n  what to do: write `sign = -1` for swing_torque in a signal map";

    #[test]
    fn a_sign_that_the_map_has_is_removed_and_not_written_again() {
        assert_eq!(said("swing_torque = \"m\"", SIGN), SIGN);
        let there = said("swing_torque = { column = \"m\", sign = -1 }", SIGN);
        assert!(
            there.contains("remove `sign = -1` for swing_torque"),
            "{there}"
        );
        let other = said("swing_velocity = { column = \"v\", sign = -1 }", SIGN);
        assert!(
            other.ends_with("; or remove it for swing_velocity"),
            "{other}"
        );
    }

    #[test]
    fn a_unit_that_the_map_has_is_another_one() {
        let fault = "x\n  what to do: write `unit = \"rpm\"` for front_wheel_speed and rear_wheel_speed in a signal map";
        let one = "front_wheel_speed = { column = \"f\", unit = \"rpm\" }";
        assert_eq!(said(one, fault), fault);
        let both = format!("{one}\nrear_wheel_speed = {{ column = \"r\", unit = \"rpm\" }}");
        let there = said(&both, fault);
        assert!(there.contains("which is not `unit = \"rpm\"`"), "{there}");
    }
}
