//! Judgement of trusted values where the truth is known.
//!
//! A row is **wrong** if it is trusted and its truth lies outside the stated 95 % interval, or more than 10 % away.

use std::collections::BTreeMap;

/// Relative error beyond which a trusted value is wrong, whatever its interval.
pub const FAR: f64 = 0.10;

/// Whether the 95 % interval of a value holds the truth.
pub fn is_covered(value: f64, std: f64, truth: f64) -> bool {
    estimation::Quantity { value, std }.holds(truth)
}

/// Whether a value is wrong: its 95 % interval does not hold the truth, or the truth is further away than [`FAR`].
pub fn is_wrong(value: f64, std: f64, truth: f64) -> bool {
    !is_covered(value, std, truth) || (value - truth).abs() > FAR * truth.abs()
}

/// One row of an estimator with its truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedRow {
    /// True value.
    pub truth: f64,
    /// Estimated value.
    pub estimate: f64,
    /// Stated standard deviation.
    pub std: f64,
    /// Whether the estimator trusts it.
    pub trusted: bool,
    /// Whether the machine moves: trust is expected only then.
    pub moving: bool,
    /// Reason why it is not trusted or not consistent, in a word; empty for none.
    pub reason: &'static str,
}

impl JudgedRow {
    fn covered(&self) -> bool {
        is_covered(self.estimate, self.std, self.truth)
    }

    fn wrong(&self) -> bool {
        is_wrong(self.estimate, self.std, self.truth)
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
    pub fn push(&mut self, row: &JudgedRow) {
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

    /// Adds the counts of another tally.
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

    /// Share of the rows in motion that are trusted.
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

    /// The most frequent reason, and its share of all rows.
    pub fn reason(&self) -> Option<(&'static str, f64)> {
        let most = self.reasons.iter().max_by_key(|(_, count)| **count)?;
        Some((most.0, share(*most.1, self.rows)))
    }
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(estimate: f64, std: f64, trusted: bool) -> JudgedRow {
        JudgedRow {
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
            let judged = JudgedRow {
                reason,
                ..row(100.0, 1.0, true)
            };
            tally.push(&judged);
        }
        assert_eq!(tally.reason(), Some(("slope", 0.5)));
    }
}
