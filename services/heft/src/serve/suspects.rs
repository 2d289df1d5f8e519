//! What is strange about the samples of each of many machines: the checks of `heft estimate`, a machine at a time.

use std::collections::BTreeMap;

use config::Description;
use recording::Map;

use super::rows::Member;
use crate::commands::estimate::look::Look;
use crate::doubts::Doubts;
use crate::failure::Failure;

/// Rows of a machine after which it is judged for the first time: a minute of 100 Hz. It is judged again after twice as many.
const FIRST: usize = 6000;
/// So many texts are told, and so many machines named in one: where all have the same lack, the rest is only counted.
const MOST_TOLD: usize = 20;
const MOST_NAMED: usize = 10;
/// So many texts are kept: machines that come and go for years take no more.
const MOST_KEPT: usize = 1000;

/// The machines whose samples are looked at.
pub struct Suspects<'a, L: Look> {
    description: &'a Description,
    map: Option<&'a Map>,
    machines: BTreeMap<u32, Suspect<L>>,
    told: Told,
    /// How many faults were told while samples came.
    warned: usize,
}

/// A machine whose samples are looked at.
struct Suspect<L: Look> {
    name: String,
    doubts: Doubts<L>,
    /// It is judged when it has so many rows.
    judge_at: usize,
}

/// What was found, and of which machines.
#[derive(Default)]
pub struct Told {
    /// Words on what may be wrong, and what is surely wrong.
    words: BTreeMap<String, Names>,
    faults: BTreeMap<String, Names>,
    /// Machines that were judged, those that have a fault, and of these those without anything that can be estimated.
    judged: usize,
    faulty: usize,
    unusable: usize,
}

/// Machines of which something is said.
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
            told: Told::default(),
            warned: 0,
        }
    }

    /// Takes a sample of a machine. What is surely wrong is told now and then: input may have no end.
    pub fn see(&mut self, number: u32, name: &str, sample: &L::Sensors) {
        let suspect = self.machines.entry(number).or_insert_with(|| Suspect {
            name: name.to_owned(),
            doubts: Doubts::of(self.description).mapped(self.map.cloned()),
            judge_at: FIRST,
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

    /// A machine has gone: it is judged by what came.
    pub fn forget(&mut self, number: u32) {
        if let Some(suspect) = self.machines.remove(&number)
            && let Some(fault) = self.told.add(&suspect.name, &suspect.doubts)
        {
            warn(&mut self.warned, &suspect.name, &fault);
        }
    }

    /// Judges those that are still there; the rows of each that were refused were counted elsewhere.
    pub fn finish(mut self, members: &BTreeMap<u32, Member>) -> Told {
        for (number, mut suspect) in std::mem::take(&mut self.machines) {
            let refused = members.get(&number).map_or(0, |member| member.refused);
            suspect.doubts.refused(refused as usize);
            self.told.add(&suspect.name, &suspect.doubts);
        }
        self.told
    }
}

/// Tells a fault while samples come: those of the first, as all machines may have it.
fn warn(warned: &mut usize, name: &str, fault: &str) {
    *warned += 1;
    if *warned <= MOST_TOLD {
        tracing::warn!("machine {name}: {fault}");
    }
}

impl Told {
    /// Notes what there is to say of a machine; its fault, if that is a new one.
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

    /// Takes what another one found.
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

    /// Says everything; what is surely wrong of some is the answer no, and of all without a row a bad input.
    pub fn tell(&self) -> Result<(), Failure> {
        let all = self.words.iter().chain(&self.faults);
        for (words, names) in all.clone().take(MOST_TOLD) {
            eprintln!("machine {names}: {words}");
        }
        match all.count() {
            0..=MOST_TOLD => {}
            all => eprintln!("{} more remarks of this kind are left out", all - MOST_TOLD),
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

/// Notes words of a machine.
fn note(all: &mut BTreeMap<String, Names>, words: String, name: &str) {
    if all.len() < MOST_KEPT || all.contains_key(&words) {
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
    fn of_many_names_the_first_are_told_and_the_others_counted() {
        let mut names = Names::default();
        (0..12).for_each(|k| names.add(k.to_string()));
        assert_eq!(names.to_string(), "0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 2 more");
    }
}
