//! Description of an excavator. The defaults are those of the reference machine, a 5.5 t excavator
//! whose swing inertia spans the 4380 to 9761 kg m^2 of Oh, Yi, Seo, Kim, Lee 2017.

use crate::keys::{Numbers, choice, table};

choice! {
    /// What is assumed of damping, torque offset and payload.
    pub enum Variant {
        /// Payload that may change, found by itself (posture-torque); damping and torque offset as described, their
        /// uncertainty in the interval (torque, posture, velocity).
        Auto = "auto",
        /// Damping and torque are calibrated.
        Known = "known",
        /// Damping within damping_std, torque with an offset, both estimated; payload constant while moving.
        Tolerant = "tolerant",
    }
}

table! {
    /// The machine.
    pub struct Machine, "machine" {
        /// Operating mass; with it all that is not stated has the value that machines of this mass have, with their spread.
        operating_mass: Option<f64> = None, "kg", 200.0 to 1e6;
        /// Rated payload of the bucket; "none" takes that of machines of the operating mass.
        rated_payload: Option<f64> = None, "kg", 1.0 to 1e5;
        /// Largest torque of the swing; "none" takes that of machines of the operating mass.
        swing_torque: Option<f64> = None, "N m", 1.0 to 1e7;
        /// Viscous damping of the swing, as known beforehand (b-bar).
        nominal_damping: f64 = 1500.0, "N m s/rad", 0.0 to 1e7;
        /// Coulomb friction torque of the swing.
        coulomb_friction: f64 = 250.0, "N m", 0.0 to 1e6;
        /// Standard deviation of the Coulomb friction; "none" takes prior.friction_std.
        coulomb_friction_std: Option<f64> = None, "N m", 0.0 to 1e6;
        /// Efficiency of the swing drive: driving torque arrives times it, braking torque divided by it.
        drive_efficiency: f64 = 1.0, "", 0.5 to 1.0;
        /// Its standard deviation.
        drive_efficiency_std: f64 = 0.03, "", 0.0 to 0.5;
        /// First moment of the upper body without boom, arm and bucket about the swing axis, forward positive (a
        /// counterweight makes it negative); "none" takes 1.15 times what balances the folded, empty attachment, as machines have.
        upper_first_moment: Option<f64> = None, "kg m", -1e7 to 1e7;
        /// Its standard deviation; "none" takes 3 % of a stated moment, a third of one that is not.
        upper_first_moment_std: Option<f64> = None, "kg m", 0.0 to 1e7;
        /// Standard deviation of the slope of the ground along each of two axes.
        slope_std: f64 = 0.03, "rad", 0.0 to 0.5;
        /// Relative standard deviation of the described masses and inertias of boom and arm.
        mass_tolerance: f64 = 0.018, "", 0.0 to 0.5;
        /// The same of the upper body's inertia: counterweight, tank, options; "none" takes 7 times mass_tolerance (0.126).
        upper_tolerance: Option<f64> = None, "", 0.0 to 1.0;
        /// The same of the bucket's mass: attachments are changed; "none" takes 11 times mass_tolerance (0.2).
        bucket_tolerance: Option<f64> = None, "", 0.0 to 1.0;
        /// Correlation of the errors of the masses of boom and arm with that of sensors.swing_torque_gain, where `heft calibrate` has found
        /// them together; "none": nobody has, and what the lengths do to the inertia comes on top of mass_tolerance.
        links_gain_correlation: Option<f64> = None, "", -1.0 to 1.0;
        /// The same of the upper body's inertia with that gain.
        upper_gain_correlation: f64 = 0.0, "", -1.0 to 1.0;
        /// The same of the upper body's inertia with the masses of boom and arm.
        upper_links_correlation: f64 = 0.0, "", -1.0 to 1.0;
        /// Correlation of the error of the bucket's mass with that of sensors.swing_torque_gain; "none": the calibration scaled the bucket by
        /// the factor of boom and arm.
        bucket_gain_correlation: Option<f64> = None, "", -1.0 to 1.0;
        /// The same of the upper body's inertia with the bucket's mass.
        upper_bucket_correlation: f64 = 0.0, "", -1.0 to 1.0;
        /// The same of the masses of boom and arm with the bucket's mass.
        links_bucket_correlation: f64 = 0.0, "", -1.0 to 1.0;
        /// Relative standard deviation of the described lengths.
        geometry_tolerance: f64 = 0.008, "", 0.0 to 0.2;
        /// Inertia of the upper body without boom, arm and bucket, about the swing axis (J_u).
        upper_inertia: f64 = 1698.0, "kg m^2", 0.0 to 1e9;
        /// Smallest inertia that an estimate may take.
        inertia_min: f64 = 2500.0, "kg m^2", 1e-9 to 1e9;
        /// Largest inertia that an estimate may take.
        inertia_max: f64 = 20000.0, "kg m^2", 1e-9 to 1e9;
    }
}

table! {
    /// Geometry and masses of the attachment; angles as in the messages.
    pub struct Attachment, "machine.geometry" {
        /// Swing axis to boom pin, horizontal (x0).
        boom_pin: f64 = 0.6317, "m", -10.0 to 10.0;
        /// Boom pin to arm pin (L1).
        boom_length: f64 = 3.0, "m", 0.0 to 50.0;
        /// Arm pin to bucket pin (L2).
        arm_length: f64 = 1.6, "m", 0.0 to 50.0;
        /// Boom pin to the boom's centre of mass (c1).
        boom_centre: f64 = 1.38, "m", 0.0 to 50.0;
        /// Arm pin to the arm's centre of mass (c2).
        arm_centre: f64 = 0.67, "m", 0.0 to 50.0;
        /// Bucket pin to the bucket's centre of mass (c3).
        bucket_centre: f64 = 0.42, "m", 0.0 to 50.0;
        /// Bucket pin to the payload's centre of mass (cp).
        payload_centre: f64 = 0.48, "m", 0.0 to 50.0;
        /// Standard deviation of that centre, along the bucket and across; "none" takes 5 % of payload_centre in `heft calibrate`, and
        /// the spread among machines where payload_centre is guessed.
        payload_centre_std: Option<f64> = None, "m", 0.0 to 10.0;
        /// Height of the boom's centre of mass above the line of its pins: goosenecks have some .085 of its length (n1).
        boom_rise: f64 = 0.0, "m", -5.0 to 5.0;
        /// The bucket's centre of mass beside the line from its pin to its tip, on the side of its back (n3).
        bucket_rise: f64 = 0.0, "m", -5.0 to 5.0;
        /// The same of the payload's (np).
        payload_rise: f64 = 0.0, "m", -5.0 to 5.0;
        /// Radius of gyration of the payload (kp).
        payload_gyration: f64 = 0.25, "m", 0.0 to 10.0;
        /// Mass of the boom (m1).
        boom_mass: f64 = 430.0, "kg", 0.0 to 1e6;
        /// Mass of the arm (m2).
        arm_mass: f64 = 210.0, "kg", 0.0 to 1e6;
        /// Mass of the empty bucket (m3).
        bucket_mass: f64 = 165.0, "kg", 0.0 to 1e6;
        /// Inertia of the boom across its length, at its centre of mass (I1).
        boom_inertia: f64 = 330.0, "kg m^2", 0.0 to 1e7;
        /// Inertia of the arm across its length (I2).
        arm_inertia: f64 = 46.0, "kg m^2", 0.0 to 1e7;
        /// Inertia of the bucket across its length (I3).
        bucket_inertia: f64 = 14.0, "kg m^2", 0.0 to 1e7;
        /// Inertia of the boom about its length (Ir1).
        boom_axial_inertia: f64 = 9.0, "kg m^2", 0.0 to 1e7;
        /// Inertia of the arm about its length (Ir2).
        arm_axial_inertia: f64 = 4.0, "kg m^2", 0.0 to 1e7;
        /// Inertia of the bucket about its length (Ir3).
        bucket_axial_inertia: f64 = 9.0, "kg m^2", 0.0 to 1e7;
    }
}

table! {
    /// The cylinders that carry the boom.
    pub struct BoomCylinder, "machine.boom_cylinder" {
        /// Number of cylinders side by side.
        count: f64 = 1.0, "", 1.0 to 4.0;
        /// Area of the piston; 0 says that nothing is known of the cylinder, and leaves its pressures out.
        head_area: f64 = 0.0, "m^2", 0.0 to 1.0;
        /// Its standard deviation; "none" takes 0.5 %.
        head_area_std: Option<f64> = None, "m^2", 0.0 to 1.0;
        /// Area of the piston less that of the rod.
        rod_area: f64 = 0.0, "m^2", 0.0 to 1.0;
        /// Cylinder base to boom foot (a).
        base_distance: f64 = 0.0, "m", 0.0 to 20.0;
        /// Its standard deviation; "none" takes 0.4 %.
        base_distance_std: Option<f64> = None, "m", 0.0 to 1.0;
        /// Boom foot to rod eye (c).
        rod_distance: f64 = 0.0, "m", 0.0 to 20.0;
        /// Its standard deviation; "none" takes 0.4 %.
        rod_distance_std: Option<f64> = None, "m", 0.0 to 1.0;
        /// Angle between the two at boom angle 0 (delta).
        angle: f64 = 0.0, "rad", -6.3 to 6.3;
        /// Its standard deviation.
        angle_std: f64 = 0.005, "rad", 0.0 to 1.0;
        /// Friction of the seals, as a share of all pistons at 20 MPa.
        friction: f64 = 0.03, "", 0.0 to 0.5;
        /// Its standard deviation.
        friction_std: f64 = 0.02, "", 0.0 to 0.5;
        /// Share of it that is left when the cylinder stops: all of it where it stops at once, none where it bounces.
        friction_kept: f64 = 0.5, "", 0.0 to 1.0;
        /// Its standard deviation.
        friction_kept_std: f64 = 0.5, "", 0.0 to 1.0;
        /// Force that the pressures show too much, by the zeros of their sensors.
        force_offset: f64 = 0.0, "N", -1e6 to 1e6;
        /// Its standard deviation; "none" takes that of the sensors' zeros.
        force_offset_std: Option<f64> = None, "N", 0.0 to 1e6;
        /// Relative standard deviation of the moment; "none" takes those of areas, distances and angle.
        span_std: Option<f64> = None, "", 0.0 to 0.5;
        /// Correlation of the errors of force offset and span.
        span_offset_correlation: f64 = 0.0, "", -1.0 to 1.0;
        /// Moment about the boom foot that the drawing misses: with the cosine of the boom's angle to the horizontal.
        boom_cos: f64 = 0.0, "N m", -1e7 to 1e7;
        /// With its sine.
        boom_sin: f64 = 0.0, "N m", -1e7 to 1e7;
        /// With the cosine of the arm's angle to the horizontal.
        arm_cos: f64 = 0.0, "N m", -1e7 to 1e7;
        /// With its sine.
        arm_sin: f64 = 0.0, "N m", -1e7 to 1e7;
        /// With the cosine of the bucket's angle to the horizontal.
        bucket_cos: f64 = 0.0, "N m", -1e7 to 1e7;
        /// With its sine.
        bucket_sin: f64 = 0.0, "N m", -1e7 to 1e7;
    }
}

table! {
    /// The sensors.
    pub struct Sensors, "sensors" {
        /// Samples per second.
        rate: f64 = 100.0, "Hz", 1.0 to 100000.0;
        /// Noise of the swing velocity (sigma_w).
        swing_velocity_std: f64 = 0.005, "rad/s", 1e-9 to 10.0;
        /// Noise of the swing angle, where an encoder serves in place of the velocity.
        swing_angle_std: f64 = 0.0005, "rad", 1e-12 to 1.0;
        /// Noise of the swing torque (sigma_T).
        swing_torque_std: f64 = 100.0, "N m", 1e-9 to 1e6;
        /// Standard deviation of the torque's gain about 1; "none" takes 0.05, or 0.03 where the boom's pressures weigh too. Nobody
        /// knows a gain exactly: 0 says that nothing is known of it and takes 0.05, but is meant with the variant "known", whose "none" is 0.
        swing_torque_gain_std: Option<f64> = None, "", 0.0 to 1.0;
        /// How late the torque comes.
        swing_torque_delay: f64 = 0.0, "s", 0.0 to 1.0;
        /// Its standard deviation.
        swing_torque_delay_std: f64 = 0.015, "s", 0.0 to 1.0;
        /// How late the swing velocity comes.
        swing_velocity_delay: f64 = 0.0, "s", 0.0 to 1.0;
        /// Its standard deviation.
        swing_velocity_delay_std: f64 = 0.015, "s", 0.0 to 1.0;
        /// Noise of the joint angles.
        angle_std: f64 = 0.001, "rad", 0.0 to 1.0;
        /// Standard deviation of the zero of a cylinder's pressure. White noise is negligible beside the friction of the seals.
        pressure_offset_std: f64 = 100e3, "Pa", 0.0 to 1e8;
        /// Standard deviation of the zero of a joint angle.
        angle_offset_std: f64 = 0.0087, "rad", 0.0 to 1.0;
        /// Boom angle that is measured where the true one is 0, as calibrated.
        boom_angle_offset: f64 = 0.0, "rad", -0.5 to 0.5;
        /// The same of the arm angle.
        arm_angle_offset: f64 = 0.0, "rad", -0.5 to 0.5;
        /// The same of the bucket angle.
        bucket_angle_offset: f64 = 0.0, "rad", -0.5 to 0.5;
        /// A velocity of this size or more is taken as missing (end of the sensor's range).
        swing_velocity_limit: f64 = 5.0, "rad/s", 1e-6 to 1e6;
        /// A joint angle of this size or more is taken as missing.
        angle_limit: f64 = core::f64::consts::TAU, "rad", 0.1 to 1000.0;
        /// Measured over true swing torque, as calibrated.
        swing_torque_gain: f64 = 1.0, "", 0.01 to 100.0;
        /// Swing torque that is measured where there is none, as calibrated.
        swing_torque_offset: f64 = 0.0, "N m", -1e6 to 1e6;
    }
}

table! {
    /// What is known before the first sample.
    pub struct Prior, "prior" {
        /// Swing inertia.
        inertia: f64 = 6500.0, "kg m^2", 1e-9 to 1e9;
        /// Its standard deviation.
        inertia_std: f64 = 1950.0, "kg m^2", 1e-12 to 1e9;
        /// Payload.
        payload: f64 = 200.0, "kg", -1e5 to 1e5;
        /// Its standard deviation.
        payload_std: f64 = 160.0, "kg", 1e-9 to 1e5;
        /// Carry-back: soil that sticks in an emptied bucket, as a share of the rated payload.
        carry_back: f64 = 0.035, "", 0.0 to 1.0;
        /// Its standard deviation: nothing to 15 % sticks, mostly little (an exponential distribution). Clay keeps .12 +- .06. From load to
        /// load the carry-back varies by 8/7 of it.
        carry_back_std: f64 = 0.035, "", 1e-4 to 1.0;
        /// Standard deviation of the damping about nominal_damping (s_b); 0 or the variant "known" say that it is calibrated.
        damping_std: f64 = 225.0, "N m s/rad", 0.0 to 1e7;
        /// Standard deviation of the torque offset (s_d).
        torque_offset_std: f64 = 60.0, "N m", 0.0 to 1e6;
        /// The same for the variant "known".
        known_torque_offset_std: f64 = 30.0, "N m", 0.0 to 1e6;
        /// Standard deviation of the Coulomb friction about coulomb_friction, where it is estimated.
        friction_std: f64 = 250.0, "N m", 0.0 to 1e6;
    }
}

table! {
    /// The estimators.
    pub struct Estimator, "estimator" {
        /// Natural frequency of the common second-order filter of velocity, torque and friction (wn).
        filter_frequency: f64 = 11.7, "rad/s", 0.01 to 1e5;
        /// Its damping ratio (zeta).
        filter_damping: f64 = 0.707, "", 0.1 to 10.0;
        /// Random walk of the acceleration in the Kalman filter, variance per second (q_c; q = q_c T).
        q_c: f64 = 0.0047, "rad^2/s^5", 1e-15 to 1e12;
        /// Convergence delay of the Kalman filter, the length of a change window; "none" computes it from the gain.
        convergence_delay: Option<f64> = None, "s", 0.0 to 100.0;
        /// Forgetting per sample, one factor or one per parameter; empty takes each method's own. A list replaces
        /// paper.lambda_normal and paper.lambda_window.
        forgetting: Numbers = Numbers::EMPTY, "", 0.0001 to 1.0;
        /// Nominal rule: distance of the estimated from the nominal damping at which it acts (Eqs. 28-29).
        epsilon: f64 = 27.0, "N m s/rad", 0.0 to 1e9;
        /// svf-rls estimates the viscous damping too.
        estimate_damping: bool = false, "";
        /// svf-rls estimates the Coulomb friction too.
        estimate_friction: bool = false, "";
        /// svf-rls estimates a torque offset too.
        estimate_offset: bool = false, "";
        /// The caller declares that the inertia does not change (mode A).
        constant_inertia: bool = false, "";
        /// What is assumed of damping, torque offset and payload.
        variant: Variant = Variant::Auto, "";
        /// Velocity over which the friction of the joint estimators changes sign.
        friction_width: f64 = 0.008, "rad/s", 1e-9 to 10.0;
        /// The same in svf-rls.
        svf_friction_width: f64 = 0.02, "rad/s", 1e-9 to 10.0;
        /// svf-rls learns above this filtered acceleration.
        svf_acceleration_min: f64 = 0.05, "rad/s^2", 0.0 to 1e6;
        /// Covariance of svf-rls at the start and its largest value.
        svf_covariance: f64 = 100.0, "", 1e-9 to 1e18;
        /// The torque enters as the mean of two samples, with variance (sigma_T / this)^2; 1, and not 1.41, since each
        /// sample is in two means.
        torque_noise_divisor: f64 = 1.0, "", 0.1 to 10.0;
        /// What the model of the torque leaves out, as a share of the largest torque seen (noise per 0.01 s); less or
        /// more of it is found from the innovations.
        torque_noise_share: f64 = 0.1, "", 0.0 to 1.0;
        /// Innovations beyond this many standard deviations are weakened.
        gate: f64 = 4.0, "", 1.0 to 1e6;
        /// Innovations beyond this many standard deviations are dropped, at most three in a row (modes C, A).
        reject: f64 = 5.0, "", 1.0 to 1e6;
        /// Smallest payload that an estimate may take.
        payload_min: f64 = -50.0, "kg", -1e5 to 1e5;
        /// Largest payload that an estimate may take.
        payload_max: f64 = 900.0, "kg", 0.0 to 1e5;
        /// Random walk of the payload: this times 1e-5 of the squared rated payload is its variance per second (q_m).
        q_m: f64 = 1.0, "", 0.0 to 1e9;
        /// Random walk of ln J, variance per second (q_l).
        q_l: f64 = 0.0225, "1/s", 0.0 to 1e3;
        /// Factor of the reported standard deviation of the method torque, variant "known" (c_I).
        interval_factor: f64 = 0.6, "", 0.1 to 10.0;
        /// Measures the velocity's bias over the first 0.5 s, if the machine stands then.
        calibrate_at_rest: bool = true, "";
        /// Measures the velocity's noise in the same time, within 1 to 4 times the described one.
        measure_noise_at_rest: bool = true, "";
        /// After a stand of this length the payload may be another.
        reopen_after: f64 = 0.5, "s", 0.0 to 1e6;
        /// Second, more sensitive detector of torque changes (modes C and A with constant inertia).
        weak_onset: bool = true, "";
        /// Bucket opening rate that announces a change of payload.
        opening_rate: f64 = 0.3490658503988659, "rad/s", 0.0 to 100.0;
        /// Share of the payload that leaves per angle of opening (1.4 per rad).
        opening_decay: f64 = 1.4, "1/rad", 0.0 to 100.0;
        /// Largest free change of payload per angle of opening.
        opening_change_max: f64 = 300.0, "kg/rad", 0.0 to 1e5;
        /// Free change of payload after an alarm and in the second filter.
        change_rate_std: f64 = 600.0, "kg/s", 0.0 to 1e5;
        /// Sum of normalised innovations at which a changed payload is declared.
        change_threshold: f64 = 10.0, "", 0.1 to 1e6;
        /// Random walk of the inertia in mode A, relative.
        velocity_drift: f64 = 0.2, "1/sqrt(s)", 0.0 to 10.0;
        /// The same with constant_inertia.
        velocity_drift_constant: f64 = 0.005, "1/sqrt(s)", 0.0 to 10.0;
        /// Random walk of the torque in mode A.
        velocity_torque_drift: f64 = 30.0, "N m/sqrt(s)", 0.0 to 1e6;
        /// The same with constant_inertia.
        velocity_torque_drift_constant: f64 = 10.0, "N m/sqrt(s)", 0.0 to 1e6;
        /// Verdict: excited at this velocity.
        excited_velocity: f64 = 0.10, "rad/s", 0.0 to 100.0;
        /// Verdict: consistent up to this mean of the normalised innovations squared.
        consistent_nis: f64 = 1.8, "", 0.1 to 16.0;
        /// Verdict: converged when the half width of the 95 % interval is below this share of J.
        converged_share: f64 = 0.10, "", 0.001 to 1.0;
        /// Verdict: fresh with a velocity at most this old.
        fresh_velocity: f64 = 0.10, "s", 1e-6 to 100.0;
        /// Verdict: fresh with torque and angles at most this old.
        fresh_others: f64 = 0.20, "s", 1e-6 to 100.0;
    }
}

table! {
    /// The regression of the paper, method multi-forgetting-rls.
    pub struct Paper, "estimator.paper" {
        /// Known times of torque changes; empty finds them online.
        change_times: Numbers = Numbers::EMPTY, "s", -1e12 to 1e12;
        /// Forgetting of inertia, damping and torque outside the change windows.
        lambda_normal: [f64; 3] = [0.99, 0.69, 0.1], "", 0.0001 to 1.0;
        /// Forgetting of the three inside the change windows.
        lambda_window: [f64; 3] = [0.99, 0.69, 0.1], "", 0.0001 to 1.0;
        /// Initial covariances of the three.
        covariance: [f64; 3] = [19.0, 6e6, 6e9], "", 1e-12 to 1e14;
        /// Initial torque (the initial inertia and damping are prior.inertia and machine.nominal_damping).
        torque: f64 = 2548.0, "N m", -1e7 to 1e7;
        /// The nominal-parameter rule for the damping is on.
        nominal_rule: bool = true, "";
        /// The regression begins at this time and runs through every standstill from then on; "none" begins with the data
        /// and holds at standstill.
        start_time: Option<f64> = None, "s", -1e12 to 1e12;
        /// The regression holds its estimate from this time on; "none" goes to the end.
        stop_time: Option<f64> = None, "s", -1e12 to 1e12;
    }
}

/// Description of an excavator.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Description {
    /// `[machine]`
    pub machine: Machine,
    /// `[machine.geometry]`
    pub geometry: Attachment,
    /// `[machine.boom_cylinder]`
    pub boom_cylinder: BoomCylinder,
    /// `[sensors]`
    pub sensors: Sensors,
    /// `[prior]`
    pub prior: Prior,
    /// `[estimator]`
    pub estimator: Estimator,
    /// `[estimator.paper]`
    pub paper: Paper,
    /// Whether the lengths of boom and arm are stated although they are those of the reference machine; no key.
    pub stated: [bool; 2],
}

impl Description {
    /// Keys that are all together at their defaults on the reference machine alone.
    pub const REFERENCE: &[&str] = &[
        "machine.geometry.boom_mass",
        "machine.geometry.arm_mass",
        "machine.upper_inertia",
    ];

    /// Notes that a key is stated, and whether at its default.
    pub fn note(&mut self, path: &str, is_default: bool) {
        let keys = [
            "machine.geometry.boom_length",
            "machine.geometry.arm_length",
        ];
        if let Some(at) = keys.iter().position(|key| *key == path) {
            self.stated[at] = is_default;
        }
    }

    /// The configuration that reproduces Table 1 of the paper on its own cycle: regression from
    /// 5.5 to 9.3 s, changes of torque known at 5.5 and 7.5 s, initial inertia as given (the
    /// figures are reached only by starting at the true one).
    #[must_use]
    pub fn paper_preset(inertia: f64) -> Self {
        let mut preset = Self::default();
        preset.prior.inertia = inertia;
        preset.estimator.calibrate_at_rest = false;
        preset.estimator.convergence_delay = Some(0.25);
        preset.paper.change_times = Numbers::new(&[5.5, 7.5]).unwrap_or(Numbers::EMPTY);
        preset.paper.start_time = Some(5.5);
        preset.paper.stop_time = Some(9.3);
        preset
    }
}
