//! The ends of the arm's travel: there a stop carries what the cylinders do not, or the pressure of the pump is trapped behind a piston that
//! cannot move. Neither is weight.
//!
//! Where the stops are nobody states: an end is where the arm has never been beyond. A moment beyond what was lifted is the upper stop's there,
//! for nothing comes into a bucket in the air; one that is less than that of an empty bucket is the lower one's, or the ground's. It says nothing
//! until the arm has left.

/// This near an end the arm is at it [rad].
const NEAR: f64 = 0.03;
/// An arm that has not gone so far up has reached no upper end [rad].
const TRAVEL: f64 = 0.2;
/// Beyond an end that was taken for one by more than this, it was none [rad].
const BEYOND: f64 = 0.06;

/// An end of the arm's travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum End {
    Lower,
    Upper,
}

/// Memory of the ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Stops {
    /// Lowest and highest angle so far [rad].
    range: Option<[f64; 2]>,
    /// The stop that the arm stands against, and where [rad].
    against: Option<(End, f64)>,
}

impl Stops {
    /// Takes the angle of the arm [rad].
    pub fn see(&mut self, lift: f64) {
        let [low, high] = self.range.get_or_insert([lift; 2]);
        *low = low.min(lift);
        *high = high.max(lift);
        // How far it has gone from where it met the stop, to either side.
        let stays = |(end, at): &(End, f64)| {
            let out = match end {
                End::Lower => at - lift,
                End::Upper => lift - at,
            };
            (-NEAR..BEYOND).contains(&out)
        };
        self.against = self.against.filter(stays);
    }

    /// Whether the arm is at an end of its travel.
    pub fn is_at(&self, end: End, lift: f64) -> bool {
        self.range.is_some_and(|[low, high]| match end {
            End::Lower => lift < low + NEAR,
            End::Upper => high - low > TRAVEL && lift > high - NEAR,
        })
    }

    /// The stop carries.
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
        // What was taken for a stop and gives way is none.
        stops.meet(End::Upper, 0.5);
        stops.see(0.58);
        assert!(!stops.carry());
        assert!(!stops.is_at(End::Lower, 0.0) && stops.is_at(End::Lower, -0.5));
    }
}
