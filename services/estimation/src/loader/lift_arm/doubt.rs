//! Propagation of the drawing's standard deviations (its *doubts*) to payload and centre of gravity, by finite differences: each number is
//! moved by its standard deviation, one number a row.
//!
//! An error of the drawing is the same in every row and does not average out, so its effect is added to the answer. A round takes some
//! twenty rows, in which an arm hardly moves.
//!
//! The payload is at least 0 ([`crate::positive`]). This bound also updates the ratio lam (and the height) through its covariance c with
//! the payload:
//! ```text
//! m_p becomes m_p' with sigma':   lam' = lam + k d,   sigma_lam'^2 = k^2 sigma'^2 + max(1, d^2/sigma^2) (sigma_lam^2 - k^2 sigma^2)
//! k = c/sigma^2,  d = m_p' - m_p
//! ```
//! This is the rule of jointly normal variables, but for the maximum. A d beyond sigma shows that some number is off by more than its stated
//! deviation, so the remaining deviation grows in proportion.
//!
//! An emptied bucket is a known weight ([`super::tare`]). With the effects t_i of the numbers on the weight that it shows, and e_i on
//! payload, ratio or height x now:
//! ```text
//! x -= K (shown - left),   variance -= K sum e_i t_i,   K = sum e_i t_i/(sum t_i^2 + sigma_shown^2 + sigma_left^2)
//! ```
//! While the bucket stays empty, t_i is the effect on the payload now. For later loads it is the effect at the posture of the dump.
//! An exchanged bucket moves the centre of gravity as a load does, a zero or a misdescribed bucket does not: the covariances divide the
//! error between them.

use super::drawing::Drawing;
use super::geometry::{Empty, Posture, Stance};
use super::numbers::{EMPTY_HEIGHT, EMPTY_RATIO, LIFT_ZERO, Moves, NUMBERS, TILT_ZERO, TURN};
use super::tare::Tare;
use crate::Quantity;
use crate::loader::layout::Each;
use crate::math::sqrt;
use crate::positive::positive;

/// Standard deviation of a stated number over its stated one. The errors are a mixture: one number in five is off by three times its
/// deviation (scales not level, another tyre, a full tank). Zeros of angles and the linkage are excepted: their deviations are those of
/// sensors that nobody set, and of all linkages.
const MISSTATED: f64 = 1.6;

/// Effects of each number on payload, ratio and height, and their covariances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Doubts {
    /// Effect of each number, moved by its standard deviation, on payload, ratio and height [kg, -, m].
    effects: [[f64; 3]; NUMBERS],
    sums: Sums,
    /// The sums of this round so far.
    round: Sums,
    /// The next number to move.
    next: usize,
    /// Each number has been moved once: the sums are those of all.
    whole: bool,
    /// Measurement by the bucket while it is empty.
    now: Option<Tare>,
    /// The last emptied bucket that is a measurement for later loads.
    last: Option<Tared>,
}

/// An emptied bucket, and the effects of the numbers on its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Tared {
    tare: Tare,
    effects: [f64; NUMBERS],
    /// Variance of `tare.apart`: by the numbers, the rows and the material left in it [kg^2].
    total: f64,
}

/// Variances of payload, ratio and height, covariances of the payload with ratio and height, and of all three with the emptied bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Sums {
    variances: [f64; 3],
    with_payload: [f64; 2],
    with_tare: [f64; 3],
}

impl Sums {
    /// Contribution of a number with these effects, and the effect `tared` on the emptied bucket, times `weight`.
    fn of(effects: &[f64; 3], tared: f64, weight: f64) -> Self {
        let weighted = effects.map(|effect| weight * effect);
        Self {
            variances: core::array::from_fn(|i| weighted[i] * effects[i]),
            with_payload: core::array::from_fn(|i| weighted[0] * effects[1 + i]),
            with_tare: weighted.map(|effect| effect * tared),
        }
    }

    /// Adds another contribution.
    fn add(&mut self, other: &Self) {
        let add = |sums: &mut [f64], others: &[f64]| {
            for (sum, other) in sums.iter_mut().zip(others) {
                *sum += other;
            }
        };
        add(&mut self.variances, &other.variances);
        add(&mut self.with_payload, &other.with_payload);
        add(&mut self.with_tare, &other.with_tare);
    }

    /// The bucket is empty now: the effects on the emptied bucket are those on the payload.
    fn tared(mut self) -> Self {
        let [ratio, height] = self.with_payload;
        self.with_tare = [self.variances[0], ratio, height];
        self
    }

    /// Conditional covariances given the emptied bucket, whose innovation has the variance `total`, with the Kalman gains.
    fn conditioned(mut self, total: f64) -> (Self, [f64; 3]) {
        let gains = self.with_tare.map(|covariance| covariance / total);
        for ((variance, gain), covariance) in
            self.variances.iter_mut().zip(gains).zip(self.with_tare)
        {
            *variance -= gain * covariance;
        }
        for (sum, covariance) in self.with_payload.iter_mut().zip(&self.with_tare[1..]) {
            *sum -= gains[0] * covariance;
        }
        (self, gains)
    }
}

/// An answer with the standard deviations of the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubted {
    /// Payload with its whole standard deviation [kg].
    pub payload: Quantity,
    /// Centre of gravity [-, m].
    pub centre: Each<Quantity>,
    /// Standard deviations of the centre of gravity without those of the empty machine's, for a filter that estimates that one [-, m].
    pub moved: Each<f64>,
    /// Covariances with the payload.
    sums: Sums,
}

/// Variance of a number over its stated one.
pub(super) fn weight(number: usize) -> f64 {
    match number {
        LIFT_ZERO | TILT_ZERO | TURN => 1.0,
        _ => MISSTATED * MISSTATED,
    }
}

impl Doubts {
    /// Computes the effects of the next number, moved by its standard deviation. `shown`: payload of this row; `payload`: that of the
    /// filter; `empty`: the described machine in this stance.
    pub fn see(
        &mut self,
        drawing: &mut Drawing,
        (stance, posture): (&Stance, &Posture),
        [shown, payload]: [f64; 2],
        empty: &Empty,
    ) {
        let number = self.next;
        let moves = Moves::of(number);
        drawing.put_off(number);
        let (drawing, moved) = (&*drawing, &drawing.moved);
        let turned = moves.stance.then(|| drawing.stance(moved, posture));
        let stance = turned.as_ref().unwrap_or(stance);
        let shift = if moves.moment && drawing.weighs_by(number) {
            drawing.shown(moved, stance, posture).payload() - shown
        } else {
            0.0
        };
        let machine = moves.centre.then(|| drawing.empty_at(moved, stance));
        let here = empty.with(payload);
        let there = machine.as_ref().unwrap_or(empty).with(payload + shift);
        let effects = [shift, there.ratio - here.ratio, there.height - here.height];
        self.put(number, effects);
        self.next += 1;
        if self.next >= drawing.doubted {
            (self.next, self.whole) = (0, true);
            // Fresh sums, free of the rounding of subtracted effects.
            self.sums = core::mem::take(&mut self.round);
        }
    }

    /// Returns whether the sums are those of all numbers.
    pub fn are_whole(&self) -> bool {
        self.whole
    }

    /// Sets the effects of a number, moved by its standard deviation, on payload, ratio and height [kg, -, m].
    pub(super) fn put(&mut self, number: usize, effects: [f64; 3]) {
        let (old, weight) = (self.effects[number], weight(number));
        let tared = self.last.as_ref().map_or(0.0, |t| t.effects[number]);
        let new = Sums::of(&effects, tared, weight);
        self.sums.add(&Sums::of(&old, tared, -weight));
        self.sums.add(&new);
        self.round.add(&new);
        self.effects[number] = effects;
    }

    /// Rescales a number that was estimated: its new deviation is `by` times the old one, its value has changed by `moved` old deviations.
    pub fn learnt(&mut self, number: usize, by: f64, moved: f64) {
        let (old, weight) = (self.effects[number], weight(number));
        let new = old.map(|effect| by * effect);
        let tared = self.last.as_ref().map_or(0.0, |t| t.effects[number]);
        let before = Sums::of(&old, tared, -weight);
        let after = Sums::of(&new, by * tared, weight);
        self.sums.add(&before);
        self.sums.add(&after);
        // The sums of this round hold a number before `next` already; later ones are added with the new effects.
        if number < self.next {
            self.round.add(&before);
            self.round.add(&after);
        }
        self.effects[number] = new;
        if let Some(last) = &mut self.last {
            last.total += weight * (by * by - 1.0) * tared * tared;
            last.tare.apart += moved * tared;
            last.effects[number] = by * tared;
        }
    }

    /// Sets the measurement by a bucket that is empty now; none where its content is unknown.
    pub fn empty(&mut self, tare: Option<Tare>) {
        self.now = tare;
        if let Some(tare) = tare.filter(|tare| tare.at_dump) {
            self.sums = self.sums.tared();
            self.round = self.round.tared();
            self.last = Some(Tared {
                tare,
                effects: self.of_payloads(),
                total: self.sums.variances[0] + tare.variance,
            });
        }
    }

    /// Drops the measurements by emptied buckets.
    pub fn forget(&mut self) {
        (self.now, self.last) = (None, None);
    }

    /// Standard deviation of the payload by one number, as stated [kg].
    pub fn of_payload(&self, number: usize) -> f64 {
        self.effects[number][0].abs()
    }

    /// Effect of each number, moved by its standard deviation, on the payload [kg].
    pub fn of_payloads(&self) -> [f64; NUMBERS] {
        self.effects.map(|[payload, ..]| payload)
    }

    /// Standard deviation of the difference between the payloads here and there, where the numbers had the effects `there` [kg].
    pub fn between(&self, there: &[f64; NUMBERS]) -> f64 {
        let apart = |(number, there): (usize, &f64)| {
            let by = self.effects[number][0] - there;
            weight(number) * by * by
        };
        sqrt(there.iter().enumerate().map(apart).sum())
    }

    /// Standard deviation of the payload by all numbers, without an emptied bucket [kg].
    pub fn shown(&self) -> f64 {
        sqrt(self.sums.variances[0].max(0.0))
    }

    /// The sums given an emptied bucket, and the errors of payload, ratio and height that it identifies [kg, -, m].
    fn conditioned(&self) -> (Sums, [f64; 3]) {
        let ((sums, gains), apart) = match (&self.now, &self.last) {
            (Some(tare), _) => {
                let sums = self.sums.tared();
                (
                    sums.conditioned(sums.variances[0] + tare.variance),
                    tare.apart,
                )
            }
            (None, Some(tared)) => (self.sums.conditioned(tared.total), tared.tare.apart),
            (None, None) => return (self.sums, [0.0; 3]),
        };
        (sums, gains.map(|gain| gain * apart))
    }

    /// Error of the payload identified by an emptied bucket, with the remaining standard deviation by the numbers [kg].
    pub fn off(&self) -> Quantity {
        let (sums, error) = self.conditioned();
        Quantity {
            value: error[0],
            std: sqrt(sums.variances[0].max(0.0)),
        }
    }

    /// The answer with all standard deviations, times `wider`. `rows`: standard deviations of the rows, as effects on payload, ratio and
    /// height.
    pub fn doubted(&self, payload: f64, centre: Each<f64>, rows: [f64; 3], wider: f64) -> Doubted {
        let (mut sums, error) = self.conditioned();
        sums.add(&Sums::of(&rows, 0.0, 1.0));
        let std = |variance: f64| wider * sqrt(variance.max(0.0));
        let of = |i: usize| std(sums.variances[i]);
        let without = |number: usize, i: usize| {
            let own = self.effects[number][i];
            std(sums.variances[i] - weight(number) * own * own)
        };
        let quantity = |value: f64, std: f64| Quantity { value, std };
        // An emptied bucket that showed less than 0 has corrected the payload already.
        let is_tared = self.now.is_some() || self.last.is_some();
        let payload_wider = if is_tared { 1.0 } else { wider };
        let payload_std = payload_wider * sqrt(sums.variances[0].max(0.0));
        Doubted {
            payload: quantity(payload - error[0], payload_std),
            centre: Each {
                ratio: quantity(centre.ratio - error[1], of(1)),
                height: quantity(centre.height - error[2], of(2)),
            },
            moved: Each {
                ratio: without(EMPTY_RATIO, 1),
                height: without(EMPTY_HEIGHT, 2),
            },
            sums,
        }
    }
}

impl Doubted {
    /// The same given that the payload is at least 0.
    pub fn not_less_than_nothing(&self) -> Self {
        let payload = positive(self.payload);
        if payload == self.payload {
            return *self;
        }
        let moved = payload.value - self.payload.value;
        let [old, new] = [self.payload, payload].map(|p| p.std * p.std);
        let gains = self
            .sums
            .with_payload
            .map(|sum| sum / self.sums.variances[0]);
        let unlikely = (moved * moved / old).max(1.0);
        let left = |std: f64, gain: f64| {
            let beside = (std * std - gain * gain * old).max(0.0);
            sqrt(gain * gain * new + unlikely * beside)
        };
        let cut = |i: usize, q: Quantity| Quantity {
            value: q.value + gains[i] * moved,
            std: left(q.std, gains[i]),
        };
        if !gains.iter().all(|gain| gain.is_finite()) {
            return *self;
        }
        let Each { ratio, height } = self.centre;
        Self {
            payload,
            centre: Each {
                ratio: cut(0, ratio),
                height: cut(1, height),
            },
            moved: Each {
                ratio: left(self.moved.ratio, gains[0]),
                height: left(self.moved.height, gains[1]),
            },
            sums: self.sums,
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
        [shown, shown.not_less_than_nothing()]
    }

    #[test]
    fn a_full_bucket_is_what_the_pressures_show() {
        let [shown, widened] = shown(2000.0);
        assert_eq!(shown, widened);
        assert!((widened.centre.ratio.std - MISSTATED * 0.02_f64.hypot(0.005)).abs() < 1e-12);
        assert!((widened.moved.ratio - MISSTATED * 0.02).abs() < 1e-12);
    }

    #[test]
    fn a_bound_on_the_payload_also_updates_the_ratio() {
        let [shown, widened] = shown(0.0);
        // Half a normal distribution: mean .798, standard deviation .603.
        let payload = widened.payload;
        assert!(
            (payload.value - 79.8 * MISSTATED).abs() < 0.1,
            "{payload:?}"
        );
        assert!((payload.std - 60.3 * MISSTATED).abs() < 0.1, "{payload:?}");
        let Each { ratio, height } = widened.centre;
        assert!((ratio.value - 0.5 - 2e-4 * payload.value).abs() < 1e-12);
        let left = |beside: f64| (2e-4 * payload.std).hypot(MISSTATED * beside);
        assert!((ratio.std - left(0.005)).abs() < 1e-12);
        assert!((height.std - 1e-3 * payload.std).abs() < 1e-12);
        assert!(height.std < shown.centre.height.std);
        // Without the empty machine's centre only the part by the payload remains.
        assert!((widened.moved.ratio - left(0.0)).abs() < 1e-9);
    }

    #[test]
    fn an_emptied_bucket_takes_its_error_out_of_the_payload() {
        let mut tared = doubts();
        tared.empty(Some(Tare {
            apart: 130.0,
            variance: 900.0,
            at_dump: true,
        }));
        let variance = (MISSTATED * 100.0).powi(2);
        let gain = variance / (variance + 900.0);
        // A load comes. The numbers have the same effects on it: the correction by the bucket stays.
        tared.empty(None);
        for _ in 0..3 {
            tared.put(0, [100.0, 0.02, 0.1]);
        }
        let centre = Each {
            ratio: 0.6,
            height: 1.4,
        };
        let answer = tared.doubted(2000.0, centre, [0.0; 3], 1.0);
        assert!((answer.payload.value - 2000.0 + gain * 130.0).abs() < 1e-9);
        assert!((answer.payload.std - (variance * (1.0 - gain)).sqrt()).abs() < 1e-9);
        let prior = doubts().doubted(2000.0, centre, [0.0; 3], 1.0);
        // The ratio is corrected as far as the same numbers move it.
        let with = 0.02 / 100.0;
        let Each { ratio, .. } = answer.centre;
        assert!((ratio.value - 0.6 + with * gain * 130.0).abs() < 1e-12);
        let learnt = with * with * variance * gain;
        assert!((ratio.std - (prior.centre.ratio.std.powi(2) - learnt).sqrt()).abs() < 1e-12);
        tared.forget();
        assert_eq!(
            tared.doubted(2000.0, centre, [0.0; 3], 1.0).payload.value,
            2000.0
        );
    }

    #[test]
    fn a_number_that_is_learnt_in_the_middle_of_a_round_is_learnt_in_the_next_sums() {
        let effects = |number: usize| [100.0 / (1.0 + number as f64), 1e-3, 2e-3];
        let mut doubts = Doubts::default();
        for number in 0..NUMBERS {
            doubts.put(number, effects(number));
        }
        doubts.round = Sums::default();
        for number in 0..NUMBERS {
            if number == 5 {
                doubts.next = number;
                doubts.learnt(2, 3.0, 0.0);
                doubts.learnt(7, 3.0, 0.0);
            }
            let by = if matches!(number, 2 | 7) && number >= 5 {
                3.0
            } else {
                1.0
            };
            doubts.put(number, effects(number).map(|effect| by * effect));
        }
        let apart = |a: f64, b: f64| (a - b).abs() / b;
        for (sum, round) in doubts.sums.variances.iter().zip(doubts.round.variances) {
            assert!(apart(*sum, round) < 1e-12, "{sum} {round}");
        }
    }

    #[test]
    fn where_the_numbers_do_the_same_the_same_bucket_is_no_other() {
        let doubts = doubts();
        let here = doubts.of_payloads();
        assert_eq!(doubts.between(&here), 0.0);
        let there = here.map(|effect| effect - 50.0);
        let (one, all) = (doubts.between(&there), NUMBERS as f64);
        let stated = 3.0 + (all - 3.0) * MISSTATED * MISSTATED;
        assert!((one - 50.0 * stated.sqrt()).abs() < 1e-9, "{one}");
    }

    #[test]
    fn a_bucket_far_below_zero_leaves_the_ratio_uncertain() {
        let [_, widened] = shown(-300.0);
        let away = (widened.payload.value + 300.0) / 100.0;
        assert!(
            away > 3.0 && widened.centre.ratio.std > 0.005 * away,
            "{away}"
        );
    }
}
