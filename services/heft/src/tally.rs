//! Running scores of the quantities of a run: a few counts each, whatever its length. A whole recording
//! is scored by [`view::score`].

use statistics::judge::is_covered;

use crate::quantity::Quantity;

/// Running scores of one estimated quantity.
#[derive(Debug, Clone, Copy)]
pub struct Tally {
    /// The quantity.
    pub quantity: Quantity,
    /// Time of the latest estimate \[s\].
    pub time: f64,
    /// Latest value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Whether it is trusted.
    pub trusted: bool,
    /// Truth at the same sample.
    pub truth: Option<f64>,
    /// Estimates seen.
    pub seen: u64,
    /// Trusted ones among them.
    pub trusted_count: u64,
    /// Trusted ones with a known truth.
    pub scored: u64,
    /// Number of those whose 95 % interval held the truth.
    pub covered: u64,
    /// Largest error of a trusted estimate [%].
    pub worst: f64,
    /// Sum of squared errors of trusted estimates [%^2].
    pub squares: f64,
    /// Latest trusted estimate: time, value, standard deviation, truth.
    pub last_trusted: Option<(f64, f64, f64, Option<f64>)>,
}

impl Tally {
    pub fn new(quantity: Quantity) -> Self {
        Self {
            quantity,
            time: 0.0,
            value: 0.0,
            std: 0.0,
            trusted: false,
            truth: None,
            seen: 0,
            trusted_count: 0,
            scored: 0,
            covered: 0,
            worst: 0.0,
            squares: 0.0,
            last_trusted: None,
        }
    }

    /// Text for the live line.
    pub fn short(&self) -> String {
        let q = self.quantity;
        let truth = self.truth.map_or(String::new(), |t| {
            format!(" (true {})", q.number(t, self.std))
        });
        let verdict = if self.trusted {
            "trusted"
        } else {
            "not trusted"
        };
        format!(
            "{} {}{truth} {verdict}",
            q.short(),
            q.text(self.value, self.std)
        )
    }

    pub fn add(&mut self, time: f64, value: f64, std: f64, trusted: bool, truth: Option<f64>) {
        (self.time, self.value, self.std) = (time, value, std);
        (self.trusted, self.truth) = (trusted, truth);
        self.seen += 1;
        if !trusted {
            return;
        }
        self.trusted_count += 1;
        self.last_trusted = Some((time, value, std, truth));
        if let Some(truth) = truth.filter(|t| *t != 0.0) {
            let error = 100.0 * (value / truth - 1.0);
            self.scored += 1;
            self.covered += u64::from(is_covered(value, std, truth));
            self.worst = self.worst.max(error.abs());
            self.squares += error * error;
        }
    }
}
