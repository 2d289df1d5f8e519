//! Alarms: a run that was killed or failed, a machine that is silent or has not been trusted for a long time, and learnt
//! parameters that have drifted by more than their intervals allow.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::live::{Fleet, Machine, SILENT};
use super::shown::{Quantity, quantities};
use crate::key::MachineId;

/// Drift limit, in standard deviations of the difference of two estimates. Independent normal errors exceed it with a probability of
/// 1 in 16 000. Errors of one machine are not independent, so their probability is less.
const DRIFT: f64 = 4.0;
/// Clock error beyond which an alarm is raised [ms].
const CLOCK_MS: i64 = 10_000;

/// Number of machines with the same new alarm beyond which one line reports them all.
const MANY: usize = 10;

/// Text for a run that was killed, or whose supervisor gave up.
const BROKE_OFF: &str = "its run broke off: killed, or given up after failures";

/// What is an alarm.
#[derive(Debug, Clone, clap::Args)]
pub struct AlarmArgs {
    /// Minutes for which a running machine was not trusted; or a time such as 2h
    #[arg(long, default_value_t = 30.0, value_name = "MIN", value_parser = minutes)]
    pub untrusted_after: f64,
}

/// Parses a duration [min]; a bare number is in minutes.
fn minutes(text: &str) -> Result<f64, String> {
    super::counted(text, 60.0)
}

/// An alarm that was raised or is over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alarm {
    /// The machine.
    pub id: MachineId,
    /// Kind of alarm.
    pub kind: &'static str,
    /// Description for people.
    pub text: String,
}

impl std::fmt::Display for Alarm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.id, self.text)
    }
}

/// Checks every machine; returns the alarms that were raised or ended.
pub fn look(fleet: &mut Fleet, args: &AlarmArgs) -> Vec<Alarm> {
    let limit = Duration::from_secs_f64(args.untrusted_after * 60.0);
    // After a start of the collector, contact with a present machine may take up to this time.
    let is_early = fleet.begun.is_some_and(|begun| begun.elapsed() < SILENT);
    let mut changed = Vec::new();
    for (id, machine) in &mut fleet.machines {
        if is_early && !machine.is_here() {
            continue;
        }
        let before = std::mem::take(&mut machine.alarms.on);
        let now = found(machine, &before, limit);
        for (kind, text) in &now {
            if !before.contains_key(kind) {
                let (id, text) = (id.clone(), text.clone());
                changed.push(Alarm { id, kind, text });
            }
        }
        for kind in before.keys().filter(|k| !now.contains_key(*k)) {
            let text = format!("{kind}: over");
            let id = id.clone();
            changed.push(Alarm { id, kind, text });
        }
        machine.alarms.on = now;
    }
    changed
}

/// Alarms of a machine now, as texts by kind; `before`: those of the last check.
fn found(
    machine: &mut Machine,
    before: &BTreeMap<&'static str, String>,
    limit: Duration,
) -> BTreeMap<&'static str, String> {
    let mut on = BTreeMap::new();
    if machine.broke_off {
        // The silence that follows is part of the same fault. Whether the earlier alarms are over is unknown, so they stay.
        machine.alarms.untrusted = None;
        on.clone_from(before);
        on.insert("broken", BROKE_OFF.to_owned());
        return on;
    }
    if !machine.is_here() {
        machine.alarms.untrusted = None;
        if !machine.ended && !machine.is_stranger() {
            // Whether the earlier alarms are over is unknown, so they stay.
            on.clone_from(before);
            let text = format!("silent for more than {} s", SILENT.as_secs());
            on.insert("silent", text);
        }
        return on;
    }
    if machine.clock_ms.abs() > CLOCK_MS {
        let seconds = machine.clock_ms as f64 / 1e3;
        on.insert("clock", format!("its clock is off by {seconds:+.0} s"));
    }
    let all = machine
        .main("estimate")
        .map(|(_, e)| quantities(e))
        .unwrap_or_default();
    let trusted = all.first().is_some_and(|q| q.trusted);
    let since = *machine.alarms.untrusted.get_or_insert_with(Instant::now);
    if trusted {
        machine.alarms.untrusted = None;
    } else if since.elapsed() >= limit {
        let minutes = since.elapsed().as_secs() / 60;
        on.insert("untrusted", format!("not trusted for {minutes} min"));
    }
    for quantity in all.into_iter().filter(|q| q.learnt && q.trusted) {
        let first = machine
            .alarms
            .first
            .entry(quantity.key)
            .or_insert_with(|| quantity.clone());
        if let Some(text) = drift(first, &quantity) {
            let all = on.entry("drift").or_default();
            let comma = if all.is_empty() { "" } else { "; " };
            *all += &format!("{comma}{text}");
        }
    }
    on
}

/// Describes a parameter that has drifted by more than [`DRIFT`].
fn drift(first: &Quantity, now: &Quantity) -> Option<String> {
    let std = first.std.hypot(now.std);
    ((now.value - first.value).abs() > DRIFT * std)
        .then(|| format!("{} was {} and is {}", now.label, first.text(), now.text()))
}

/// Lines for people: alarms of one kind that many machines raise at once share a line.
pub fn lines(raised: &[Alarm]) -> Vec<String> {
    let mut kinds: BTreeMap<(&str, bool), Vec<&Alarm>> = BTreeMap::new();
    for alarm in raised {
        let is_over = alarm.text.ends_with(": over");
        kinds.entry((alarm.kind, is_over)).or_default().push(alarm);
    }
    let line = |alarms: Vec<&Alarm>| match alarms.as_slice() {
        [first, .., last] if alarms.len() > MANY => vec![format!(
            "{} machines, from {} to {}: {}",
            alarms.len(),
            first.id,
            last.id,
            first.text
        )],
        all => all.iter().map(ToString::to_string).collect(),
    };
    kinds.into_values().flat_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status::Status;

    fn args() -> AlarmArgs {
        AlarmArgs {
            untrusted_after: 0.0,
        }
    }

    #[test]
    fn a_silent_machine_is_reported_once_and_so_is_its_return() {
        let mut fleet = Fleet::default();
        let id = MachineId::new("north", "ex-1").expect("names");
        fleet.known(&id, "excavator", "0.1", false);
        let raised = look(&mut fleet, &args());
        assert_eq!(raised.len(), 1);
        assert_eq!(raised[0].kind, "silent");
        assert!(look(&mut fleet, &args()).is_empty());
        let status = Status {
            wall_ms: crate::wall_ms(),
            ..Default::default()
        };
        fleet.status(&id, status, 1);
        let kinds: Vec<_> = look(&mut fleet, &args())
            .into_iter()
            .map(|a| (a.kind, a.text))
            .collect();
        assert!(
            kinds.contains(&("silent", "silent: over".into())),
            "{kinds:?}"
        );
        assert!(kinds.iter().any(|k| k.0 == "untrusted"), "{kinds:?}");
    }

    #[test]
    fn what_was_wrong_before_a_machine_fell_silent_is_not_over_by_that() {
        let mut fleet = Fleet::default();
        let id = MachineId::new("north", "ex-1").expect("names");
        fleet.known(&id, "excavator", "0.1", false);
        let machine = fleet.machines.get_mut(&id).expect("it");
        machine
            .alarms
            .on
            .insert("drift", "Damping was 1 and is 2".into());
        let raised = look(&mut fleet, &args());
        assert_eq!(
            raised.iter().map(|a| a.kind).collect::<Vec<_>>(),
            ["silent"]
        );
    }

    #[test]
    fn after_a_start_no_machine_is_silent_before_it_could_be_received_nor_one_that_had_ended() {
        let mut fleet = Fleet::default();
        for (name, ended) in [("ex-1", false), ("ex-2", true)] {
            let id = MachineId::new("north", name).expect("names");
            fleet.known(&id, "excavator", "0.1", ended);
        }
        fleet.begun = Some(Instant::now());
        assert_eq!(look(&mut fleet, &args()), []);
        fleet.begun = Instant::now().checked_sub(SILENT);
        let raised = look(&mut fleet, &args());
        let raised: Vec<_> = raised.iter().map(|a| a.id.machine.as_str()).collect();
        assert_eq!(raised, ["ex-1"]);
    }

    #[test]
    fn a_machine_that_ended_is_not_silent() {
        let mut fleet = Fleet::default();
        let id = MachineId::new("north", "ex-1").expect("names");
        let status = Status {
            ended: true,
            wall_ms: crate::wall_ms(),
            ..Default::default()
        };
        fleet.status(&id, status, 1);
        fleet.token(&id, false);
        assert!(look(&mut fleet, &args()).is_empty());
    }

    #[test]
    fn a_run_that_broke_off_is_one_alarm_until_the_next_begins() {
        let mut fleet = Fleet::default();
        let id = MachineId::new("north", "ex-1").expect("names");
        let of = |broke_off| Status {
            broke_off,
            wall_ms: crate::wall_ms(),
            ..Default::default()
        };
        let args = AlarmArgs {
            untrusted_after: 30.0,
        };
        let kinds = |fleet: &mut Fleet| -> Vec<String> {
            let raised = look(fleet, &args).into_iter();
            raised.map(|a| format!("{} {}", a.kind, a.text)).collect()
        };
        fleet.status(&id, of(true), 1);
        assert_eq!(kinds(&mut fleet), [format!("broken {BROKE_OFF}")]);
        // Its gateway leaves.
        fleet.token(&id, false);
        assert_eq!(kinds(&mut fleet), [""; 0]);
        fleet.status(&id, of(false), 2);
        assert_eq!(kinds(&mut fleet), ["broken broken: over"]);
    }

    #[test]
    fn a_parameter_has_drifted_when_the_intervals_say_so() {
        let at = |value, std| Quantity {
            key: "damping",
            label: "Damping",
            unit: "N m s/rad",
            value,
            std,
            trusted: true,
            learnt: true,
            is_load: false,
        };
        assert_eq!(drift(&at(100.0, 3.0), &at(118.0, 4.0)), None);
        assert!(drift(&at(100.0, 3.0), &at(121.0, 4.0)).is_some_and(|t| t.contains("Damping")));
    }
}
