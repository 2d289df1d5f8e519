//! Forgetting factors and updating rules over time.

use messages::{ExcavatorEstimate, excavator_bits as bits};

use crate::estimate::method;
use crate::panels::{Panel, TIME};
use crate::plot::{Plot, Style};

/// One of the three forgetting factors.
type Factor = fn(&ExcavatorEstimate) -> f64;

pub(super) fn forgetting(estimates: &[ExcavatorEstimate]) -> Option<Panel> {
    let used = |e: &ExcavatorEstimate| e.forgetting_inertia > 0.0;
    estimates.iter().any(used).then(|| {
        let title = format!("Forgetting factors [–]: {}", method(estimates));
        let mut plot = Plot::new(title, TIME).y_range(0.0, 1.05);
        let lines: [(&str, Factor); 3] = [
            ("inertia", |e| e.forgetting_inertia),
            ("damping", |e| e.forgetting_damping),
            ("torque", |e| e.forgetting_torque),
        ];
        for (i, (label, value)) in lines.into_iter().enumerate() {
            let points: Vec<_> = estimates.iter().map(|e| (e.stamp.time, value(e))).collect();
            if points.iter().any(|p| p.1 > 0.0) {
                plot.line(label, Style::Series(i), &points);
            }
        }
        Panel::half(plot, "")
    })
}

pub(super) fn activity(estimates: &[ExcavatorEstimate]) -> Option<Panel> {
    let acts = |e: &ExcavatorEstimate| e.flags & (bits::NOMINAL | bits::WINDOW) != 0;
    estimates.iter().any(acts).then(|| {
        let title = format!("Updating rules: {}", method(estimates));
        let mut plot = Plot::new(title, TIME)
            .y_range(-0.1, 1.1)
            .y_names(vec![(0.0, "rests".into()), (1.0, "acts".into())]);
        let rules = [
            ("nominal damping", bits::NOMINAL),
            ("change window", bits::WINDOW),
        ];
        for (i, (label, bit)) in rules.into_iter().enumerate() {
            let value = |e: &ExcavatorEstimate| f64::from(u8::from(e.flags & bit != 0));
            let points: Vec<_> = estimates.iter().map(|e| (e.stamp.time, value(e))).collect();
            plot.line(label, Style::Series(i), &points);
        }
        Panel::half(plot, "")
    })
}
