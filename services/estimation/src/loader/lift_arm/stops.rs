//! Detects the stops at the ends of the arm's travel, where pressures are no weight: a stop carries the arm, or the pump's pressure is
//! trapped behind a piston that cannot move.
//!
//! The ends are not stated: an end is the extreme angle so far. A moment beyond that of the lifted load is due to the upper stop, since
//! nothing enters a bucket in the air. A moment below that of an empty bucket is due to the lower stop or the ground. Then rows are not used
//! until the arm has left the end.

/// Distance from an end within which the arm is at it [rad].
const NEAR: f64 = 0.03;
/// Least travel of an arm that may have reached its upper end [rad].
const TRAVEL: f64 = 0.2;
/// Distance beyond a supposed end that refutes it [rad].
const BEYOND: f64 = 0.06;

/// An end of the arm's travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum End {
    Lower,
    Upper,
}

/// Range of the arm, and the present stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Stops {
    /// Lowest and highest angle so far [rad].
    range: Option<[f64; 2]>,
    /// The stop that carries, and the angle of the arm at its contact [rad].
    against: Option<(End, f64)>,
}

impl Stops {
    /// Updates with the angle of the arm [rad].
    pub fn see(&mut self, lift: f64) {
        let [low, high] = self.range.get_or_insert([lift; 2]);
        *low = low.min(lift);
        *high = high.max(lift);
        // Distance from the contact, positive beyond the stop.
        let stays = |(end, at): &(End, f64)| {
            let out = match end {
                End::Lower => at - lift,
                End::Upper => lift - at,
            };
            (-NEAR..BEYOND).contains(&out)
        };
        self.against = self.against.filter(stays);
    }

    /// The arm is at this end of its travel.
    pub fn is_at(&self, end: End, lift: f64) -> bool {
        self.range.is_some_and(|[low, high]| match end {
            End::Lower => lift < low + NEAR,
            End::Upper => high - low > TRAVEL && lift > high - NEAR,
        })
    }

    /// Sets the stop that carries, at this angle.
    pub fn meet(&mut self, end: End, lift: f64) {
        self.against = Some((end, lift));
    }

    /// A stop carries: pressures are no weight.
    pub fn carry(&self) -> bool {
        self.against.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_is_where_the_arm_has_never_been_beyond_and_is_left_when_it_has_moved() {
        let mut stops = Stops::default();
        (0..=100).for_each(|k| stops.see(-0.5 + 0.01 * f64::from(k)));
        assert!(stops.is_at(End::Upper, 0.49) && !stops.is_at(End::Upper, 0.4));
        stops.meet(End::Upper, 0.5);
        stops.see(0.51);
        assert!(stops.carry());
        stops.see(0.46);
        assert!(!stops.carry() && stops.is_at(End::Upper, 0.5));
        // A supposed stop that gives way is none.
        stops.meet(End::Upper, 0.5);
        stops.see(0.58);
        assert!(!stops.carry());
        assert!(!stops.is_at(End::Lower, 0.0) && stops.is_at(End::Lower, -0.5));
    }
}
