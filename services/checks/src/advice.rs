//! Advice to write a line into a signal map, and what it becomes where the map already contains the line.

use recording::{Finding, Map};

/// The advice to state the unit of these signals, "a, b and c" or one of them.
pub fn write_unit(unit: &str, signals: &str) -> String {
    write(&format!("unit = \"{unit}\""), signals)
}

/// The advice to change the sign of these signals.
pub fn write_sign(signals: &str) -> String {
    write("sign = -1", signals)
}

fn write(line: &str, signals: &str) -> String {
    format!("write `{line}` for {signals} in a signal map")
}

/// The fault with the remedy that helps where the map already contains the advised line.
pub fn advised(fault: Finding, map: Option<&Map>) -> Finding {
    let instead = map.and_then(|map| instead(&fault.remedy, map));
    match instead {
        Some(remedy) => Finding { remedy, ..fault },
        None => fault,
    }
}

/// The remedy in place of one that advises a line, which this map already contains.
fn instead(remedy: &str, map: &Map) -> Option<String> {
    let (said, names) = advised_line(remedy)?;
    let has = |name: &str| map.said(name).iter().any(|line| line == said);
    let is_sign = said.starts_with("sign");
    let write = format!("write `{said}`");
    if names.iter().all(|name| has(name)) {
        let instead = match is_sign {
            true => format!("remove `{said}`"),
            false => format!("find the unit of the column, which is not `{said}`, and write it"),
        };
        return Some(remedy.replace(&write, &instead));
    }
    // Torque and velocity are compared with each other.
    let of_two = is_sign && names == ["swing_torque"] && has("swing_velocity");
    of_two.then(|| format!("{remedy}; or remove it for swing_velocity"))
}

/// The line that a remedy advises to [`write`], and the signals for which.
fn advised_line(remedy: &str) -> Option<(&str, Vec<&str>)> {
    let (_, advice) = remedy.split_once("write `")?;
    let (said, after) = advice.split_once("` for ")?;
    let (names, _) = after.split_once(" in a signal map")?;
    let names = names.split(", ").flat_map(|names| names.split(" and "));
    Some((said, names.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(map: &str, remedy: &str) -> String {
        let map = Map::parse(&format!("[columns]\n{map}\n"), "map.toml").expect("a map");
        advised(Finding::new("x", remedy), Some(&map)).remedy
    }

    #[test]
    fn a_sign_that_the_map_has_is_removed_and_not_written_again() {
        let sign = &write_sign("swing_torque");
        assert_eq!(&said("swing_torque = \"m\"", sign), sign);
        let there = said("swing_torque = { column = \"m\", sign = -1 }", sign);
        assert!(
            there.contains("remove `sign = -1` for swing_torque"),
            "{there}"
        );
        let other = said("swing_velocity = { column = \"v\", sign = -1 }", sign);
        assert!(
            other.ends_with("; or remove it for swing_velocity"),
            "{other}"
        );
    }

    #[test]
    fn a_unit_that_the_map_has_is_another_one() {
        let fault = &write_unit("rpm", "front_wheel_speed and rear_wheel_speed");
        let one = "front_wheel_speed = { column = \"f\", unit = \"rpm\" }";
        assert_eq!(&said(one, fault), fault);
        let both = format!("{one}\nrear_wheel_speed = {{ column = \"r\", unit = \"rpm\" }}");
        let there = said(&both, fault);
        assert!(there.contains("which is not `unit = \"rpm\"`"), "{there}");
    }
}
