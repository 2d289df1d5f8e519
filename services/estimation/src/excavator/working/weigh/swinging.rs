//! A load that hangs or sloshes swings on while the machine stands: the oscillation of the moment.

use super::{EMPTY, HOLDS, Weigh, fits};
use crate::excavator::measurements::boom_moment::{GRAVITY, Moment};
use crate::kalman::Innovation;

/// Oscillation of the moment of a standing machine, as a share of it, above which the load swings. Loads that do not: at most .0015; one
/// on a hook: .0035 to .03.
const WAVERING: f64 = 0.003;
/// Time constant with which the oscillation is observed \[s\].
const WATCHED: f64 = 2.5;
/// Number of blocks in which joints that changed the content, and what swings with them, come to rest (0.6 s).
const SETTLES: u32 = 3;
/// Largest change of the load's lever from block to block during that observation \[m\].
const STILL: f64 = 0.02;

/// Observation of the moment while the machine stands.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Watched {
    /// Content at the start of the stand \[kg\].
    payload: Option<f64>,
    /// Moment per kilogram of payload [N m/kg].
    lever: f64,
    /// Deviation of the moment from the expected one, as shares of the moment: its mean, and the last difference from that mean.
    mean: f64,
    last: f64,
    /// Number of blocks until the joints that changed the content are at rest.
    settling: u32,
}

impl Weigh {
    /// Observes the oscillation of the moment: a load that hangs or sloshes swings on while the machine stands. Friction, drawing and
    /// noise do not oscillate from block to block, nor does an empty bucket.
    pub(in crate::excavator) fn watch(
        &mut self,
        m: &Moment,
        innovation: Innovation,
        (payload, rated): (f64, f64),
        stands: bool,
    ) {
        if payload < EMPTY * rated {
            self.forget();
            return;
        }
        let watched = &mut self.watched;
        let share = (m.period / WATCHED).min(1.0);
        if m.moves {
            self.wavering *= 1.0 - 0.2 * share;
        }
        let moved = (m.still_payload - watched.lever).abs() > STILL * GRAVITY;
        watched.lever = m.still_payload;
        if !stands || m.moves || moved || m.period > HOLDS {
            watched.payload = None;
            return;
        }
        // A jump is no oscillation.
        if !fits(innovation) {
            return;
        }
        let begun = watched.payload.is_some();
        let payload = *watched.payload.get_or_insert(payload);
        let whole = m.measured.abs().max(f64::MIN_POSITIVE);
        let apart = (m.measured - m.still - payload * m.still_payload) / whole;
        watched.settling = watched.settling.saturating_sub(1);
        if !begun || watched.settling > 0 {
            (watched.mean, watched.last) = (apart, 0.0);
            return;
        }
        watched.mean += share * (apart - watched.mean);
        let away = apart - watched.mean;
        // Noise is independent from block to block: the mean of its products is zero.
        self.wavering += share * (away * watched.last - self.wavering);
        watched.last = away;
    }

    /// Restarts the observation of the oscillation.
    pub(super) fn forget(&mut self) {
        self.wavering = 0.0;
        self.watched.payload = None;
        self.watched.settling = SETTLES;
    }

    /// Returns whether the load hangs, or swings for another reason.
    pub(in crate::excavator) fn swings(&self) -> bool {
        self.wavering > WAVERING * WAVERING
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{MOMENT, described, innovation};
    use super::*;
    use crate::math::{exp, sin_cos};

    /// Whether the load swings, on a machine that stands for 6 s with a moment that differs by a share from block to block.
    fn stands(payload: f64, share: impl Fn(f64) -> f64) -> bool {
        let mut weigh = described();
        weigh.forget();
        for block in 0..30 {
            let moment = Moment {
                measured: MOMENT * (1.0 + share(0.2 * f64::from(block))),
                still: MOMENT,
                period: 0.2,
                ..Moment::default()
            };
            weigh.watch(&moment, innovation(0.0), (payload, 1000.0), true);
        }
        weigh.swings()
    }

    #[test]
    fn a_bucket_that_settles_after_a_dump_does_not_hang() {
        let settles = |t: f64| 0.04 * exp(-t / 0.1);
        assert!(!stands(800.0, settles), "4 %, gone within half a second");
    }

    #[test]
    fn a_load_that_swings_wavers_slowly_and_noise_does_not() {
        assert!(
            stands(800.0, |t| 0.01 * sin_cos(2.0 * t).0),
            "1 % at 2 rad/s"
        );
        assert!(!stands(800.0, |_| 0.01), "another load");
        let relaxes = |t: f64| 0.04 * exp(-t / 3.0);
        assert!(!stands(20.0, relaxes), "nothing in it");
        let noise = [0.003, -0.002, -0.003, 0.001, 0.002, -0.001, 0.003, -0.003];
        assert!(
            !stands(800.0, |t| noise[(t * 5.0) as usize % 8]),
            "0.24 % of noise"
        );
    }
}
