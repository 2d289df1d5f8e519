//! Measured latencies as JSON.

use std::path::Path;

use hdrhistogram::Histogram;
use limits::Primitive;
use serde_json::{Value, json};

use super::measure::{Measured, Passage, max_us, us};
use crate::build::IDENTITY;
use crate::failure::Failure;
use crate::results;

const QUANTILES: [(&str, f64); 3] = [("p50", 0.5), ("p99", 0.99), ("p999", 0.999)];

fn percentiles(h: &Histogram<u64>) -> Value {
    let mut object = serde_json::Map::new();
    for (name, quantile) in QUANTILES {
        object.insert(name.into(), json!(us(h, quantile)));
    }
    object.insert("max".into(), json!(max_us(h)));
    Value::Object(object)
}

/// One set of conditions.
pub fn record(m: &Measured) -> Value {
    let limits: serde_json::Map<String, Value> = m
        .limits
        .iter()
        .filter(|(_, h)| !h.is_empty())
        .map(|(kind, h)| (kind.name().to_owned(), percentiles(h)))
        .collect();
    let futex = m.limit(Primitive::Futex).map(percentiles);
    let hops = |p: &Passage| p.hops.iter().map(percentiles).collect::<Vec<_>>();
    let by_bell = m.conditions.spin.as_ref().map(|_| {
        json!({
            "e2e_us": percentiles(&m.by_bell.end_to_end),
            "hops_us": hops(&m.by_bell),
            "lost": m.by_bell.lost,
        })
    });
    let bins: Vec<Value> = m
        .ours
        .end_to_end
        .iter_log(1_000, 1.25)
        .filter(|bin| bin.count_since_last_iteration() > 0)
        .map(|bin| {
            json!([
                bin.value_iterated_to() as f64 / 1e3,
                bin.count_since_last_iteration()
            ])
        })
        .collect();
    json!({
        "rate": m.conditions.rate,
        "rt": m.conditions.realtime,
        "cores": m.conditions.cores(),
        "load": m.conditions.loaded,
        "machine": m.chain.machine.name(),
        "spin": m.conditions.spin,
        "by_bell": by_bell,
        "e2e_us": percentiles(&m.ours.end_to_end),
        "last_hop_by_event_us": percentiles(&m.by_event),
        "hops_us": hops(&m.ours),
        "limit_us": futex,
        "limits_us": limits,
        "ratio_p50": m.ratio(0.5),
        "ratio_p999": m.ratio(0.999),
        "lost": m.ours.lost,
        "samples": m.ours.end_to_end.len(),
        "histogram_us": bins,
    })
}

/// Writes the first measurement at the top, and all of them below it.
pub fn write(file: &Path, all: &[Value]) -> Result<(), Failure> {
    let mut top = all.first().cloned().unwrap_or_else(|| json!({}));
    if let Some(object) = top.as_object_mut() {
        object.insert("runs".into(), json!(all));
    }
    results::json(file, &[], "latency", IDENTITY, &top)
}

#[cfg(test)]
mod tests {
    use super::super::chain::Chain;
    use super::super::conditions::Conditions;
    use super::*;
    use messages::Machine;

    #[test]
    fn a_record_says_what_was_measured_where_and_next_to_what() {
        let conditions = Conditions {
            rate: 1_000.0,
            realtime: true,
            pinned: vec![0, 1],
            loaded: false,
            spin: None,
        };
        let chain = Chain::of(Machine::Excavator);
        let mut measured = Measured::new(&chain, &conditions).unwrap();
        measured.ours.end_to_end.record(30_000).unwrap();
        let futex = measured
            .limits
            .iter_mut()
            .find(|(k, _)| *k == Primitive::Futex);
        futex.unwrap().1.record(20_000).unwrap();
        let record = record(&measured);
        assert_eq!(record["rate"], 1_000.0);
        assert_eq!(record["rt"], true);
        assert_eq!(record["cores"], 2);
        for key in ["e2e_us", "limit_us"] {
            for quantile in ["p50", "p99", "p999", "max"] {
                assert!(record[key][quantile].is_f64(), "{key} {quantile}");
            }
        }
        // 30 over 20 µs, in a histogram of three digits.
        for ratio in ["ratio_p50", "ratio_p999"] {
            let ratio = record[ratio].as_f64().unwrap();
            assert!((ratio - 1.5).abs() < 3e-3, "{ratio}");
        }
        assert_eq!(record["lost"], 0);
        assert_eq!(record["limits_us"].as_object().unwrap().len(), 1);
    }
}
