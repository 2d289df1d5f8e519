//! A calibrated description as text: the relevant keys only, with their origin.

use std::collections::BTreeMap;
use std::fmt::Write;

use config::Tables;
use estimation::Quantity;

use crate::outcome::Summary;

/// Comment behind an identified value, before its standard deviation.
const CALIBRATED: &str = " # calibrated, ± ";

/// Writes the keys of a calibrated description, with their comments.
pub struct Pen<D> {
    /// The description so far.
    pub description: D,
    notes: BTreeMap<String, String>,
}

impl<D: Tables + Default> Pen<D> {
    /// Starts with the previous description.
    pub fn new(description: D) -> Self {
        Self {
            description,
            notes: BTreeMap::new(),
        }
    }

    /// Sets a value with its standard deviation.
    pub fn value(&mut self, key: &str, q: Quantity) {
        let was = self.description.number(key);
        if self.description.set_number(key, rounded(q.value, q.std)) {
            let was = was.map_or(String::new(), |w| {
                format!(", described {}", rounded(w, 0.0))
            });
            let note = format!("{CALIBRATED}{:.2e}{was}", q.std);
            self.notes.insert(key.into(), note);
        }
    }

    /// Sets a standard deviation.
    pub fn std(&mut self, key: &str, std: f64) {
        if self.description.set_number(key, rounded(std, std)) {
            self.notes.insert(key.into(), " # calibrated".into());
        }
    }

    /// Sets a correlation, to three decimals.
    pub fn correlation(&mut self, key: &str, correlation: f64) {
        if self.description.set_number(key, rounded(correlation, 1.0)) {
            self.notes.insert(key.into(), " # calibrated".into());
        }
    }

    /// The description as text, with its origin as comments.
    pub fn text(&self, summary: &Summary<'_>, origin: &[String]) -> String {
        let mut text = String::new();
        for line in origin.iter().chain(summary.remarks) {
            let _ = writeln!(text, "# {line}");
        }
        for fault in summary.faults {
            let _ = writeln!(text, "# NOT TO BE TRUSTED: {fault}");
        }
        let complete = self.description.to_toml();
        let printed = keys(&complete, &D::default().to_toml(), &self.notes);
        let _ = write!(text, "\n{printed}\n{}", summary.joint());
        text
    }
}

/// The lines of a complete printed description ([`config::Tables::to_toml`]) whose key has a note, which is
/// appended, or whose value differs from that in `default`.
pub fn keys(complete: &str, default: &str, notes: &BTreeMap<String, String>) -> String {
    let usual: Vec<(String, String, String)> = assignments(default);
    let mut text = String::new();
    let mut table = String::new();
    for (in_table, name, value) in assignments(complete) {
        let key = format!("{in_table}.{name}");
        let note = notes.get(&key);
        let same = usual.contains(&(in_table.clone(), name.clone(), value.clone()));
        if same && note.is_none() && key != "machine.kind" {
            continue;
        }
        if in_table != table {
            let gap = if text.is_empty() { "" } else { "\n" };
            let _ = writeln!(text, "{gap}[{in_table}]");
            table = in_table;
        }
        let note = note.map_or("", String::as_str);
        let _ = writeln!(text, "{name} = {value}{note}");
    }
    text
}

/// The identified keys of a calibrated description, with their values.
pub fn found(text: &str) -> Vec<(String, Quantity)> {
    let quantity = |(table, name, value): (String, String, String)| {
        let (value, note) = value.split_once(CALIBRATED)?;
        let std = note.split(',').next()?.parse().ok()?;
        let value = value.parse().ok()?;
        Some((format!("{table}.{name}"), Quantity { value, std }))
    };
    assignments(text).into_iter().filter_map(quantity).collect()
}

/// Table, key and value of each assignment.
fn assignments(text: &str) -> Vec<(String, String, String)> {
    let mut table = String::new();
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            table = name.to_owned();
        } else if !line.starts_with('#')
            && let Some((name, value)) = line.split_once('=')
        {
            found.push((
                table.clone(),
                name.trim().to_owned(),
                value.trim().to_owned(),
            ));
        }
    }
    found
}

/// Rounds to three digits below the standard deviation.
pub fn rounded(value: f64, std: f64) -> f64 {
    if !(std > 0.0 && std.is_finite() && value.is_finite()) {
        return value;
    }
    let unit = 10_f64.powi((std.log10().floor() as i32 - 3).max(-300));
    let rounded = (value / unit).round() * unit;
    // By its decimal form, so that the binary rounding of 0.1 + 0.2 is not printed.
    let decimals = (-(unit.log10().round() as i32)).max(0) as usize;
    format!("{rounded:.decimals$}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_relevant_keys_are_printed() {
        let mut d = config::Excavator::default();
        d.machine.nominal_damping = 1492.0;
        d.estimator.constant_inertia = true;
        let notes = BTreeMap::from([(
            "machine.coulomb_friction".to_owned(),
            " # was 250".to_owned(),
        )]);
        let text = keys(
            &d.to_toml(),
            &config::Excavator::default().to_toml(),
            &notes,
        );
        assert_eq!(
            text,
            "[machine]\nkind = \"excavator\"\nnominal_damping = 1492.0\ncoulomb_friction = 250.0 # was 250\n\n[estimator]\nconstant_inertia = true\n"
        );
        assert_eq!(config::Excavator::parse(&text, "t"), Ok(d));
    }

    #[test]
    fn what_was_found_is_read_again() {
        let mut pen = Pen::new(config::Excavator::default());
        let damping = Quantity {
            value: 1492.125,
            std: 4.2,
        };
        pen.value("machine.nominal_damping", damping);
        pen.std("machine.nominal_damping_std", 4.2);
        let complete = pen.description.to_toml();
        let text = keys(
            &complete,
            &config::Excavator::default().to_toml(),
            &pen.notes,
        );
        assert_eq!(
            found(&text),
            [("machine.nominal_damping".to_owned(), damping)]
        );
    }

    #[test]
    fn numbers_keep_three_digits_below_their_uncertainty() {
        assert_eq!(rounded(1_492.123_456_7, 4.2), 1492.123);
        assert_eq!(rounded(1.029_912_345_6, 0.0019), 1.029_912);
        assert_eq!(rounded(5.0, 0.0), 5.0);
    }
}
