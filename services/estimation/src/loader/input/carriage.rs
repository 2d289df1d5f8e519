//! How a loader carries its bucket while it drives: flat or turned in. A bucket that mostly seems to hang down or to be turned over
//! indicates a wrong angle. That of the lift arm or of the bucket has another sign or zero.

use crate::math::round;
use core::f64::consts::TAU;

/// Speed above which the machine drives [m/s].
const DRIVES: f64 = 1.0;
/// Angles in which a bucket is carried, pin to load, to the horizontal [rad]: with its floor, .4 below that line, from 63 degrees tipped
/// (levelling) to 63 rolled back. Full buckets of independent simulators had .7 to 1.3, of one linkage up to 1.5.
const CARRIED: [f64; 2] = [-0.7, 1.5];
/// Least time of driving for a result [s].
const ENOUGH: f64 = 2.0;
/// Time between two rows beyond which there is a gap [s].
const GAP: f64 = 0.5;

/// Times of driving so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Carriage {
    /// Time of driving, and the part of it with the bucket in a position in which none is carried [s].
    driven: f64,
    odd: f64,
}

impl Carriage {
    /// Adds a row `dt` \[s\] after the one before: speed [m/s], angles of the lift arm to the horizontal and of the bucket to the
    /// arm \[rad\].
    pub fn see(&mut self, speed: f64, [lift, tilt]: [f64; 2], dt: f64) {
        if !((0.0..GAP).contains(&dt) && speed.abs() > DRIVES) {
            return;
        }
        let bucket = lift + tilt;
        let bucket = bucket - TAU * round(bucket / TAU);
        self.driven += dt;
        if !(CARRIED[0]..CARRIED[1]).contains(&bucket) {
            self.odd += dt;
        }
    }

    /// Whether the bucket was mostly in a position in which none is carried.
    #[must_use]
    pub fn is_odd(&self) -> bool {
        self.driven > ENOUGH && 2.0 * self.odd > self.driven
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sign_that_is_wrong_shows_in_how_the_bucket_is_carried() {
        // Filling, carrying turned in, dumping, driving back with a flat bucket.
        let cycle = [
            (0.5, -0.7, 0.7),
            (3.0, -0.5, 1.7),
            (0.3, 0.6, -1.3),
            (3.0, -0.6, 1.0),
        ];
        let odd = |signs: [f64; 2]| {
            let mut carriage = Carriage::default();
            for (speed, lift, tilt) in cycle {
                (0..1000)
                    .for_each(|_| carriage.see(speed, [signs[0] * lift, signs[1] * tilt], 0.01));
            }
            carriage.is_odd()
        };
        // A sensor may count from a whole turn further on.
        for turns in [-TAU, TAU] {
            let mut carriage = Carriage::default();
            for (speed, lift, tilt) in cycle {
                (0..1000).for_each(|_| carriage.see(speed, [lift, tilt + turns], 0.01));
            }
            assert!(!carriage.is_odd(), "{turns}");
        }
        assert!(!odd([1.0, 1.0]));
        assert!(odd([-1.0, 1.0]) && odd([1.0, -1.0]));
        assert!(!Carriage::default().is_odd());
    }
}
