//! Loads: one message for each swing of an excavator or drive of a loader, counted as in the report, while they happen.

use view::estimate::Estimate;
use view::stretches::{PAUSE, SHORTEST};

/// Finds the stretches of motion in a stream of estimates.
#[derive(Debug, Default, Clone)]
pub struct Loads<E> {
    open: Option<Stretch<E>>,
    /// The beginning of this motion was missed: it is skipped up to the next pause, and left to the recording.
    skips: bool,
    /// Time of the last motion while skipping [s].
    skipped: f64,
}

#[derive(Debug, Clone)]
struct Stretch<E> {
    start: f64,
    end: f64,
    reported: E,
}

impl<E: Estimate> Loads<E> {
    /// Takes the next estimate. At the end of a stretch, returns its last trusted estimate, or its last one.
    pub fn take(&mut self, estimate: &E) -> Option<E> {
        let time = estimate.stamp().time;
        let moves = estimate.motion() >= E::MOTION_NAME.1;
        if self.skips {
            if moves || self.skipped.is_nan() {
                self.skipped = time;
            }
            self.skips = (0.0..PAUSE).contains(&(time - self.skipped));
            return None;
        }
        // A time that goes backwards ends the stretch as well.
        let is_over = |s: &Stretch<E>| !(0.0..PAUSE).contains(&(time - s.end));
        let over = self.open.take_if(|s| is_over(s));
        if moves {
            match &mut self.open {
                Some(stretch) => {
                    stretch.end = time;
                    if estimate.trusted() || !stretch.reported.trusted() {
                        stretch.reported = *estimate;
                    }
                }
                None => {
                    self.open = Some(Stretch {
                        start: time,
                        end: time,
                        reported: *estimate,
                    });
                }
            }
        }
        over.filter(|s| s.end - s.start >= SHORTEST)
            .map(|s| s.reported)
    }

    /// Discards the current stretch, because estimates were missed.
    pub fn forget(&mut self) {
        self.open = None;
        (self.skips, self.skipped) = (true, f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, excavator_bits as x};

    fn estimate(i: u64) -> ExcavatorEstimate {
        let t = i as f64 * 0.1;
        let moves = (1.0..2.0).contains(&t) || (2.2..4.0).contains(&t) || (6.0..6.5).contains(&t);
        let mut estimate = ExcavatorEstimate {
            velocity: if moves { -0.5 } else { 0.0 },
            flags: if (2.95..3.05).contains(&t) {
                x::TRUSTED
            } else {
                0
            },
            ..Default::default()
        };
        (estimate.stamp.time, estimate.stamp.sequence) = (t, i);
        estimate
    }

    #[test]
    fn a_swing_is_reported_once_by_its_last_trusted_estimate() {
        let mut loads = Loads::default();
        let reported: Vec<u64> = (0..80)
            .filter_map(|i| loads.take(&estimate(i)))
            .map(|e| e.stamp.sequence)
            .collect();
        assert_eq!(reported, [30]);
    }

    #[test]
    fn a_swing_whose_beginning_was_missed_is_not_reported() {
        let mut loads = Loads::default();
        loads.forget();
        assert!((25..80).all(|i| loads.take(&estimate(i)).is_none()));
    }

    #[test]
    fn a_dip_is_no_end_of_a_swing_whose_beginning_was_missed() {
        let mut loads = Loads::default();
        loads.forget();
        // Below the limit from 2.0 to 2.2 s.
        assert!((15..80).all(|i| loads.take(&estimate(i)).is_none()));
    }
}
