//! `/metrics`: the state of a run in the text format of Prometheus.

use std::fmt::Write;
use std::time::Instant;

use crate::estimate::Estimate;
use crate::monitor::{Each, MachineState, Monitor};

/// The media type of the format.
pub(super) const KIND: &str = "text/plain; version=0.0.4; charset=utf-8";

macro_rules! rows {
    ($( $family:literal, $kind:literal, $help:literal; )*) => { [$( ($family, $kind, $help) ),*] };
}

/// Families with their kind and meaning.
const FAMILIES: [(&str, &str, &str); 14] = rows! {
    "heft_estimate", "gauge", "Estimated quantity, in the SI unit of its label.";
    "heft_estimate_std", "gauge", "Its standard deviation.";
    "heft_trusted", "gauge", "1 where heft trusts the quantity now.";
    "heft_last_trusted", "gauge", "The last trusted value.";
    "heft_last_trusted_age_seconds", "gauge", "Time since the last trusted value, on the machine's clock.";
    "heft_channel_messages_total", "counter", "Messages received.";
    "heft_channel_lost_total", "counter", "Messages that never came.";
    "heft_process_samples_total", "counter", "Samples treated by a process.";
    "heft_process_late_total", "counter", "Samples that came later than a period.";
    "heft_process_lost_total", "counter", "Samples that a process did not get.";
    "heft_process_restarts_total", "counter", "Times that a process was started again.";
    "heft_process_fault", "gauge", "Code of the last fault; 0 is none.";
    "heft_process_silent_seconds", "gauge", "Time since the last sign of life.";
    "heft_simulated", "gauge", "1 where the samples are a simulator's: nothing is measured.";
};

/// Samples by family.
#[derive(Debug, Default)]
struct Samples(Vec<(&'static str, String, f64)>);

impl Samples {
    fn add(&mut self, family: &'static str, labels: &[(&str, &str)], value: f64) {
        if !value.is_finite() {
            return;
        }
        let labels = labels.iter().map(|(name, text)| {
            let text = text
                .replace('\\', "\\\\")
                .replace('"', "\\\"")
                .replace('\n', "\\n");
            format!("{name}=\"{text}\"")
        });
        self.0
            .push((family, labels.collect::<Vec<_>>().join(","), value));
    }
}

/// All metrics of a run.
pub(super) fn text(monitor: &Monitor, now: Instant) -> String {
    let mut samples = Samples::default();
    monitor.machines.each(&mut samples);
    for (name, channel) in &monitor.channels {
        let labels = [("channel", *name)];
        samples.add("heft_channel_messages_total", &labels, channel.count as f64);
        samples.add("heft_channel_lost_total", &labels, channel.lost as f64);
    }
    for (index, process) in &monitor.processes {
        let (name, h) = (monitor.name(*index), &process.health);
        let labels = [("process", name.as_str())];
        let silent = now.saturating_duration_since(process.seen).as_secs_f64();
        for (family, value) in [
            ("heft_process_samples_total", h.steps as f64),
            ("heft_process_late_total", h.late as f64),
            ("heft_process_lost_total", h.lost as f64),
            ("heft_process_restarts_total", h.restarts as f64),
            ("heft_process_fault", f64::from(h.fault)),
            ("heft_process_silent_seconds", silent),
        ] {
            samples.add(family, &labels, value);
        }
    }
    samples.add(
        "heft_simulated",
        &[],
        f64::from(u8::from(monitor.is_simulated)),
    );
    written(&samples)
}

/// The estimates of a machine.
impl Each for &mut Samples {
    type Output = ();

    fn of<E: Estimate>(&mut self, state: &MachineState<E>) {
        for (channel, tracked) in &state.estimators {
            let (e, mut headline) = (&tracked.last, 0);
            for p in E::PARAMETERS {
                let labels = [
                    ("machine", E::MACHINE.name()),
                    ("channel", *channel),
                    ("method", e.method_name()),
                    ("quantity", p.key),
                    ("unit", p.unit),
                ];
                self.add("heft_estimate", &labels, p.value(e));
                self.add("heft_estimate_std", &labels, p.std(e));
                if !p.headline() {
                    continue;
                }
                let trusted = e.flags() & p.trusted != 0;
                self.add("heft_trusted", &labels, f64::from(u8::from(trusted)));
                if let Some(last) = tracked.trusted.get(headline).and_then(Option::as_ref) {
                    let age = e.stamp().time - last.stamp().time;
                    self.add("heft_last_trusted", &labels, p.value(last));
                    self.add("heft_last_trusted_age_seconds", &labels, age);
                }
                headline += 1;
            }
        }
    }
}

/// The samples grouped by family, as the format requires.
fn written(samples: &Samples) -> String {
    let mut out = String::new();
    for (family, kind, help) in FAMILIES {
        let mut its = samples.0.iter().filter(|s| s.0 == family).peekable();
        if its.peek().is_none() {
            continue;
        }
        let _ = writeln!(out, "# HELP {family} {help}\n# TYPE {family} {kind}");
        for (_, labels, value) in its {
            let labels = if labels.is_empty() {
                String::new()
            } else {
                format!("{{{labels}}}")
            };
            let _ = writeln!(out, "{family}{labels} {value}");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{LoaderEstimate, Stamp, channels, loader_bits as bits};

    #[test]
    fn the_last_trusted_value_and_its_age_are_reported() {
        let (mut monitor, start) = (Monitor::new(vec!["sensor".into()]), Instant::now());
        for (time, ratio, flags) in [(1.0, 0.4, bits::TRUSTED_RATIO), (3.5, 0.5, 0)] {
            let estimate = LoaderEstimate {
                stamp: Stamp {
                    time,
                    ..Default::default()
                },
                cg_ratio: ratio,
                cg_ratio_std: 0.01,
                estimated: bits::STATE,
                flags,
                ..Default::default()
            };
            monitor.push(&channels::LOADER_CG_UKF, &estimate, start);
        }
        let text = text(&monitor, start);
        let value = |family: &str| {
            let quantity = "quantity=\"cg_ratio\"";
            let line = text
                .lines()
                .find(|l| l.starts_with(&format!("{family}{{")) && l.contains(quantity));
            line.and_then(|l| l.rsplit(' ').next()?.parse::<f64>().ok())
        };
        assert_eq!(value("heft_estimate"), Some(0.5));
        assert_eq!(value("heft_trusted"), Some(0.0));
        assert_eq!(value("heft_last_trusted"), Some(0.4));
        assert_eq!(value("heft_last_trusted_age_seconds"), Some(2.5));
        // Each family once, with its kind before its samples.
        let kinds = text.lines().filter(|l| l.starts_with("# TYPE")).count();
        let distinct: std::collections::BTreeSet<_> =
            text.lines().filter(|l| l.starts_with("# TYPE")).collect();
        assert_eq!(kinds, distinct.len());
    }
}
