//! What many machines of a kind have learnt, compared: who stands out.

use std::collections::BTreeMap;
use std::io::{self, Write};

use rusqlite::{Connection, params};
use serde_json::json;

use super::intake::decode;
use super::shown::{Quantity, kind_of, main_channel, quantities};
use super::table::Format;

/// A learnt parameter of a machine: the last that was trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct Learnt {
    /// Site and machine.
    pub names: [String; 2],
    /// When [ms since 1970].
    pub wall_ms: i64,
    /// Value and standard deviation.
    pub quantity: Quantity,
    /// How many machines are compared, itself among them.
    pub machines: usize,
    /// How far it stands from its like, see [`statistics::standing`]; none of fewer than four machines.
    pub standing: Option<f64>,
}

/// By kind of machine and parameter, by site and machine.
pub type Compared = BTreeMap<(&'static str, &'static str), Vec<Learnt>>;

/// The last trusted value of every learnt parameter of every machine since a moment, compared within its kind.
///
/// # Errors
/// The history cannot be read.
pub fn compare(sql: &Connection, since_ms: i64, site: Option<&str>) -> rusqlite::Result<Compared> {
    let mut query = sql.prepare(
        "SELECT m.site, m.name, s.name, e.wall_ms, e.payload FROM message e JOIN stream s ON s.id = e.stream
         JOIN machine m ON m.id = s.machine
         WHERE s.name = 'estimate/' || ?1 AND m.kind = ?2 AND e.wall_ms >= ?3 AND (?4 IS NULL OR m.site = ?4)
         ORDER BY m.site, m.name, e.wall_ms DESC",
    )?;
    let mut all = Compared::new();
    for machine in messages::Machine::ALL {
        let Some(main) = main_channel(machine.name()) else {
            continue;
        };
        let mut rows = query.query(params![main, machine.name(), since_ms, site])?;
        while let Some(row) = rows.next()? {
            let stream: String = row.get(2)?;
            let Some(estimate) = decode(&stream, &row.get::<_, Vec<u8>>(4)?) else {
                continue;
            };
            let names = [row.get(0)?, row.get(1)?];
            for quantity in quantities(&estimate)
                .into_iter()
                .filter(|q| q.learnt && q.trusted)
            {
                let known = all.entry((kind_of(&estimate), quantity.key)).or_default();
                // The latest comes first.
                if known.last().is_none_or(|last| last.names != names) {
                    known.push(Learnt {
                        names: names.clone(),
                        wall_ms: row.get(3)?,
                        quantity,
                        machines: 1,
                        standing: None,
                    });
                }
            }
        }
    }
    all.values_mut().for_each(|machines| judge(machines));
    Ok(all)
}

fn judge(machines: &mut [Learnt]) {
    let values: Vec<_> = machines
        .iter()
        .map(|m| (m.quantity.value, m.quantity.std))
        .collect();
    let standing = statistics::standing(&values);
    for (i, machine) in machines.iter_mut().enumerate() {
        machine.machines = values.len();
        machine.standing = standing.as_ref().map(|all| all[i]);
    }
}

impl Learnt {
    fn stands_out(&self) -> bool {
        self.standing
            .is_some_and(|z| z.abs() > statistics::STANDS_OUT)
    }
}

/// Writes them, a line for each machine and parameter.
///
/// # Errors
/// Nothing more can be written.
pub fn write(compared: &Compared, format: Format, out: &mut impl Write) -> io::Result<()> {
    if format == Format::Csv {
        writeln!(
            out,
            "site,machine,kind,parameter,unit,value,std,wall_ms,machines,standing,stands_out"
        )?;
    }
    for ((kind, key), machines) in compared {
        for learnt in machines {
            let ([site, machine], q) = (&learnt.names, &learnt.quantity);
            let (count, odd) = (learnt.machines, learnt.stands_out());
            match format {
                Format::Csv => {
                    let standing = learnt.standing.map_or(String::new(), |z| format!("{z:.2}"));
                    writeln!(
                        out,
                        "{site},{machine},{kind},{key},{},{},{},{},{count},{standing},{odd}",
                        q.unit, q.value, q.std, learnt.wall_ms
                    )?;
                }
                Format::Json => {
                    let object = json!({
                        "site": site, "machine": machine, "kind": kind, "parameter": key, "unit": q.unit,
                        "value": q.value, "std": q.std, "wall_ms": learnt.wall_ms,
                        "machines": count, "standing": learnt.standing, "stands_out": odd,
                    });
                    writeln!(out, "{object}")?;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collector::intake::Taken;
    use crate::collector::store::Store;
    use crate::key::MachineId;
    use crate::label::Label;
    use crate::status::Status;
    use messages::{Envelope, ExcavatorEstimate, excavator_bits};

    fn taken(machine: usize, number: u64, damping: f64, trusted: bool) -> Taken {
        let estimate = ExcavatorEstimate {
            damping,
            damping_std: 15.0,
            estimated: u32::MAX,
            flags: if trusted { excavator_bits::TRUSTED } else { 0 },
            ..ExcavatorEstimate::default()
        };
        let mut payload = Vec::new();
        recording::payload::encode(&estimate, &mut payload);
        let id = MachineId::new("north", &format!("ex-{machine}")).expect("names");
        Taken {
            label: Label {
                machine: id.machine.clone(),
                epoch: 1,
                number,
                after: number.checked_sub(1).map(|n| n as i64),
                wall_ms: 1000 + number,
            },
            id,
            stream: format!("estimate/{}", main_channel("excavator").expect("a channel")),
            payload,
            envelope: Envelope::ExcavatorEstimate(estimate),
        }
    }

    #[test]
    fn the_last_that_was_trusted_counts_and_the_odd_machine_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("fleet.sqlite");
        let mut store = Store::open(&file).expect("a history");
        store.begin().expect("a transaction");
        let status = Status {
            kind: "excavator".into(),
            ..Status::default()
        };
        for (machine, damping) in [1490.0, 1510.0, 1500.0, 1505.0, 1900.0]
            .into_iter()
            .enumerate()
        {
            let rows = [(damping - 300.0, true), (damping, true), (4.0, false)];
            for (number, (value, trusted)) in rows.into_iter().enumerate() {
                let taken = taken(machine, number as u64, value, trusted);
                store.insert(&taken).expect("written");
                store.status(&taken.id, &status).expect("written");
            }
        }
        store.commit().expect("written");
        let sql = crate::collector::query::open(&file).expect("a history");
        let compared = compare(&sql, 0, Some("north")).expect("read");
        let found = &compared[&("excavator", "damping")];
        let values: Vec<f64> = found.iter().map(|l| l.quantity.value).collect();
        assert_eq!(values, [1490.0, 1510.0, 1500.0, 1505.0, 1900.0]);
        let odd: Vec<bool> = found.iter().map(Learnt::stands_out).collect();
        assert_eq!(odd, [false, false, false, false, true]);
        for format in [Format::Csv, Format::Json] {
            let mut out = Vec::new();
            write(&compared, format, &mut out).expect("memory");
            let text = String::from_utf8(out).expect("text");
            assert_eq!(text.matches("ex-4").count(), 1, "{text}");
            assert_eq!(text.matches("true").count(), 1, "{text}");
        }
        assert!(compare(&sql, 0, Some("south")).expect("read").is_empty());
        assert!(compare(&sql, 5000, None).expect("read").is_empty());
    }
}
