//! The described arm, bucket, cylinder and empty machine, each number with its doubt, and what follows by geometry.

use super::super::RATED_SHARE;
use super::super::keys::{LiftArm, LiftCylinder, Machine, Prior, Sensors};
use super::super::layout::Each;
use super::super::wheel_dynamics::GRAVITY;
use super::turn::Turn;
use crate::math::{sin_cos, sqrt};

/// Numbers of the drawing, in this order.
pub(super) const LENGTH: usize = 0;
pub(super) const MASS: usize = 1;
pub(super) const MASS_DISTANCE: usize = 2;
pub(super) const BUCKET: usize = 3;
pub(super) const LOAD_DISTANCE: usize = 4;
pub(super) const HEAD_AREA: usize = 5;
pub(super) const ROD_AREA: usize = 6;
pub(super) const BASE: usize = 7;
pub(super) const EYE: usize = 8;
pub(super) const CYLINDER_ANGLE: usize = 9;
pub(super) const PIVOT_X: usize = 10;
pub(super) const PIVOT_Z: usize = 11;
pub(super) const EMPTY_MASS: usize = 12;
pub(super) const EMPTY_RATIO: usize = 13;
pub(super) const EMPTY_HEIGHT: usize = 14;
pub(super) const FRICTION: usize = 15;
pub(super) const HEAD_ZERO: usize = 16;
pub(super) const ROD_ZERO: usize = 17;
pub(super) const LIFT_ZERO: usize = 18;
pub(super) const TILT_ZERO: usize = 19;
/// What the bucket weighs beyond the one that the empty machine was weighed with.
pub(super) const EXCHANGED: usize = 20;
/// Numbers of a calibration: relative error of the moment, and force that the pressures show too much.
pub(super) const SPAN: usize = 21;
pub(super) const OFFSET: usize = 22;
/// How many there are.
pub(super) const NUMBERS: usize = 23;
/// What a calibration leaves as the drawing has it: the load may lie elsewhere, angles and friction change with the posture.
const LEFT: [usize; 6] = [
    LOAD_DISTANCE,
    CYLINDER_ANGLE,
    FRICTION,
    LIFT_ZERO,
    TILT_ZERO,
    EXCHANGED,
];

/// The pressure at which a cylinder's largest force, and so its friction, is stated [Pa].
pub(super) const FULL_PRESSURE: f64 = 20e6;
/// Pressure on the rod side where nobody measures it [Pa], and its standard deviation.
pub(super) const USUAL_ROD_PRESSURE: f64 = 0.6e6;
/// Angle of the bucket where nobody measures it: level, and anything between dumped and curled.
const UNKNOWN_BUCKET: f64 = 0.4;
/// A bucket is changed in minutes: one machine in nine carries one that is 25 % heavier or lighter than the stated. Share of its mass.
const OTHER_BUCKET: f64 = 0.08;
/// Least lever of the load, as a share of the arm's length: an arm that stands upright weighs nothing.
const LEAST_LEVER: f64 = 0.2;
/// The ground can carry the bucket while its pin is below this share of the arm's length.
const LOW: f64 = 0.4;

/// The described numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Drawing {
    pub values: [f64; NUMBERS],
    /// Their standard deviations.
    pub std: [f64; NUMBERS],
    /// The same as far as the payload depends on them: a calibration knows moments better than their parts.
    weighing: [f64; NUMBERS],
    /// How many of them are in doubt.
    pub doubted: usize,
    /// Correlation of the errors of span and offset.
    pub correlation: f64,
    /// Moments that the drawing misses, with cosine and sine of the angles of arm and bucket [N m].
    missed: [f64; 4],
    count: f64,
    wheelbase: f64,
    /// Arm, and bucket to the horizontal, as the empty machine is stated.
    reference: [Turn; 2],
    /// The cylinder's angle.
    cylinder: Turn,
    /// What the bucket may carry [kg].
    pub capacity: f64,
    pub pressure_std: f64,
}

/// Arm, bucket and what is measured in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Posture {
    /// The arm to the horizontal.
    pub arm: Turn,
    /// The bucket, pin to load, to the horizontal.
    pub bucket: Turn,
    /// Pressures [Pa].
    pub head: f64,
    pub rod: f64,
    /// g cos(slope), and the specific force along the body [m/s^2].
    pub gravity: f64,
    pub acceleration: f64,
    /// Friction as a share of its size, positive while the rod goes out.
    pub seals: f64,
    /// Friction beside it, as a share of the full force.
    pub rest: f64,
}

/// Places of the masses from the pivot [m].
struct Places {
    arm: [f64; 2],
    load: [f64; 2],
}

/// The machine with its arm where it is, before a payload is added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Empty {
    mass: f64,
    /// First moments over the wheelbase, and above the ground [kg], [kg m].
    front: f64,
    up: f64,
    /// What a kilogram of load adds to them [-], [m].
    ahead: f64,
    height: f64,
}

impl Empty {
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
    /// None where the arm or its cylinder is not described.
    pub fn of(
        arm: &LiftArm,
        cylinder: &LiftCylinder,
        machine: &Machine,
        sensors: &Sensors,
        prior: &Prior,
    ) -> Option<Self> {
        let described = [
            arm.length,
            cylinder.head_area,
            cylinder.base_distance,
            cylinder.rod_distance,
        ];
        if described.iter().any(|x| *x <= 0.0) {
            return None;
        }
        let or = |stated: f64, usual: f64| if stated > 0.0 { stated } else { usual };
        let empty_mass = or(arm.empty_mass, machine.mass);
        let by = |value: f64, std: f64, share: f64| (value, or(std, share * value.abs()));
        let both = [
            by(arm.length, arm.length_std, 0.01),
            by(arm.mass, arm.mass_std, 0.05),
            by(arm.mass_distance, arm.mass_distance_std, 0.05),
            by(arm.bucket_mass, arm.bucket_mass_std, 0.2),
            by(arm.payload_distance, arm.payload_distance_std, 0.1),
            by(cylinder.head_area, cylinder.head_area_std, 0.01),
            by(cylinder.rod_area, cylinder.rod_area_std, 0.01),
            by(cylinder.base_distance, cylinder.base_distance_std, 0.01),
            by(cylinder.rod_distance, cylinder.rod_distance_std, 0.01),
            (cylinder.angle, cylinder.angle_std),
            (arm.pivot_x, or(arm.pivot_x_std, 0.01 * arm.length)),
            (arm.pivot_z, or(arm.pivot_z_std, 0.01 * arm.length)),
            by(empty_mass, arm.empty_mass_std, 0.02),
            (
                or(arm.empty_ratio, prior.cg_ratio),
                or(arm.empty_ratio_std, prior.cg_ratio_std),
            ),
            (
                or(arm.empty_height, prior.cg_height),
                or(arm.empty_height_std, prior.cg_height_std),
            ),
            by(cylinder.friction, cylinder.friction_std, 0.5),
            (0.0, sensors.pressure_offset_std),
            (0.0, sensors.pressure_offset_std),
            (0.0, sensors.angle_offset_std),
            (0.0, sensors.angle_offset_std),
            (0.0, OTHER_BUCKET * arm.bucket_mass),
            (0.0, cylinder.span_std),
            (cylinder.force_offset, cylinder.force_offset_std),
        ];
        let std = both.map(|(_, std)| std);
        let (span, offset) = (cylinder.span_std > 0.0, cylinder.force_offset_std > 0.0);
        let values = both.map(|(value, _)| value);
        Some(Self {
            capacity: capacity(cylinder.count, &values),
            values,
            std,
            weighing: weighing(std, span, offset),
            doubted: if span || offset { NUMBERS } else { SPAN },
            correlation: cylinder.span_offset_correlation,
            missed: [arm.arm_cos, arm.arm_sin, arm.bucket_cos, arm.bucket_sin],
            count: cylinder.count,
            wheelbase: machine.wheelbase,
            reference: [
                Turn::of(arm.reference_angle),
                Turn::of(arm.reference_angle + arm.reference_tilt),
            ],
            cylinder: Turn::of(cylinder.angle),
            pressure_std: sensors.pressure_std,
        })
    }

    /// The numbers with one of them off by its deviation: as the centre of gravity depends on it, and as the payload does.
    pub fn off(&self, number: usize) -> [[f64; NUMBERS]; 2] {
        [&self.std, &self.weighing].map(|std| {
            let mut values = self.values;
            let (beside, along) = (1.0 - self.correlation * self.correlation, self.correlation);
            match number {
                SPAN => values[OFFSET] += along * std[OFFSET],
                OFFSET => values[OFFSET] -= (1.0 - sqrt(beside.max(0.0))) * std[OFFSET],
                _ => {}
            }
            values[number] += std[number];
            values
        })
    }

    /// Ratio and height of the empty machine, with standard deviations.
    pub fn empty(&self) -> Each<(f64, f64)> {
        let of = |i: usize| (self.values[i], self.std[i]);
        Each {
            ratio: of(EMPTY_RATIO),
            height: of(EMPTY_HEIGHT),
        }
    }

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
        let length = sqrt(square.max(1e-6));
        (length, base * eye * sine / length)
    }

    fn places(v: &[f64; NUMBERS], arm: Turn, bucket: Turn) -> Places {
        Places {
            arm: [v[MASS_DISTANCE] * arm.cosine, v[MASS_DISTANCE] * arm.sine],
            load: [
                v[LENGTH] * arm.cosine + v[LOAD_DISTANCE] * bucket.cosine,
                v[LENGTH] * arm.sine + v[LOAD_DISTANCE] * bucket.sine,
            ],
        }
    }

    /// Where the masses are, the sensors' zeros being off.
    fn places_now(v: &[f64; NUMBERS], posture: &Posture) -> Places {
        let arm = posture.arm.by(v[LIFT_ZERO]);
        let bucket = posture.bucket.by(v[LIFT_ZERO] + v[TILT_ZERO]);
        Self::places(v, arm, bucket)
    }

    /// Moment of the empty arm and bucket, and that of a kilogram of load [N m], [N m/kg].
    pub fn moments(&self, v: &[f64; NUMBERS], posture: &Posture) -> (f64, f64) {
        let places = Self::places_now(v, posture);
        let of = |[x, z]: [f64; 2]| x * posture.gravity - z * posture.acceleration;
        let per_load = of(places.load).max(LEAST_LEVER * v[LENGTH] * GRAVITY);
        let missed: f64 = self
            .missed
            .iter()
            .zip(turns(posture))
            .map(|(m, turn)| m * turn)
            .sum();
        (
            v[MASS] * of(places.arm) + (v[BUCKET] + v[EXCHANGED]) * of(places.load) + missed,
            per_load,
        )
    }

    /// Moment of the cylinders less their friction [N m].
    pub fn lifting(&self, v: &[f64; NUMBERS], posture: &Posture) -> f64 {
        let (_, lever) = self.cylinder(v, posture.arm);
        let head = v[HEAD_AREA] * (posture.head - v[HEAD_ZERO]);
        let rod = v[ROD_AREA] * (posture.rod - v[ROD_ZERO]);
        let friction = (posture.seals * v[FRICTION] + posture.rest) * self.full_force(v);
        lever * (self.count * (head - rod) - v[OFFSET] - friction) / (1.0 + v[SPAN])
    }

    /// The payload that the pressures of this row show [kg].
    pub fn payload(&self, v: &[f64; NUMBERS], posture: &Posture) -> f64 {
        let (empty, per_load) = self.moments(v, posture);
        (self.lifting(v, posture) - empty) / per_load
    }

    /// The machine with its arm in this posture.
    pub fn empty_at(&self, v: &[f64; NUMBERS], posture: &Posture) -> Empty {
        let now = Self::places_now(v, posture);
        // The reference is where the arm truly stood.
        let then = Self::places(v, self.reference[0], self.reference[1]);
        let moved = |axis: usize| {
            v[MASS] * (now.arm[axis] - then.arm[axis])
                + v[BUCKET] * (now.load[axis] - then.load[axis])
        };
        let ahead = (self.wheelbase + v[PIVOT_X] + now.load[0]) / self.wheelbase;
        let height = v[PIVOT_Z] + now.load[1];
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

/// The deviations that are left for the payload where the moment's span or offset was calibrated.
fn weighing(std: [f64; NUMBERS], span: bool, offset: bool) -> [f64; NUMBERS] {
    let mut left = std;
    for (number, std) in left[..SPAN].iter_mut().enumerate() {
        let calibrated = match number {
            HEAD_ZERO | ROD_ZERO => offset,
            _ => span && !LEFT.contains(&number),
        };
        if calibrated {
            *std = 0.0;
        }
    }
    left
}

/// Force of the cylinders at full pressure [N].
fn full_force(count: f64, v: &[f64; NUMBERS]) -> f64 {
    count * v[HEAD_AREA] * FULL_PRESSURE
}

/// The payload whose weight the cylinders hold with a level arm at full pressure, at most the rated one [kg].
fn capacity(count: f64, v: &[f64; NUMBERS]) -> f64 {
    let (base, eye) = (v[BASE], v[EYE]);
    let lever = base * eye / sqrt(base * base + eye * eye);
    let held = full_force(count, v) * lever / ((v[LENGTH] + v[LOAD_DISTANCE]) * GRAVITY);
    held.min(RATED_SHARE * v[EMPTY_MASS])
}
