//! Detects whether the ground may carry part of the bucket.
//!
//! The contact is not measured. A bucket reaches the ground only by lowering, by the arm that pulls it in, or by closing, while the
//! upper body stands or sweeps slowly. Or the cylinders carry less although no joint moves. It is free again when it has risen from its
//! lowest place, or when the machine swings. A bucket that closes may dig; one that the arm pulls in without rising does.

use crate::math::sin_cos;

/// Time constant of the smoothed angles \[s\].
const SMOOTHING: f64 = 0.1;
/// Descent from its highest place after which a bucket may touch the ground [lengths of boom and arm].
const FALLEN: f64 = 0.006;
/// Closing angle of arm and bucket by which they dig \[rad\]. An angle, not a rate: rates of noisy angles are noise.
const DIGGING: [f64; 2] = [0.03, 0.05];
/// Ratio of the bucket's path towards the machine to its rise, beyond which the arm digs.
const PULLING: f64 = 2.0;
/// Height above its lowest place at which the bucket is free [lengths of boom and arm].
const RAISED: f64 = 0.035;
/// Swing velocity, and its duration, that show a free bucket [rad/s, s].
const SWINGING: f64 = 0.08;
const SWUNG: f64 = 0.15;
/// The same velocity of a bucket that digs: an operator who wiggles or sweeps it in the ground reaches .2 rad/s.
pub(in crate::excavator) const SWEEPING: f64 = 0.25;

/// Tracks whether the bucket may touch the ground.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct Ground {
    touches: bool,
    digs: bool,
    /// The arm has pulled the bucket in during a sweep.
    pulled: bool,
    smoothed: Option<[f64; 3]>,
    /// Since the bucket was last free: its highest place, the arm's stretch, the bucket's largest angle.
    highest: f64,
    stretched: Stretch,
    open: f64,
    /// Lowest place since it may touch the ground.
    lowest: f64,
    /// The arm's stretch since the upper body last stood.
    sweeping: Stretch,
    swung: f64,
}

/// The arm's largest angle \[rad\], and the bucket's height there \[m\].
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Stretch {
    arm: f64,
    height: f64,
}

impl Stretch {
    const NONE: Self = Self {
        arm: f64::NEG_INFINITY,
        height: 0.0,
    };

    /// Follows an arm of this length; returns whether it pulls the bucket in. Lifting pulls it in as well, but less relative to the rise.
    fn follow(&mut self, arm: f64, height: f64, length: f64) -> bool {
        if arm > self.arm {
            *self = Self { arm, height };
        }
        let pulled = self.arm - arm;
        pulled > DIGGING[0] && pulled * length > PULLING * (height - self.height)
    }
}

impl Ground {
    /// At the start the bucket may touch the ground.
    pub(in crate::excavator) fn new() -> Self {
        Self {
            touches: true,
            digs: true,
            pulled: false,
            smoothed: None,
            highest: f64::NEG_INFINITY,
            stretched: Stretch::NONE,
            sweeping: Stretch::NONE,
            open: f64::NEG_INFINITY,
            lowest: f64::INFINITY,
            swung: 0.0,
        }
    }

    /// Takes one tick: joint angles \[rad\], lengths of boom and arm \[m\], swing velocity [rad/s]. The upper body `stands`, or hardly
    /// moves.
    pub(in crate::excavator) fn step(
        &mut self,
        posture: [f64; 3],
        lengths: [f64; 2],
        (velocity, stands): (f64, bool),
        period: f64,
    ) {
        let before = self.smoothed.unwrap_or(posture);
        let share = period / (SMOOTHING + period);
        let now: [f64; 3] = core::array::from_fn(|i| before[i] + share * (posture[i] - before[i]));
        self.smoothed = Some(now);
        let free_from = if self.digs { SWEEPING } else { SWINGING };
        self.swung = if velocity.abs() > free_from {
            self.swung + period
        } else {
            0.0
        };
        if self.swung > SWUNG {
            self.free();
            return;
        }
        let reach = lengths[0] + lengths[1];
        let height = lengths[0] * sin_cos(now[0]).0 + lengths[1] * sin_cos(now[0] + now[1]).0;
        self.highest = self.highest.max(height);
        self.open = self.open.max(now[2]);
        let pulls = self.stretched.follow(now[1], height, lengths[1]);
        if stands {
            self.sweeping = Stretch::NONE;
        }
        self.pulled = self.sweeping.follow(now[1], height, lengths[1]) || self.pulled && !stands;
        let digs = pulls || self.open - now[2] > DIGGING[1];
        self.touches |= digs || self.highest - height > FALLEN * reach;
        self.digs |= digs;
        if self.touches {
            self.lowest = self.lowest.min(height);
            if height > self.lowest + RAISED * reach {
                self.free();
            }
        }
    }

    fn free(&mut self) {
        *self = Self {
            touches: false,
            digs: false,
            smoothed: self.smoothed,
            swung: self.swung,
            ..Self::new()
        };
    }

    /// The upper body stands, or swings. Without pressures, only a sweep needs the ground.
    pub(in crate::excavator) fn ends_sweep(&mut self) {
        (self.pulled, self.sweeping, self.smoothed) = (false, Stretch::NONE, None);
    }

    /// The bucket has opened: earlier motions no longer fill it.
    pub(in crate::excavator) fn opens(&mut self) {
        self.digs = false;
        self.pulled = false;
        (self.stretched, self.sweeping) = (Stretch::NONE, Stretch::NONE);
        self.open = f64::NEG_INFINITY;
    }

    /// The ground seems to carry part of the bucket, although no joint moved it there.
    pub(in crate::excavator) fn rests(&mut self) {
        self.touches = true;
    }

    /// The bucket may be filling.
    pub(in crate::excavator) fn digs(&self) -> bool {
        self.digs
    }

    /// The arm has pulled the bucket in without raising it, since the upper body last stood: the bucket fills in a sweep.
    pub(in crate::excavator) fn is_pulled(&self) -> bool {
        self.pulled
    }

    /// The bucket may touch the ground.
    pub(in crate::excavator) fn may_touch(&self) -> bool {
        self.touches
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTHS: [f64; 2] = [5.7, 2.9];
    const PERIOD: f64 = 0.01;

    /// A bucket in the air, after a swing.
    fn in_the_air() -> Ground {
        let mut ground = Ground::new();
        for _ in 0..100 {
            ground.step([0.7, -1.7, -0.5], LENGTHS, (0.5, false), PERIOD);
        }
        ground
    }

    /// Moves from one posture to another at constant rates, within a time \[s\].
    fn move_to(ground: &mut Ground, from: [f64; 3], to: [f64; 3], time: f64) {
        sweep(ground, 0.0, (from, to), time);
    }

    /// The same while the machine swings at `velocity` [rad/s].
    fn sweep(ground: &mut Ground, velocity: f64, (from, to): ([f64; 3], [f64; 3]), time: f64) {
        let ticks = (time / PERIOD) as usize;
        for i in 0..=ticks {
            let share = i as f64 / ticks as f64;
            let posture = core::array::from_fn(|j| from[j] + share * (to[j] - from[j]));
            ground.step(posture, LENGTHS, (velocity, velocity == 0.0), PERIOD);
        }
    }

    #[test]
    fn a_bucket_that_sweeps_slowly_in_the_ground_still_digs() {
        let pulls = ([0.7, -1.7, -0.5], [0.7, -2.0, -0.5]);
        let digs = |velocity: f64| {
            let mut ground = in_the_air();
            move_to(&mut ground, pulls.0, pulls.1, 1.0);
            sweep(&mut ground, velocity, (pulls.1, pulls.1), 1.0);
            ground.digs()
        };
        assert!(digs(0.2) && !digs(0.3));
    }

    #[test]
    fn an_arm_that_pulls_in_a_sweep_is_another_than_one_that_has_pulled_before() {
        let after = |[first, second]: [f64; 2], velocity: f64| {
            let mut ground = in_the_air();
            let at = |arm: f64| [0.7, -1.7 - arm, -0.5];
            move_to(&mut ground, at(0.0), at(first), 1.0);
            sweep(&mut ground, velocity, (at(first), at(first + second)), 1.0);
            ground
        };
        assert!(!after([0.3, 0.0], 0.2).is_pulled());
        assert!(!after([0.3, 0.2], 0.3).is_pulled(), "free");
        let mut ground = after([0.3, 0.2], 0.2);
        assert!(ground.is_pulled());
        ground.opens();
        assert!(!ground.is_pulled(), "what was dug has left");
        assert!(!after([0.3, -0.2], 0.2).is_pulled(), "it stretches");
    }

    #[test]
    fn noise_of_the_angles_does_not_take_a_bucket_to_the_ground() {
        let mut ground = in_the_air();
        let mut state = 1_u32;
        for _ in 0..6000 {
            // Uniform, standard deviation 0.2 deg.
            let posture = [0.7, -1.7, -0.5].map(|angle| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                angle + 0.0121 * (f64::from(state) / f64::from(u32::MAX) - 0.5)
            });
            ground.step(posture, LENGTHS, (0.0, true), PERIOD);
            assert!(!ground.may_touch());
        }
    }

    #[test]
    fn a_bucket_gets_to_the_ground_by_lowering_and_off_it_by_lifting() {
        let mut ground = in_the_air();
        let (high, low) = ([0.7, -1.7, -0.5], [0.6, -1.7, -0.5]);
        move_to(&mut ground, high, low, 8.0);
        assert!(ground.may_touch() && !ground.digs(), "however slowly");
        move_to(&mut ground, low, high, 1.0);
        assert!(!ground.may_touch());
    }

    #[test]
    fn an_arm_that_is_pulled_in_digs_and_one_that_lifts_does_not() {
        let mut ground = in_the_air();
        move_to(&mut ground, [0.7, -1.7, -0.5], [0.7, -2.0, -0.5], 1.0);
        assert!(ground.digs());
        let mut ground = in_the_air();
        move_to(&mut ground, [0.7, -1.7, -0.5], [1.0, -1.8, -0.5], 1.0);
        assert!(!ground.may_touch());
        move_to(&mut ground, [1.0, -1.8, -0.5], [1.0, -1.8, -0.8], 1.0);
        assert!(ground.digs(), "a bucket that closes");
    }
}
