//! Default description of an excavator from its operating mass and a few more stated numbers.
//!
//! Excavators have similar proportions: lengths grow with the cube root of the operating mass M, masses with M, inertias with
//! M^(5/3), the swing torque with M^(4/3). The factors are means over tracked excavators of 8 to 40 t, from data sheets and the four
//! machines of `data/foreign`. The true values of these lie within the stated spread. Stated values replace guessed ones, and scale
//! what depends on them: a stated boom length scales its centre of mass, a stated rated payload scales the bucket.

use super::cylinder::Cylinder;
use super::doubts::Doubts;
use super::geometry::Geometry;
use super::keys::{Description, Prior};
use crate::CommonError;
use crate::loads;
use crate::math::{cbrt, norm, sqrt};

/// Lengths per cube root of the operating mass [m/kg^(1/3)]: boom; arm; bucket pin to the centres of mass of bucket and payload;
/// gyration of the payload; radii of gyration of boom, arm and bucket about their lengths.
const BOOM: f64 = 0.197;
const ARM: f64 = 0.102;
const BUCKET_CENTRE: f64 = 0.027;
const PAYLOAD_CENTRE: f64 = 0.030;
const PAYLOAD_GYRATION: f64 = 0.016;
const AXIAL: [f64; 3] = [0.0088, 0.0078, 0.0122];
/// Distance from swing axis to boom pin and its standard deviation, as shares of the boom's length: .2 m and .15 m at 21 t. Below
/// `COMPACT` [kg] the boom may stand ahead on a swing post: .21 on the reference machine, .04 on one of 8 t without a post.
const BOOM_PIN: [f64; 2] = [0.04, 0.027];
const BOOM_PIN_COMPACT: [f64; 2] = [0.12, 0.08];
const COMPACT: f64 = 10_000.0;
/// Radius of a load, in lengths of the boom.
const LOAD_RADIUS: f64 = 1.1;
/// Standard deviation of a guessed load centre, as a share of its distance from the bucket pin, along and beside the line to the
/// tip: buckets are bent, and .12 to .25 of the tip's distance deep beside it.
const LOAD_CENTRE_SPREAD: f64 = 0.28;
/// Distance from the middle of the payload's prior to a full bucket, in its standard deviations: two thirds of the payloads lie within
/// one, and a full one a little beyond.
const FULL_STDS: f64 = 1.25;
/// Distances of centres of mass from the lines of the pins: goosenecks stand .05 to .12 of the boom above theirs; bucket and load lie
/// .12 to .25 of the tip's distance behind the line to it [m/kg^(1/3)].
const BOOM_RISE: f64 = 0.085;
const BUCKET_RISE: f64 = 0.0097;
/// Standard deviation of the empty attachment's weight by guessed centres of boom and bucket, as a share of a full load. It is that
/// between the postures of an emptied and of a full bucket. Posts and buckets of compact machines differ more.
const FORM_SPREAD: f64 = 0.06;
const FORM_SPREAD_COMPACT: f64 = 0.12;
/// The same for a drawing that states the centres along the lines of the pins, and not beside them.
const FORM_SPREAD_DRAWN: f64 = 0.06;
/// Relative standard deviation of a load by a boom that bends sideways. Its frequency with a full bucket is f = 2 to 6 Hz (a box section
/// as a cantilever). The gyro rides on the light upper body, so an attachment of inertia J that swings at F = .5 Hz shows J (1 + (F/f)^2).
/// Loaded minus empty is too large by 1.6 (F/f)^2 of the load. Root mean square of that, with the logarithm of f uniform.
const BENDING: f64 = 0.045;
/// Limits of the inertia, as shares of the folded empty and of the stretched full machine's; standard deviation of its prior, as a share
/// of their geometric mean.
const LEAST_INERTIA: f64 = 0.4;
const MOST_INERTIA: f64 = 3.0;
const INERTIA_SPREAD: f64 = 0.3;
/// Middle and standard deviation of the payload's prior, and largest payload of a bucket, as shares of the rated payload.
const MIDDLE_PAYLOAD: f64 = 0.5;
const PAYLOAD_SPREAD: f64 = 0.4;
const MOST_PAYLOAD: f64 = 1.6;
/// Centres of mass of boom and arm, as shares of the link's length.
const BOOM_CENTRE: f64 = 0.48;
const ARM_CENTRE: f64 = 0.36;
/// Masses of boom and arm as shares of the operating mass; mass of the bucket as a share of the rated payload.
const BOOM_MASS: f64 = 0.087;
const ARM_MASS: f64 = 0.047;
const BUCKET_MASS: f64 = 0.46;
/// Rated payload over M^(7/6) [kg^(-1/6)]: buckets of large machines are larger than in proportion. Within 4 % of the reference machine
/// and of four others (5.5, 8, 14 and 40 t); the share of M would be .0725 at 5.5 t and .105 at 40 t.
const RATED: f64 = 0.0173;
/// Inertias of boom and arm over mass times length squared, of the bucket over mass times squared centre distance.
const LINKS: [f64; 3] = [0.085, 0.095, 0.3];
/// Inertia of the upper body over M^(5/3) [kg^(-2/3) m^2], and its relative spread. Compact machines have .55 (no tail that swings out)
/// to 1.0 of it.
const UPPER: [f64; 2] = [0.0018, 0.25];
const UPPER_COMPACT: [f64; 2] = [0.0014, 0.35];
/// Swing torque over M^(4/3) [N m/kg^(4/3)].
const TORQUE: f64 = 0.115;
/// Damping [s], friction, its spread, offset and noise over the swing torque.
const DAMPING: f64 = 0.105;
const DAMPING_STD: f64 = 0.35;
const FRICTION: f64 = 0.04;
const FRICTION_STD: f64 = 0.025;
const OFFSET: f64 = 0.018;
const NOISE: f64 = 0.007;
/// Relative spreads of values guessed from the operating mass: masses of boom and arm; bucket. The shares are those of machines from
/// 8 t on: boom and arm of compact machines are up to a third lighter.
const SPREAD: f64 = 0.05;
const SPREAD_COMPACT: f64 = 0.2;
const BUCKET_SPREAD: f64 = 0.3;
/// Relative spread of the reach by guessed lengths of boom and arm: booms differ by 5 to 6 %, arms by 5 % of a third of the reach.
const REACH_SPREAD: [f64; 2] = [0.037, 0.017];
/// Extreme postures of a working machine: folded, stretched [rad].
const FOLDED: [f64; 3] = [0.96, -2.55, -1.48];
const STRETCHED: [f64; 3] = [0.4, -0.5, -0.3];

impl Description {
    /// Operating mass of the reference machine \[kg\].
    pub const REFERENCE_MASS: f64 = 5500.0;

    /// Default description of a machine of the stated operating mass; that of the reference machine where none is stated.
    #[must_use]
    pub fn of_its_size(&self) -> Self {
        let Some(mass) = self.machine.operating_mass else {
            return Self::default();
        };
        let mut d = Self::default();
        let length = cbrt(mass);
        let stated = |i: usize, value: f64, default: f64, guess: f64| {
            if value == default && !self.stated[i] {
                guess
            } else {
                value
            }
        };
        d.stated = self.stated;
        let (g, known) = (&mut d.geometry, &self.geometry);
        let rated = self.machine.rated_payload.unwrap_or(rated_payload(mass));
        let torque = self.machine.swing_torque.unwrap_or(TORQUE * mass * length);
        let lengths = [
            (known.boom_length, g.boom_length, BOOM * length),
            (known.arm_length, g.arm_length, ARM * length),
        ];
        // A stated length that equals the guess counts as guessed.
        let guessed = [0, 1].map(|i| {
            let (known, default, guess) = lengths[i];
            known == guess || known == default && !self.stated[i]
        });
        g.boom_length = stated(0, known.boom_length, g.boom_length, BOOM * length);
        g.arm_length = stated(1, known.arm_length, g.arm_length, ARM * length);
        g.boom_pin = boom_pin(mass)[0] * g.boom_length;
        g.boom_centre = BOOM_CENTRE * g.boom_length;
        g.arm_centre = ARM_CENTRE * g.arm_length;
        g.bucket_centre = BUCKET_CENTRE * length;
        g.payload_centre = PAYLOAD_CENTRE * length;
        g.boom_rise = BOOM_RISE * g.boom_length;
        g.bucket_rise = BUCKET_RISE * length;
        g.payload_rise = BUCKET_RISE * length;
        g.payload_gyration = PAYLOAD_GYRATION * length;
        g.boom_mass = BOOM_MASS * mass;
        g.arm_mass = ARM_MASS * mass;
        g.bucket_mass = BUCKET_MASS * rated;
        let inertia = |share: f64, m: f64, l: f64| share * m * l * l;
        g.boom_inertia = inertia(LINKS[0], g.boom_mass, g.boom_length);
        g.arm_inertia = inertia(LINKS[1], g.arm_mass, g.arm_length);
        g.bucket_inertia = inertia(LINKS[2], g.bucket_mass, g.bucket_centre);
        g.boom_axial_inertia = inertia(1.0, g.boom_mass, AXIAL[0] * length);
        g.arm_axial_inertia = inertia(1.0, g.arm_mass, AXIAL[1] * length);
        g.bucket_axial_inertia = inertia(1.0, g.bucket_mass, AXIAL[2] * length);
        let [upper_inertia, upper_spread] = if mass < COMPACT { UPPER_COMPACT } else { UPPER };
        d.machine.upper_inertia = upper_inertia * mass * length * length;
        d.machine.operating_mass = Some(mass);
        d.machine.rated_payload = self.machine.rated_payload;
        d.machine.swing_torque = self.machine.swing_torque;
        // The upper inertia is unstated: it has the default, or an earlier guess.
        let upper = self.machine.upper_inertia;
        if upper == Self::default().machine.upper_inertia || upper == d.machine.upper_inertia {
            d.machine.mass_tolerance = if mass < COMPACT {
                SPREAD_COMPACT
            } else {
                SPREAD
            };
            d.machine.upper_tolerance = Some(upper_spread);
            d.machine.bucket_tolerance = Some(BUCKET_SPREAD);
        }
        let spread = |i: usize| if guessed[i] { REACH_SPREAD[i] } else { 0.0 };
        let lengths = sqrt(spread(0) * spread(0) + spread(1) * spread(1));
        d.machine.geometry_tolerance = d.machine.geometry_tolerance.max(lengths);
        d.friction(torque);
        d.priors(rated);
        d
    }

    /// Relative standard deviation of a load's radius by a guessed distance from the swing axis to the boom pin. 0 if that distance is
    /// stated, or no operating mass is.
    #[must_use]
    pub fn guessed_radius_std(&self) -> f64 {
        match self.machine.operating_mass {
            Some(mass) if self.geometry.boom_pin == self.of_its_size().geometry.boom_pin => {
                boom_pin(mass)[1] / LOAD_RADIUS
            }
            _ => 0.0,
        }
    }

    /// The same by the load centre in the bucket, where it is guessed or its deviation stated; 0 also after a calibration with weighed loads,
    /// whose deviations include it.
    #[must_use]
    pub fn load_centre_share(&self) -> f64 {
        let radius = LOAD_RADIUS * self.geometry.boom_length;
        if self.is_calibrated() || radius <= 0.0 {
            return 0.0;
        }
        self.load_centre_std() / radius
    }

    /// Standard deviation of the load centre in the bucket, where it is guessed or its deviation stated; 0 otherwise \[m\].
    #[must_use]
    pub fn load_centre_std(&self) -> f64 {
        let (g, guess) = (&self.geometry, self.of_its_size().geometry);
        let is_guessed =
            self.machine.operating_mass.is_some() && g.payload_centre == guess.payload_centre;
        let guessed = if is_guessed {
            LOAD_CENTRE_SPREAD * g.payload_centre
        } else {
            0.0
        };
        g.payload_centre_std.unwrap_or(guessed)
    }

    /// Standard deviation of the empty attachment's weight by guessed centres of boom and bucket \[kg\].
    #[must_use]
    pub fn guessed_form_std(&self) -> f64 {
        let Some(mass) = self.machine.operating_mass else {
            return 0.0;
        };
        let (g, guess) = (&self.geometry, self.of_its_size().geometry);
        let drawn = [g.boom_centre, g.bucket_centre] != [guess.boom_centre, guess.bucket_centre];
        let bent = [g.boom_rise, g.bucket_rise] != [guess.boom_rise, guess.bucket_rise];
        let share = match mass < COMPACT {
            _ if drawn && bent || self.is_calibrated() => 0.0,
            _ if drawn => FORM_SPREAD_DRAWN,
            true => FORM_SPREAD_COMPACT,
            false => FORM_SPREAD,
        };
        share * self.prior.full_load()
    }

    /// Standard deviation of the bucket's mass \[kg\].
    fn bucket_std(&self) -> f64 {
        Doubts::bucket_share(&self.machine) * self.geometry.bucket_mass
    }

    /// Whether masses and gain were calibrated together, with weighed loads.
    fn is_calibrated(&self) -> bool {
        self.machine.links_gain_correlation.is_some()
    }

    /// Settings of the ledger of loads, as far as the description determines them.
    #[must_use]
    pub fn loads(&self) -> loads::Settings {
        loads::Settings {
            common: self.loads_common(),
            ..loads::Settings::with_rated(self.prior.full_load())
        }
    }

    /// Errors common to all loads. Scale: by lengths, a guessed boom pin and guessed centres in the inertia per kilogram of load, and by a
    /// bending boom where only the swing weighs. Zero: by guessed centres, and by soil that is indistinguishable from the bucket.
    #[must_use]
    pub fn loads_common(&self) -> CommonError {
        let radius = [
            self.machine.geometry_tolerance,
            self.guessed_radius_std(),
            self.load_centre_share(),
        ];
        let sticks = self.prior.sticking().among(self.bucket_std());
        // The deviations of a calibration with weighed loads include it.
        let bends = if self.is_calibrated() || Cylinder::of_boom(self).is_some() {
            0.0
        } else {
            BENDING
        };
        CommonError {
            scale_std: norm(&[2.0 * norm(&radius), bends]),
            zero_std: norm(&[self.guessed_form_std(), sticks.std]),
        }
    }

    /// Sets what depends on the largest torque of the swing.
    fn friction(&mut self, torque: f64) {
        self.machine.nominal_damping = DAMPING * torque;
        self.prior.damping_std = DAMPING_STD * DAMPING * torque;
        self.machine.coulomb_friction = FRICTION * torque;
        self.prior.friction_std = FRICTION_STD * torque;
        self.prior.torque_offset_std = OFFSET * torque;
        self.prior.known_torque_offset_std = 0.5 * OFFSET * torque;
        self.sensors.swing_torque_std = NOISE * torque;
        let reference = Self::default();
        let scale = self.machine.nominal_damping / reference.machine.nominal_damping;
        self.estimator.epsilon = scale * reference.estimator.epsilon;
        self.paper.torque = scale * reference.paper.torque;
        let drift = [
            reference.estimator.velocity_torque_drift,
            reference.estimator.velocity_torque_drift_constant,
        ];
        [
            self.estimator.velocity_torque_drift,
            self.estimator.velocity_torque_drift_constant,
        ] = drift.map(|drift| scale * drift);
    }

    /// Sets priors and limits of inertia and payload.
    fn priors(&mut self, rated: f64) {
        let geometry = Geometry::of(self);
        let [least, most] = [(FOLDED, 0.0), (STRETCHED, rated)]
            .map(|(posture, payload)| geometry.inertia(posture).with_payload(payload));
        let middle = sqrt(least * most);
        self.machine.inertia_min = LEAST_INERTIA * least;
        self.machine.inertia_max = MOST_INERTIA * most;
        self.prior.inertia = middle;
        self.prior.inertia_std = INERTIA_SPREAD * middle;
        self.prior.payload = MIDDLE_PAYLOAD * rated;
        self.prior.payload_std = PAYLOAD_SPREAD * rated;
        let reference = Self::default();
        let scale = rated / reference.prior.full_load();
        let e = &mut self.estimator;
        e.payload_min = scale * reference.estimator.payload_min;
        e.payload_max = MOST_PAYLOAD * rated;
        e.opening_change_max = scale * reference.estimator.opening_change_max;
        e.change_rate_std = scale * reference.estimator.change_rate_std;
    }
}

/// Soil that sticks in the bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sticking {
    /// Expected mass, and its standard deviation \[kg\].
    pub(super) expected: f64,
    pub(super) std: f64,
    /// Share of soil in the deviation of bucket and soil together from their expected mass.
    pub(super) share: f64,
}

impl Sticking {
    /// Posterior where only the sum of soil and bucket is weighed; `bucket_std`: standard deviation of the bucket's mass \[kg\].
    pub(super) fn among(self, bucket_std: f64) -> Self {
        let both = norm(&[self.std, bucket_std]).max(f64::MIN_POSITIVE);
        let part = self.std / both;
        Self {
            std: part * bucket_std,
            share: part * part,
            ..self
        }
    }

    /// Soil in a bucket that weighs `both` more than the described bucket, soil included \[kg\].
    pub(super) fn of(&self, both: f64) -> f64 {
        self.expected + self.share * (both - self.expected)
    }
}

impl Prior {
    /// Soil that sticks in an emptied bucket.
    pub(super) fn sticking(&self) -> Sticking {
        let [expected, std] =
            [self.carry_back, self.carry_back_std].map(|share| share * self.full_load());
        Sticking {
            expected,
            std,
            share: 1.0,
        }
    }

    /// The payload of a full bucket \[kg\].
    #[must_use]
    pub fn full_load(&self) -> f64 {
        self.payload + FULL_STDS * self.payload_std
    }
}

/// Rated payload of a machine of this operating mass \[kg\].
fn rated_payload(mass: f64) -> f64 {
    RATED * mass * sqrt(cbrt(mass))
}

/// Distance from the swing axis to the boom pin and its standard deviation, as shares of the boom's length, for this
/// operating mass \[kg\].
fn boom_pin(mass: f64) -> [f64; 2] {
    if mass < COMPACT {
        BOOM_PIN_COMPACT
    } else {
        BOOM_PIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boom_pin_of_machines_that_exist_lies_within_its_spread_and_a_stated_one_has_none() {
        // Operating mass, boom, boom pin: data/foreign, and the reference machine.
        for (mass, boom, pin) in [
            (5500.0, 3.0, 0.6317),
            (8000.0, 3.59, 0.13),
            (14_000.0, 4.99, 0.154),
            (40_000.0, 6.90, 0.258),
        ] {
            let mut d = Description::default();
            d.machine.operating_mass = Some(mass);
            d.geometry.boom_length = boom;
            d.geometry = d.of_its_size().geometry;
            let std = LOAD_RADIUS * boom * d.guessed_radius_std();
            let guess = d.geometry.boom_pin;
            assert!((guess - pin).abs() < 1.3 * std, "{mass}: {guess} +- {std}");
            d.geometry.boom_pin = pin;
            assert_eq!(d.guessed_radius_std(), 0.0);
        }
        assert_eq!(Description::default().guessed_radius_std(), 0.0);
    }

    #[test]
    fn centres_that_nobody_states_are_doubted_in_all_loads_and_stated_ones_are_not() {
        let class = |mass: f64| {
            let mut d = Description::default();
            d.machine.operating_mass = Some(mass);
            d.of_its_size()
        };
        let d = class(21_500.0);
        let rated = rated_payload(21_500.0);
        let zero = |d: &Description, form: f64| {
            let soil = d.prior.sticking().among(d.bucket_std()).std / rated;
            d.loads_common().zero_std / rated - norm(&[form, soil])
        };
        assert!(zero(&d, FORM_SPREAD).abs() < 0.005);
        assert!(class(5500.0).loads_common().zero_std > 0.1 * rated_payload(5500.0));
        let mut drawn = d;
        drawn.geometry.boom_centre = 2.7;
        assert!(zero(&drawn, FORM_SPREAD_DRAWN).abs() < 0.005);
        drawn.geometry.boom_rise = 0.4;
        assert_eq!(drawn.guessed_form_std(), 0.0);
        let by_centre = drawn.loads_common().scale_std;
        drawn.geometry.payload_centre = 0.9;
        let exact = drawn.loads_common().scale_std;
        assert!(exact < by_centre);
        // A stated deviation counts, guessed centre or not.
        drawn.geometry.payload_centre_std = Some(0.3);
        assert!(drawn.loads_common().scale_std > exact);
        let mut held = class(21_500.0);
        held.geometry.payload_centre_std = Some(0.0);
        assert_eq!(held.load_centre_share(), 0.0);
    }

    #[test]
    fn a_boom_that_bends_is_a_doubt_of_all_loads_that_only_the_swing_weighs() {
        let mut d = Description::default();
        d.machine.geometry_tolerance = 0.0;
        assert_eq!(d.loads_common().scale_std, BENDING);
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance) = (0.6, 1.3);
        assert_eq!(d.loads_common().scale_std, 0.0);
    }

    #[test]
    fn a_centre_beside_the_line_is_one_on_a_line_turned_by_their_angle() {
        let mut d = Description::default();
        d.geometry.payload_rise = 0.2;
        let mut on_line = Description::default();
        let centre = d.geometry.payload_centre;
        on_line.geometry.payload_centre = norm(&[centre, 0.2]);
        let angle = f64::atan2(0.2, centre);
        let posture = [0.5, -1.4, -0.9];
        let of = |d: &Description, turned: f64| {
            let [boom, arm, bucket] = posture;
            Geometry::of(d).inertia([boom, arm, bucket + turned])
        };
        let [beside, line] = [of(&d, 0.0).radius, of(&on_line, angle).radius];
        assert!((beside - line).abs() < 1e-12, "{beside} {line}");
        assert!(
            beside > of(&Description::default(), 0.0).radius,
            "it hangs in front"
        );
    }

    #[test]
    fn a_compact_machine_may_be_a_third_lighter_than_its_class() {
        let class = |mass: f64| {
            let mut d = Description::default();
            d.machine.operating_mass = Some(mass);
            d.of_its_size().machine.mass_tolerance
        };
        assert!(0.33 < 2.0 * class(2500.0) && class(2500.0) > 3.0 * class(21_500.0));
        let mut drawn = Description::default();
        drawn.machine.operating_mass = Some(2500.0);
        drawn.machine.upper_inertia = 700.0;
        let stated = Description::default().machine.mass_tolerance;
        assert_eq!(drawn.of_its_size().machine.mass_tolerance, stated);
    }

    #[test]
    fn lengths_that_nobody_states_are_doubted_and_stated_ones_are_not() {
        let of = |boom: Option<f64>, arm: Option<f64>| {
            let mut d = Description::default();
            d.machine.operating_mass = Some(14_000.0);
            d.geometry.boom_length = boom.unwrap_or(d.geometry.boom_length);
            d.geometry.arm_length = arm.unwrap_or(d.geometry.arm_length);
            d.of_its_size().machine.geometry_tolerance
        };
        let drawing = Description::default().machine.geometry_tolerance;
        assert_eq!(of(Some(4.6), Some(2.5)), drawing);
        assert!(of(None, None) > of(None, Some(2.5)));
        assert!(of(None, Some(2.5)) > of(Some(4.6), None));
        assert!(of(Some(4.6), None) > drawing);
    }

    #[test]
    fn machines_of_all_sizes_are_like_those_that_exist() {
        // Operating mass, boom, arm [m], upper inertia [kg m^2], boom mass, rated payload [kg], damping: data/foreign.
        for (mass, boom, arm, upper, boom_mass, rated, damping) in [
            (8000.0, 3.59, 2.02, 5660.0, 690.0, 620.0, 1755.0),
            (14000.0, 4.99, 2.36, 16568.0, 1215.0, 1172.0, 3790.0),
            (22000.0, 5.74, 2.91, 34777.0, 1960.0, 2000.0, 7165.0),
            (40000.0, 6.90, 3.47, 79831.0, 3553.0, 4183.0, 15798.0),
        ] {
            let mut d = Description::default();
            d.machine.operating_mass = Some(mass);
            let d = d.of_its_size();
            assert_eq!(d.of_its_size(), d, "a guess is no statement");
            for (guess, truth, spread) in [
                (d.geometry.boom_length, boom, 0.15),
                (d.geometry.arm_length, arm, 0.15),
                (d.machine.upper_inertia, upper, 0.25),
                (d.geometry.boom_mass, boom_mass, 0.1),
                (d.estimator.payload_max, 1.6 * rated, 0.05),
                (d.machine.nominal_damping, damping, 0.35),
            ] {
                assert!(
                    (guess / truth - 1.0).abs() < spread,
                    "{mass} {guess} {truth}"
                );
            }
        }
        assert_eq!(Description::default().of_its_size(), Description::default());
    }
}
