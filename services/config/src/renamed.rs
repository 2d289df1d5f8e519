//! Keys that had another name: files, recordings and options that use it are still read.

use toml_edit::{Document, Item};

/// The old name and that of today, each with its table.
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

/// The name of today of a key that has been renamed; `None` for every other.
pub fn renamed(key: &str) -> Option<&'static str> {
    let found = RENAMED.iter().find(|(old, _)| *old == key);
    found.map(|(_, today)| *today)
}

/// The name of today of any key.
pub(crate) fn today(key: &str) -> &str {
    renamed(key).unwrap_or(key)
}

/// The old names that a description uses; none of a text that is no TOML.
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
    RENAMED
        .map(|(old, _)| old)
        .into_iter()
        .filter(is_used)
        .collect()
}
