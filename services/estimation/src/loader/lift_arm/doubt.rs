//! What the doubts of the drawing do to payload and centre of gravity: each number moved by its standard deviation, one a row.
//!
//! A number that is off is off in every row, so nothing averages it out: its effect is added to the answer. Twenty rows go round, in
//! which an arm hardly moves.
//!
//! A bucket holds no less than nothing ([`crate::positive`]), and what is told of the payload is told of all that goes with it:
//! ```text
//! m_p becomes m_p' with sigma':   lam' = lam + (c/sigma^2)(m_p' - m_p),   sigma_lam'^2 = sigma_lam^2 - (c/sigma^2)^2 (sigma^2 - sigma'^2)
//! ```
//! with c the covariance of payload and lam, as of every jointly normal pair.

use super::super::layout::Each;
use super::drawing::{Drawing, EMPTY_HEIGHT, EMPTY_RATIO, NUMBERS, Posture};
use crate::Quantity;
use crate::math::sqrt;
use crate::positive::positive;

/// Effects of each number on payload, ratio and height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Doubts {
    effects: [[f64; 3]; NUMBERS],
    sums: Sums,
    next: usize,
}

/// Variances of payload, ratio and height, and covariances of the payload with the latter two.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Sums {
    variances: [f64; 3],
    with_payload: [f64; 2],
}

impl Sums {
    fn add(mut self, effects: &[f64; 3]) -> Self {
        for (sum, effect) in self.variances.iter_mut().zip(effects) {
            *sum += effect * effect;
        }
        for (sum, effect) in self.with_payload.iter_mut().zip(&effects[1..]) {
            *sum += effects[0] * effect;
        }
        self
    }
}

/// An answer as the pressures give it, or as a bucket allows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubted {
    /// Payload with its whole doubt [kg].
    pub payload: Quantity,
    /// Centre of gravity, by values and standard deviations [-, m].
    pub centre: Each<Quantity>,
    /// Standard deviations without those of the empty machine's centre: who measures that one otherwise has these left [-, m].
    pub moved: Each<f64>,
}

impl Doubts {
    /// Moves the next number by its standard deviation.
    pub fn see(&mut self, drawing: &Drawing, posture: &Posture, payload: f64) {
        let mut moved = drawing.values;
        moved[self.next] += drawing.std[self.next];
        let shift = drawing.payload(&moved, posture) - drawing.payload(&drawing.values, posture);
        let here = drawing.centre(&drawing.values, posture, payload);
        let there = drawing.centre(&moved, posture, payload + shift);
        self.effects[self.next] = [shift, there.ratio - here.ratio, there.height - here.height];
        self.next = (self.next + 1) % NUMBERS;
        self.sums = self.effects.iter().fold(Sums::default(), Sums::add);
    }

    /// Standard deviation of the payload by all numbers [kg].
    pub fn payload(&self) -> f64 {
        sqrt(self.sums.variances[0])
    }

    /// The answer with all doubts, each `wider` than it was stated. `rows`: what the rows leave open, as effects like those of a number.
    pub fn doubted(&self, payload: f64, centre: Each<f64>, rows: [f64; 3], wider: f64) -> Doubted {
        let sums = self.sums.add(&rows);
        let std = |variance: f64| wider * sqrt(variance.max(0.0));
        let of = |i: usize| std(sums.variances[i]);
        let without = |number: usize, i: usize| {
            let own = self.effects[number][i];
            std(sums.variances[i] - own * own)
        };
        let quantity = |value: f64, std: f64| Quantity { value, std };
        Doubted {
            payload: quantity(payload, of(0)),
            centre: Each {
                ratio: quantity(centre.ratio, of(1)),
                height: quantity(centre.height, of(2)),
            },
            moved: Each {
                ratio: without(EMPTY_RATIO, 1),
                height: without(EMPTY_HEIGHT, 2),
            },
        }
    }

    /// The same, the bucket holding no less than nothing.
    pub fn not_less_than_nothing(&self, doubted: &Doubted, rows: [f64; 3]) -> Doubted {
        let sums = self.sums.add(&rows);
        let payload = positive(doubted.payload);
        let moved = payload.value - doubted.payload.value;
        let [old, new] = [doubted.payload, payload].map(|p| p.std * p.std);
        let told = |i: usize| sums.with_payload[i] / sums.variances[0];
        let cut = |i: usize, q: Quantity| Quantity {
            value: q.value + told(i) * moved,
            std: less(q.std, told(i), old - new),
        };
        if !told(0).is_finite() || !told(1).is_finite() {
            return *doubted;
        }
        let Each { ratio, height } = doubted.centre;
        Doubted {
            payload,
            centre: Each {
                ratio: cut(0, ratio),
                height: cut(1, height),
            },
            moved: Each {
                ratio: less(doubted.moved.ratio, told(0), old - new),
                height: less(doubted.moved.height, told(1), old - new),
            },
        }
    }
}

/// Standard deviation of what goes by `told` with a payload that has lost so much of its variance.
fn less(std: f64, told: f64, lost: f64) -> f64 {
    sqrt((std * std - told * told * lost).max(0.0))
}
