//! Checks of the samples of many machines: those of `heft estimate`, for each machine.

use std::collections::BTreeMap;

use checks::Look;
use config::Description;
use recording::Map;

use super::rows::Member;
use crate::doubts::{Doubts, FIRST_JUDGED};
use crate::failure::Failure;

/// Largest number of texts reported, and of machines named in one. Further ones are counted.
const MOST_REPORTED: usize = 20;
const MOST_NAMED: usize = 10;
/// Largest number of texts stored: a bound on memory where machines come and go for years.
const MOST_TEXTS: usize = 1000;

/// The machines whose samples are checked.
pub struct Suspects<'a, L: Look> {
    description: &'a Description,
    map: Option<&'a Map>,
    machines: BTreeMap<u32, Suspect<L>>,
    findings: Findings,
    /// Number of faults reported while samples arrive.
    warned: usize,
}

/// A machine whose samples are checked.
struct Suspect<L: Look> {
    name: String,
    doubts: Doubts<L>,
    /// Number of rows at the next judgement.
    judge_at: usize,
}

/// Findings, each with its machines.
#[derive(Default)]
pub struct Findings {
    /// Remarks on possible errors, and certain errors.
    words: BTreeMap<String, Names>,
    faults: BTreeMap<String, Names>,
    /// Number of machines judged, of those with a fault, and of those among them without a usable row.
    judged: usize,
    faulty: usize,
    unusable: usize,
}

/// Machines that share a finding.
#[derive(Default)]
struct Names {
    first: Vec<String>,
    more: usize,
}

impl<'a, L: Look> Suspects<'a, L> {
    /// Machines of a description, whose samples were read with this map.
    pub fn new(description: &'a Description, map: Option<&'a Map>) -> Self {
        Self {
            description,
            map,
            machines: BTreeMap::new(),
            findings: Findings::default(),
            warned: 0,
        }
    }

    /// Adds a sample of a machine. Certain errors are reported at once, at each judgement: the input may be endless.
    pub fn see(&mut self, number: u32, name: &str, sample: &L::Sensors) {
        let suspect = self.machines.entry(number).or_insert_with(|| Suspect {
            name: name.to_owned(),
            doubts: Doubts::of(self.description).mapped(self.map.cloned()),
            judge_at: FIRST_JUDGED,
        });
        suspect.doubts.see(sample);
        if suspect.doubts.rows() < suspect.judge_at {
            return;
        }
        suspect.judge_at *= 2;
        if let Err(fault) = suspect.doubts.judge(&recording::Lacks::default()) {
            warn(&mut self.warned, &suspect.name, &fault.to_string());
        }
    }

    /// Judges a machine that has left.
    pub fn forget(&mut self, number: u32) {
        if let Some(suspect) = self.machines.remove(&number)
            && let Some(fault) = self.findings.add(&suspect.name, &suspect.doubts)
        {
            warn(&mut self.warned, &suspect.name, &fault);
        }
    }

    /// Judges the machines that remain. `members` counts the refused rows of each.
    pub fn finish(mut self, members: &BTreeMap<u32, Member>) -> Findings {
        for (number, mut suspect) in std::mem::take(&mut self.machines) {
            let refused = members.get(&number).map_or(0, |member| member.refused);
            suspect.doubts.refused(refused as usize);
            self.findings.add(&suspect.name, &suspect.doubts);
        }
        self.findings
    }
}

/// Reports a fault while samples arrive, up to a number of them: all machines may have the same.
fn warn(warned: &mut usize, name: &str, fault: &str) {
    *warned += 1;
    if *warned <= MOST_REPORTED {
        tracing::warn!("machine {name}: {fault}");
    }
}

impl Findings {
    /// Adds the findings of a machine. Returns its fault where no machine had it before.
    fn add<L: Look>(&mut self, name: &str, doubts: &Doubts<L>) -> Option<String> {
        self.judged += 1;
        for words in doubts.words() {
            note(&mut self.words, words, name);
        }
        let fault = doubts
            .has_rows()
            .and_then(|()| doubts.judge(&recording::Lacks::default()))
            .err()?;
        self.faulty += 1;
        self.unusable += usize::from(fault.status == 2);
        let fault = fault.to_string();
        let is_new = !self.faults.contains_key(&fault);
        note(&mut self.faults, fault.clone(), name);
        is_new.then_some(fault)
    }

    /// Adds the findings of another shard.
    pub fn merge(&mut self, other: Self) {
        for (mine, its) in [
            (&mut self.words, other.words),
            (&mut self.faults, other.faults),
        ] {
            for (words, names) in its {
                let all = mine.entry(words).or_default();
                names.first.into_iter().for_each(|name| all.add(name));
                all.more += names.more;
            }
        }
        self.judged += other.judged;
        self.faulty += other.faulty;
        self.unusable += other.unusable;
    }

    /// Reports all findings. A fault of some machines is status 1, all machines without a usable row status 2.
    pub fn report(&self) -> Result<(), Failure> {
        let all = self.words.iter().chain(&self.faults);
        for (words, names) in all.clone().take(MOST_REPORTED) {
            eprintln!("machine {names}: {words}");
        }
        match all.count() {
            0..=MOST_REPORTED => {}
            all => eprintln!(
                "{} more remarks of this kind are left out",
                all - MOST_REPORTED
            ),
        }
        if self.faulty == 0 {
            return Ok(());
        }
        let message = format!(
            "the samples of {} of {} machines are not what they are taken for\n  where: {}\n  what to do: see what is said of each above; the map and the machine file count for all of them",
            self.faulty,
            self.judged,
            self.names()
        );
        match self.unusable == self.judged {
            true => Err(Failure::reported(message)),
            false => Err(Failure::answer_is_no(message)),
        }
    }

    /// The machines that have a fault.
    fn names(&self) -> Names {
        let mut all = Names::default();
        let first = self.faults.values().flat_map(|names| &names.first);
        first
            .take(MOST_NAMED)
            .for_each(|name| all.add(name.clone()));
        all.more = self.faulty - all.first.len();
        all
    }
}

/// Adds a text of a machine.
fn note(all: &mut BTreeMap<String, Names>, words: String, name: &str) {
    if all.len() < MOST_TEXTS || all.contains_key(&words) {
        all.entry(words).or_default().add(name.to_owned());
    }
}

impl Names {
    fn add(&mut self, name: String) {
        match self.first.len() < MOST_NAMED {
            true => self.first.push(name),
            false => self.more += 1,
        }
    }
}

impl std::fmt::Display for Names {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.first.join(", "))?;
        match self.more {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_names_the_first_are_reported_and_the_others_counted() {
        let mut names = Names::default();
        (0..12).for_each(|k| names.add(k.to_string()));
        assert_eq!(names.to_string(), "0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 2 more");
    }
}
