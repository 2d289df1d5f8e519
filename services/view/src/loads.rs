//! Presentation of loads: a table, JSON, a printable page.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write;

use estimation::HALF_WIDTH_95;
use estimation::loads::{Load, Now, Stage, Total, Truck, Weight, Witness};
use messages::Machine;
use serde_json::{Value, json};
use steps::loads::{LoadCounter, Outage, are_doubtful, outage_words, reason_and_flags, why_words};

use crate::number::{interval_95, significant, value_and_std};
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
        let (held, known) = self.covered();
        let words =
            || format!("The truth lies inside {held} of {known} intervals of the trusted loads.");
        (known > 0).then(words)
    }

    fn covered(&self) -> (usize, usize) {
        let trusted = self.loads.iter().chain(&self.carried).filter(|l| l.trusted);
        let known = trusted.filter_map(|l| Some((l, self.truths.get(&l.number)?)));
        let held = known.map(|(load, truth)| {
            let [low, high] = load.weight.interval();
            (low..=high).contains(truth)
        });
        held.fold((0, 0), |(held, all), holds| {
            (held + usize::from(holds), all + 1)
        })
    }
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

/// First columns of a table of loads.
pub const FIRST: &str = "recording,load,truck,day,";

/// Header of the table.
pub const HEADER: &str = "recording,load,truck,day,filled,dumped,kg,kg_std,kg_low,kg_high,carry_back,carry_back_std,\
    carry_back_weighed,delivered,delivered_std,common_std,witness,trusted,reason,stage";

/// A line of the table.
pub fn csv_line(name: &str, machine: Machine, load: &Load) -> String {
    let [low, high] = load.weight.interval();
    let delivered = load.delivered();
    let dumped = load.dumped.map_or(String::new(), |t| format!("{t:.2}"));
    format!(
        "{},{},{},{},{:.2},{dumped},{:.1},{:.1},{low:.1},{high:.1},{:.1},{:.1},{},{:.1},{:.1},{:.1},{},{},{},{}",
        recording::csv::quoted(name),
        load.number,
        load.truck,
        load.day,
        load.filled,
        load.weight.kg,
        load.weight.std,
        load.carry_back.kg,
        load.carry_back.std,
        u8::from(load.carry_back_weighed),
        delivered.kg,
        delivered.std,
        load.weight.common_std,
        load.witness.name(),
        u8::from(load.trusted),
        recording::csv::quoted(why_words(machine, load)),
        load.stage.name(),
    )
}

/// The table of all accounts.
pub fn csv(accounts: &[Account]) -> String {
    let mut out = format!("{HEADER}\n");
    for account in accounts {
        let all = account.loads.iter().chain(&account.carried);
        for load in all {
            out += &csv_line(&account.name, account.machine, load);
            out.push('\n');
        }
    }
    out
}

/// Whether a file with this beginning is such a table.
pub fn is_csv(head: &[u8]) -> bool {
    head.starts_with(FIRST.as_bytes())
}

fn weight_json(weight: &Weight) -> Value {
    let [low, high] = weight.interval();
    json!({"kg": weight.kg, "std": weight.std, "common_std": weight.common_std, "low": low, "high": high})
}

/// A load as JSON.
pub fn load_json(machine: Machine, load: &Load) -> Value {
    json!({
        "load": load.number, "truck": load.truck, "day": load.day, "stage": load.stage.name(),
        "filled": load.filled, "dumped": load.dumped,
        "in_bucket": weight_json(&load.weight),
        "carry_back": weight_json(&load.carry_back), "carry_back_weighed": load.carry_back_weighed,
        "delivered": weight_json(&load.delivered()),
        "witness": load.witness.name(), "trusted": load.trusted, "reason": why_words(machine, load),
        "what_to_do": what_to_do(machine, load),
    })
}

/// A sum as JSON.
pub fn total_json(total: &Total) -> Value {
    let half = HALF_WIDTH_95 * total.std();
    json!({
        "loads": total.loads, "untrusted": total.untrusted, "unweighed": total.unweighed, "kg": total.kg, "std": total.std(),
        "own_std": total.own_variance.sqrt(), "common_std": total.common_std,
        "low": total.kg - half, "high": total.kg + half,
    })
}

/// A truck as JSON.
pub fn truck_json(truck: &Truck) -> Value {
    json!({
        "truck": truck.number, "signal": truck.signal, "day": truck.day, "from": truck.from, "to": truck.to,
        "total": total_json(&truck.total), "target": truck.target, "remaining": truck.remaining(),
    })
}

/// Content of the bucket now, as JSON.
pub fn now_json(now: &Now) -> Value {
    let half = HALF_WIDTH_95 * now.std;
    json!({"kg": now.kg, "std": now.std, "low": now.kg - half, "high": now.kg + half, "age": now.age})
}

fn outage_json(account: &Account, outage: &Outage) -> Value {
    let [from, to] = outage.longest;
    json!({
        "reason": outage_words(account.machine, outage), "what_to_do": outage_advice(account.machine, outage),
        "seconds": outage.seconds, "share": outage.seconds / account.seconds.max(outage.seconds),
        "stretches": outage.stretches, "from": from, "to": to, "to_the_end": outage.lasts,
    })
}

/// An account as JSON.
pub fn json(account: &Account) -> Value {
    let load = |load: &Load| load_json(account.machine, load);
    json!({
        "recording": account.name, "machine": account.machine.name(),
        "loads": account.loads.iter().map(load).collect::<Vec<_>>(),
        "in_the_bucket_at_the_end": account.carried.as_ref().map(load),
        "trucks": account.trucks.iter().map(truck_json).collect::<Vec<_>>(),
        "total": total_json(&account.all), "guessed": account.guessed,
        "outages": account.outages.iter().map(|o| outage_json(account, o)).collect::<Vec<_>>(),
    })
}

/// A run so far, for the live page.
pub fn live_json(counter: &LoadCounter) -> Value {
    let machine = counter.machine();
    let load = |load: &Load| load_json(machine, load);
    let ledger = counter.ledger();
    json!({
        "machine": machine.name(),
        "now": now_json(&ledger.now()),
        "carried": ledger.carried().as_ref().map(load),
        "truck": truck_json(&ledger.truck()),
        "day": json!({"day": ledger.day().number, "trucks": ledger.day().trucks, "total": total_json(&ledger.day().total)}),
        "loads": counter.newest().take(LATEST).map(|it| load(&it)).collect::<Vec<_>>(),
        "guessed": counter.guessed(),
        "outages": outages(counter),
    })
}

/// Number of loads on the live page.
const LATEST: usize = 12;

/// "1 121 kg, 95 %: 872 to 1 370".
pub fn weight_words(weight: &Weight) -> String {
    let (kg, _) = value_and_std(weight.kg, weight.std);
    format!("{kg} kg, 95 %: {}", interval_95(weight.kg, weight.std))
}

/// A load in a line.
pub fn line(machine: Machine, load: &Load) -> String {
    let why = why_words(machine, load);
    let doubt = if load.trusted {
        ", trusted".to_owned()
    } else {
        format!(", not trusted: {why}")
    };
    let rest = if load.carry_back_weighed {
        let (kg, _) = value_and_std(load.carry_back.kg, load.carry_back.std);
        format!(", {kg} kg left in the bucket")
    } else {
        String::new()
    };
    // The next weighing is the last that changes it.
    let stage = match load.stage {
        Stage::Settled => "final",
        stage => stage.name(),
    };
    format!(
        "load {} {stage}: {} (by {}){rest}{doubt}",
        load.number,
        weight_words(&load.weight),
        load.witness.name(),
    )
}

/// A truck in a line.
pub fn truck_line(truck: &Truck) -> String {
    let total = &truck.total;
    let mut text = format!("truck {}: {}", truck.number, total_words(total));
    if let Some(missing) = truck.remaining() {
        let (amount, _) = value_and_std(missing.abs(), total.std().max(1.0));
        let what = if missing >= 0.0 {
            "missing"
        } else {
            "too much"
        };
        let _ = write!(text, "; {amount} kg {what}");
    }
    text
}

/// A sum in words.
pub fn total_words(total: &Total) -> String {
    let (kg, _) = value_and_std(total.kg, total.std().max(1.0));
    let plural = if total.loads == 1 { "" } else { "s" };
    let of_them = |n: u32, what: &str| match n {
        0 => String::new(),
        n => format!(", {n} of them not {what}"),
    };
    let doubt = of_them(total.unweighed, "weighed") + &of_them(total.untrusted, "trusted");
    format!(
        "{kg} kg, 95 %: {}, in {} load{plural}{doubt}",
        interval_95(total.kg, total.std().max(1.0)),
        total.loads
    )
}

/// Seconds of a recording for people: "1:02:03", or the time of day in UTC if they count from 1970.
pub fn clock(time: f64) -> String {
    const DAY: f64 = 86_400.0;
    const SINCE_1970: f64 = 1e9;
    if time < 0.0 {
        return format!("-{}", clock(-time));
    }
    // Rounded first, because 24:00:00 does not exist.
    let rounded = (time * 10.0).round();
    let tenths = if time >= SINCE_1970 {
        rounded.rem_euclid(10.0 * DAY)
    } else {
        rounded
    } as i64;
    let (seconds, tenths) = (tenths.div_euclid(10), tenths.rem_euclid(10));
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if time >= SINCE_1970 {
        format!("{hours:02}:{minutes:02}:{seconds:02} UTC")
    } else if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes}:{seconds:02}.{tenths}")
    }
}

/// An account with one load that is not trusted.
#[cfg(test)]
pub(crate) fn account() -> Account {
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
