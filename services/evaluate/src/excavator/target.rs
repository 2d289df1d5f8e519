//! A target: limits of a number.
//!
//! The numbers come from a finite number of seeds. Some hundred targets are judged at once, so a limit counts as missed only if
//! it is exceeded by more than three standard errors. Below that the judgement is "close".

use serde_json::{Value, json};

/// Number of standard errors that is attributed to chance.
const LUCK: f64 = 3.0;

/// A target and the value reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The quantity.
    pub what: &'static str,
    /// The value reached.
    pub value: f64,
    /// Lower limit.
    pub least: f64,
    /// Upper limit.
    pub most: f64,
    /// Standard error of the value.
    pub error: f64,
}

impl Target {
    /// At most `most`.
    pub fn most(what: &'static str, value: f64, most: f64) -> Self {
        Self::between(what, value, f64::NEG_INFINITY, most)
    }

    /// At least `least`.
    pub fn least(what: &'static str, value: f64, least: f64) -> Self {
        Self::between(what, value, least, f64::INFINITY)
    }

    /// Between two limits.
    pub fn between(what: &'static str, value: f64, least: f64, most: f64) -> Self {
        Self {
            what,
            value,
            least,
            most,
            error: 0.0,
        }
    }

    /// The same with the standard error of its value.
    pub fn known_to(self, error: f64) -> Self {
        Self { error, ..self }
    }

    /// Whether the value lies within the limits.
    fn within(&self, allowance: f64) -> bool {
        self.least - allowance <= self.value && self.value <= self.most + allowance
    }

    /// Whether it is met, or missed by no more than chance.
    pub fn met(&self) -> bool {
        self.within(LUCK * self.error)
    }

    /// `{"what":..,"value":..,"least":..,"most":..,"error":..,"met":..}`; null for a limit that does not exist, and for a value
    /// that was never reached.
    pub fn json(&self) -> Value {
        json!({
            "what": self.what, "value": self.value, "least": self.least, "most": self.most,
            "error": self.error, "met": self.met(),
        })
    }
}

/// Whether all targets of a line are met.
pub fn all_met(targets: &[Target]) -> bool {
    targets.iter().all(Target::met)
}

/// The record of a line with its `targets`, and with `met` if all of them are.
pub fn recorded(mut record: Value, targets: &[Target]) -> Value {
    record["targets"] = targets.iter().map(Target::json).collect();
    record["met"] = json!(all_met(targets));
    record
}

/// "pass", or the missed targets and their values; "-" without targets.
pub fn judgement(targets: &[Target]) -> String {
    let missed: Vec<String> = targets
        .iter()
        .filter(|t| !t.within(0.0))
        .map(describe)
        .collect();
    match (targets.is_empty(), missed.is_empty(), all_met(targets)) {
        (true, _, _) => "-".into(),
        (false, true, _) => "pass".into(),
        (false, false, true) => format!("close: {}", missed.join(", ")),
        (false, false, false) => format!("FAIL: {}", missed.join(", ")),
    }
}

fn describe(target: &Target) -> String {
    let Target {
        what,
        value,
        least,
        most,
        ..
    } = target;
    if value > most {
        format!("{what} {value:.2} > {most}")
    } else {
        format!("{what} {value:.2} < {least}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_judgement_names_what_is_missed() {
        let good = Target::most("max", 2.0, 3.0);
        let bad = Target::between("coverage", 88.0, 92.0, 98.0);
        assert_eq!(judgement(&[]), "-");
        assert_eq!(judgement(&[good]), "pass");
        assert_eq!(judgement(&[good, bad]), "FAIL: coverage 88.00 < 92");
        assert_eq!(
            judgement(&[bad.known_to(1.4)]),
            "close: coverage 88.00 < 92"
        );
        assert!(!Target::most("max", f64::NAN, 3.0).met());
    }
}
