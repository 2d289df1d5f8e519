//! Judgement of one quantity: value, verdict, reasons.

/// Judgement of one quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Judgement {
    /// The value with its uncertainty: "The swing inertia is 5 873 ± 61 kg m² (95 %: ...)".
    pub value: String,
    /// Whether it is trusted.
    pub trusted: bool,
    /// Reasons for or against trust.
    pub reasons: Vec<String>,
    /// Remedy; empty if it is trusted.
    pub advice: &'static str,
}

impl Judgement {
    /// Of a quantity without an estimate; `value` says so.
    pub(crate) fn without_estimate(value: &str) -> Self {
        Self {
            value: value.into(),
            trusted: false,
            reasons: vec!["no sample has been accepted so far".into()],
            advice: "check that the sensors send, and that the map names the right columns",
        }
    }

    /// Verdict and reasons: "heft trusts it: ...", "heft does not trust it, because ...".
    pub fn verdict(&self) -> String {
        let reasons = list(&self.reasons);
        if self.trusted {
            format!("heft trusts it: {reasons}.")
        } else {
            format!("heft does not trust it, because {reasons}.")
        }
    }

    /// The remedy as a sentence; empty if it is trusted.
    pub fn what_to_do(&self) -> String {
        if self.advice.is_empty() {
            return String::new();
        }
        format!("What to do: {}.", self.advice)
    }

    /// Value, verdict, reasons, and remedy.
    pub fn sentence(&self) -> String {
        let text = format!("{}. {} {}", self.value, self.verdict(), self.what_to_do());
        text.trim_end().to_owned()
    }
}

/// "a", "a and b", "a, b and c".
fn list(items: &[String]) -> String {
    match items {
        [] => "no reason was given".into(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
