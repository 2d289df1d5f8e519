//! Comparison of the learnt parameters of many machines of a kind: outliers.

use std::collections::BTreeMap;
use std::io::{self, Write};

use messages::Machine;
use rusqlite::{Connection, params};
use serde_json::json;

use super::intake::decode;
use super::shown::{Quantity, learnt, main_channel, quantities};
use super::table::Format;

/// The last trusted value of a learnt parameter of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterValue {
    /// Site and machine.
    pub names: [String; 2],
    /// When [ms since 1970].
    pub wall_ms: i64,
    /// Value and standard deviation.
    pub quantity: Quantity,
    /// Number of machines compared, including this one.
    pub machines: usize,
    /// Distance from the other machines, see [`statistics::standing`]; `None` for fewer than four machines.
    pub standing: Option<f64>,
}

/// Values by kind of machine and parameter, in order of site and machine.
pub type Comparison = BTreeMap<(&'static str, &'static str), Vec<ParameterValue>>;

/// The last trusted value of every learnt parameter of every machine since a given time, compared within its kind.
///
/// # Errors
/// The history cannot be read.
pub fn compare(
    sql: &Connection,
    since_ms: i64,
    site: Option<&str>,
) -> rusqlite::Result<Comparison> {
    let mut all = Comparison::new();
    let mut machines = sql.prepare(
        "SELECT id, site, name FROM machine WHERE kind = ?1 AND (?2 IS NULL OR site = ?2) ORDER BY site, name",
    )?;
    for kind in Machine::ALL {
        let mut rows = machines.query(params![kind.name(), site])?;
        while let Some(row) = rows.next()? {
            let names = [row.get(1)?, row.get(2)?];
            for (wall_ms, quantity) in latest(sql, row.get(0)?, kind, since_ms)? {
                let like = all.entry((kind.name(), quantity.key)).or_default();
                like.push(ParameterValue {
                    names: names.clone(),
                    wall_ms,
                    quantity,
                    machines: 1,
                    standing: None,
                });
            }
        }
    }
    all.values_mut().for_each(|machines| judge(machines));
    Ok(all)
}

/// The last trusted values of all learnt parameters of a machine, with their times. Reads from the newest estimate backwards, as
/// far as needed.
fn latest(
    sql: &Connection,
    machine: i64,
    kind: Machine,
    since_ms: i64,
) -> rusqlite::Result<Vec<(i64, Quantity)>> {
    let mut wanted = learnt(kind);
    let mut found = Vec::new();
    let Some(stream) = main_channel(kind.name()).map(|main| format!("estimate/{main}")) else {
        return Ok(found);
    };
    let mut runs = sql.prepare_cached(
        "SELECT s.id, r.off_ms FROM stream s JOIN run r ON r.machine = s.machine AND r.run = s.run
         WHERE s.machine = ? AND s.name = ? ORDER BY r.id DESC",
    )?;
    let mut estimates = sql.prepare_cached(
        "SELECT wall_ms, payload FROM message WHERE stream = ? AND wall_ms >= ? ORDER BY number DESC",
    )?;
    let mut runs = runs.query(params![machine, stream])?;
    while let Some(run) = runs.next()? {
        let (stream_id, off_ms): (i64, i64) = (run.get(0)?, run.get(1)?);
        let mut rows = estimates.query(params![stream_id, since_ms.saturating_add(off_ms)])?;
        while let Some(row) = rows.next()?
            && !wanted.is_empty()
        {
            let Some(estimate) = decode(&stream, &row.get::<_, Vec<u8>>(1)?) else {
                continue;
            };
            for quantity in quantities(&estimate) {
                if quantity.trusted && wanted.contains(&quantity.key) {
                    wanted.retain(|key| *key != quantity.key);
                    found.push((row.get::<_, i64>(0)?.saturating_sub(off_ms), quantity));
                }
            }
        }
    }
    Ok(found)
}

fn judge(machines: &mut [ParameterValue]) {
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

impl ParameterValue {
    fn stands_out(&self) -> bool {
        self.standing
            .is_some_and(|z| z.abs() > statistics::STANDS_OUT)
    }
}

/// Writes the comparison, a line for each machine and parameter.
///
/// # Errors
/// Nothing more can be written.
pub fn write(compared: &Comparison, format: Format, out: &mut impl Write) -> io::Result<()> {
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
    use crate::collector::intake::StreamMessage;
    use crate::collector::store::Store;
    use crate::key::MachineId;
    use crate::label::Label;
    use crate::status::Status;
    use messages::{Envelope, ExcavatorEstimate, excavator_bits};

    fn taken(machine: usize, number: u64, damping: f64, trusted: bool) -> StreamMessage {
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
        StreamMessage {
            label: Label {
                machine: id.machine.clone(),
                run: 1,
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
        let odd: Vec<bool> = found.iter().map(ParameterValue::stands_out).collect();
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
