//! Running scores of the quantities of a run: a few counts each, whatever its length. A whole recording
//! is scored by [`view::score`].

use statistics::judge::is_covered;

use crate::quantity::Quantity;

/// The value of a quantity in one estimate.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scored {
    /// Time \[s\].
    pub time: f64,
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Whether it is trusted.
    pub trusted: bool,
    /// Truth at the same sample.
    pub truth: Option<f64>,
}

/// Running scores of one estimated quantity.
#[derive(Debug, Clone, Copy)]
pub struct Tally {
    /// The quantity.
    pub quantity: Quantity,
    /// The latest estimate.
    pub latest: Scored,
    /// The latest trusted estimate.
    pub last_trusted: Option<Scored>,
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
}

impl Tally {
    pub fn new(quantity: Quantity) -> Self {
        Self {
            quantity,
            latest: Scored::default(),
            last_trusted: None,
            seen: 0,
            trusted_count: 0,
            scored: 0,
            covered: 0,
            worst: 0.0,
            squares: 0.0,
        }
    }

    /// Text for the live line.
    pub fn short(&self) -> String {
        let (q, latest) = (self.quantity, self.latest);
        let truth = latest.truth.map_or(String::new(), |t| {
            format!(" (true {})", q.number(t, latest.std))
        });
        let verdict = if latest.trusted {
            "trusted"
        } else {
            "not trusted"
        };
        format!(
            "{} {}{truth} {verdict}",
            q.short(),
            q.text(latest.value, latest.std)
        )
    }

    pub fn add(&mut self, estimate: Scored) {
        self.latest = estimate;
        self.seen += 1;
        if !estimate.trusted {
            return;
        }
        self.trusted_count += 1;
        self.last_trusted = Some(estimate);
        let Scored { value, std, .. } = estimate;
        if let Some(truth) = estimate.truth.filter(|t| *t != 0.0) {
            let error = 100.0 * (value / truth - 1.0);
            self.scored += 1;
            self.covered += u64::from(is_covered(value, std, truth));
            self.worst = self.worst.max(error.abs());
            self.squares += error * error;
        }
    }
}
