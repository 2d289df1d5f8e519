//! Keys of earlier versions: files and recordings with them are still read.

use messages::Machine;
use toml_edit::{Document, Item};

/// Old and present name, each with its table.
const RENAMED: [(&str, &str); 2] = [
    (
        "sensors.slope_follows",
        "sensors.slope_acceleration_sensitivity",
    ),
    (
        "sensors.slope_follows_std",
        "sensors.slope_acceleration_sensitivity_std",
    ),
];

/// Keys and tables without a successor, left out where a file has them.
const RETIRED: [(Machine, &str); 4] = [
    // Of a variant of `posture-torque` that the default replaced.
    (Machine::Excavator, "estimator.drop_q_m"),
    // The boom's cylinder alone weighs the load.
    (Machine::Excavator, "machine.arm_cylinder"),
    // The rod side's force is at most a tenth of the head side's.
    (Machine::Excavator, "machine.boom_cylinder.rod_area_std"),
    // White noise of a pressure is negligible beside the friction of the seals.
    (Machine::Excavator, "sensors.pressure_std"),
];

/// Whether a key or a table of this machine has no effect any more.
pub fn is_retired(machine: Machine, path: &str) -> bool {
    let is_in = |table: &str| {
        path.strip_prefix(table)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    RETIRED
        .iter()
        .any(|(of, retired)| *of == machine && is_in(retired))
}

/// The present name of a renamed key; `None` for every other.
pub fn renamed(key: &str) -> Option<&'static str> {
    let found = RENAMED.iter().find(|(old, _)| *old == key);
    found.map(|(_, today)| *today)
}

/// The present name of any key.
pub(crate) fn today(key: &str) -> &str {
    renamed(key).unwrap_or(key)
}

/// The renamed and the retired keys that a machine's description uses; none for a text that is not TOML.
pub fn old_names(machine: Machine, text: &str) -> Vec<&'static str> {
    let Ok(document) = Document::parse(text) else {
        return Vec::new();
    };
    let is_used = |old: &&str| {
        let mut path = old.split('.');
        let first = path.next().and_then(|name| document.get(name));
        let found: Option<&Item> = path.fold(first, |item, name| item?.get(name));
        found.is_some()
    };
    let retired = RETIRED.iter().filter(|(of, _)| *of == machine);
    let old = RENAMED
        .iter()
        .map(|(old, _)| *old)
        .chain(retired.map(|(_, old)| *old));
    old.filter(is_used).collect()
}
