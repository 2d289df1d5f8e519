//! Keys of earlier versions: files and recordings with them are still read.

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

/// Keys without a successor, left out where a file has them. `drop_q_m` belonged to a variant of `posture-torque` that the default replaced.
const RETIRED: [&str; 1] = ["estimator.drop_q_m"];

/// Whether a key had an effect in earlier versions only.
pub(crate) fn is_retired(key: &str) -> bool {
    RETIRED.contains(&key)
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

/// The renamed and the retired keys that a description uses; none for a text that is not TOML.
pub fn old_names(text: &str) -> Vec<&'static str> {
    let Ok(document) = Document::parse(text) else {
        return Vec::new();
    };
    let is_used = |old: &&str| {
        let mut path = old.split('.');
        let first = path.next().and_then(|name| document.get(name));
        let found: Option<&Item> = path.fold(first, |item, name| item?.get(name));
        found.is_some()
    };
    let old = RENAMED.iter().map(|(old, _)| *old).chain(RETIRED);
    old.filter(is_used).collect()
}
