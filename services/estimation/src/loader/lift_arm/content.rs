//! Detects when the bucket's content may change: while its angle to the horizontal changes, and while the ground may carry a part of it.
//!
//! Carrying and level lifting leave the bucket's angle unchanged. A bucket that turns low is in the heap: the ground carries a part of it,
//! and pushes. Contact of a bucket that does not turn shows as a jump of the moment (`scale`). After contact the bucket is free once
//! the arm has lifted it or the machine has driven away. Until then it may be pushed on, and its content grows without any sign. While
//! the wheels push (`drive`) the machine does not drive away: grading and stripping take minutes, and the ground carries any part.
//!
//! Cylinders that carry less than a quarter of the empty arm and bucket weigh nothing: the arm floats, lies on its bucket, or the sensor
//! reads zero.

/// Rate of the bucket beyond which it turns [rad/s].
const TURNS: f64 = 0.12;
/// Rate of the bucket beyond which it turns slowly [rad/s]: five standard deviations of an angle's noise of 2 mrad, smoothed.
const TURNS_SLOWLY: f64 = 0.02;
/// Rate of the arm beyond which it lifts or lowers [rad/s].
const LIFTS: f64 = 0.04;
/// Time for which the content settles after the bucket has turned [s].
const SETTLES: f64 = 0.5;
/// Least time for which the ground may carry the bucket after contact [s]; the whole time where the speed is not measured.
const HOLDS: f64 = 0.8;
/// Distance after which a low bucket is free of the ground [m]. Chosen on 58 loaders: with 1 m the trusted share is .05 less, and errors
/// are as rare.
const FREE_AFTER: f64 = 0.3;
/// Least speed in that distance [m/s]: a machine that stands for three seconds without pushing is free too.
const CREEPS: f64 = 0.1;

/// State of the contact with the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Content {
    /// Time until the content has settled, and least time until the ground is free [s].
    settling: f64,
    held: f64,
    /// Distance that is left until the bucket is free of the ground [m].
    way: f64,
}

impl Default for Content {
    /// At the start the ground may carry the bucket.
    fn default() -> Self {
        Self {
            settling: SETTLES,
            held: HOLDS,
            way: 0.0,
        }
    }
}

/// Motion of arm and bucket in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    /// The bucket turns.
    pub turning: bool,
    /// Rate of change of the content, as a share of that of a turning bucket.
    pub changing: f64,
    /// The arm lifts or lowers.
    pub lifting: bool,
    /// The content still moves after a turn.
    pub settling: bool,
    /// The ground may carry the bucket: pressures carry no information about the content.
    pub held: bool,
    /// The content is not known.
    pub open: bool,
}

impl Content {
    /// Updates with the rates of arm and bucket [rad/s] and the speed of the machine [m/s]. `turn`: of the bucket per turn of the arm;
    /// `low`: the ground is within reach; `pushes`: the wheels push.
    pub fn motion(
        &mut self,
        [lift, bucket]: [f64; 2],
        turn: f64,
        [low, pushes]: [bool; 2],
        speed: Option<f64>,
        dt: f64,
    ) -> Motion {
        // An arm that carries the tilt cylinder turns its bucket up as it lifts. That empties no bucket, and fills none in the air.
        let by_tilt = bucket - turn * lift;
        let turning = bucket.abs() > TURNS && (low || bucket < 0.0 || by_tilt > TURNS);
        // A bucket that turns down slowly loses content in proportion to its angle; one that turns up is filled only by the ground.
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

    /// The cylinders do not carry the arm: the ground or something else does.
    pub fn put_down(&mut self, motion: &Motion) -> Motion {
        self.touch();
        Motion {
            held: true,
            open: true,
            ..*motion
        }
    }

    /// Restarts the contact: the moment has jumped, the bucket turns or the wheels push. It acts where the bucket is low.
    pub fn touch(&mut self) {
        (self.held, self.way) = (HOLDS, FREE_AFTER);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STILL: [f64; 2] = [0.0; 2];
    const LOW: [bool; 2] = [true, false];

    /// Time for which a bucket stays open after contact [s]; `acts`: it is low, the wheels push; driven at this speed [m/s].
    fn open_for(acts: [bool; 2], speed: Option<f64>) -> f64 {
        let mut content = Content::default();
        let free = [acts[0], false];
        (0..200).for_each(|_| _ = content.motion(STILL, 0.0, free, speed, 0.01));
        assert!(!content.motion(STILL, 0.0, free, speed, 0.01).open);
        content.touch();
        let open = (0..1000).take_while(|_| content.motion(STILL, 0.0, acts, speed, 0.01).open);
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
        assert!(content.motion([0.3, 0.0], 0.0, LOW, Some(0.0), 0.01).held);
        assert!(
            !content
                .motion([0.3, 0.0], 0.0, [false; 2], Some(0.0), 0.01)
                .held
        );
        (0..200).for_each(|_| _ = content.motion(STILL, 0.0, LOW, Some(0.0), 0.01));
        assert!(!content.motion(STILL, 0.0, LOW, Some(0.0), 0.01).open);
    }

    #[test]
    fn a_bucket_that_the_lifting_arm_turns_up_keeps_its_content_and_one_that_the_tilt_cylinder_turns_may_not()
     {
        let open = |[lift, bucket]: [f64; 2], turn: f64, low: bool| {
            let mut content = Content::default();
            (0..200).for_each(|_| _ = content.motion(STILL, turn, [low, false], Some(2.0), 0.01));
            content
                .motion([lift, bucket], turn, [low, false], Some(2.0), 0.01)
                .open
        };
        assert!(!open([0.3, 0.3], 1.0, false));
        assert!(open([0.3, 0.3], 1.0, true), "in the ground");
        assert!(open([-0.3, -0.3], 1.0, false), "it may spill");
        assert!(open([0.0, 0.3], 1.0, false));
        assert!(
            open([0.3, 0.3], 0.0, false),
            "held by a linkage, it would not turn"
        );
    }
}
