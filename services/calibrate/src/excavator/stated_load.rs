//! A stated load, tested against what the other measurements say of it.

use estimation::{HALF_WIDTH_95, Quantity};

use super::swings::Swings;
use crate::fit::Task;

/// A stated load, and what all other measurements and tolerances of the description say of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    /// Number of the recording.
    pub recording: usize,
    /// Name of the recording.
    pub name: String,
    /// Stated load \[kg\].
    pub stated: Quantity,
    /// Load by the motion, with the description's masses and torque \[kg\].
    pub by_motion: Quantity,
    /// Load by the pressures of the boom's cylinders \[kg\].
    pub by_pressures: Option<Quantity>,
}

/// Distance of a stated load from the other measurements, in standard deviations, beyond which it is misstated: one sound load in 2000.
const CONTRADICTED: f64 = 3.5;
/// The same for a remark.
const DOUBTED: f64 = 2.0;
/// Share of stated loads that are wrong by more than their stated deviation, and the relative standard deviation of these: another
/// bucketful, a volume for a mass, a weighing of another day.
const MISSTATED: (f64, f64) = (0.1, 0.1);

impl Doubt {
    /// The load by all but its statement \[kg\].
    #[must_use]
    pub fn found(&self) -> Quantity {
        let pressures = self.by_pressures;
        pressures.map_or(self.by_motion, |p| combined(self.by_motion, p))
    }

    /// Distance of the two, in standard deviations.
    #[must_use]
    pub fn distance(&self) -> f64 {
        distance(&self.stated, &self.found())
    }

    /// Whether the stated load is refused.
    #[must_use]
    pub fn contradicts(&self) -> bool {
        self.distance() > CONTRADICTED
    }

    /// Whether a reader should know of it.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.distance() > DOUBTED
    }

    /// The load with its deviation: as it was stated, or misstated, each with its probability.
    #[must_use]
    pub fn believed(&self) -> Quantity {
        let (share, error) = MISSTATED;
        let found = self.found();
        let misstated = norm(error * self.stated.value, self.stated.std);
        let hypotheses =
            [(1.0 - share, self.stated.std), (share, misstated)].map(|(share, std)| {
                let both = norm(std, found.std);
                let likelihood =
                    (-0.5 * (found.value - self.stated.value).powi(2) / (both * both)).exp() / both;
                let stated = Quantity { std, ..self.stated };
                (share * likelihood, combined(stated, found))
            });
        let all: f64 = hypotheses.iter().map(|(weight, _)| weight).sum();
        let mean = |of: &dyn Fn(&Quantity) -> f64| -> f64 {
            hypotheses
                .iter()
                .map(|(weight, q)| weight / all * of(q))
                .sum()
        };
        if all <= 0.0 {
            // Both are impossible: the load is refused.
            return self.stated;
        }
        let value = mean(&|q| q.value);
        let outside = |half: f64| {
            mean(&|q| {
                let (by, std) = (q.value - value, q.std.max(f64::MIN_POSITIVE));
                beyond((half - by) / std) + beyond((half + by) / std)
            })
        };
        let half = half_width(outside, 1.0 - COVERED);
        Quantity {
            value,
            std: half / HALF_WIDTH_95,
        }
    }
}

/// Probability of the interval that a deviation stands for.
const COVERED: f64 = 0.95;

/// Half width outside of which lies this probability, which falls as the width grows.
fn half_width(outside: impl Fn(f64) -> f64, probability: f64) -> f64 {
    let mut high = 1.0;
    while outside(high) > probability && high < 1e9 {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if outside(middle) > probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Probability that a normal error exceeds `z` standard deviations (Abramowitz, Stegun 1964, 7.1.26, to 1e-7).
fn beyond(z: f64) -> f64 {
    if z < 0.0 {
        return 1.0 - beyond(-z);
    }
    const FACTORS: [f64; 5] = [
        1.061405429,
        -1.453152027,
        1.421413741,
        -0.284496736,
        0.254829592,
    ];
    let t = 1.0 / (1.0 + 0.3275911 * z * std::f64::consts::FRAC_1_SQRT_2);
    let polynomial = FACTORS.iter().fold(0.0, |sum, factor| sum * t + factor) * t;
    0.5 * polynomial * (-0.5 * z * z).exp()
}

/// Root of the sum of two squares. `f64::hypot` asks for a newer C library.
fn norm(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Mean of two measurements with their weights.
fn combined(a: Quantity, b: Quantity) -> Quantity {
    let (of_a, of_b) = (a.std * a.std, b.std * b.std);
    let sum = (of_a + of_b).max(f64::MIN_POSITIVE);
    Quantity {
        value: (a.value * of_b + b.value * of_a) / sum,
        std: (of_a * of_b / sum).sqrt(),
    }
}

/// Distance of two weights, in standard deviations.
pub(super) fn distance(a: &Quantity, b: &Quantity) -> f64 {
    (a.value - b.value).abs() / (a.std.powi(2) + b.std.powi(2)).sqrt()
}

/// The stated loads, each beside the load that the motion shows if it is not stated. `held`: tolerances of held parameters, in prior
/// standard deviations.
pub fn doubts(task: &Task<'_, Swings>, held: &[f64]) -> Vec<Doubt> {
    let swings = task.model;
    let stated = swings.stated.iter().flatten();
    let heaviest = stated.fold(0.0, |h: f64, t| h.max(t.value));
    let numbered = swings.stated.iter().enumerate();
    let loaded = numbered.filter_map(|(r, stated)| Some((r, stated.filter(|s| s.value > 0.0)?)));
    loaded
        .filter_map(|(recording, stated)| {
            Some(Doubt {
                recording,
                name: swings.series[recording].name.clone(),
                stated,
                by_motion: weigh_by_description(task, (recording, stated), heaviest, held)?,
                by_pressures: None,
            })
        })
        .collect()
}

/// The most contradicted one of stated loads.
#[must_use]
pub fn misstated(doubts: &[Doubt]) -> Option<&Doubt> {
    let refused = doubts.iter().filter(|d| d.contradicts());
    refused.max_by(|a, b| a.distance().total_cmp(&b.distance()))
}

fn weigh_by_description(
    task: &Task<'_, Swings>,
    (recording, stated): (usize, Quantity),
    heaviest: f64,
    held: &[f64],
) -> Option<Quantity> {
    let mut open = task.model.clone();
    let wide = Quantity {
        value: stated.value,
        std: heaviest.max(stated.value).max(task.model.full_bucket),
    };
    let at = open.release(recording, wide);
    let mut fixed = task.fixed.to_vec();
    if at == fixed.len() {
        fixed.push(false);
    }
    fixed[at] = false;
    // Starts at the description, instead of where a wrong load has led.
    let start = vec![0.0; fixed.len()];
    let released = Task {
        model: &open,
        blocks: task.blocks,
        least_gain: task.least_gain,
        fixed: &fixed,
        stop: task.stop,
        progress: &|_| {},
    };
    let mut fit = released.run(&start);
    let mut held = held.to_vec();
    held.resize(fixed.len(), 0.0);
    // With the derivatives of the held parameters, whose tolerances count.
    let none = vec![false; fixed.len()];
    let everything = Task {
        fixed: &none,
        ..released
    };
    fit.information = everything.information(&fit.place);
    let uncertainty = crate::honesty::uncertainty(&fit, &open.parameters, &fixed, &held)?;
    let parameter = &open.parameters[at];
    Some(Quantity {
        value: parameter.value(fit.place[at]),
        std: parameter.value_std(fit.place[at], uncertainty.std(at)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kg(value: f64, std: f64) -> Quantity {
        Quantity { value, std }
    }

    /// 800 kg on a weighbridge, and as motion and pressures weigh them.
    fn doubt(by_motion: Quantity, by_pressures: Option<Quantity>) -> Doubt {
        Doubt {
            recording: 0,
            name: "loaded".into(),
            stated: kg(800.0, 5.0),
            by_motion,
            by_pressures,
        }
    }

    #[test]
    fn a_load_that_everything_confirms_keeps_its_deviation() {
        let believed = doubt(kg(805.0, 30.0), Some(kg(795.0, 11.0))).believed();
        assert!((believed.value - 800.0).abs() < 1.0, "{believed:?}");
        assert!(believed.std < 8.0, "{believed:?}");
    }

    #[test]
    fn pressures_refuse_a_load_of_which_the_motion_cannot_tell() {
        let motion = kg(740.0, 30.0);
        let alone = doubt(motion, None);
        assert!(!alone.contradicts());
        // The interval covers both.
        let believed = alone.believed();
        assert!(
            (believed.value - 740.0).abs() < 1.96 * believed.std,
            "{believed:?}"
        );
        assert!(doubt(motion, Some(kg(742.0, 11.0))).contradicts());
    }

    #[test]
    fn of_two_measurements_the_better_one_counts() {
        let mean = combined(kg(0.0, 3.0), kg(10.0, 1.0));
        assert!((mean.value - 9.0).abs() < 1e-12 && (mean.std - 0.9_f64.sqrt()).abs() < 1e-12);
    }
}
