//! Age of a sample after each hop.

use super::Panel;
use crate::estimate::Estimate;
use crate::plot::{Plot, Style};
use crate::run::Estimator;
use statistics::quantile;

/// The sorted latencies of one hop.
#[derive(Debug, Clone)]
pub struct Hop {
    /// "sensor → estimate".
    pub name: &'static str,
    /// Latencies, ascending \[ns\].
    pub sorted_ns: Vec<f64>,
}

impl Hop {
    /// Quantile `q` \[ns\].
    pub fn quantile_ns(&self, q: f64) -> f64 {
        quantile(&self.sorted_ns, q)
    }
}

/// The hops of an estimator, from the publish times in its messages, and the whole path. Empty if nothing was published (a run on
/// a file).
pub fn hops<E: Estimate>(estimator: &Estimator<E>) -> Vec<Hop> {
    type Pick<E> = fn(&E) -> (u64, u64);
    let table: [(&'static str, Pick<E>); 5] = [
        ("measurement → sensor", |e| {
            (e.stamp().measured_ns, e.hops().sensor_ns)
        }),
        ("sensor → filter", |e| {
            (e.hops().sensor_ns, e.hops().filter_ns)
        }),
        ("filter → estimate", |e| {
            (e.hops().filter_ns, e.hops().estimate_ns)
        }),
        ("sensor → estimate", |e| {
            (e.hops().sensor_ns, e.hops().estimate_ns)
        }),
        ("whole way", |e| {
            (e.stamp().measured_ns, e.hops().estimate_ns)
        }),
    ];
    let hop = |(name, pick): (&'static str, Pick<E>)| {
        let passed = estimator
            .estimates
            .iter()
            .map(pick)
            .filter(|t| t.0 > 0 && t.1 >= t.0);
        let mut sorted_ns: Vec<_> = passed.map(|t| (t.1 - t.0) as f64).collect();
        sorted_ns.sort_by(f64::total_cmp);
        (!sorted_ns.is_empty()).then_some(Hop { name, sorted_ns })
    };
    table.into_iter().filter_map(hop).collect()
}

/// The share of samples that took longer, over the latency.
pub fn panel(title: &str, hops: &[Hop]) -> Option<Panel> {
    let mut plot = Plot::new(title, "Latency [µs]").logarithmic();
    for (i, hop) in hops.iter().enumerate() {
        plot.line(hop.name, Style::Series(i), &exceedance(&hop.sorted_ns));
    }
    (!hops.is_empty()).then(|| Panel::half(plot, ""))
}

fn exceedance(sorted_ns: &[f64]) -> Vec<(f64, f64)> {
    let n = sorted_ns.len() as f64;
    let point = |(i, ns): (usize, &f64)| (ns.max(1.0) / 1e3, 1.0 - i as f64 / n);
    sorted_ns.iter().enumerate().map(point).collect()
}
