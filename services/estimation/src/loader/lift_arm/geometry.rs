//! Moments about the arm's pivot, payload and centre of gravity of a drawing in a posture. The equations are those of the parent module.

use super::drawing::{Drawing, full_force};
use super::numbers::{
    BASE, BUCKET, CYLINDER_ANGLE, EMPTY_HEIGHT, EMPTY_MASS, EMPTY_RATIO, EXCHANGED, EYE, FRICTION,
    HEAD_AREA, HEAD_ZERO, LENGTH, LIFT_ZERO, LOAD_DISTANCE, MASS, MASS_DISTANCE, NUMBERS, OFFSET,
    PIVOT_X, PIVOT_Z, ROD_AREA, ROD_ZERO, SPAN, TILT_ZERO, TURN,
};
use super::turn::Turn;
use crate::GRAVITY;
use crate::loader::layout::Each;
use crate::math::{sin_cos, sqrt};

/// Assumed rod-side pressure where it is not measured [Pa].
pub(super) const USUAL_ROD_PRESSURE: f64 = 0.6e6;
/// Assumed angle from pin to load, to the horizontal, where it is not measured [rad]: the bucket's floor is level.
pub(super) const UNKNOWN_BUCKET: f64 = 0.4;
/// Least lever of the load, as a share of the arm's length: an upright arm does not weigh.
const LEAST_LEVER: f64 = 0.2;
/// Least length of a cylinder [m], against division by zero.
const LEAST_LENGTH: f64 = 1e-3;
/// Share of the moment of empty arm and bucket below which the cylinders do not carry the arm.
const CARRIED_AT_LEAST: f64 = 0.25;
/// Height of the bucket's pin below which the ground can carry the bucket, as a share of the arm's length.
const LOW: f64 = 0.4;

/// Posture and measurements of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Posture {
    /// Angle of the arm to the horizontal.
    pub arm: Turn,
    /// Angle of the bucket, pin to load, to the horizontal.
    pub bucket: Turn,
    /// Pressures of head and rod side [Pa].
    pub head: f64,
    pub rod: f64,
    /// g cos(slope), and the specific force along the body [m/s^2].
    pub gravity: f64,
    pub acceleration: f64,
    /// Friction as a share of its full size, positive while the rod extends.
    pub seals: f64,
    /// Residual friction, as a share of the full force.
    pub rest: f64,
}

/// Places of the masses from the pivot, forward and up [m].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Places {
    /// Centre of mass of the arm.
    arm: [f64; 2],
    /// The bucket's pin.
    pin: [f64; 2],
    /// The load from the bucket's pin.
    beyond: [f64; 2],
}

impl Places {
    /// Effective place of the load, its distance from the pin times the bucket turn; with `turn` 1 its true place.
    fn load(&self, turn: f64) -> [f64; 2] {
        core::array::from_fn(|axis| self.pin[axis] + turn * self.beyond[axis])
    }
}

/// Places of masses and cylinder in a posture, computed once a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stance {
    places: Places,
    /// Length of the cylinder, and its lever [m].
    pub rod_length: f64,
    lever: f64,
}

/// Moments about the pivot in a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    /// Lever of the cylinder [m].
    pub lever: f64,
    /// Moment of the empty arm and bucket [N m], and of a kilogram of load [N m/kg].
    pub empty: f64,
    pub per_load: f64,
    /// Moment of the cylinders by their pressures, less friction [N m].
    pub lifting: f64,
}

impl Shown {
    /// Payload by this row alone [kg].
    pub fn payload(&self) -> f64 {
        (self.lifting - self.empty) / self.per_load
    }
}

/// The machine with its arm where it is, before a payload is added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Empty {
    /// Mass [kg].
    mass: f64,
    /// First moments: from the rear axle over the wheelbase [kg], and above the ground [kg m].
    front: f64,
    up: f64,
    /// The same per kilogram of load [-], [m].
    ahead: f64,
    height: f64,
}

impl Empty {
    /// Payload at which the rear axle carries no load, lam = 1 [kg].
    pub fn most(&self) -> f64 {
        (self.mass - self.front) / (self.ahead - 1.0)
    }

    /// Ratio and height of the centre of gravity with this payload.
    pub fn with(&self, payload: f64) -> Each<f64> {
        let mass = self.mass + payload;
        Each {
            ratio: (self.front + payload * self.ahead) / mass,
            height: (self.up + payload * self.height) / mass,
        }
    }
}

/// Cosine and sine of the angles of arm and bucket to the horizontal.
pub(super) fn turns(posture: &Posture) -> [f64; 4] {
    let (arm, bucket) = (posture.arm, posture.bucket);
    [arm.cosine, arm.sine, bucket.cosine, bucket.sine]
}

impl Drawing {
    /// g cos(slope) [m/s^2].
    pub fn gravity(&self, slope: f64) -> f64 {
        GRAVITY * sin_cos(slope).1
    }

    /// Angle of the bucket from the horizontal [rad].
    pub fn bucket_angle(&self, lift: f64, tilt: Option<f64>) -> f64 {
        tilt.map_or(UNKNOWN_BUCKET, |tilt| lift + tilt)
    }

    /// The ground may carry the bucket.
    pub fn is_low(&self, arm: Turn) -> bool {
        self.values[PIVOT_Z] + self.values[LENGTH] * arm.sine < LOW * self.values[LENGTH]
    }

    /// Force of the cylinders at full pressure [N].
    pub fn full_force(&self, v: &[f64; NUMBERS]) -> f64 {
        full_force(self.count, v)
    }

    /// Standard deviation of the cylinders' force by the noise of the pressures [N].
    pub fn force_std(&self) -> f64 {
        let (head, rod) = (self.values[HEAD_AREA], self.values[ROD_AREA]);
        self.count * self.pressure_std * sqrt(head * head + rod * rod)
    }

    /// Length of the cylinder [m].
    pub fn rod_length(&self, arm: Turn) -> f64 {
        self.cylinder(&self.values, arm).0
    }

    /// Lever of the cylinder [m].
    pub fn lever(&self, arm: Turn) -> f64 {
        self.cylinder(&self.values, arm).1
    }

    /// Length of the cylinder and its lever [m].
    fn cylinder(&self, v: &[f64; NUMBERS], arm: Turn) -> (f64, f64) {
        let off = v[LIFT_ZERO] + v[CYLINDER_ANGLE] - self.values[CYLINDER_ANGLE];
        let Turn { sine, cosine } = arm.and(self.cylinder).by(off);
        let (base, eye) = (v[BASE], v[EYE]);
        let square = base * base + eye * eye - 2.0 * base * eye * cosine;
        let length = sqrt(square.max(LEAST_LENGTH * LEAST_LENGTH));
        (length, base * eye * sine / length)
    }

    fn places(v: &[f64; NUMBERS], arm: Turn, bucket: Turn) -> Places {
        Places {
            arm: [v[MASS_DISTANCE] * arm.cosine, v[MASS_DISTANCE] * arm.sine],
            pin: [v[LENGTH] * arm.cosine, v[LENGTH] * arm.sine],
            beyond: [
                v[LOAD_DISTANCE] * bucket.cosine,
                v[LOAD_DISTANCE] * bucket.sine,
            ],
        }
    }

    /// Stance in this posture, with the zeros of the angles in `v`.
    pub fn stance(&self, v: &[f64; NUMBERS], posture: &Posture) -> Stance {
        let (rod_length, lever) = self.cylinder(v, posture.arm);
        let arm = posture.arm.by(v[LIFT_ZERO]);
        let bucket = posture.bucket.by(v[LIFT_ZERO] + v[TILT_ZERO]);
        Stance {
            places: Self::places(v, arm, bucket),
            rod_length,
            lever,
        }
    }

    /// The moments of a row.
    pub fn shown(&self, v: &[f64; NUMBERS], stance: &Stance, posture: &Posture) -> Shown {
        let of = |[x, z]: [f64; 2]| x * posture.gravity - z * posture.acceleration;
        let carried = of(stance.places.load(v[TURN]));
        let per_load = carried.max(LEAST_LEVER * v[LENGTH] * GRAVITY);
        let missed: f64 = self
            .missed
            .iter()
            .zip(turns(posture))
            .map(|(m, turn)| m * turn)
            .sum();
        Shown {
            lever: stance.lever,
            empty: v[MASS] * of(stance.places.arm) + (v[BUCKET] + v[EXCHANGED]) * carried + missed,
            per_load,
            lifting: self.lifted(v, stance.lever, posture),
        }
    }

    /// Moment of the cylinders with this lever, less their friction [N m].
    pub fn lifted(&self, v: &[f64; NUMBERS], lever: f64, posture: &Posture) -> f64 {
        let friction = (posture.seals * v[FRICTION] + posture.rest) * self.full_force(v);
        lever * (self.force(v, posture) - friction) / (1.0 + v[SPAN])
    }

    /// The same with their friction [N m].
    pub fn pressed(&self, v: &[f64; NUMBERS], lever: f64, posture: &Posture) -> f64 {
        lever * self.force(v, posture) / (1.0 + v[SPAN])
    }

    /// Force of the cylinders by their pressures [N].
    fn force(&self, v: &[f64; NUMBERS], posture: &Posture) -> f64 {
        let head = v[HEAD_AREA] * (posture.head - v[HEAD_ZERO]);
        let rod = v[ROD_AREA] * (posture.rod - v[ROD_ZERO]);
        self.count * (head - rod) - v[OFFSET]
    }

    /// Moments of the empty arm and bucket [N m], and of a kilogram of load [N m/kg].
    pub fn moments(&self, v: &[f64; NUMBERS], posture: &Posture) -> (f64, f64) {
        let shown = self.shown(v, &self.stance(v, posture), posture);
        (shown.empty, shown.per_load)
    }

    /// Moment of the cylinders less their friction [N m].
    pub fn lifting(&self, v: &[f64; NUMBERS], posture: &Posture) -> f64 {
        self.lifted(v, self.cylinder(v, posture.arm).1, posture)
    }

    /// The cylinders carry the arm: their moment exceeds a part of the described one that no error of the drawing explains.
    pub fn carries_itself(&self, shown: &Shown) -> bool {
        let v = &self.values;
        // The moment with all mass at the end of the arm is an upper bound of any posture.
        let most = (v[MASS] + v[BUCKET]) * (v[LENGTH] + v[LOAD_DISTANCE]) * GRAVITY;
        shown.lifting > CARRIED_AT_LEAST * most.min(shown.empty)
    }

    /// Place of the load in a posture: ahead of the front axle, and above the ground [m].
    pub fn load_place(&self, v: &[f64; NUMBERS], posture: &Posture) -> [f64; 2] {
        let load = self.stance(v, posture).places.load(1.0);
        [v[PIVOT_X] + load[0], v[PIVOT_Z] + load[1]]
    }

    /// The machine with its arm in this stance.
    pub fn empty_at(&self, v: &[f64; NUMBERS], stance: &Stance) -> Empty {
        let now = &stance.places;
        // The reference angles are true ones, without the sensors' zeros.
        let then = Self::places(v, self.reference[0], self.reference[1]);
        let (load, stated) = (now.load(1.0), then.load(1.0));
        let moved = |axis: usize| {
            v[MASS] * (now.arm[axis] - then.arm[axis]) + v[BUCKET] * (load[axis] - stated[axis])
        };
        let ahead = (self.wheelbase + v[PIVOT_X] + load[0]) / self.wheelbase;
        let height = v[PIVOT_Z] + load[1];
        Empty {
            mass: v[EMPTY_MASS] + v[EXCHANGED],
            front: v[EMPTY_MASS] * v[EMPTY_RATIO]
                + moved(0) / self.wheelbase
                + v[EXCHANGED] * ahead,
            up: v[EMPTY_MASS] * v[EMPTY_HEIGHT] + moved(1) + v[EXCHANGED] * height,
            ahead,
            height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::numbers::Moves;
    use super::super::tests::settings;
    use super::*;

    #[test]
    fn a_number_moves_what_its_flags_state() {
        let drawing = Drawing::of(&settings()).expect("a described arm");
        let posture = Posture {
            arm: Turn::of(0.3),
            bucket: Turn::of(0.5),
            head: 9e6,
            rod: 1e6,
            gravity: 9.7,
            acceleration: 0.8,
            seals: 0.6,
            rest: 0.01,
        };
        let all = |v: &[f64; NUMBERS]| {
            let stance = drawing.stance(v, &posture);
            let payload = drawing.shown(v, &stance, &posture).payload();
            (stance, payload, drawing.empty_at(v, &stance))
        };
        let before = all(&drawing.values);
        for number in 0..NUMBERS {
            let mut values = drawing.values;
            values[number] += 0.01;
            let after = all(&values);
            let Moves {
                stance,
                moment,
                centre,
            } = Moves::of(number);
            assert_eq!(stance, before.0 != after.0, "{number}");
            assert_eq!(moment, before.1 != after.1, "{number}");
            assert_eq!(centre, before.2 != after.2, "{number}");
        }
    }
}
