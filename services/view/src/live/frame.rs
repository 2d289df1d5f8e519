//! The transmitted JSON: numbers 30 times a second, words 4 times a second.

use std::time::Instant;

use messages::fault;
use serde_json::{Map, Value, json};

use crate::estimate::{Estimate, Parameter};
use crate::monitor::{ChannelState, Each, MachineState, Monitor, ProcessState, Tracked};
use crate::number::{large, nanoseconds};
use crate::posture::{JOINTS, Posture};
use crate::report::state_name;

/// The numbers of all estimators: `{t, e: [{c, v: [[value, std]...], k: trusted, n: NIS, f: forgetting}], truth}`.
pub(super) fn series(monitor: &Monitor) -> String {
    let all = monitor.machines.each(Series).concat();
    let truths = monitor.machines.each(Truth);
    json!({
        "t": monitor.time,
        "e": all,
        "truth": truths.into_iter().collect::<Map<_, _>>(),
        "p": monitor.postures.iter().map(|(m, p)| ((*m).to_owned(), posture(p))).collect::<Map<_, _>>(),
    })
    .to_string()
}

/// Angles by the names of their joints [rad]; unmeasured ones are left out.
fn posture(posture: &Posture) -> Value {
    let joints = JOINTS.iter().zip(posture);
    let known = joints.filter_map(|(name, angle)| Some(((*name).to_owned(), number((*angle)?))));
    Value::Object(known.collect())
}

/// The numbers of the estimators of a machine.
struct Series;

impl Each for Series {
    type Output = Vec<Value>;

    fn of<E: Estimate>(&mut self, state: &MachineState<E>) -> Vec<Value> {
        let one = |(channel, tracked): (&&'static str, &Tracked<E>)| {
            let last = &tracked.last;
            let values = E::PARAMETERS
                .iter()
                .map(|p| json!([number(p.value(last)), number(p.std(last))]));
            let trusted = E::headlines().map(|p| u8::from(last.flags() & p.trusted != 0));
            json!({
                "c": channel,
                "m": last.method_name(),
                "v": values.collect::<Vec<_>>(),
                "k": trusted.collect::<Vec<_>>(),
                "n": number(tracked.nis_mean),
                "f": last.forgetting(),
            })
        };
        state.estimators.iter().map(one).collect()
    }
}

/// The name of a machine, and the truth of its parameters.
struct Truth;

impl Each for Truth {
    type Output = (String, Value);

    fn of<E: Estimate>(&mut self, state: &MachineState<E>) -> (String, Value) {
        let truth = state.truth.as_ref().map_or(Value::Null, |t| {
            E::PARAMETERS.iter().map(|p| number(p.truth(t))).collect()
        });
        (E::MACHINE.name().to_owned(), truth)
    }
}

/// Seven digits, more than a screen shows; null for a number that is not finite.
fn number(value: f64) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    format!("{value:.6e}")
        .parse::<f64>()
        .map_or(Value::Null, Value::from)
}

/// Verdicts, processes and channels in words.
pub(super) fn status(
    monitor: &Monitor,
    loads: Option<Value>,
    now: Instant,
    viewers: usize,
    skipped: u64,
) -> String {
    let verdicts = monitor.machines.each(Judgements).concat();
    let processes = monitor
        .processes
        .iter()
        .map(|(i, p)| process(&monitor.name(*i), p, now));
    let channels = monitor
        .channels
        .iter()
        .map(|(name, c)| channel(name, c, now));
    json!({
        "verdicts": verdicts,
        "processes": processes.collect::<Vec<_>>(),
        "channels": channels.collect::<Vec<_>>(),
        "simulated": monitor.is_simulated,
        "loads": loads,
        "viewers": viewers,
        "skipped": skipped,
    })
    .to_string()
}

/// The verdicts on a machine, in words.
struct Judgements;

impl Each for Judgements {
    type Output = Vec<Value>;

    fn of<E: Estimate>(&mut self, state: &MachineState<E>) -> Vec<Value> {
        // The default method, ukf, comes before the regression.
        let one = |(channel, tracked): (&&'static str, &Tracked<E>)| {
            let last = &tracked.last;
            let figures = |p: &Parameter<E, E::Truth>, e: &E| {
                let (number, interval) = large(p.value(e), p.std(e), p.unit);
                json!({"number": number, "interval": interval, "time": e.stamp().time})
            };
            let words = last
                .judgements()
                .into_iter()
                .zip(E::headlines())
                .zip(&tracked.trusted);
            let words = words.map(|((j, p), trusted)| {
                json!({
                    "title": p.label,
                    "now": p.value(last).is_finite().then(|| figures(p, last)),
                    "value": j.value.clone(),
                    "trusted": j.trusted,
                    "verdict": j.verdict(),
                    "advice": j.what_to_do(),
                    "last": trusted.as_ref().map(|e| figures(p, e)),
                })
            });
            json!({
                "channel": channel,
                "machine": E::MACHINE.name(),
                "method": tracked.last.method_name(),
                "time": tracked.last.stamp().time,
                "judgements": words.collect::<Vec<_>>(),
            })
        };
        state.estimators.iter().rev().map(one).collect()
    }
}

fn process(name: &str, state: &ProcessState, now: Instant) -> Value {
    let h = &state.health;
    let ns = |ns: u64| nanoseconds(ns as f64);
    json!({
        "name": name,
        "pid": h.pid,
        "state": state_name(h.state),
        "silent_s": now.saturating_duration_since(state.seen).as_secs_f64(),
        "rate": state.rate(),
        "lost": h.lost,
        "late": h.late,
        "restarts": h.restarts,
        "step": format!("{} / {}", ns(h.step_p50_ns), ns(h.step_p99_ns)),
        "age": format!("{} / {}", ns(h.age_p50_ns), ns(h.age_p999_ns)),
        "fault": fault::text(h.fault),
    })
}

fn channel(name: &str, state: &ChannelState, now: Instant) -> Value {
    json!({
        "name": name,
        "rate": state.rate(),
        "lost": state.lost,
        "count": state.count,
        "silent_s": now.saturating_duration_since(state.seen).as_secs_f64(),
    })
}
