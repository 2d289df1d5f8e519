//! The numbers as JSON.

use std::fs;
use std::path::Path;

use hdrhistogram::Histogram;
use limits::Kind;
use serde_json::{Value, json};

use super::measure::{Measured, max_us, us};
use crate::failure::Failure;

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
    let futex = m.limit(Kind::Futex).map(percentiles);
    let bins: Vec<Value> = m
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
        "load": m.conditions.loaded,
        "e2e_us": percentiles(&m.end_to_end),
        "last_hop_by_event_us": percentiles(&m.by_event),
        "hops_us": m.hops.iter().map(percentiles).collect::<Vec<_>>(),
        "limit_us": futex,
        "limits_us": limits,
        "ratio_p50": m.ratio(0.5),
        "ratio_p999": m.ratio(0.999),
        "lost": m.lost,
        "samples": m.end_to_end.len(),
        "histogram_us": bins,
    })
}

/// The first measurement at the top, all of them below it.
pub fn write(file: &Path, all: &[Value]) -> Result<(), Failure> {
    let mut top = all.first().cloned().unwrap_or_else(|| json!({}));
    if let Some(object) = top.as_object_mut() {
        object.insert("runs".into(), json!(all));
    }
    let text = serde_json::to_string_pretty(&top).map_err(Failure::internal)?;
    fs::write(file, text + "\n").map_err(|e| Failure::file("write", file, &e))
}
