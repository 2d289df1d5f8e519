//! Description of a wheel loader with independently driven axles. The defaults are those of the
//! 4.7 t reference machine (Yang, Wang, Han 2021, with the geometry that the paper leaves out).

use crate::keys::{choice, table};

choice! {
    /// Sign of the dynamic load transfer.
    pub enum LoadTransfer {
        /// Accelerating loads the rear axle.
        Physical = "physical",
        /// As printed in the paper, Eqs. (6), (7), (10), (11).
        Printed = "printed",
    }
}

choice! {
    /// Noise and protections of the methods with six states.
    pub enum Tuning {
        /// The configuration that reproduces the paper's conditions.
        Paper = "paper",
        /// The noises of this file, finite tyre friction, mid-point inputs, limits on.
        Tuned = "tuned",
    }
}

choice! {
    /// Which input drives the step from one row to the next.
    pub enum Inputs {
        /// Mid-point, but hold under the tuning "paper".
        Auto = "auto",
        /// Mean of the rows at both ends of the step.
        Midpoint = "midpoint",
        /// The row at the beginning of the step (zero-order hold).
        Hold = "hold",
    }
}

table! {
    /// The machine.
    pub struct Machine, "machine" {
        /// Mass, where the data do not carry one.
        mass: f64 = 4700.0, "kg", 1e-3 to 1e6;
        /// Rolling radius at the nominal axle load.
        wheel_radius: f64 = 0.55, "m", 0.01 to 10.0;
        /// Inertia of an axle with its wheels and drive, at the wheel.
        axle_inertia: f64 = 3.33, "kg m^2", 1e-6 to 1e6;
        /// Distance of the axles (l).
        wheelbase: f64 = 2.30, "m", 0.1 to 50.0;
        /// Front axle to bucket tip (l_c).
        bucket_reach: f64 = 1.70, "m", 0.0 to 50.0;
        /// Rolling resistance (f).
        rolling_resistance: f64 = 0.020, "", 0.0 to 1.0;
        /// Motor to wheel; used by the simulator, torques in the data are those at the wheel.
        gear_ratio: f64 = 20.0, "", 1e-3 to 1e4;
        /// Largest tyre force over axle load (mu); 0 leaves it unlimited.
        friction: f64 = 0.8, "", 0.0 to 10.0;
        /// Relative loss of rolling radius per relative axle load (rho).
        radius_load_sensitivity: f64 = 0.012, "", 0.0 to 0.2;
        /// Its standard deviation, from tyre to tyre where nobody measured it (anything between a rigid tyre and twice the usual one); widens the reported interval of the ratio until the machine has driven both ways.
        radius_load_sensitivity_std: f64 = 0.007, "", 0.0 to 0.2;
        /// Slip stiffness of the front axle over that of the rear under equal loads, as calibrated.
        stiffness_ratio: f64 = 1.0, "", 0.1 to 10.0;
        /// Standard deviation of the ratio of the axles' slip stiffnesses; widens the reported interval of the ratio.
        stiffness_ratio_std: f64 = 0.05, "", 0.0 to 1.0;
        /// p, where the slip stiffness falls with the load F_z as F_z^-p, as calibrated.
        stiffness_load_exponent: f64 = 0.0, "", -1.0 to 1.0;
        /// Standard deviation of p where the slip stiffness falls with the load F_z as F_z^-p; widens the reported interval of the height.
        stiffness_load_exponent_std: f64 = 0.2, "", 0.0 to 1.0;
        /// Relaxation length of the tyres; 0 for tyres that do not wind up.
        relaxation_length: f64 = 0.10, "m", 0.0 to 10.0;
    }
}

table! {
    /// The lift arm, which a cylinder pressure weighs. Lengths from its pivot; a standard deviation of 0 is that of a drawing: 1 % of a
    /// length, 5 % of the arm's mass, 20 % of the bucket's, 10 % of the load's distance. A mass or distance of 0 is a guess of the machine's size.
    pub struct LiftArm, "machine.lift_arm" {
        /// Pivot of the arm to the bucket's pin; 0 where no arm is described, and pressures are not used.
        length: f64 = 0.0, "m", 0.0 to 30.0;
        /// Its standard deviation.
        length_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// Pivot ahead of the front axle, negative behind it.
        pivot_x: f64 = 0.0, "m", -20.0 to 20.0;
        /// Its standard deviation.
        pivot_x_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// Pivot above the ground.
        pivot_z: f64 = 0.0, "m", 0.0 to 20.0;
        /// Its standard deviation.
        pivot_z_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// Mass of the arm; 0 for 6 % of the machine's, known to a quarter.
        mass: f64 = 0.0, "kg", 0.0 to 1e6;
        /// Its standard deviation.
        mass_std: f64 = 0.0, "kg", 0.0 to 1e6;
        /// Pivot to the arm's centre of mass; 0 for .54 of the length, known to 10 %.
        mass_distance: f64 = 0.0, "m", 0.0 to 30.0;
        /// Its standard deviation.
        mass_distance_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// Mass of the empty bucket; 0 for 6.5 % of the machine's, known to 40 %.
        bucket_mass: f64 = 0.0, "kg", 0.0 to 1e6;
        /// Its standard deviation.
        bucket_mass_std: f64 = 0.0, "kg", 0.0 to 1e6;
        /// Bucket's pin to the centre of the load, and of the bucket; 0 for .23 of the arm's length, known to a fifth.
        payload_distance: f64 = 0.0, "m", 0.0 to 10.0;
        /// Its standard deviation.
        payload_distance_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// How far the bucket turns with the arm while nobody tilts, in angles of the arm: 1 with the tilt cylinder on the arm; with the cylinder on the frame 0 for parallel lift, .1 to .3 for a Z-bar; "none" holds both cylinders for possible.
        bucket_turn: Option<f64> = None, "", -0.5 to 1.5;
        /// Its standard deviation; 0 for .05.
        bucket_turn_std: f64 = 0.0, "", 0.0 to 1.0;
        /// Arm angle at which the empty machine's centre of gravity is stated, up from the horizontal.
        reference_angle: f64 = 0.0, "rad", -1.6 to 1.6;
        /// Tilt angle at which it is stated, bucket to arm.
        reference_tilt: f64 = 0.0, "rad", -3.2 to 3.2;
        /// Mass of the empty machine; 0 for `machine.mass`.
        empty_mass: f64 = 0.0, "kg", 0.0 to 1e6;
        /// Its standard deviation; 0 for 2 % of it.
        empty_mass_std: f64 = 0.0, "kg", 0.0 to 1e6;
        /// Share of its weight on the front axle; 0 for `prior.cg_ratio`.
        empty_ratio: f64 = 0.0, "", 0.0 to 0.99;
        /// Its standard deviation; 0 for `prior.cg_ratio_std`.
        empty_ratio_std: f64 = 0.0, "", 0.0 to 1.0;
        /// Height of its centre of gravity; 0 for `prior.cg_height`.
        empty_height: f64 = 0.0, "m", 0.0 to 20.0;
        /// Its standard deviation; 0 for `prior.cg_height_std`.
        empty_height_std: f64 = 0.0, "m", 0.0 to 10.0;
        /// Moment about the pivot that the drawing misses: with the cosine of the arm's angle to the horizontal.
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
    /// The cylinders that lift the arm. A standard deviation of 0 is that of a drawing: 1 % of an area or a length, half of the friction.
    pub struct LiftCylinder, "machine.lift_arm.cylinder" {
        /// How many.
        count: f64 = 2.0, "", 1.0 to 8.0;
        /// Area of the head side of one.
        head_area: f64 = 0.0, "m^2", 0.0 to 1.0;
        /// Its standard deviation.
        head_area_std: f64 = 0.0, "m^2", 0.0 to 1.0;
        /// Area of the rod side of one.
        rod_area: f64 = 0.0, "m^2", 0.0 to 1.0;
        /// Its standard deviation.
        rod_area_std: f64 = 0.0, "m^2", 0.0 to 1.0;
        /// Base of the cylinder to the arm's pivot.
        base_distance: f64 = 0.0, "m", 0.0 to 10.0;
        /// Its standard deviation.
        base_distance_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// Arm's pivot to the eye of the rod.
        rod_distance: f64 = 0.0, "m", 0.0 to 10.0;
        /// Its standard deviation.
        rod_distance_std: f64 = 0.0, "m", 0.0 to 5.0;
        /// Angle between both at arm angle 0.
        angle: f64 = 1.3, "rad", -3.2 to 3.2;
        /// Its standard deviation.
        angle_std: f64 = 0.01, "rad", 0.0 to 1.0;
        /// Friction of the seals, as a share of the force of 20 MPa on the head side.
        friction: f64 = 0.03, "", 0.0 to 0.5;
        /// Its standard deviation.
        friction_std: f64 = 0.0, "", 0.0 to 0.5;
        /// Force that the pressures show too much, by the zeros of their sensors.
        force_offset: f64 = 0.0, "N", -1e6 to 1e6;
        /// Its standard deviation; 0 for that of the sensors' zeros.
        force_offset_std: f64 = 0.0, "N", 0.0 to 1e6;
        /// Relative standard deviation of the moment, as calibrated; 0 for those of areas, distances, angles and masses.
        span_std: f64 = 0.0, "", 0.0 to 0.5;
        /// Correlation of the errors of force offset and span.
        span_offset_correlation: f64 = 0.0, "", -1.0 to 1.0;
    }
}

table! {
    /// The sensors.
    pub struct Sensors, "sensors" {
        /// Samples per second.
        rate: f64 = 100.0, "Hz", 1.0 to 100000.0;
        /// Noise of the speed.
        speed_std: f64 = 0.02, "m/s", 1e-9 to 10.0;
        /// Noise of the wheel speeds.
        wheel_speed_std: f64 = 0.002, "rad/s", 1e-9 to 10.0;
        /// Noise of the slope.
        slope_std: f64 = 0.002, "rad", 1e-9 to 1.0;
        /// Noise of the specific force.
        acceleration_std: f64 = 0.05, "m/s^2", 1e-9 to 10.0;
        /// Specific force that the accelerometer shows where there is none (its zero, and gravity where it is mounted askew), as calibrated.
        acceleration_offset: f64 = 0.0, "m/s^2", -2.0 to 2.0;
        /// Its standard deviation; widens the reported interval of the ratio.
        acceleration_offset_std: f64 = 0.05, "m/s^2", 1e-9 to 10.0;
        /// Measured over true torque of the front axle, as calibrated.
        front_torque_gain: f64 = 1.0, "", 0.1 to 10.0;
        /// Measured over true torque of the rear axle, as calibrated.
        rear_torque_gain: f64 = 1.0, "", 0.1 to 10.0;
        /// Standard deviation of each axle's torque gain; widens the reported interval of the ratio.
        torque_gain_std: f64 = 0.005, "", 0.0 to 1.0;
        /// Delay of the speed against the other signals (satellite receivers, radars); `full` learns it.
        speed_delay: f64 = 0.0, "s", 0.0 to 1.0;
        /// Its standard deviation before the first row.
        speed_delay_std: f64 = 0.08, "s", 1e-6 to 1.0;
        /// Delay of the slope against the other signals: the time constant of an inclinometer, as calibrated.
        slope_delay: f64 = 0.0, "s", 0.0 to 10.0;
        /// Its standard deviation, from which a calibration starts; on line the errors of the slope show in the motion.
        slope_delay_std: f64 = 0.3, "s", 1e-6 to 10.0;
        /// Share of the acceleration that the slope sensor takes for a slope, as calibrated; acts where an accelerometer tells it.
        slope_acceleration_sensitivity: f64 = 0.0, "", 0.0 to 0.9;
        /// Its standard deviation, from which a calibration starts.
        slope_acceleration_sensitivity_std: f64 = 0.2, "", 1e-6 to 1.0;
        /// Noise of the cylinder pressures.
        pressure_std: f64 = 5e4, "Pa", 1.0 to 1e8;
        /// Standard deviation of the zero of each pressure sensor.
        pressure_offset_std: f64 = 1e5, "Pa", 0.0 to 1e8;
        /// Standard deviation of the gain of the cylinder pressures about 1: range, unit, what a sensor lost. A calibrated span holds it.
        pressure_gain_std: f64 = 0.03, "", 0.0 to 1.0;
        /// Standard deviation of the zeros of lift and tilt angle; 0.009 (half a degree) where somebody set them.
        angle_offset_std: f64 = 0.035, "rad", 0.0 to 1.0;
    }
}

table! {
    /// What is known before the first row. The deviations include the spread from machine to machine: K 2 and 1.5,
    /// height 0.10 and 0.08 m, ratio 0.05 and 0.03.
    pub struct Prior, "prior" {
        /// Slip stiffness (K).
        slip_stiffness: f64 = 19.0, "", 0.1 to 1000.0;
        /// Its standard deviation.
        slip_stiffness_std: f64 = 2.5, "", 1e-9 to 1000.0;
        /// Height of the centre of gravity (h).
        cg_height: f64 = 0.90, "m", 0.01 to 20.0;
        /// Its standard deviation.
        cg_height_std: f64 = 0.13, "m", 1e-9 to 10.0;
        /// Share of the static weight on the front axle (lambda).
        cg_ratio: f64 = 0.45, "", 0.01 to 0.99;
        /// Its standard deviation.
        cg_ratio_std: f64 = 0.06, "", 1e-9 to 1.0;
        /// Standard deviation of the speed at the start.
        speed_std: f64 = 0.05, "m/s", 1e-9 to 100.0;
        /// Standard deviation of the wheel speeds at the start.
        wheel_speed_std: f64 = 0.05, "rad/s", 1e-9 to 100.0;
        /// Standard deviation of the unmeasured spade force at the start.
        spade_force_std: f64 = 300.0, "N", 1e-9 to 1e6;
        /// Relative error of the front rolling radius, as calibrated.
        front_radius_error: f64 = 0.0, "", -0.2 to 0.2;
        /// Relative error of the rear rolling radius, as calibrated.
        rear_radius_error: f64 = 0.0, "", -0.2 to 0.2;
        /// Standard deviation of the relative radius errors at the start; 5e-4 when calibrated.
        radius_std: f64 = 0.005, "", 1e-12 to 0.5;
        /// Slope that the sensor shows on level ground, as calibrated.
        slope_bias: f64 = 0.0, "rad", -0.5 to 0.5;
        /// Standard deviation of the slope bias at the start.
        slope_bias_std: f64 = 0.01, "rad", 1e-12 to 1.0;
    }
}

table! {
    /// The estimators. The q_ keys are standard deviations per 10 ms of driving.
    pub struct Estimator, "estimator" {
        /// Sign of the dynamic load transfer.
        load_transfer: LoadTransfer = LoadTransfer::Physical, "";
        /// Configuration of the methods isr-ukf-printed, isr-ukf and ekf.
        tuning: Tuning = Tuning::Paper, "";
        /// Inputs of a step.
        inputs: Inputs = Inputs::Auto, "";
        /// Equal sub-steps per row.
        substeps: usize = 1, "", 1.0 to 1000.0;
        /// Spread of the sigma points (the tuning "paper" has 0.01).
        alpha: f64 = 0.3, "", 1e-4 to 10.0;
        /// Weight of the centre point in the covariance.
        beta: f64 = 2.0, "", -10.0 to 10.0;
        /// Second spread of the sigma points.
        kappa: f64 = 0.0, "", -5.0 to 100.0;
        /// Random walk of the speed.
        q_speed: f64 = 1e-4, "m/s", 0.0 to 10.0;
        /// Random walk of the wheel speeds.
        q_wheel_speed: f64 = 1e-3, "rad/s", 0.0 to 10.0;
        /// Random walk of the slip stiffness.
        q_slip_stiffness: f64 = 3e-4, "", 0.0 to 100.0;
        /// Random walk of the height.
        q_cg_height: f64 = 3e-5, "m", 0.0 to 1.0;
        /// Random walk of the ratio.
        q_cg_ratio: f64 = 3e-5, "", 0.0 to 1.0;
        /// Random walk of the unmeasured spade force.
        q_spade_force: f64 = 150.0, "N", 0.0 to 1e6;
        /// Random walk of the radius errors.
        q_radius: f64 = 1e-7, "", 0.0 to 1.0;
        /// Least random walk of the slope bias; errors of the slope that the motion shows add to it.
        q_slope_bias: f64 = 3e-5, "rad", 0.0 to 1.0;
        /// Random walk of the delay of the speed.
        q_speed_delay: f64 = 1e-5, "s", 0.0 to 1.0;
        /// Smallest speed in a slip denominator.
        v_min: f64 = 0.30, "m/s", 1e-3 to 10.0;
        /// Parameters are frozen below this speed.
        v_freeze: f64 = 0.5, "m/s", 0.0 to 10.0;
        /// Wheel-speed noise from axle-load ripple acting through the slip, share of the slip (cb).
        c_b: f64 = 0.05, "", 0.0 to 10.0;
        /// Wheel-speed noise from axle-load ripple acting through the radius (crho).
        c_rho: f64 = 0.05, "", 0.0 to 10.0;
        /// Wheel-speed noise from changes of torque (ct).
        c_t: f64 = 2.0, "", 0.0 to 10.0;
        /// Innovations beyond this many standard deviations are weakened.
        gate: f64 = 5.0, "", 1.0 to 1e6;
        /// Innovations beyond this many standard deviations are dropped.
        reject: f64 = 20.0, "", 1.0 to 1e9;
        /// Smallest slip stiffness.
        slip_stiffness_min: f64 = 4.0, "", 0.01 to 1000.0;
        /// Largest slip stiffness.
        slip_stiffness_max: f64 = 80.0, "", 0.01 to 1e4;
        /// Smallest height.
        cg_height_min: f64 = 0.3, "m", 0.0 to 20.0;
        /// Largest height.
        cg_height_max: f64 = 2.5, "m", 0.01 to 20.0;
        /// Smallest ratio.
        cg_ratio_min: f64 = 0.1, "", 0.0 to 1.0;
        /// Largest ratio.
        cg_ratio_max: f64 = 0.9, "", 0.0 to 1.0;
        /// Mean normalised innovation squared at which the filter is reset.
        reset_nis: f64 = 6.0, "", 1.0 to 1e6;
        /// A longer step between rows is a gap: speed and wheel speeds are taken anew.
        gap: f64 = 0.25, "s", 1e-3 to 1e3;
        /// Spade force that means digging; parameters are frozen.
        dig_force: f64 = 2500.0, "N", 0.0 to 1e7;
        /// Digging lasts at least this long.
        dig_hold: f64 = 0.5, "s", 0.0 to 100.0;
        /// Height and ratio are reopened after digging to this many prior standard deviations; 0 leaves them.
        reopen: f64 = 2.0, "", 0.0 to 100.0;
        /// Once the ratio is known the parameters are loosened, because the start was linearised at the initial guess: share
        /// of the prior that comes back per squared standard deviation of way; 0 is off.
        relearn: f64 = 0.02, "", 0.0 to 100.0;
        /// The boom moves: random walks of height and ratio times this.
        boom_gain: f64 = 40.0, "", 0.0 to 1e4;
        /// What cannot be learnt of the height; added to its reported standard deviation.
        cg_height_floor: f64 = 0.04, "m", 0.0 to 10.0;
        /// What cannot be learnt of the ratio, relative; added to its reported standard deviation.
        cg_ratio_floor: f64 = 0.011, "", 0.0 to 1.0;
        /// Least error of the load sensitivity of the rolling radius that counts, whatever is stated; 0 when calibrated.
        load_sensitivity_floor: f64 = 0.002, "", 0.0 to 0.2;
        /// Verdict: the ratio is excited when the torque varies by this (standard deviation over 5 s).
        excited_torque: f64 = 300.0, "N m", 0.0 to 1e6;
        /// Verdict: the height is excited when the acceleration varies by this.
        excited_acceleration: f64 = 0.3, "m/s^2", 0.0 to 100.0;
        /// Verdict: fresh with every needed input at most this old.
        fresh: f64 = 0.25, "s", 1e-3 to 100.0;
        /// Verdict: consistent up to this mean normalised innovation squared.
        consistent_nis: f64 = 2.0, "", 0.1 to 100.0;
        /// Verdict: the ratio has converged at this relative standard deviation.
        converged_ratio: f64 = 0.05, "", 1e-4 to 1.0;
        /// Verdict: the height has converged at this standard deviation.
        converged_height: f64 = 0.08, "m", 1e-4 to 10.0;
    }
}

/// Description of a wheel loader.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Description {
    /// `[machine]`
    pub machine: Machine,
    /// `[machine.lift_arm]`
    pub lift_arm: LiftArm,
    /// `[machine.lift_arm.cylinder]`
    pub lift_cylinder: LiftCylinder,
    /// `[sensors]`
    pub sensors: Sensors,
    /// `[prior]`
    pub prior: Prior,
    /// `[estimator]`
    pub estimator: Estimator,
    /// Whether wheel radius and height of the centre of gravity are stated although they are those of the reference machine; no key.
    pub stated: [bool; 2],
}

impl Description {
    /// Keys that are all together at their defaults on the reference machine alone.
    pub const REFERENCE: &[&str] = &[
        "machine.wheelbase",
        "machine.wheel_radius",
        "machine.bucket_reach",
        "machine.axle_inertia",
    ];
    /// Mass of the reference machine \[kg\].
    pub const REFERENCE_MASS: f64 = Machine::DEFAULT.mass;

    /// Notes that a key is stated, and whether at its default.
    pub fn note(&mut self, path: &str, is_default: bool) {
        let keys = ["machine.wheel_radius", "prior.cg_height"];
        if let Some(at) = keys.iter().position(|key| *key == path) {
            self.stated[at] = is_default;
        }
    }
}
