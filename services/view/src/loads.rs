//! The loads of a recording or a run, with what is doubtful in them.

mod json;
mod table;
mod words;

use std::collections::{BTreeMap, VecDeque};

use estimation::loads::{Load, Total, Truck, Witness};
use messages::Machine;
use steps::loads::{LoadCounter, Outage, are_doubtful, outage_words, reason_and_flags, why_words};

pub use self::json::{json, live_json};
pub use self::table::{csv, is_csv};
pub use self::words::{clock, line, total_words, truck_line};
use crate::number::significant;
use crate::{excavator, loader};

/// The loads of one recording, or of a run so far.
#[derive(Debug, Clone)]
pub struct Account {
    /// Its source.
    pub name: String,
    /// The machine.
    pub machine: Machine,
    /// Loads in order.
    pub loads: Vec<Load>,
    /// Content of the bucket at the end.
    pub carried: Option<Load>,
    /// Trucks in order.
    pub trucks: Vec<Truck>,
    /// Sum of all loads.
    pub all: Total,
    /// Times in which a fault of a sensor left no load weighed, one for each reason.
    pub outages: Vec<Outage>,
    /// Time of all rows \[s\].
    pub seconds: f64,
    /// Missing signal that would weigh a load, and the remedy.
    pub lacks: Option<&'static str>,
    /// Pressures that were measured and weigh nothing, and the remedy.
    pub unused: Option<&'static str>,
    /// Values that the machine file does not state, the resulting width of the loads, and the remedy.
    pub guessed: Option<String>,
    /// Finding from the emptied buckets of a loader, if it exceeds adhering soil.
    pub shown_empty: Option<String>,
    /// True content by the number of the load \[kg\]; empty if unknown.
    pub truths: BTreeMap<u32, f64>,
}

/// True content of the bucket of a simulated machine over time.
#[derive(Debug, Clone, Default)]
pub struct Truths {
    /// Times \[s\] and values \[kg\] of its changes, the latest ones.
    changes: VecDeque<(f64, f64)>,
    /// The last value of all.
    last: Option<(f64, f64)>,
}

impl Truths {
    const REMEMBERED: usize = 1 << 20;

    /// Notes the true content; ignores NaN, which means unknown.
    pub fn know(&mut self, time: f64, kg: f64) {
        if !kg.is_finite() {
            return;
        }
        if self.last.is_none_or(|(_, last)| last != kg) {
            if self.changes.len() == Self::REMEMBERED {
                self.changes.pop_front();
            }
            self.changes.push_back((time, kg));
        }
        self.last = Some((time, kg));
    }

    /// Time \[s\] and content \[kg\] of the last known value.
    pub fn last(&self) -> Option<(f64, f64)> {
        self.last
    }

    /// Largest content while a load was carried \[kg\].
    pub fn of(&self, load: &Load) -> Option<f64> {
        let ends = self.changes.iter().skip(1).map(|change| change.0);
        let ends = ends.chain([f64::INFINITY]);
        let until = load.dumped.unwrap_or(f64::INFINITY);
        let within = self
            .changes
            .iter()
            .zip(ends)
            .filter(|(change, end)| change.0 <= until && *end > load.filled);
        within.map(|(change, _)| change.1).reduce(f64::max)
    }
}

impl Account {
    /// The account of a counter; `trucks`: the complete ones.
    pub fn of(name: &str, counter: &LoadCounter, trucks: Vec<Truck>, truths: &Truths) -> Self {
        let dumped = counter.loads().copied().filter(|l| l.dumped.is_some());
        let (loads, carried): (Vec<_>, _) = (dumped.collect(), counter.ledger().carried());
        let known = loads.iter().chain(&carried);
        let truths = known.filter_map(|load| Some((load.number, truths.of(load)?)));
        Self {
            name: name.to_owned(),
            machine: counter.machine(),
            truths: truths.collect(),
            loads,
            carried,
            trucks,
            all: counter.ledger().all(),
            outages: counter.outages(),
            seconds: counter.seconds(),
            lacks: counter.lacks(),
            unused: counter.unused(),
            guessed: counter.guessed().map(str::to_owned),
            shown_empty: counter.shown_empty(),
        }
    }

    /// The times without a weighed load, and the remedies.
    pub fn outages(&self) -> impl Iterator<Item = String> {
        let line = |outage| outage_line(self.machine, self.seconds, outage);
        self.outages.iter().map(line)
    }

    /// The longest outage, if all of them are more than a tenth of the recording: the sum is in doubt.
    pub fn in_doubt(&self) -> Option<&Outage> {
        let longest = self.outages.iter();
        let longest = longest.max_by(|a, b| a.seconds.total_cmp(&b.seconds));
        longest.filter(|_| are_doubtful(&self.outages, self.seconds))
    }

    /// The outages, and each reason why loads are not trusted with its remedy, once.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts: Vec<String> = self.outages().collect();
        for load in self
            .loads
            .iter()
            .chain(&self.carried)
            .filter(|l| !l.trusted)
        {
            let (why, to_do) = (
                why_words(self.machine, load),
                what_to_do(self.machine, load),
            );
            let doubt = format!("Not trusted, because {why}. What to do: {to_do}.");
            if !doubts.contains(&doubt) {
                doubts.push(doubt);
            }
        }
        doubts
    }

    /// Further remarks on all loads: unused pressures, values that the machine file does not state, and findings from emptied
    /// buckets.
    pub fn remarks(&self) -> Vec<String> {
        let unused = self
            .unused
            .map(|why| format!("No load is weighed by pressure: {why}."));
        let holds = [unused, self.guessed.clone(), self.shown_empty.clone()];
        holds.into_iter().flatten().collect()
    }

    /// Whether no load was found.
    pub fn is_empty(&self) -> bool {
        self.loads.is_empty() && self.carried.is_none()
    }

    /// Number of intervals of the trusted loads that hold the truth, in words; `None` if no truth is known.
    pub fn covered_words(&self) -> Option<String> {
        let all = self.loads.iter().chain(&self.carried);
        let (held, known) = covered(all.map(|l| (l, self.truths.get(&l.number).copied())));
        let words =
            || format!("The truth lies inside {held} of {known} intervals of the trusted loads.");
        (known > 0).then(words)
    }
}

/// Number of intervals of trusted loads that hold the truth, and of those whose truth is known.
pub fn covered<'a>(loads: impl Iterator<Item = (&'a Load, Option<f64>)>) -> (usize, usize) {
    let trusted = loads.filter(|(load, _)| load.trusted);
    let known = trusted.filter_map(|(load, truth)| Some((load.weight.interval(), truth?)));
    known.fold((0, 0), |(held, all), ([low, high], truth)| {
        (held + usize::from((low..=high).contains(&truth)), all + 1)
    })
}

/// The times of a run without a weighed load up to now, and the remedies.
pub fn outages(counter: &LoadCounter) -> Vec<String> {
    let line = |outage| outage_line(counter.machine(), counter.seconds(), outage);
    counter.outages().iter().map(line).collect()
}

/// An outage within rows of so many `seconds`, and its remedy.
fn outage_line(machine: Machine, seconds: f64, outage: &Outage) -> String {
    let [from, to] = outage.longest.map(clock);
    let until = if outage.lasts { "the end" } else { &to };
    let time = format!(
        "{:.0} s, {} % of the recording",
        outage.seconds,
        significant(100.0 * outage.seconds / seconds.max(outage.seconds), 2)
    );
    let when = match outage.stretches {
        1 => format!("From {from} to {until} ({time}) no load was weighed"),
        n => format!(
            "In {n} stretches, the longest from {from} to {until} ({time} in all), no load was weighed"
        ),
    };
    format!(
        "{when}, because {}: loads may be missing in the sum. What to do: {}.",
        outage_words(machine, outage),
        outage_advice(machine, outage),
    )
}

/// Remedy for an outage.
pub fn outage_advice(machine: Machine, outage: &Outage) -> &'static str {
    // No flag is set: without a reason an input is missing.
    match machine {
        Machine::Excavator => excavator::load_advice(outage.reason, 0),
        Machine::Loader => loader::load_advice(outage.reason, 0),
    }
}

/// Remedy for a load; empty if it is trusted.
fn what_to_do(machine: Machine, load: &Load) -> &'static str {
    if load.trusted {
        return "";
    }
    if load.witness == Witness::Nothing {
        return "state more of the machine, or weigh one load (heft calibrate)";
    }
    let (reason, flags) = reason_and_flags(load);
    match machine {
        Machine::Excavator => excavator::load_advice(reason, flags),
        Machine::Loader => loader::load_advice(reason, flags),
    }
}

/// An account with one load that is not trusted.
#[cfg(test)]
pub(crate) fn account() -> Account {
    use estimation::loads::{Stage, Weight};
    let weight = |kg, std| Weight {
        kg,
        std,
        common_std: 0.8 * std,
        ..Weight::default()
    };
    let load = Load {
        number: 1,
        truck: 1,
        stage: Stage::Settled,
        filled: 8.5,
        dumped: Some(12.7),
        weight: weight(1139.0, 60.0),
        carry_back: weight(45.0, 20.0),
        carry_back_weighed: true,
        trusted: false,
        why: 11,
        ..Load::default()
    };
    let total = Total::default().with(Some(&load));
    let truck = Truck {
        number: 1,
        total,
        target: Some(24_000.0),
        ..Truck::default()
    };
    Account {
        name: "a,b <i>.csv".to_owned(),
        machine: Machine::Excavator,
        loads: vec![load],
        carried: None,
        trucks: vec![truck],
        all: total,
        outages: Vec::new(),
        seconds: 0.0,
        lacks: None,
        unused: None,
        guessed: None,
        shown_empty: None,
        truths: BTreeMap::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::json::total_json;
    use super::*;

    #[test]
    fn each_line_of_the_table_has_the_columns_of_its_header() {
        let text = csv(&[account()]);
        assert!(is_csv(text.as_bytes()));
        let mut lines = text.lines();
        let columns = lines.next().map(|h| h.split(',').count());
        let line = lines.next().expect("a load");
        let rest = line.strip_prefix("\"a,b <i>.csv\"").expect("a quoted name");
        assert_eq!(Some(rest.split(',').count()), columns);
        assert!(
            line.contains("the bucket's content may have changed"),
            "{line}"
        );
    }

    #[test]
    fn a_load_that_nothing_weighed_is_counted_in_the_sum_and_says_so() {
        let mut load = account().loads[0];
        load.witness = Witness::Nothing;
        let total = account().all.with(Some(&load));
        let said = total_words(&total);
        let counted = "in 2 loads, 1 of them not weighed, 2 of them not trusted";
        assert!(said.ends_with(counted), "{said}");
        assert_eq!(total_json(&total)["unweighed"], 1);
        assert!(line(Machine::Excavator, &load).contains("by nothing"));
        assert!(why_words(Machine::Excavator, &load).contains("not weighed"));
    }

    #[test]
    fn json_has_both_kinds_of_errors() {
        let value = json(&account());
        let total = &value["total"];
        let number = |key: &str| total[key].as_f64().expect("a number");
        let both = number("own_std").hypot(number("common_std"));
        assert!((both - number("std")).abs() < 1e-9);
        assert_eq!(
            value["loads"][0]["reason"],
            "the bucket's content may have changed"
        );
        assert_eq!(
            value["loads"][0]["what_to_do"],
            "swing on: the next swing decides"
        );
    }

    #[test]
    fn one_reason_is_said_once_whether_the_machine_swings_or_not() {
        let mut account = account();
        let mut swinging = account.loads[0];
        swinging.why |= 0xff_ff00;
        account.loads.push(swinging);
        let remedy = "swing on: the next swing decides";
        let doubt = format!(
            "Not trusted, because the bucket's content may have changed. What to do: {remedy}."
        );
        assert_eq!(account.doubts(), [doubt]);
    }

    #[test]
    fn an_outage_says_when_why_and_what_to_do_and_a_long_one_leaves_the_sum_in_doubt() {
        let mut account = account();
        let outage = Outage {
            reason: 16,
            stretches: 1,
            seconds: 150.0,
            longest: [90.2, 240.0],
            lasts: true,
        };
        (account.outages, account.seconds) = (vec![outage], 240.0);
        let said = account.doubts().swap_remove(0);
        assert_eq!(
            said,
            "From 1:30.2 to the end (150 s, 63 % of the recording) no load was weighed, because a joint angle has jumped further than \
             a joint moves: loads may be missing in the sum. What to do: check the angle sensor; after its repair begin another run or recording."
        );
        assert_eq!(account.in_doubt(), Some(&outage));
        let value = json(&account);
        assert_eq!(value["outages"][0]["to_the_end"], true);
        assert_eq!(value["outages"][0]["share"], 0.625);
        let some = Outage {
            stretches: 2,
            lasts: false,
            reason: steps::loads::MISSING,
            ..outage
        };
        (account.outages, account.seconds) = (vec![some], 3600.0);
        let said = account.doubts().swap_remove(0);
        for words in [
            "In 2 stretches, the longest from 1:30.2 to 4:00.0 (150 s, 4.2 % of the recording in all)",
            "an input is missing or too old",
            "check the sensors and the map",
        ] {
            assert!(said.contains(words), "{said}");
        }
        assert_eq!(account.in_doubt(), None);
    }

    #[test]
    fn the_loads_of_the_live_page_are_those_that_its_truck_adds_up() {
        use messages::{ExcavatorEstimate, Message, Stamp, excavator_bits as bits};
        let machine = "[machine]\nkind = \"excavator\"\noperating_mass = 21500\n";
        let counter = LoadCounter::of_text(machine, steps::loads::Options::default());
        let mut counter = counter.expect("a description");
        let mut weighed = Vec::new();
        for i in 0..1500u32 {
            // The emptied bucket shows less and less, and more and more precisely.
            let after = f64::from(i.saturating_sub(600)) / 900.0;
            let estimate = ExcavatorEstimate {
                stamp: Stamp {
                    time: f64::from(i) * 0.01,
                    ..Stamp::default()
                },
                payload: match i {
                    200..600 => 900.0,
                    _ => 80.0 - 60.0 * after,
                },
                payload_std: 20.0 - 10.0 * after,
                estimated: bits::PAYLOAD,
                flags: bits::TRUSTED,
                ..ExcavatorEstimate::default()
            };
            counter.see(&estimate.envelope());
            let json = live_json(&counter);
            let loads = json["loads"].as_array().expect("a list");
            let dumped = loads.iter().filter(|load| load["stage"] != "carried");
            let sum: f64 = dumped
                .filter_map(|load| load["delivered"]["kg"].as_f64())
                .sum();
            let truck = json["truck"]["total"]["kg"].as_f64();
            assert!((truck.expect("a sum") - sum).abs() < 1e-6, "{json}");
            weighed.push(sum);
        }
        weighed.dedup();
        assert!(weighed.len() > 2, "the carry-back became better known");
    }

    #[test]
    fn times_are_read_as_minutes_hours_or_time_of_day() {
        assert_eq!(clock(62.34), "1:02.3");
        assert_eq!(clock(3723.0), "1:02:03");
        assert_eq!(clock(1_700_000_000.0), "22:13:20 UTC");
        assert_eq!(clock(1_700_006_399.96), "00:00:00 UTC");
        assert_eq!(clock(-65.0), "-1:05.0");
    }
}
