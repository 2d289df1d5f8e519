//! Loads, trucks and sums as JSON.

use estimation::HALF_WIDTH_95;
use estimation::loads::{Load, Now, Total, Truck, Weight};
use messages::Machine;
use serde_json::{Value, json};
use steps::loads::{LoadCounter, Outage, outage_words, why_words};

use super::{Account, outage_advice, outages, what_to_do};

fn weight_json(weight: &Weight) -> Value {
    let [low, high] = weight.interval();
    json!({"kg": weight.kg, "std": weight.std, "common_std": weight.common_std, "low": low, "high": high})
}

/// A load as JSON.
fn load_json(machine: Machine, load: &Load) -> Value {
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
pub(super) fn total_json(total: &Total) -> Value {
    let half = HALF_WIDTH_95 * total.std();
    json!({
        "loads": total.loads, "untrusted": total.untrusted, "unweighed": total.unweighed, "kg": total.kg, "std": total.std(),
        "own_std": total.own_variance.sqrt(), "common_std": total.common_std,
        "low": total.kg - half, "high": total.kg + half,
    })
}

/// A truck as JSON.
fn truck_json(truck: &Truck) -> Value {
    json!({
        "truck": truck.number, "signal": truck.signal, "day": truck.day, "from": truck.from, "to": truck.to,
        "total": total_json(&truck.total), "target": truck.target, "remaining": truck.remaining(),
    })
}

/// Content of the bucket now, as JSON.
fn now_json(now: &Now) -> Value {
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
