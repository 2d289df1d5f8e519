//! Stated keys of a description: those with another value than the default of a machine of its size.

use std::collections::BTreeMap;

use messages::Machine;

use crate::renamed::today;
use crate::{Key, Keyed, Value, known, print};

/// The stated keys with their values in TOML.
pub(crate) fn stated<M: Keyed>(machine: &M) -> BTreeMap<&'static str, String> {
    let tables = machine.tables();
    let chosen = places(machine).into_iter().filter(|place| place.1);
    let pairs = chosen.filter_map(|((at, index), _)| {
        let value = tables[at].get(index)?;
        Some((tables[at].keys()[index].path, print::toml(&value)))
    });
    pairs.collect()
}

/// Table and index of each key, and whether it is stated: whether its value differs from the default of the machine's size without
/// it. Values that follow from a stated operating mass are not stated.
pub(crate) fn places<M: Keyed>(machine: &M) -> Vec<((usize, usize), bool)> {
    let plain = M::default();
    let mut places = Vec::new();
    for (at, (table, plain)) in machine.tables().iter().zip(plain.tables()).enumerate() {
        for index in 0..table.keys().len() {
            let mut without = machine.clone();
            let is_stated = plain.get(index).is_some_and(|default| {
                without.tables_mut()[at].set(index, &default);
                without.of_its_size().tables()[at].get(index) != table.get(index)
            });
            places.push(((at, index), is_stated));
        }
    }
    places
}

/// The numbers that follow from the mass: they are not stated, and differ from those of a machine with unknown mass.
pub(crate) fn of_mass<M: Keyed>(machine: &M) -> Vec<(Key, f64)> {
    let (plain, tables) = (M::default(), machine.tables());
    let open = places(machine).into_iter().filter(|place| !place.1);
    let numbers = open.filter_map(|((at, index), _)| match tables[at].get(index)? {
        value if plain.tables()[at].get(index) == Some(value) => None,
        Value::Number(number) => Some((tables[at].keys()[index], number)),
        _ => None,
    });
    numbers.collect()
}

/// The keys with another stated value than in an earlier description, which any version of heft may have
/// written: old names count, and a key that this version does not have cannot differ.
pub(crate) fn changed(
    machine: Machine,
    now: &BTreeMap<&'static str, String>,
    earlier: &BTreeMap<String, String>,
) -> Vec<String> {
    let earlier: BTreeMap<&str, &String> = earlier.iter().map(|(k, v)| (today(k), v)).collect();
    let keys = known::keys(machine).into_iter();
    let differ = keys.filter(|key| earlier.get(*key).copied() != now.get(*key));
    differ.map(str::to_owned).collect()
}
