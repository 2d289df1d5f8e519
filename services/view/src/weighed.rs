//! What each bucket held, as the run counted it.

use std::collections::BTreeMap;

use messages::channels::{EXCAVATOR_LOADS, LOADER_LOADS};
use messages::{EXCAVATOR_REASONS, ExcavatorLoads, LOADER_REASONS, LoaderLoads, loads_bits};
use recording::{Error, Reader};
use sheet::loads::WITNESSES;

/// A load as the run reported it last.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadRow {
    /// From 1.
    pub number: u32,
    /// The truck that it was put on.
    pub truck: u32,
    /// What was in the bucket, and its standard deviation \[kg\].
    pub mass: (f64, f64),
    /// What stayed in it, and its standard deviation \[kg\].
    pub carry_back: (f64, f64),
    /// Since when the bucket held it \[s\].
    pub filled: f64,
    /// When it began to leave \[s\].
    pub dumped: f64,
    /// It is in the bucket.
    pub is_carried: bool,
    /// Its mass may be believed.
    pub is_trusted: bool,
    /// Source of its mass.
    pub witness: &'static str,
    /// Why it is not trusted; empty where there is nothing to say.
    pub why: &'static str,
}

/// A load of a message of either machine.
macro_rules! weighed {
    ($message:expr, $reasons:expr) => {{
        let m = $message;
        let witness = WITNESSES.iter().find(|w| w.number == m.witness);
        let reasons: &[(&'static str, &'static str)] = $reasons;
        let why = reasons
            .get(m.reason as usize)
            .map_or("", |(_, words)| *words);
        LoadRow {
            number: m.load,
            truck: m.truck,
            mass: (m.mass, m.mass_std),
            carry_back: (m.carry_back, m.carry_back_std),
            filled: m.filled,
            dumped: m.dumped,
            is_carried: m.flags & loads_bits::CARRIED != 0,
            is_trusted: m.flags & loads_bits::TRUSTED != 0,
            witness: witness.map_or("", |w| w.name),
            why: if m.reason == 0 { "" } else { why },
        }
    }};
}

/// The loads of a recording, the first one first; of each what was said last.
///
/// # Errors
/// The recording is damaged.
pub fn read(reader: &Reader) -> Result<Vec<LoadRow>, Error> {
    let mut loads = BTreeMap::new();
    let mut take = |load: LoadRow| {
        // A truck's number moves on when the next one comes: a load stays with the one it was put on.
        let truck = loads
            .get(&load.number)
            .map_or(load.truck, |l: &LoadRow| l.truck);
        if load.number > 0 {
            loads.insert(load.number, LoadRow { truck, ..load });
        }
    };
    for m in reader.stream::<ExcavatorLoads>(EXCAVATOR_LOADS.name)? {
        take(weighed!(m, EXCAVATOR_REASONS));
    }
    for m in reader.stream::<LoaderLoads>(LOADER_LOADS.name)? {
        take(weighed!(m, LOADER_REASONS));
    }
    Ok(loads.into_values().collect())
}

/// A loader's load.
#[cfg(test)]
pub(crate) fn of_loader(m: &LoaderLoads) -> LoadRow {
    weighed!(m, LOADER_REASONS)
}
