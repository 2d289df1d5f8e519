//! How often a value that calls itself trusted is wrong: the measure and its table, for both machines.
//!
//! A row is **wrong** if it says trusted and its truth lies outside the stated 95 % interval, or more than 10 % away.
//! An honest estimator is wrong in at most one trusted row of twenty, whatever the machine does; and its interval
//! holds the truth in 95 % of all rows, trusted or not, moving or standing.

use crate::text::{Table, plain};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A trusted value further away than this share of the truth is wrong, whatever its interval says.
const FAR: f64 = 0.10;
/// Half width of a 95 % interval in standard deviations.
const HALF_WIDTH: f64 = estimation::HALF_WIDTH_95;

/// One row of an estimator beside its truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// What is so.
    pub truth: f64,
    /// What the estimator says.
    pub estimate: f64,
    /// The standard deviation it states.
    pub std: f64,
    /// Whether it says trusted.
    pub trusted: bool,
    /// Whether the machine moves: only then trust can be asked for.
    pub moving: bool,
    /// Why it is not trusted or not consistent, in a word; empty if nothing is given.
    pub reason: &'static str,
}

impl Judged {
    fn covered(&self) -> bool {
        (self.estimate - self.truth).abs() <= HALF_WIDTH * self.std
    }

    fn wrong(&self) -> bool {
        !self.covered() || (self.estimate - self.truth).abs() > FAR * self.truth.abs()
    }
}

/// Counts over many rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    rows: u64,
    covered: u64,
    moving: u64,
    trusted_moving: u64,
    trusted: u64,
    wrong: u64,
    /// Sum of the squared relative errors of trusted rows.
    square: f64,
    reasons: BTreeMap<&'static str, u64>,
}

impl Tally {
    /// Counts one row.
    pub fn push(&mut self, row: &Judged) {
        self.rows += 1;
        self.covered += u64::from(row.covered());
        self.moving += u64::from(row.moving);
        if row.trusted {
            let relative = (row.estimate - row.truth) / row.truth;
            self.trusted += 1;
            self.trusted_moving += u64::from(row.moving);
            self.wrong += u64::from(row.wrong());
            self.square += relative * relative;
        }
        if !row.reason.is_empty() {
            *self.reasons.entry(row.reason).or_default() += 1;
        }
    }

    /// Adds the counts of another.
    pub fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.covered += other.covered;
        self.moving += other.moving;
        self.trusted_moving += other.trusted_moving;
        self.trusted += other.trusted;
        self.wrong += other.wrong;
        self.square += other.square;
        for (reason, count) in &other.reasons {
            *self.reasons.entry(reason).or_default() += count;
        }
    }

    /// Share of the rows in motion that say trusted.
    pub fn trusted(&self) -> f64 {
        share(self.trusted_moving, self.moving)
    }

    /// Share of the trusted rows that are wrong; 0 where none is trusted.
    pub fn wrong(&self) -> f64 {
        share(self.wrong, self.trusted)
    }

    /// Root mean square of the relative error of the trusted rows [%].
    pub fn rms(&self) -> f64 {
        100.0 * (self.square / self.trusted.max(1) as f64).sqrt()
    }

    /// Share of all rows whose interval holds the truth.
    pub fn covered(&self) -> f64 {
        share(self.covered, self.rows)
    }

    /// The reason most often given, and the share of all rows that give it.
    pub fn reason(&self) -> Option<(&'static str, f64)> {
        let most = self.reasons.iter().max_by_key(|(_, count)| **count)?;
        Some((most.0, share(*most.1, self.rows)))
    }
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// One line of the table: an effect at one severity.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The effect.
    pub effect: String,
    /// How strong it is, with its unit; empty if it has no degrees.
    pub severity: String,
    /// The quantity, or the method, that is judged.
    pub what: String,
    /// The counts.
    pub tally: Tally,
    /// The largest share of wrong among trusted rows that is allowed.
    pub allowed: f64,
    /// The least trusted share of the moving time that is asked for.
    pub least_trusted: f64,
    /// The least coverage of all rows that is asked for.
    pub least_covered: f64,
}

impl Line {
    /// A line with the limits that every effect has: wrong at most .05, nothing else asked.
    pub fn new(effect: &str, severity: &str, what: &str, tally: Tally) -> Self {
        Self {
            effect: effect.to_owned(),
            severity: severity.to_owned(),
            what: what.to_owned(),
            tally,
            allowed: 0.05,
            least_trusted: 0.0,
            least_covered: 0.0,
        }
    }

    /// Whether the line holds its limits.
    pub fn met(&self) -> bool {
        self.tally.wrong() <= self.allowed
            && self.tally.trusted() >= self.least_trusted
            && self.tally.covered() >= self.least_covered
    }

    /// `{"effect":..,"severity":..,"what":..,"trusted":..,"wrong":..,"rms":..,"covered":..,"reason":..,"met":..}`;
    /// shares from 0 to 1, rms in percent.
    pub fn json(&self) -> Value {
        let t = &self.tally;
        json!({
            "effect": self.effect, "severity": self.severity, "what": self.what, "trusted": t.trusted(),
            "wrong": t.wrong(), "rms": t.rms(), "covered": t.covered(),
            "reason": t.reason().map(|(reason, _)| reason), "met": self.met(),
        })
    }
}

/// `{"lines":[..]}`.
pub fn json(lines: &[Line]) -> Value {
    json!({ "lines": lines.iter().map(Line::json).collect::<Vec<_>>() })
}

/// The table as text.
pub fn text(lines: &[Line]) -> String {
    let mut table = Table::new(&[
        "effect", "severity", "what", "trusted", "wrong", "rms %", "covered", "reason", "",
    ]);
    for line in lines {
        let t = &line.tally;
        let reason = t.reason().map_or("-".to_owned(), |(reason, share)| {
            format!("{reason} {share:.2}")
        });
        table.row([
            line.effect.clone(),
            line.severity.clone(),
            line.what.clone(),
            plain(t.trusted(), 2),
            plain(t.wrong(), 3),
            plain(t.rms(), 2),
            plain(t.covered(), 3),
            reason,
            crate::text::verdict(line.met()),
        ]);
    }
    table.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(estimate: f64, std: f64, trusted: bool) -> Judged {
        Judged {
            truth: 100.0,
            estimate,
            std,
            trusted,
            moving: true,
            reason: "",
        }
    }

    #[test]
    fn wrong_is_outside_the_interval_or_more_than_ten_percent_away() {
        let mut tally = Tally::default();
        for judged in [
            row(101.0, 1.0, true),
            row(103.0, 1.0, true),
            row(111.0, 10.0, true),
            row(150.0, 1.0, false),
        ] {
            tally.push(&judged);
        }
        assert_eq!(tally.trusted(), 0.75);
        assert_eq!(tally.wrong(), 2.0 / 3.0);
        assert_eq!(tally.covered(), 0.5);
    }

    #[test]
    fn the_reason_most_often_given_is_named() {
        let mut tally = Tally::default();
        for reason in ["slope", "gain", "slope", ""] {
            let judged = Judged {
                reason,
                ..row(100.0, 1.0, true)
            };
            tally.push(&judged);
        }
        assert_eq!(tally.reason(), Some(("slope", 0.5)));
    }
}
