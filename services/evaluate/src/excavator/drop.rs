//! The default estimator while the payload changes during the swing.
//!
//! JSON: `{"events":[{"event":..,"during":{..},"after":{..},"later":{..},"flag":{"median":..,"missed":..},
//! "valid_wrong":{"median":..,"p95":..,"max":..},"targets":[..],"met":..},..],"no_change":{..},
//! "sweep":[{"first":..,"during":{..},"after":{..}},..]}`. `during` is from first to last
//! material, `after` 0.3 to 0.5 s after, `later` from 0.5 s on; errors in percent; `flag` is the time from the
//! first material to the flag `changing`, `valid_wrong` the time with a valid value wrong by more than 10 % \[s\].

use super::case::{Case, PAYLOADS};
use super::estimators::{Point, Setup, series};
use super::score::{Score, Summary, Window};
use super::target::{Target, all_met, judgement, recorded};
use crate::text::{Table, plain};
use crate::{Error, Options, Report, seeds};
use serde_json::{Value, json};
use sim::excavator::Scenario::{self, *};
use statistics::{largest, mean, mean_error, median, p95, percentage};

/// Targets of an event; there is none for a part that the swing does not reach.
#[derive(Clone, Copy)]
struct Requirement {
    during: Option<f64>,
    later: f64,
    /// Whether the bucket is measured to open.
    visible: bool,
}

const fn seen(during: f64) -> Requirement {
    Requirement {
        during: Some(during),
        later: 5.5,
        visible: true,
    }
}

const fn unseen() -> Requirement {
    Requirement {
        during: None,
        later: 11.0,
        visible: false,
    }
}

const EVENTS: [(Scenario, Requirement); 15] = [
    (DropAccelerating, seen(12.0)),
    (DropReversal, seen(25.0)),
    (Drop, seen(37.0)),
    (DropBraking, seen(37.0)),
    (HalfAccelerating, seen(12.0)),
    (HalfBraking, seen(37.0)),
    (SlowDrop, seen(17.0)),
    (
        SlowBraking,
        Requirement {
            later: 7.0,
            ..seen(17.0)
        },
    ),
    (OpenAccelerating, seen(12.0)),
    (OpenBraking, seen(37.0)),
    (OpenEmpty, seen(37.0)),
    (StillAccelerating, unseen()),
    (StillBraking, unseen()),
    (PickUpAccelerating, unseen()),
    (PickUpBraking, unseen()),
];

/// Largest error after a detected change, and after an undetected one [%].
const AFTER: (f64, f64) = (7.0, 11.0);
/// Largest delay of the flag after the first material if the bucket does not move [s].
const FLAG: f64 = 0.45;

/// Least velocity of a scored sample: a change may be close to a stop [rad/s].
const SWINGS: f64 = 0.05;

fn swinging(from: f64, to: f64) -> Window {
    let velocity = SWINGS;
    Window { from, to, velocity }
}

/// Period of the samples [s].
const PERIOD: f64 = 0.01;

struct Outcome {
    during: Score,
    after: Score,
    later: Score,
    /// Time from the first material to the flag [s].
    flag: Option<f64>,
    /// Time with a valid value that is wrong [s].
    valid_wrong: f64,
}

/// Evaluates the table.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut table = Table::headed(
        "event; during: max median; p95; coverage; after: p95; coverage; later: p95; flag s; missed %; valid wrong s; p95; max; target",
    );
    let (mut list, mut met) = (Vec::new(), true);
    for (scenario, asked) in EVENTS {
        let outcomes = outcomes(options, scenario)?;
        let event = Event::of(scenario, asked, &outcomes);
        met &= all_met(&event.targets);
        table.row(event.cells());
        list.push(event.json());
    }
    let (alarms, alarm_targets) = false_alarms(options)?;
    met &= all_met(&alarm_targets);
    let (sweep_table, sweep) = sweep(options)?;
    let text = format!(
        "Payload that changes in the swing (D_auto): largest errors in percent, {} seeds\n\n{table}  \
         without a change: false alarms in {alarms:.2} % of the swings: {}\n\n{SWEEP}\n{sweep_table}",
        options.seeds,
        judgement(&alarm_targets),
    );
    let json = json!({
        "events": list, "sweep": sweep,
        "no_change": { "false_alarms": alarms, "targets": alarm_targets.iter().map(Target::json).collect::<Vec<_>>() },
    });
    Ok(Report { text, json, met })
}

fn outcomes(options: &Options, scenario: Scenario) -> Result<Vec<Outcome>, Error> {
    let case = Case::new(scenario, None);
    let (first, last) = scenario.change().unwrap_or((f64::INFINITY, f64::INFINITY));
    let setup = Setup::auto();
    seeds(options, scenario.name(), |seed| {
        let points = series(&case, &setup, seed)?;
        let score = |from, to| Score::of(&points, swinging(from, to));
        let is_wrong = |p: &&Point| p.time >= first && valid_and_wrong(p);
        Ok(Outcome {
            during: score(first, last),
            after: score(last + 0.3, last + 0.5),
            later: score(last + 0.5, 9.3),
            flag: flag(&points, first),
            valid_wrong: PERIOD * points.iter().filter(is_wrong).count() as f64,
        })
    })
}

/// Valid here means converged and not changing: trust needs seconds, longer than a load falls.
fn valid_and_wrong(point: &Point) -> bool {
    let flags = point.estimate.flags;
    let valid = flags.converged && !flags.changing;
    valid && point.is_far() && point.truth.velocity.abs() >= 0.05
}

/// Time from the first material to the flag; negative if the flag was set before.
fn flag(points: &[Point], first: f64) -> Option<f64> {
    let before = points.iter().rev().skip_while(|p| p.time > first - 1e-9);
    let raised = before.take_while(|p| p.estimate.flags.changing).last();
    let later = points
        .iter()
        .find(|p| p.time >= first - 1e-9 && p.estimate.flags.changing);
    raised.or(later).map(|p| p.time - first)
}

struct Event {
    scenario: Scenario,
    during: Summary,
    after: Summary,
    later: Summary,
    /// Whether the swing lasts long enough for samples after and later.
    reached: (bool, bool),
    flag: f64,
    missed: f64,
    /// Median, 95th percentile and largest [s].
    valid_wrong: (f64, f64, f64),
    targets: Vec<Target>,
}

impl Event {
    fn of(scenario: Scenario, asked: Requirement, outcomes: &[Outcome]) -> Self {
        let summary = |part: fn(&Outcome) -> Score| {
            Summary::of(&outcomes.iter().map(part).collect::<Vec<_>>())
        };
        let flags: Vec<f64> = outcomes.iter().filter_map(|o| o.flag).collect();
        let wrong: Vec<f64> = outcomes.iter().map(|o| o.valid_wrong).collect();
        let mut event = Self {
            scenario,
            during: summary(|o| o.during),
            after: summary(|o| o.after),
            later: summary(|o| o.later),
            reached: (
                outcomes.iter().all(|o| o.after.samples > 0),
                outcomes.iter().all(|o| o.later.samples > 0),
            ),
            flag: median(&flags),
            missed: percentage(outcomes.iter().map(|o| o.flag.is_none())),
            valid_wrong: (median(&wrong), p95(&wrong), largest(&wrong)),
            targets: Vec::new(),
        };
        event.targets = event.asked(asked);
        event
    }

    fn asked(&self, asked: Requirement) -> Vec<Target> {
        let mut targets = vec![Target::most("missed", self.missed, 0.0)];
        targets.extend(asked.during.map(|most| {
            Target::most("during", self.during.max_p95, most).known_to(self.during.error.max_p95)
        }));
        if self.reached.0 {
            let after = if asked.visible { AFTER.0 } else { AFTER.1 };
            targets.push(
                Target::most("after", self.after.max_p95, after).known_to(self.after.error.max_p95),
            );
        }
        if self.reached.1 {
            targets.push(
                Target::most("later", self.later.max_p95, asked.later)
                    .known_to(self.later.error.max_p95),
            );
        }
        if asked.visible {
            targets.push(
                Target::least("coverage", self.during.coverage, 95.0)
                    .known_to(self.during.error.coverage),
            );
            targets.push(Target::most("valid wrong", self.valid_wrong.2, 0.0));
        } else {
            targets.push(Target::most("flag", self.flag, FLAG));
        }
        targets
    }

    fn cells(&self) -> Vec<String> {
        let if_any = |any: bool, value: f64| if any { plain(value, 1) } else { "-".into() };
        vec![
            self.scenario.name().into(),
            plain(self.during.max_median, 1),
            plain(self.during.max_p95, 1),
            plain(self.during.coverage, 0),
            if_any(self.reached.0, self.after.max_p95),
            if_any(self.reached.0, self.after.coverage),
            if_any(self.reached.1, self.later.max_p95),
            plain(self.flag, 2),
            plain(self.missed, 0),
            plain(self.valid_wrong.0, 2),
            plain(self.valid_wrong.1, 2),
            plain(self.valid_wrong.2, 2),
            judgement(&self.targets),
        ]
    }

    fn json(&self) -> Value {
        let record = json!({
            "event": self.scenario.name(), "during": self.during.json(), "after": self.after.json(),
            "later": self.later.json(), "flag": { "median": self.flag, "missed": self.missed },
            "valid_wrong": {
                "median": self.valid_wrong.0, "p95": self.valid_wrong.1, "max": self.valid_wrong.2,
            },
        });
        recorded(record, &self.targets)
    }
}

/// Share of undisturbed swings in which the flag is set before the bucket opens at 9.3 s [%].
fn false_alarms(options: &Options) -> Result<(f64, Vec<Target>), Error> {
    let mut alarms = Vec::new();
    for payload in PAYLOADS {
        let case = Case::new(Base, Some(payload));
        alarms.extend(seeds(options, "false alarms", |seed| {
            Ok(series(&case, &Setup::auto(), seed)?
                .iter()
                .any(|p| p.time < 9.3 && p.estimate.flags.changing))
        })?);
    }
    let hits: Vec<f64> = alarms
        .iter()
        .map(|hit| if *hit { 100.0 } else { 0.0 })
        .collect();
    let target = Target::most("false alarms", mean(&hits), 1.0).known_to(mean_error(&hits));
    Ok((target.value, vec![target]))
}

const SWEEP: &str = "The same dump of 423 kg in 0.65 s at any time of the swing (no targets):\n";
/// Bucket openings of the sweep: the first [s], their distance [s], their number.
const OPENINGS: (f64, f64, usize) = (6.25, 0.15, 14);

/// Errors by the time at which the material begins to fall.
fn sweep(options: &Options) -> Result<(Table, Vec<Value>), Error> {
    let (mut table, mut list) = (
        Table::headed("first material s; during: max median; p95; coverage; after: p95; coverage"),
        Vec::new(),
    );
    for opens in (0..OPENINGS.2).map(|i| OPENINGS.0 + OPENINGS.1 * i as f64) {
        let first = opens + 0.15;
        let last = first + 0.65;
        let case = Case::of(Base, Scenario::dump_at(opens), Base.start());
        let scores = seeds(options, &format!("dump at {first:.2} s"), |seed| {
            let points = series(&case, &Setup::auto(), seed)?;
            let score = |from, to| Score::of(&points, swinging(from, to));
            Ok((score(first, last), score(last + 0.3, last + 0.5)))
        })?;
        let during = Summary::of(&scores.iter().map(|s| s.0).collect::<Vec<_>>());
        let after = Summary::of(&scores.iter().map(|s| s.1).collect::<Vec<_>>());
        let reached = scores.iter().all(|s| s.1.samples > 0);
        let if_any = |value: f64| if reached { plain(value, 1) } else { "-".into() };
        table.row([
            plain(first, 2),
            plain(during.max_median, 1),
            plain(during.max_p95, 1),
            plain(during.coverage, 0),
            if_any(after.max_p95),
            if_any(after.coverage),
        ]);
        list.push(json!({
            "first": first, "during": during.json(),
            "after": if reached { after.json() } else { Value::Null },
        }));
    }
    Ok((table, list))
}
