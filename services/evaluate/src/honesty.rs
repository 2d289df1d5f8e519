//! Share of wrong values among the trusted: the table, for both machines. The measure is that of [`statistics::judge`]. An honest
//! estimator is wrong in at most one trusted row of twenty, whatever the machine does. Its interval holds the truth in 95 % of
//! all rows, trusted or not, moving or standing.

use crate::text::{Table, plain};
use serde_json::{Value, json};

pub use statistics::judge::{JudgedRow, Tally};

/// One line of the table: an effect at one severity.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The effect.
    pub effect: String,
    /// Its severity with a unit; empty if it has no degrees.
    pub severity: String,
    /// The quantity, or the method, that is judged.
    pub what: String,
    /// The counts.
    pub tally: Tally,
    /// Largest allowed share of wrong among trusted rows.
    pub allowed: f64,
    /// Least required trusted share of the moving time.
    pub least_trusted: f64,
    /// Least required coverage of all rows.
    pub least_covered: f64,
}

impl Line {
    /// A line with the common limits: wrong at most .05, no other.
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

    /// Whether the line is within its limits.
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
    let mut table =
        Table::headed("effect; severity; what; trusted; wrong; rms %; covered; reason; ");
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
