//! Renamed keys: files, recordings and options with the old name are still read.

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

/// The present name of a renamed key; `None` for every other.
pub fn renamed(key: &str) -> Option<&'static str> {
    let found = RENAMED.iter().find(|(old, _)| *old == key);
    found.map(|(_, today)| *today)
}

/// The present name of any key.
pub(crate) fn today(key: &str) -> &str {
    renamed(key).unwrap_or(key)
}

/// The old names that a description uses; none for a text that is not TOML.
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
