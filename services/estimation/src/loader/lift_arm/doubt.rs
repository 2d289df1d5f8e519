//! What the doubts of the drawing do to payload and centre of gravity: each number moved by its standard deviation, one a row.
//!
//! A number that is off is off in every row, so nothing averages it out: its effect is added to the answer. Some twenty rows go round, in
//! which an arm hardly moves.
//!
//! A bucket holds no less than nothing ([`crate::positive`]), and what is known of the payload is known of all that goes with it:
//! ```text
//! m_p becomes m_p' with sigma':   lam' = lam + k d,   sigma_lam'^2 = k^2 sigma'^2 + max(1, d^2/sigma^2) (sigma_lam^2 - k^2 sigma^2)
//! k = c/sigma^2,  d = m_p' - m_p
//! ```
//! with c the covariance of payload and lam, as of every jointly normal pair. The maximum is what is added: a d beyond sigma says that
//! a number is off by more than it claims, nobody says which, and what goes with it is uncertain in proportion.

use super::super::layout::Each;
use super::drawing::{
    Drawing, EMPTY_HEIGHT, EMPTY_RATIO, Empty, LIFT_ZERO, NUMBERS, Posture, TILT_ZERO,
};
use crate::Quantity;
use crate::math::sqrt;
use crate::positive::positive;

/// What somebody states is a mixture: one number in five is off by three times what it says (scales that were not level, another tyre,
/// a full tank). Its deviation over the stated one, for the centre of gravity; a payload's interval is as the numbers are stated. Zeros of
/// angles are as wide as sensors that nobody set already.
const MISSTATED: f64 = 1.6;

/// Effects of each number on payload, ratio and height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Doubts {
    effects: [[f64; 3]; NUMBERS],
    sums: Sums,
    /// The sums of this round.
    round: Sums,
    next: usize,
}

/// Variances of payload, ratio and height, and covariances of the payload with the latter two. Those of the centre hold misstatements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Sums {
    variances: [f64; 3],
    with_payload: [f64; 2],
}

impl Sums {
    /// Adds the effects of a number that is `wider` than it was stated, for the centre; takes them away with a `sign` of -1.
    fn add(mut self, effects: &[f64; 3], wider: f64, sign: f64) -> Self {
        let scales = [sign, sign * wider * wider, sign * wider * wider];
        for ((sum, effect), scale) in self.variances.iter_mut().zip(effects).zip(scales) {
            *sum += scale * effect * effect;
        }
        for (sum, effect) in self.with_payload.iter_mut().zip(&effects[1..]) {
            *sum += sign * effects[0] * effect;
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

/// How much wider than stated a number is.
fn misstated(number: usize) -> f64 {
    match number {
        LIFT_ZERO | TILT_ZERO => 1.0,
        _ => MISSTATED,
    }
}

impl Doubts {
    /// Moves the next number by its standard deviation. `empty`: the machine as it is described.
    pub fn see(&mut self, drawing: &Drawing, posture: &Posture, payload: f64, empty: &Empty) {
        let [moved, weighing] = drawing.off(self.next);
        let shift = drawing.payload(&weighing, posture) - drawing.payload(&drawing.values, posture);
        let here = empty.with(payload);
        let there = drawing.empty_at(&moved, posture).with(payload + shift);
        let effects = [shift, there.ratio - here.ratio, there.height - here.height];
        self.put(self.next, effects);
        self.next += 1;
        if self.next == drawing.doubted {
            self.next = 0;
            // As new: what rounding left of taken away effects is gone.
            self.sums = core::mem::take(&mut self.round);
        }
    }

    fn put(&mut self, number: usize, effects: [f64; 3]) {
        let (old, wider) = (self.effects[number], misstated(number));
        self.sums = self.sums.add(&old, wider, -1.0).add(&effects, wider, 1.0);
        self.round = self.round.add(&effects, wider, 1.0);
        self.effects[number] = effects;
    }

    /// Standard deviation of the payload by all numbers [kg].
    pub fn payload(&self) -> f64 {
        sqrt(self.sums.variances[0].max(0.0))
    }

    /// The answer with all doubts, each `wider` than it was stated. `rows`: what the rows leave open, as effects like those of a number.
    pub fn doubted(&self, payload: f64, centre: Each<f64>, rows: [f64; 3], wider: f64) -> Doubted {
        let sums = self.sums.add(&rows, 1.0, 1.0);
        let std = |variance: f64| wider * sqrt(variance.max(0.0));
        let of = |i: usize| std(sums.variances[i]);
        let without = |number: usize, i: usize| {
            let own = misstated(number) * self.effects[number][i];
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
        let sums = self.sums.add(&rows, 1.0, 1.0);
        let payload = positive(doubted.payload);
        let moved = payload.value - doubted.payload.value;
        let [old, new] = [doubted.payload, payload].map(|p| p.std * p.std);
        let gain = |i: usize| sums.with_payload[i] / sums.variances[0];
        let unlikely = (moved * moved / old).max(1.0);
        let left = |std: f64, gain: f64| {
            let beside = (std * std - gain * gain * old).max(0.0);
            sqrt(gain * gain * new + unlikely * beside)
        };
        let cut = |i: usize, q: Quantity| Quantity {
            value: q.value + gain(i) * moved,
            std: left(q.std, gain(i)),
        };
        if !gain(0).is_finite() || !gain(1).is_finite() {
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
                ratio: left(doubted.moved.ratio, gain(0)),
                height: left(doubted.moved.height, gain(1)),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two numbers: one moves payload and ratio together, one the ratio alone.
    fn doubts() -> Doubts {
        let mut doubts = Doubts::default();
        doubts.put(0, [30.0, 0.01, 0.2]);
        doubts.put(0, [100.0, 0.02, 0.1]);
        doubts.put(EMPTY_RATIO, [0.0, 0.005, 0.0]);
        doubts
    }

    /// Ratio and height where the pressures show this payload.
    fn shown(payload: f64) -> [Doubted; 2] {
        let centre = Each {
            ratio: 0.5,
            height: 1.0,
        };
        let doubts = doubts();
        let shown = doubts.doubted(payload, centre, [0.0; 3], 1.0);
        [shown, doubts.not_less_than_nothing(&shown, [0.0; 3])]
    }

    #[test]
    fn a_full_bucket_is_what_the_pressures_show() {
        let [shown, widened] = shown(1000.0);
        assert_eq!(shown, widened);
        assert!((widened.centre.ratio.std - MISSTATED * 0.02_f64.hypot(0.005)).abs() < 1e-12);
        assert!((widened.moved.ratio - MISSTATED * 0.02).abs() < 1e-12);
    }

    #[test]
    fn what_an_empty_bucket_tells_of_the_payload_it_tells_of_the_ratio() {
        let [shown, widened] = shown(0.0);
        // Half a normal distribution: mean .798, standard deviation .603.
        assert!(
            (widened.payload.value - 79.8).abs() < 0.1 && (widened.payload.std - 60.3).abs() < 0.1
        );
        let Each { ratio, height } = widened.centre;
        assert!((ratio.value - 0.5 - 2e-4 * widened.payload.value).abs() < 1e-12);
        // What the payload's own misstatement leaves is not told by an empty bucket.
        let left = |stated: f64| {
            let beside = MISSTATED * MISSTATED * stated * stated - 0.02_f64.powi(2);
            (2e-4 * widened.payload.std).hypot(beside.sqrt())
        };
        assert!((ratio.std - left(0.02_f64.hypot(0.005))).abs() < 1e-12);
        let height_left =
            (1e-3 * widened.payload.std).hypot(0.1 * (MISSTATED * MISSTATED - 1.0).sqrt());
        assert!((height.std - height_left).abs() < 1e-12);
        assert!(height.std < shown.centre.height.std);
        // As if the load were known otherwise: only its part is left of the machine's centre.
        assert!((widened.moved.ratio - left(0.02)).abs() < 1e-9);
    }

    #[test]
    fn a_bucket_far_below_zero_leaves_the_ratio_uncertain() {
        let [_, widened] = shown(-300.0);
        let away = (widened.payload.value + 300.0) / 100.0;
        assert!(away > 3.0 && widened.centre.ratio.std > 0.005 * away);
    }
}
