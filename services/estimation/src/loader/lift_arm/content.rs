//! When the bucket's content may change: while the bucket turns against the ground, which fills or empties it, or the ground takes hold.
//!
//! Carrying and lifting level leave the bucket's angle as it is. A bucket that turns low is in the heap: the ground carries
//! a part of it, and pushes. Whatever carries a bucket that does not turn comes as a jump of the moment (`scale`). A bucket that
//! the ground has had is free when the arm has lifted it or the machine has driven away: until then it may be pushed on, and what
//! it holds grows without any sign. While the wheels push against something (`drive`) nobody drives away: who grades or strips does
//! that for minutes, and the ground carries what it likes.
//!
//! A cylinder that carries less than a quarter of the empty arm and bucket weighs nothing: the arm floats, lies on its bucket, or the
//! sensor reads nothing.

/// Rate of the bucket beyond which it turns [rad/s].
const TURNS: f64 = 0.12;
/// Rate of the bucket beyond which it turns slowly [rad/s]: five standard deviations of an angle's noise of 2 mrad, smoothed.
const TURNS_SLOWLY: f64 = 0.02;
/// Rate of the arm beyond which it lifts or lowers [rad/s].
const LIFTS: f64 = 0.04;
/// How long the content settles after the bucket turned [s].
const SETTLES: f64 = 0.5;
/// How long the ground holds on after the bucket turned low [s], at least; so long where nobody tells the speed.
const HOLDS: f64 = 0.8;
/// How far the machine drives until a low bucket is free of the ground [m]. Chosen on 58 loaders: 1 m is .05 less trusted, and as
/// seldom wrong.
const FREE_AFTER: f64 = 0.3;
/// Who stands for three seconds without torque pushes no more: as if it drove away at this speed [m/s].
const CREEPS: f64 = 0.1;

/// Memory of arm and bucket.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Content {
    /// Time that is left [s].
    settling: f64,
    held: f64,
    /// Way that is left in the ground [m].
    way: f64,
}

impl Default for Content {
    /// At the start anything may hold the bucket.
    fn default() -> Self {
        Self {
            settling: SETTLES,
            held: HOLDS,
            way: 0.0,
        }
    }
}

/// What arm and bucket do in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    /// The bucket turns, the arm lifts or lowers.
    pub turning: bool,
    /// How fast the content may change, as a share of what it does while the bucket turns.
    pub changing: f64,
    pub lifting: bool,
    /// The content still moves.
    pub settling: bool,
    /// The ground may carry the bucket: its pressure says nothing.
    pub held: bool,
    /// The content is not known.
    pub open: bool,
}

impl Content {
    /// Takes the rates of arm and bucket [rad/s], and how fast the machine drives [m/s]; `low` where the ground is within reach, `pushes`
    /// where the wheels do.
    pub fn motion(
        &mut self,
        [lift, bucket]: [f64; 2],
        [low, pushes]: [bool; 2],
        speed: Option<f64>,
        dt: f64,
    ) -> Motion {
        let turning = bucket.abs() > TURNS;
        // What a bucket that turns slowly loses it loses by the angle; only the ground fills one that turns up.
        let slowly = bucket < -TURNS_SLOWLY || (low && bucket > TURNS_SLOWLY);
        let changing = if turning {
            1.0
        } else if slowly {
            bucket.abs() / TURNS
        } else {
            0.0
        };
        self.settling = (self.settling - dt).max(0.0);
        self.held = (self.held - dt).max(0.0);
        let speed = speed.map_or(FREE_AFTER / HOLDS, |v| v.abs().max(CREEPS));
        self.way = if low {
            (self.way - speed * dt).max(0.0)
        } else {
            0.0
        };
        if turning {
            self.settling = SETTLES;
        }
        if turning || pushes {
            self.touch();
        }
        let held = low && (self.held > 0.0 || self.way > 0.0);
        Motion {
            turning,
            changing,
            lifting: lift.abs() > LIFTS,
            settling: self.settling > 0.0,
            held,
            open: turning || held || self.settling > 0.0,
        }
    }

    /// The cylinders do not carry the arm: what does, nobody tells.
    pub fn put_down(&mut self, motion: &Motion) -> Motion {
        self.touch();
        Motion {
            held: true,
            open: true,
            ..*motion
        }
    }

    /// The moment jumped, the bucket turns or the wheels push: where it is low, the ground takes hold of it, or lets go.
    pub fn touch(&mut self) {
        (self.held, self.way) = (HOLDS, FREE_AFTER);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STILL: [f64; 2] = [0.0; 2];
    const LOW: [bool; 2] = [true, false];

    /// How long a bucket that the ground has taken hold of stays open [s]; low, pushed, and driven at this speed [m/s].
    fn open_for(acts: [bool; 2], speed: Option<f64>) -> f64 {
        let mut content = Content::default();
        let free = [acts[0], false];
        (0..200).for_each(|_| _ = content.motion(STILL, free, speed, 0.01));
        assert!(!content.motion(STILL, free, speed, 0.01).open);
        content.touch();
        let open = (0..1000).take_while(|_| content.motion(STILL, acts, speed, 0.01).open);
        0.01 * open.count() as f64
    }

    #[test]
    fn the_ground_holds_a_low_bucket_until_the_machine_has_driven_away() {
        assert!((open_for(LOW, Some(2.0)) - HOLDS).abs() < 0.02);
        assert!((open_for(LOW, Some(-0.2)) - FREE_AFTER / 0.2).abs() < 0.02);
        let stood = open_for(LOW, Some(0.0));
        assert!((stood - FREE_AFTER / CREEPS).abs() < 0.02, "{stood}");
        assert!(
            open_for([true; 2], Some(0.0)) > 9.9,
            "the wheels still push"
        );
        assert!(open_for([true; 2], Some(1.0)) > 9.9, "it grades");
        assert_eq!(
            open_for([false; 2], Some(0.0)),
            0.0,
            "nothing to hold on to"
        );
        let unknown = open_for(LOW, None);
        assert!((unknown - HOLDS).abs() < 0.02, "{unknown}");
    }

    #[test]
    fn an_arm_that_lifts_frees_its_bucket() {
        let mut content = Content::default();
        content.touch();
        assert!(content.motion([0.3, 0.0], LOW, Some(0.0), 0.01).held);
        assert!(!content.motion([0.3, 0.0], [false; 2], Some(0.0), 0.01).held);
        (0..200).for_each(|_| _ = content.motion(STILL, LOW, Some(0.0), 0.01));
        assert!(!content.motion(STILL, LOW, Some(0.0), 0.01).open);
    }
}
