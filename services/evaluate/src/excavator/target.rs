//! A number that has to lie within limits.

use serde_json::{Value, json};

/// A target and what was reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The quantity.
    pub what: &'static str,
    /// What was reached.
    pub value: f64,
    /// Lower limit.
    pub least: f64,
    /// Upper limit.
    pub most: f64,
}

impl Target {
    /// At most `most`.
    pub fn most(what: &'static str, value: f64, most: f64) -> Self {
        Self {
            what,
            value,
            least: f64::NEG_INFINITY,
            most,
        }
    }

    /// At least `least`.
    pub fn least(what: &'static str, value: f64, least: f64) -> Self {
        Self {
            what,
            value,
            least,
            most: f64::INFINITY,
        }
    }

    /// Between two limits.
    pub fn between(what: &'static str, value: f64, least: f64, most: f64) -> Self {
        Self {
            what,
            value,
            least,
            most,
        }
    }

    /// Whether it is met.
    pub fn met(&self) -> bool {
        self.least <= self.value && self.value <= self.most
    }

    /// `{"what":..,"value":..,"least":..,"most":..,"met":..}`; a limit that does not exist is null, and so is a
    /// value that was never reached.
    pub fn json(&self) -> Value {
        let finite = |v: f64| if v.is_finite() { json!(v) } else { Value::Null };
        json!({
            "what": self.what, "value": finite(self.value), "least": finite(self.least),
            "most": finite(self.most), "met": self.met(),
        })
    }
}

/// "pass", or which targets are missed and by what; "-" where there are none.
pub fn judgement(targets: &[Target]) -> String {
    let missed = targets.iter().filter(|target| !target.met());
    let missed: Vec<String> = missed.map(describe).collect();
    match (targets.is_empty(), missed.is_empty()) {
        (true, _) => "-".into(),
        (false, true) => "pass".into(),
        (false, false) => format!("FAIL: {}", missed.join(", ")),
    }
}

fn describe(target: &Target) -> String {
    let Target {
        what,
        value,
        least,
        most,
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
        assert!(!Target::most("max", f64::NAN, 3.0).met());
    }
}
