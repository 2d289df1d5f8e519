//! Loads of a run as text: a line for each load when it is carried and when it is dumped, and a table at the end. All numbers are
//! the ledger's; only the truth is added.

use estimation::loads::{Load, Stage};
use evaluate::text::Table;
use messages::{Envelope, Machine};
use steps::loads::{LoadCounter, why_words};
use view::live::SharedLoads;
use view::loads::{self, Truths};
use view::number;

use crate::quantity;

/// Loads with their true content.
#[derive(Debug, Default)]
pub struct Story {
    truths: Truths,
    /// Loads that have ended, with their truth.
    ended: Vec<(Load, Option<f64>)>,
}

impl Story {
    /// Stores the true content of the bucket.
    pub fn know(&mut self, truth: &Envelope) {
        if let Some(payload) = quantity::truth(truth, "payload") {
            self.truths.know(truth.stamp().time, payload);
        }
    }

    /// Takes a load of the ledger; returns a line if it is new.
    pub fn add(&mut self, machine: Machine, load: &Load) -> Option<String> {
        let truth = self.truths.of(load);
        self.ended.retain(|(known, _)| known.number != load.number);
        self.ended.push((*load, truth));
        let time = match load.stage {
            Stage::Carried => self.truths.last().map_or(load.filled, |t| t.0),
            Stage::Dumped => load.dumped?,
            Stage::Settled => return None,
        };
        let truth = truth.map_or(String::new(), |t| format!(", true {}", kg(t)));
        Some(format!(
            "{time:5.1} s  {}{truth}",
            loads::line(machine, load)
        ))
    }

    /// The present content of the bucket, as a line.
    pub fn now(&self, counter: &LoadCounter) -> String {
        let now = counter.ledger().now();
        let (value, _) = number::value_and_std(now.kg, now.std);
        let interval = number::interval_95(now.kg, now.std);
        let truth = self.truths.last();
        let time = truth.map_or(0.0, |t| t.0);
        let truth = truth.map_or(String::new(), |t| format!(", true {}", kg(t.1)));
        format!("{time:5.1} s  in the bucket now: {value} kg, 95 %: {interval}{truth}")
    }

    /// The loads as a table, with a heading.
    pub fn table(&self, machine: Machine) -> String {
        if self.ended.is_empty() {
            return "no load was carried\n".to_owned();
        }
        let header = ["load", "in the bucket", "95 %", "truth", "by", "trusted"];
        let mut table = Table::new(&header);
        for (load, truth) in &self.ended {
            let (value, _) = number::value_and_std(load.weight.kg, load.weight.std);
            table.row(vec![
                load.number.to_string(),
                format!("{value} kg"),
                format!(
                    "{} kg",
                    number::interval_95(load.weight.kg, load.weight.std)
                ),
                truth.map_or(String::new(), |t| format!("{} kg", kg(t))),
                load.witness.name().to_owned(),
                match load.trusted {
                    true => "yes".to_owned(),
                    false => format!("no: {}", why_words(machine, load)),
                },
            ]);
        }
        self.heading() + &table.to_string()
    }

    /// Number of trusted loads, and of their intervals that contain the truth.
    fn heading(&self) -> String {
        let trusted = self.ended.iter().filter(|(load, _)| load.trusted).count();
        let truth = match loads::covered(self.ended.iter().map(|(load, truth)| (load, *truth))) {
            (_, 0) => String::new(),
            (held, known) => format!("; the truth lies inside {held} of {known} intervals"),
        };
        let all = self.ended.len();
        format!("{trusted} of {all} loads trusted{truth}\n")
    }
}

/// Takes the final loads of the ledger.
pub fn finish(story: &mut Story, loads: &SharedLoads) {
    let mut counter = loads.lock();
    let _ = counter.finish();
    let machine = counter.machine();
    let all: Vec<Load> = counter
        .loads()
        .copied()
        .chain(counter.ledger().carried())
        .collect();
    drop(counter);
    for load in &all {
        let _ = story.add(machine, load);
    }
}

fn kg(value: f64) -> String {
    number::grouped(value, 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimation::loads::Weight;
    use messages::{ExcavatorTruth, Stamp};

    fn reported(truth: f64) -> (Story, Option<String>) {
        let mut story = Story::default();
        for i in 0..60 {
            let truth = ExcavatorTruth {
                stamp: Stamp {
                    time: f64::from(i) * 0.1,
                    ..Stamp::default()
                },
                payload: if (20..40).contains(&i) { truth } else { 5.0 },
                known: 1 << 6,
                ..ExcavatorTruth::default()
            };
            story.know(&Envelope::ExcavatorTruth(truth));
        }
        let load = Load {
            number: 1,
            stage: Stage::Dumped,
            filled: 2.5,
            dumped: Some(3.9),
            weight: Weight {
                kg: 437.0,
                std: 21.0,
                common_std: 10.0,
                ..Weight::default()
            },
            trusted: true,
            ..Load::default()
        };
        let line = story.add(Machine::Excavator, &load);
        (story, line)
    }

    #[test]
    fn a_load_has_one_line_with_its_interval_and_the_truth() {
        let (_, line) = reported(423.0);
        let line = line.expect("a line");
        assert!(
            line.contains("437 kg, 95 %: 396 to 478") && line.contains("true 423"),
            "{line}"
        );
    }

    #[test]
    fn the_table_has_the_numbers_of_the_line_and_says_how_many_intervals_hold_the_truth() {
        let held = reported(423.0).0.table(Machine::Excavator);
        assert!(
            held.contains("truth lies inside 1 of 1 intervals"),
            "{held}"
        );
        assert!(
            held.contains("437 kg") && held.contains("396 to 478 kg") && held.contains("423 kg"),
            "{held}"
        );
        let missed = reported(300.0).0.table(Machine::Excavator);
        assert!(missed.contains("truth lies inside 0 of 1"), "{missed}");
    }

    #[test]
    fn a_load_is_reported_again_and_not_twice() {
        let (mut story, _) = reported(423.0);
        let again = Load {
            stage: Stage::Settled,
            ..story.ended[0].0
        };
        assert_eq!(story.add(Machine::Excavator, &again), None);
        assert_eq!(story.ended.len(), 1);
    }
}
