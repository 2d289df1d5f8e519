//! Damaged recordings: truncated at a border of a record or one byte beside it, or with one flipped bit in any kind
//! of record or in its length. A reader returns the original, or reports that it returns less.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

use recording::Reader;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

/// Damaged copies per attempt.
const COPIES: usize = 40;

/// Damage of a copy.
#[derive(Clone, Copy, PartialEq)]
pub enum Damage {
    Cut,
    Flip,
}

struct Files {
    damage: Damage,
    original: Option<Original>,
    copies: usize,
}

/// Both kinds of damage.
pub fn all() -> impl Iterator<Item = Box<dyn Attack>> {
    [Damage::Cut, Damage::Flip].into_iter().map(|damage| {
        Box::new(Files {
            damage,
            original: None,
            copies: 0,
        }) as Box<dyn Attack>
    })
}

/// The recording of a run, with its contents.
pub struct Original {
    bytes: Vec<u8>,
    pub rows: Rows,
    /// Begin, kind and length of each record.
    records: Vec<(usize, u8, usize)>,
}

/// Hashes of the messages of each channel.
pub type Rows = BTreeMap<String, Vec<u64>>;

impl Original {
    pub fn make(ground: &Ground) -> Result<Self, String> {
        ground
            .run(1.5, &[])?
            .remains(Duration::from_secs(20))?
            .check(0)?;
        let file = ground.folder().join("out/run.mcap");
        let bytes = fs::read(&file).map_err(|e| e.to_string())?;
        let reader = Reader::open(&file).map_err(|e| e.to_string())?;
        Ok(Self {
            rows: rows(&reader),
            records: records(&bytes),
            bytes,
        })
    }

    /// A damaged copy, with a description of the damage.
    pub fn damaged(&self, damage: Damage, rng: &mut Rng) -> (Vec<u8>, String) {
        let mut bytes = self.bytes.clone();
        if damage == Damage::Cut {
            let (at, kind, _) = rng.one(&self.records);
            let at = (at + 1)
                .saturating_sub(rng.between(0, 3) as usize)
                .min(bytes.len());
            bytes.truncate(at);
            return (bytes, format!("cut at {at}, beside record kind {kind}"));
        }
        // All kinds of records are equally probable.
        let mut kinds: Vec<u8> = self.records.iter().map(|r| r.1).collect();
        kinds.sort_unstable();
        kinds.dedup();
        let kind = rng.one(&kinds);
        let same: Vec<_> = self
            .records
            .iter()
            .filter(|r| r.1 == kind)
            .copied()
            .collect();
        let (start, _, length) = rng.one(&same);
        // Header (with its length) and body are equally probable.
        let at = match rng.between(0, 2) {
            0 => start + rng.between(0, 9) as usize,
            _ => start + 9 + rng.between(0, length.max(1) as u64) as usize,
        };
        let at = at.min(bytes.len() - 1);
        bytes[at] ^= 1 << rng.between(0, 8);
        (bytes, format!("flip at {at} of record kind {kind}"))
    }
}

/// The records of an MCAP file, after a magic of eight bytes: opcode, length, body.
fn records(bytes: &[u8]) -> Vec<(usize, u8, usize)> {
    let mut found = Vec::new();
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 9) {
        let mut length = [0; 8];
        length.copy_from_slice(&head[1..]);
        let length = u64::from_le_bytes(length) as usize;
        if length > bytes.len() - at {
            break; // the magic at the end
        }
        found.push((at, head[0], length));
        at += 9 + length;
    }
    found
}

/// The contents of each channel according to the reader.
pub fn rows(reader: &Reader) -> Rows {
    let mut rows = Rows::new();
    for channel in reader.channels() {
        let list = rows.entry(channel.to_owned()).or_default();
        // A damaged channel ends early; the reader records the damage.
        let _ = reader.for_each_value(channel, |time, values| {
            let mut hash = time;
            for value in values {
                hash = (hash ^ value.as_f64().to_bits()).wrapping_mul(0x100_0000_01b3);
            }
            list.push(hash);
        });
    }
    rows
}

/// Whether `part` is a subsequence of `whole`.
fn is_within(part: &[u64], whole: &[u64]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|p| rest.any(|w| w == p))
}

/// Checks that a damaged recording returns the original's contents, or reports that it does not.
fn judge(file: &Path, original: &Rows) -> Result<(), String> {
    let Ok(reader) = Reader::open(file) else {
        return Ok(()); // refused is reported
    };
    let found = rows(&reader);
    let reported = !reader.is_complete() || !reader.damage().is_empty();
    for (channel, list) in &found {
        let whole = original.get(channel).map_or(&[][..], Vec::as_slice);
        if !is_within(list, whole) {
            return Err(format!("{channel} has messages that nobody wrote"));
        }
    }
    if found != *original && !reported {
        return Err("messages are missing and nothing is said".into());
    }
    Ok(())
}

impl Attack for Files {
    fn name(&self) -> String {
        match self.damage {
            Damage::Cut => "recordings cut at records".into(),
            Damage::Flip => "recordings with a flipped bit".into(),
        }
    }

    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String> {
        let original = match self.original.take() {
            Some(original) => original,
            None => Original::make(ground)?,
        };
        let file = ground.folder().join("damaged.mcap");
        let copy = ground.folder().join("whole.mcap");
        let mut outcome = Ok(Outcome::Survived { gap: 0 });
        for _ in 0..COPIES {
            let (bytes, what) = original.damaged(self.damage, rng);
            fs::write(&file, bytes).map_err(|e| e.to_string())?;
            let _ = fs::remove_file(&copy);
            let judged = judge(&file, &original.rows).and_then(|()| {
                // A readable recording can be repaired.
                match recording::recover(&file, Some(&copy)) {
                    Ok(_) if copy.exists() => judge_whole(&copy, &original.rows),
                    _ => Ok(()),
                }
            });
            self.copies += 1;
            if let Err(why) = judged {
                outcome = Err(format!("{what}: {why}"));
            }
        }
        self.original = Some(original);
        outcome
    }

    fn note(&self) -> Option<String> {
        Some(format!("{}: {} copies", self.name(), self.copies))
    }
}

fn judge_whole(copy: &Path, original: &Rows) -> Result<(), String> {
    let reader = Reader::open(copy).map_err(|e| format!("the recovered copy: {e}"))?;
    if !reader.is_complete() || !reader.damage().is_empty() {
        return Err("the recovered copy is not whole".into());
    }
    let inside = |(channel, list): (&String, &Vec<u64>)| {
        original
            .get(channel)
            .is_some_and(|whole| is_within(list, whole))
    };
    if rows(&reader).iter().all(inside) {
        Ok(())
    } else {
        Err("the recovered copy has messages that nobody wrote".into())
    }
}
