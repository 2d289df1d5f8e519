//! Numbers of the lift arm and of the machine from the machine file, each with its standard deviation.

use super::linkage::{FRAME, Linkage};
use super::numbers::{
    BASE, CYLINDER_ANGLE, EMPTY_HEIGHT, EMPTY_MASS, EMPTY_RATIO, EXCHANGED, EYE, FRICTION,
    HEAD_AREA, HEAD_ZERO, LENGTH, LIFT_ZERO, LOAD_DISTANCE, NUMBERS, OFFSET, ROD_ZERO, SPAN,
    TILT_ZERO,
};
use super::turn::Turn;
use crate::GRAVITY;
use crate::loader::RATED_SHARE;
use crate::loader::keys::{Description, LiftArm, LiftCylinder};
use crate::loader::layout::Each;
use crate::loader::settings::Settings;
use crate::math::{norm, sqrt};
use crate::{FULL_PRESSURE, Quantity};

/// Numbers whose deviation a calibration does not reduce: the load may lie elsewhere, angles and friction change with the posture.
const STILL_DRAWN: [usize; 6] = [
    LOAD_DISTANCE,
    CYLINDER_ANGLE,
    FRICTION,
    LIFT_ZERO,
    TILT_ZERO,
    EXCHANGED,
];

/// Standard deviation of an unmeasured rod-side pressure [Pa]: valves hold up to 3 MPa there.
const UNMEASURED_ROD: f64 = 0.8e6;
/// Standard deviation of the mass of an exchanged bucket, as a share: buckets are exchanged in minutes, and one machine in nine carries
/// one that is 25 % heavier or lighter than the stated.
const OTHER_BUCKET: f64 = 0.08;

/// Relative standard deviations where none is stated: of lengths and areas, of the arm's mass and its centre, of the bucket's mass, of the
/// load's place in it, of a weighed machine, of the friction of seals.
const DRAWN: f64 = 0.01;
const ARM: f64 = 0.05;
const BUCKET_MASS: f64 = 0.2;
const LOAD_PLACE: f64 = 0.1;
const WEIGHED: f64 = 0.02;
const SEALS: f64 = 0.5;
/// Defaults of numbers that are not stated, with relative standard deviations: masses of arm and bucket as shares of the machine's, the
/// arm's centre of mass and the load's place as shares of the arm's length. The drawings at hand (a 4.7 t and a 12 t machine; data sheets
/// of buckets of 5 to 25 t) have .055 and .070, .046 to .09, .53 and .55, .22 and .25.
const USUAL_ARM: (f64, f64) = (0.06, 0.25);
const USUAL_BUCKET: (f64, f64) = (0.065, 0.4);
const USUAL_CENTRE: (f64, f64) = (0.54, 0.1);
const USUAL_PLACE: (f64, f64) = (0.23, 0.2);
/// Difference of the gain's error between the pressure of an empty bucket (a fifth of a full one's) and that of a load, over the stated
/// error: errors of transmitters are stated for their range, and grow within it.
const LINEARITY: f64 = 2.0;
/// Standard deviation of a stated bucket turn where none is stated: it differs from posture to posture.
const LINKAGE: f64 = 0.05;

/// The numbers of the drawing, indexed as in `numbers`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Drawing {
    /// Values.
    pub values: [f64; NUMBERS],
    /// The values with one of them moved by its standard deviation ([`Drawing::put_off`]), and its index.
    pub moved: [f64; NUMBERS],
    is_off: usize,
    /// Their standard deviations.
    pub std: [f64; NUMBERS],
    /// Their standard deviations in the payload: 0 for those that a calibration of the moment has taken in.
    weighing: [f64; NUMBERS],
    /// Number of those whose effects are computed (`doubt`): those below this index.
    pub doubted: usize,
    /// The bucket turn is not stated, and estimated (`linkage`).
    pub learns_turn: bool,
    /// Correlation of the errors of span and offset.
    pub correlation: f64,
    /// Moments missing in the drawing, by a calibration: factors of cosine and sine of the angles of arm and bucket [N m].
    pub missed: [f64; 4],
    /// Number of lift cylinders.
    pub count: f64,
    /// Wheelbase [m].
    pub wheelbase: f64,
    /// Angles of arm and bucket to the horizontal for which the empty machine is stated.
    pub reference: [Turn; 2],
    /// Stated angle between the cylinder's base and eye, seen from the pivot, with a level arm.
    pub cylinder: Turn,
    /// Capacity of the bucket [kg].
    pub capacity: f64,
    /// Standard deviations of a pressure's noise and of its zero [Pa].
    pub pressure_std: f64,
    pressure_zero_std: f64,
    /// Standard deviation of the gain between the pressure of an empty bucket and that of a load; 0 where a calibration has taken it in.
    pub gain_left_std: f64,
}

impl Drawing {
    /// Returns none where the arm or its cylinder is not described.
    pub fn of(settings: &Settings) -> Option<Self> {
        let (arm, cylinder) = (&settings.lift_arm, &settings.lift_cylinder);
        let needed = [
            arm.length,
            cylinder.head_area,
            cylinder.base_distance,
            cylinder.rod_distance,
        ];
        if needed.iter().any(|x| *x <= 0.0) {
            return None;
        }
        let both = described(settings);
        let std = both.map(|(_, std)| std);
        let (span, offset) = (cylinder.span_std > 0.0, cylinder.force_offset_std > 0.0);
        let values = both.map(|(value, _)| value);
        Some(Self {
            capacity: capacity(cylinder.count, &values),
            values,
            moved: values,
            is_off: 0,
            std,
            weighing: weighing(std, span, offset),
            learns_turn: leaves_turn_open(arm, cylinder),
            doubted: if offset {
                NUMBERS
            } else if std[SPAN] > 0.0 {
                OFFSET
            } else {
                SPAN
            },
            correlation: cylinder.span_offset_correlation,
            missed: [arm.arm_cos, arm.arm_sin, arm.bucket_cos, arm.bucket_sin],
            count: cylinder.count,
            wheelbase: settings.machine.wheelbase,
            reference: [
                Turn::of(arm.reference_angle),
                Turn::of(arm.reference_angle + arm.reference_tilt),
            ],
            cylinder: Turn::of(cylinder.angle),
            pressure_std: settings.sensors.pressure_std,
            pressure_zero_std: settings.sensors.pressure_offset_std,
            gain_left_std: if span {
                0.0
            } else {
                LINEARITY * settings.sensors.pressure_gain_std
            },
        })
    }

    /// Moves one number by its standard deviation in `moved`, and resets the others. Span and offset move along their correlation.
    pub fn put_off(&mut self, number: usize) {
        let (moved, values, std) = (&mut self.moved, &self.values, &self.std);
        for last in [self.is_off, OFFSET] {
            moved[last] = values[last];
        }
        let (beside, along) = (1.0 - self.correlation * self.correlation, self.correlation);
        match number {
            SPAN => moved[OFFSET] += along * std[OFFSET],
            OFFSET => moved[OFFSET] -= (1.0 - sqrt(beside.max(0.0))) * std[OFFSET],
            _ => {}
        }
        moved[number] += std[number];
        self.is_off = number;
    }

    /// The payload depends on the number's error: no calibration has taken it in.
    pub fn weighs_by(&self, number: usize) -> bool {
        self.weighing[number] > 0.0
    }

    /// Sets value and standard deviation of a number.
    pub fn set(&mut self, number: usize, known: Quantity) {
        self.values[number] = known.value;
        self.moved[number] = known.value;
        self.std[number] = known.std;
        // A number that a calibration has taken in stays exact in the payload.
        if self.weighs_by(number) {
            self.weighing[number] = known.std;
        }
    }

    /// Zero error of the rod-side pressure: of its sensor, and of the usual pressure where there is none [Pa].
    pub fn rod_zero(&self, measured: bool) -> Quantity {
        let zero = self.pressure_zero_std;
        Quantity {
            value: 0.0,
            std: if measured {
                zero
            } else {
                norm(&[zero, UNMEASURED_ROD])
            },
        }
    }

    /// Ratio and height of the empty machine, with standard deviations.
    pub fn empty(&self) -> Each<(f64, f64)> {
        let of = |i: usize| (self.values[i], self.std[i]);
        Each {
            ratio: of(EMPTY_RATIO),
            height: of(EMPTY_HEIGHT),
        }
    }
}

/// Value and standard deviation of each number, as stated or by default.
fn described(settings: &Settings) -> [(f64, f64); NUMBERS] {
    let Settings {
        machine,
        lift_arm: arm,
        lift_cylinder: cylinder,
        sensors,
        prior,
        ..
    } = settings;
    let or = |stated: f64, usual: f64| if stated > 0.0 { stated } else { usual };
    let by = |value: f64, std: f64, share: f64| (value, or(std, share * value.abs()));
    // A calibration contains the moments of numbers that are not stated: then they are 0.
    let is_drawn = cylinder.span_std <= 0.0 && cylinder.force_offset_std <= 0.0;
    let usual = |value: f64, std: f64, share: f64, of: f64, (mean, spread): (f64, f64)| {
        if is_drawn && value <= 0.0 {
            (mean * of, spread * mean * of)
        } else {
            by(value, std, share)
        }
    };
    let bucket = usual(
        arm.bucket_mass,
        arm.bucket_mass_std,
        BUCKET_MASS,
        machine.mass,
        USUAL_BUCKET,
    );
    [
        by(arm.length, arm.length_std, DRAWN),
        usual(arm.mass, arm.mass_std, ARM, machine.mass, USUAL_ARM),
        usual(
            arm.mass_distance,
            arm.mass_distance_std,
            ARM,
            arm.length,
            USUAL_CENTRE,
        ),
        bucket,
        usual(
            arm.payload_distance,
            arm.payload_distance_std,
            LOAD_PLACE,
            arm.length,
            USUAL_PLACE,
        ),
        by(cylinder.head_area, cylinder.head_area_std, DRAWN),
        by(cylinder.rod_area, cylinder.rod_area_std, DRAWN),
        by(cylinder.base_distance, cylinder.base_distance_std, DRAWN),
        by(cylinder.rod_distance, cylinder.rod_distance_std, DRAWN),
        (cylinder.angle, cylinder.angle_std),
        (arm.pivot_x, or(arm.pivot_x_std, DRAWN * arm.length)),
        (arm.pivot_z, or(arm.pivot_z_std, DRAWN * arm.length)),
        by(
            or(arm.empty_mass, machine.mass),
            arm.empty_mass_std,
            WEIGHED,
        ),
        (
            or(arm.empty_ratio, prior.cg_ratio),
            or(arm.empty_ratio_std, prior.cg_ratio_std),
        ),
        (
            or(arm.empty_height, prior.cg_height),
            or(arm.empty_height_std, prior.cg_height_std),
        ),
        by(cylinder.friction, cylinder.friction_std, SEALS),
        (0.0, sensors.pressure_offset_std),
        (0.0, sensors.pressure_offset_std),
        (0.0, sensors.angle_offset_std),
        (0.0, sensors.angle_offset_std),
        (0.0, OTHER_BUCKET * bucket.0),
        turn(arm, cylinder.span_std > 0.0),
        (0.0, or(cylinder.span_std, sensors.pressure_gain_std)),
        (cylinder.force_offset, cylinder.force_offset_std),
    ]
}

impl Description {
    /// An arm is described without the place of its tilt cylinder: both places are possible, and make its loads uncertain.
    #[must_use]
    pub fn leaves_tilt_cylinder_open(&self) -> bool {
        self.lift_arm.length > 0.0 && leaves_turn_open(&self.lift_arm, &self.lift_cylinder)
    }

    /// Difference of either place of the tilt cylinder from the mean of both, as a share of a load that is lifted level. 0 where the load's
    /// distance from the pin is not stated.
    #[must_use]
    pub fn tilt_cylinder_share(&self) -> f64 {
        let arm = &self.lift_arm;
        let [frame, held] = [FRAME, 1.0].map(|turn| arm.length + turn * arm.payload_distance);
        (held - frame) / (held + frame)
    }
}

/// The bucket turn is not stated, and no calibration of the cylinders has taken it in.
fn leaves_turn_open(arm: &LiftArm, cylinder: &LiftCylinder) -> bool {
    arm.bucket_turn.is_none() && cylinder.span_std <= 0.0
}

/// Bucket turn: as stated, or the prior. A calibration without it has assumed that the bucket turns with the arm, 1.
fn turn(arm: &LiftArm, calibrated: bool) -> (f64, f64) {
    let std = if arm.bucket_turn_std > 0.0 {
        arm.bucket_turn_std
    } else {
        LINKAGE
    };
    let stated = arm.bucket_turn.or(calibrated.then_some(1.0));
    let known = stated.map_or(Linkage::NEW.known(), |value| Quantity { value, std });
    (known.value, known.std)
}

/// Standard deviations that remain in the payload where span or offset of the moment is calibrated.
fn weighing(std: [f64; NUMBERS], span: bool, offset: bool) -> [f64; NUMBERS] {
    let mut left = std;
    for (number, std) in left[..SPAN].iter_mut().enumerate() {
        let calibrated = match number {
            HEAD_ZERO | ROD_ZERO => offset,
            _ => span && !STILL_DRAWN.contains(&number),
        };
        if calibrated {
            *std = 0.0;
        }
    }
    left
}

/// Force of the cylinders at full pressure [N].
pub(super) fn full_force(count: f64, v: &[f64; NUMBERS]) -> f64 {
    count * v[HEAD_AREA] * FULL_PRESSURE
}

/// Payload whose weight the cylinders hold with a level arm at full pressure, at most the rated one (`RATED_SHARE` of the mass) [kg].
fn capacity(count: f64, v: &[f64; NUMBERS]) -> f64 {
    let (base, eye) = (v[BASE], v[EYE]);
    let lever = base * eye / sqrt(base * base + eye * eye);
    let held = full_force(count, v) * lever / ((v[LENGTH] + v[LOAD_DISTANCE]) * GRAVITY);
    held.min(RATED_SHARE * v[EMPTY_MASS])
}

#[cfg(test)]
mod tests {
    use super::super::numbers::{BUCKET, MASS, MASS_DISTANCE};
    use super::super::tests::settings;
    use super::*;

    #[test]
    fn a_mass_that_nobody_states_is_a_guess_whose_spread_holds_the_true_one() {
        let stated = settings();
        let truth = Drawing::of(&stated).expect("an arm").values;
        let mut silent = stated;
        let arm = &mut silent.lift_arm;
        (arm.bucket_mass, arm.mass) = (0.0, 0.0);
        (arm.mass_distance, arm.payload_distance) = (0.0, 0.0);
        let guess = Drawing::of(&silent).expect("an arm");
        for number in [BUCKET, MASS, MASS_DISTANCE, LOAD_DISTANCE] {
            let (value, std) = (guess.values[number], guess.std[number]);
            assert!(value > 0.0 && std > 0.09 * value, "{number}");
            assert!(
                (value - truth[number]).abs() < 2.0 * std,
                "{number}: {value}"
            );
            assert_eq!(guess.weighing[number], std);
        }
        // A calibration contains it already.
        silent.lift_cylinder.span_std = 0.01;
        assert_eq!(Drawing::of(&silent).expect("an arm").values[BUCKET], 0.0);
    }
}
