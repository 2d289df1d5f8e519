//! What a description states: the keys with another value than heft takes where nobody says anything.

use std::collections::BTreeMap;

use messages::Machine;

use crate::renamed::today;
use crate::{Keyed, known, print};

/// The stated keys with their values in TOML. A key is stated where the defaults of the machine's size, without it, have
/// another value: what follows from a stated operating mass is not.
pub(crate) fn stated<M: Keyed>(machine: &M) -> BTreeMap<&'static str, String> {
    let plain = M::default();
    let mut found = BTreeMap::new();
    for (at, (table, plain)) in machine.tables().iter().zip(plain.tables()).enumerate() {
        for (index, key) in table.keys().iter().enumerate() {
            let (Some(value), Some(default)) = (table.get(index), plain.get(index)) else {
                continue;
            };
            let mut without = machine.clone();
            without.tables_mut()[at].set(index, &default);
            if without.of_its_size().tables()[at].get(index) != Some(value) {
                found.insert(key.path, print::toml(&value));
            }
        }
    }
    found
}

/// The keys that one version of a description states otherwise than an earlier one, which any version of heft may have
/// written: old names count, and a key that this version does not have cannot differ.
pub(crate) fn changed(
    machine: Machine,
    now: &BTreeMap<&'static str, String>,
    earlier: &BTreeMap<String, String>,
) -> Vec<String> {
    let earlier: BTreeMap<&str, &String> = earlier.iter().map(|(k, v)| (today(k), v)).collect();
    let mut keys = known::all_keys(machine);
    keys.retain(|key| earlier.get(key.as_str()).copied() != now.get(key.as_str()));
    keys
}
