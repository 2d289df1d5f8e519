//! What each bucket held, as the run counted it.

use std::collections::BTreeMap;
use std::fmt::Write;

use messages::channels::{EXCAVATOR_LOADS, LOADER_LOADS};
use messages::{EXCAVATOR_REASONS, ExcavatorLoads, LOADER_REASONS, LoaderLoads, loads_bits};
use recording::{Error, Reader};
use sheet::loads::WITNESSES;

use super::html::{row, table, text};
use crate::loads::clock;
use crate::number::{interval_95, value_and_std};

/// A load as the run told it last.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighed {
    number: u32,
    truck: u32,
    mass: (f64, f64),
    carry_back: (f64, f64),
    filled: f64,
    dumped: f64,
    is_carried: bool,
    is_trusted: bool,
    witness: &'static str,
    why: &'static str,
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
        Weighed {
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
pub fn read(reader: &Reader) -> Result<Vec<Weighed>, Error> {
    let mut loads = BTreeMap::new();
    let mut take = |load: Weighed| {
        // A truck's number moves on when the next one comes: a load stays with the one it was put on.
        let truck = loads
            .get(&load.number)
            .map_or(load.truck, |l: &Weighed| l.truck);
        if load.number > 0 {
            loads.insert(load.number, Weighed { truck, ..load });
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

/// A table of the loads; nothing where none was counted.
pub(super) fn write(body: &mut String, loads: &[Weighed]) {
    if loads.is_empty() {
        return;
    }
    let head = [
        "load",
        "truck",
        "filled",
        "dumped",
        "in the bucket, kg",
        "95 %",
        "stays, kg",
        "by",
        "trusted",
    ];
    let rows: String = loads.iter().map(cells).map(|cells| row(&cells)).collect();
    let _ = write!(
        body,
        "<section class=\"words\"><h2>What each bucket held</h2>{}<p class=\"note\">As the run counted it. \
         <code>heft loads</code> adds up trucks and days.</p></section>",
        table(1, &head, &rows)
    );
}

fn cells(load: &Weighed) -> Vec<String> {
    let kg = |(value, std): (f64, f64)| value_and_std(value, std).0;
    let trusted = match (load.is_trusted, load.why) {
        (true, _) => "yes".to_owned(),
        (false, "") => "no".to_owned(),
        (false, why) => format!("no: {}", text(why)),
    };
    vec![
        load.number.to_string(),
        load.truck.to_string(),
        clock(load.filled),
        if load.is_carried {
            "not yet".into()
        } else {
            clock(load.dumped)
        },
        kg(load.mass),
        interval_95(load.mass.0, load.mass.1),
        if load.is_carried {
            String::new()
        } else {
            kg(load.carry_back)
        },
        load.witness.to_owned(),
        trusted,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_is_a_row_with_its_interval_and_why_it_is_not_trusted() {
        let mut message = LoaderLoads {
            load: 2,
            truck: 1,
            mass: 930.0,
            mass_std: 91.0,
            filled: 7.7,
            dumped: 17.1,
            witness: 1,
            flags: loads_bits::TRUSTED,
            ..LoaderLoads::default()
        };
        let trusted = cells(&weighed!(&message, LOADER_REASONS));
        assert_eq!(trusted[3], "0:17.1");
        assert_eq!(trusted[4], "930");
        assert_eq!(trusted[7..], ["pressure", "yes"]);
        (message.flags, message.reason) = (loads_bits::CARRIED, 1);
        let doubted = cells(&weighed!(&message, LOADER_REASONS));
        assert_eq!(doubted[3], "not yet");
        assert_eq!(doubted[8], format!("no: {}", LOADER_REASONS[1].1));
    }
}
