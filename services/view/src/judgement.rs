//! What heft says of one quantity: value, verdict, reasons.

/// What heft says of one quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Judgement {
    /// The value with its uncertainty: "The swing inertia is 5 873 ± 61 kg m² (95 %: ...)".
    pub value: String,
    /// Whether it may be believed.
    pub trusted: bool,
    /// Why, or why not.
    pub reasons: Vec<String>,
}

impl Judgement {
    /// Verdict and reasons: "heft trusts it: ...", "heft does not trust it, because ...".
    #[must_use]
    pub fn verdict(&self) -> String {
        let reasons = list(&self.reasons);
        if self.trusted {
            format!("heft trusts it: {reasons}.")
        } else {
            format!("heft does not trust it, because {reasons}.")
        }
    }

    /// Value, verdict and reasons.
    #[must_use]
    pub fn sentence(&self) -> String {
        format!("{}. {}", self.value, self.verdict())
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
