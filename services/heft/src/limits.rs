//! Which stated deviations limit the 95 % intervals on given data: in turn each is stated next to exactly, and the data are estimated again.

use std::fmt::Write;

use config::Description;
use messages::Envelope;
use statistics::{median, percentile};
use steps::chain::{chain, last_answer};
use view::estimate::{Estimate, Parameter};

use crate::failure::Failure;

/// Number of rows that are estimated: ten minutes at 100 Hz.
pub const ROWS: usize = 60_000;
/// Share of the rows that count: those in which a quantity is known best.
const BEST: f64 = 0.25;
/// Share of a full bucket above which a bucket holds a load, and the share of rows with less than a full one.
const LOAD: f64 = 0.5;
const FULL: f64 = 0.95;
/// Number of keys that are named, and the least reduction of an interval by each.
const NAMED: usize = 3;
const LEAST: f64 = 0.03;
/// An exact number, as a share of its stated deviation; of a deviation that follows from the number itself, as a share of that.
const EXACT: f64 = 0.01;
const EXACT_NUMBER: f64 = 1e-4;
/// Endings of the keys that state a doubt about a sensor. Others are noise, which is no statement about the machine.
const OF_SENSORS: [&str; 4] = ["_gain_std", "_offset_std", "_delay_std", "_sensitivity_std"];
/// Key that states a doubt about the soil.
const OF_SOIL: &str = "carry_back_std";
/// Keys by which a calibration is stated: `heft calibrate` writes them.
const CALIBRATED: [&str; 2] = ["span_std", "force_offset_std"];

/// The table of the limiting keys of each quantity; `estimated` is the part of the data in words.
pub fn table<E: Estimate>(
    description: &Description,
    method: &str,
    samples: &[Envelope],
    estimated: &str,
) -> Result<String, Failure> {
    let now = estimates::<E>(description, method, samples)?;
    let quantities = E::PARAMETERS.iter().filter(|p| p.headline() || p.is_load);
    let known: Vec<Known<E>> = quantities.map(|q| Known::of(q, &now)).collect();
    let mut variants = Vec::new();
    for key in config::keys(description.machine()) {
        let Some(exact) = exact(description, key) else {
            continue;
        };
        let mut stated = description.clone();
        // A value that contradicts other keys is no statement.
        if stated.set(&format!("{key}={exact:e}")).is_ok() {
            let all = estimates::<E>(&stated, method, samples)?;
            // The estimates of all keys together would not fit into memory.
            variants.push((key, known.iter().map(|k| k.std(&all)).collect()));
        }
    }
    let mut out =
        format!("What limits the 95 % intervals of {estimated}, where each is narrowest:\n");
    for (at, known) in known.iter().enumerate() {
        let narrower = variants.iter();
        let narrower = narrower.map(|(key, stds): &(&str, Vec<f64>)| (*key, stds[at]));
        out += &known.limits(&now, narrower.collect(), description);
    }
    Ok(out)
}

/// A quantity with the rows in which it is known best; none if it is never estimated.
struct Known<E: Estimate> {
    quantity: &'static Parameter<E, E::Truth>,
    rows: Vec<usize>,
}

impl<E: Estimate> Known<E> {
    fn of(quantity: &'static Parameter<E, E::Truth>, now: &[E]) -> Self {
        let rows = best_rows(quantity, now).unwrap_or_default();
        Self { quantity, rows }
    }

    /// Median of its standard deviation.
    fn std(&self, all: &[E]) -> f64 {
        self.median(all, |q, e| q.std(e))
    }

    fn median(&self, all: &[E], number: fn(&Parameter<E, E::Truth>, &E) -> f64) -> f64 {
        let numbers = self.rows.iter().filter_map(|row| all.get(*row));
        let numbers: Vec<f64> = numbers.map(|e| number(self.quantity, e)).collect();
        median(&numbers)
    }

    /// Its lines: its half width now, and with each key next to exact.
    fn limits(
        &self,
        now: &[E],
        mut narrower: Vec<(&str, f64)>,
        description: &Description,
    ) -> String {
        let quantity = self.quantity;
        if self.rows.is_empty() {
            return format!("  {}: not estimated\n", quantity.label);
        }
        let (value, present) = (self.median(now, |q, e| q.value(e)), self.std(now));
        let words = |std: f64| half_width(quantity, value, std);
        let mut out = format!("  {}: {}\n", quantity.label, words(present));
        narrower.retain(|(_, std)| *std < (1.0 - LEAST) * present);
        narrower.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (key, std) in narrower.into_iter().take(NAMED) {
            let stated = match description.number(key) {
                Some(number) if number > 0.0 => format!(" ({number})"),
                _ => String::new(),
            };
            let _ = writeln!(out, "    {} if {key}{stated} were 0", words(std));
        }
        out
    }
}

/// The rows in which a quantity is known best; of a load, of those with a load. `None` if it is never estimated.
fn best_rows<E: Estimate>(quantity: &Parameter<E, E::Truth>, now: &[E]) -> Option<Vec<usize>> {
    let estimated =
        |i: &usize| quantity.value(&now[*i]).is_finite() && quantity.std(&now[*i]).is_finite();
    let mut rows: Vec<usize> = (0..now.len()).filter(estimated).collect();
    let share = |rows: &[usize], of: &dyn Fn(&E) -> f64, share: f64| {
        let numbers: Vec<f64> = rows.iter().map(|i| of(&now[*i])).collect();
        percentile(&numbers, share)
    };
    if rows.is_empty() {
        return None;
    }
    if quantity.is_load {
        let least = LOAD * share(&rows, &|e| quantity.value(e), FULL);
        rows.retain(|i| quantity.value(&now[*i]) >= least);
    }
    let most = share(&rows, &|e| quantity.std(e), BEST);
    rows.retain(|i| quantity.std(&now[*i]) <= most);
    Some(rows)
}

/// A half width: of a load in its unit, of another quantity in percent.
fn half_width<E, T>(quantity: &Parameter<E, T>, value: f64, std: f64) -> String {
    let half = estimation::HALF_WIDTH_95 * std;
    if quantity.is_load {
        let (_, half) = view::number::value_and_std(value, half);
        format!("± {half} {}", view::number::unit(quantity.unit))
    } else {
        format!("± {:.1} %", 100.0 * half / value.abs())
    }
}

/// The deviation that states a number next to exactly; `None` for a key that states no deviation, or an exact one.
fn exact(description: &Description, key: &str) -> Option<f64> {
    let name = key.rsplit('.').next()?;
    let is_doubt = match key.split('.').next()? {
        "machine" => name.ends_with("_std") || name.ends_with("_tolerance"),
        "sensors" => OF_SENSORS.iter().any(|end| name.ends_with(end)),
        "prior" => name == OF_SOIL,
        _ => false,
    };
    if !is_doubt || CALIBRATED.contains(&name) {
        return None;
    }
    let of = key
        .strip_suffix("_std")
        .and_then(|of| description.number(of));
    match (description.number(key), of) {
        (Some(std), _) if std > 0.0 => Some(EXACT * std),
        (_, Some(number)) if number != 0.0 => Some(EXACT_NUMBER * number.abs()),
        _ => Some(EXACT_NUMBER),
    }
}

/// The estimates of all samples.
fn estimates<E: Estimate>(
    description: &Description,
    method: &str,
    samples: &[Envelope],
) -> Result<Vec<E>, Failure> {
    let mut chain = chain(description, method)?;
    let answers = samples
        .iter()
        .map(|sample| last_answer(&mut chain, *sample));
    Ok(answers
        .map(|answer| {
            answer
                .as_ref()
                .and_then(E::inside)
                .copied()
                .unwrap_or_default()
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_machine_file_can_state_better_is_a_doubt() {
        let of = |text: &str, key: &str| {
            let description = Description::parse(text, "x", None).expect("a description");
            exact(&description, key)
        };
        let is = |found: Option<f64>, expected: f64| {
            assert!(
                found.is_some_and(|x| (x / expected - 1.0).abs() < 1e-12),
                "{found:?}"
            );
        };
        let loader = "[machine]\nkind = \"loader\"\n[machine.lift_arm]\nlength = 2.5\n";
        is(of(loader, "sensors.pressure_gain_std"), 0.0003);
        is(of(loader, "machine.lift_arm.length_std"), 2.5e-4);
        for key in [
            "sensors.pressure_std",
            "prior.cg_ratio_std",
            "machine.lift_arm.length",
            "machine.lift_arm.cylinder.span_std",
        ] {
            assert_eq!(of(loader, key), None, "{key}");
        }
        let excavator = "[machine]\nkind = \"excavator\"\n";
        is(of(excavator, "machine.mass_tolerance"), 0.00018);
        assert!(of(excavator, "sensors.swing_torque_gain_std").is_some());
        assert_eq!(of(excavator, "sensors.angle_std"), None, "noise");
        is(of(excavator, "prior.carry_back_std"), 0.00035);
    }
}
