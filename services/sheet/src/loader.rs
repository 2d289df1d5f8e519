//! Tables of the wheel loader: sensor signals, and flags, quantities, reasons and methods of its estimates.

/// Passes the signals to the macro `$then`: bit, name of the bit, name, place in a `Sample` of `estimation`, unit,
/// meaning with sign, presence.
/// The message has the numbers of `first` before its bit fields and those of `later` after them. A new signal goes to the end of `later`,
/// with the next free bit. `switches` have a bit and no number.
#[macro_export]
macro_rules! loader_signals {
    ($then:ident) => {
        $then! {
            first {
                0 SPEED speed (speed) "m/s" "Forward speed of the body." Required;
                1 FRONT_WHEEL_SPEED front_wheel_speed (front_wheel_speed) "rad/s" "Speed of the front wheels." Required;
                2 REAR_WHEEL_SPEED rear_wheel_speed (rear_wheel_speed) "rad/s" "Speed of the rear wheels." Required;
                3 FRONT_TORQUE front_torque (front_torque) "N m" "Front axle torque at the wheels, total." Required;
                4 REAR_TORQUE rear_torque (rear_torque) "N m" "Rear axle torque at the wheels, total." Required;
                5 SLOPE slope (slope) "rad" "Slope of the frame, nose up positive, in reverse too." Required;
                6 ACCELERATION acceleration (acceleration) "m/s^2" "Specific force along the body axis, dv/dt + g sin(slope)." Declared;
                7 MASS mass (mass) "kg" "Mass of the machine with its load." Declared;
                8 SPADE_FORCE_X spade_force_x (spade_force_x) "N" "Force on the bucket tip that pushes the machine backward." Declared;
                9 SPADE_FORCE_Z spade_force_z (spade_force_z) "N" "Force on the bucket tip that pushes the machine down." Declared;
                11 ARTICULATION articulation (articulation) "rad" "Angle between front and rear body, positive when the machine turns left." Declared;
                12 YAW_RATE yaw_rate (yaw_rate) "rad/s" "Yaw rate of the rear body, positive anticlockwise from above." Declared;
            }
            later {
                14 LIFT_ANGLE lift_angle (lift_angle) "rad" "Angle of the lift arm to the machine's frame, 0 where it is level on level ground, up positive." Observed;
                15 TILT_ANGLE tilt_angle (tilt_angle) "rad" "Angle of the bucket relative to the lift arm, tip up positive." Observed;
                16 LIFT_HEAD_PRESSURE lift_head_pressure (lift_head_pressure) "Pa" "Pressure at the head side of the lift cylinders, their mean." Observed;
                17 LIFT_ROD_PRESSURE lift_rod_pressure (lift_rod_pressure) "Pa" "Pressure at the rod side of the lift cylinders, their mean." Observed;
                18 TRUCK truck (truck) "" "Number of the truck that is loaded; another number begins the next truck." Observed;
            }
            switches {
                10 BOOM_MOVING boom_moving (boom_moving) "" "The boom moves: a payload may be taken up or set down." Declared;
                13 BRAKE brake (brake) "" "Friction brakes act." Declared;
            }
        }
    };
}

/// Passes the flags to the macro `$then`: bit, name of the bit, name, place in an estimate of `estimation`, meaning, other
/// fields of [`Flag`]. The flags of `process` are set by the process that runs the estimator.
#[macro_export]
macro_rules! loader_flags {
    ($then:ident) => {
        $then! {
            estimator {
                0 EXCITED_RATIO excited_ratio (excited_ratio) "The motion carries information about the ratio." { column: true, frame: Some(2) };
                1 EXCITED_HEIGHT excited_height (excited_height) "The motion carries information about the height." { column: true, frame: Some(3) };
                2 CONSISTENT consistent (consistent) "Innovations agree with their predicted size." { column: true, frame: Some(4) };
                3 FRESH fresh (fresh) "Inputs are recent and complete." { column: true, frame: Some(5) };
                4 CONVERGED_RATIO converged_ratio (converged_ratio) "The interval of the ratio is narrower than the stated limit." { column: true, frame: Some(6) };
                5 CONVERGED_HEIGHT converged_height (converged_height) "The interval of the height is narrower than the stated limit." { column: true, frame: Some(7) };
                6 FROZEN frozen (frozen) "Parameters are frozen (low speed, digging)." { column: true };
                7 RESET reset (reset) "A reset happened within the last 2 s." { column: true };
                8 TRUSTED_RATIO trusted_ratio (trusted_ratio) "The ratio may be believed." { column: true, frame: Some(0) };
                9 TRUSTED_HEIGHT trusted_height (trusted_height) "The height may be believed." { column: true, frame: Some(1) };
                10 REFUSED refused (is_refused()) "The row was refused (time not increasing or not finite); the state is untouched." {};
                11 DIVERGED diverged (has_diverged()) "The filter diverged (only methods without protection)." {};
                12 IDENTIFIABLE_RATIO identifiable_ratio (identifiable_ratio) "These inputs can determine the ratio, and it is not at a bound." { frame: Some(8) };
                13 IDENTIFIABLE_HEIGHT identifiable_height (identifiable_height) "These inputs can determine the height, and it is not at a bound." { frame: Some(9) };
                15 TRUSTED_PAYLOAD trusted_payload (trusted_payload) "The payload may be believed." { column: true, frame: Some(11) };
                16 CHANGING changing (changing) "The load may be changing, whatever else is the reason; a bucket on the ground does not count." {};
                17 OF_EMPTY of_empty (of_empty) "Ratio and height are those of the empty machine with its arm at the reference: it is known that no load is in the bucket." {};
            }
            process {
                14 RESTARTED restarted "The service was started again and has not been trusted since." {};
            }
        }
    };
}

/// Passes the contents of the estimates to the macro `$then`, in three blocks.
/// `estimated`: bit, name of the bit, name, condition on an estimate of `estimation`, meaning. Without a condition the bit is set
/// from the first accepted row on.
/// `first` and `later`: name and place in the estimate, the same of the standard deviation, unit, meaning, other fields of [`Quantity`].
/// The message has `first` before its bit fields and `later` after them. A new quantity goes to the end of `later`.
#[macro_export]
macro_rules! loader_quantities {
    ($then:ident) => {
        $then! {
            estimated {
                0 STATE state () "Speed, wheel speeds, slip stiffness, height, ratio (0 until the first accepted row).";
                1 ESTIMATED_SPADE_FORCE_X spade_force_x (spade_force_x.is_some()) "Horizontal spade force.";
                2 SLOPE_BIAS slope_bias (slope_bias.is_some()) "Slope bias.";
                3 RADIUS_SCALES radius_scales (front_radius_scale.is_some()) "Rolling-radius scales.";
                4 SPEED_DELAY speed_delay (speed_delay.is_some()) "Delay of the speed.";
                5 PAYLOAD payload (payload.is_some()) "Payload.";
            }
            first {
                speed (speed) [] "m/s" "Forward speed." {
                    estimated: STATE, shown: 6, label: "Speed", column: Column::Always
                };
                front_wheel_speed (front_wheel_speed) [] "rad/s" "Speed of the front wheels." {
                    estimated: STATE, column: Column::Always
                };
                rear_wheel_speed (rear_wheel_speed) [] "rad/s" "Speed of the rear wheels." {
                    estimated: STATE, column: Column::Always
                };
                slip_stiffness (slip_stiffness.value) [slip_stiffness_std (slip_stiffness.std)] "" "Slip stiffness of the tyres, F_x = K slip F_z." {
                    estimated: STATE, trusted: TRUSTED_RATIO, shown: 4, label: "Tyre slip stiffness", range: POSITIVE, is_of_machine: true,
                    column: Column::Always, kept: Some(["prior.slip_stiffness", "prior.slip_stiffness_std"])
                };
                cg_height (cg_height.value) [cg_height_std (cg_height.std)] "m" "Height of the centre of gravity above ground." {
                    estimated: STATE, trusted: TRUSTED_HEIGHT, excited: EXCITED_HEIGHT, is_headline: true,
                    shown: 2, label: "Height of the centre of gravity", symbol: "h", range: POSITIVE,
                    column: Column::Always, frame: frame("height", 0xff21, 1e-5, 0.0),
                    kept: Some(["prior.cg_height", "prior.cg_height_std"]), kept_while: OF_EMPTY
                };
                cg_ratio (cg_ratio.value) [cg_ratio_std (cg_ratio.std)] "" "Share of the static weight on the front axle." {
                    estimated: STATE, trusted: TRUSTED_RATIO, is_headline: true,
                    shown: 1, label: "Front-axle load fraction", symbol: "λ", range: (0.0, 1.0),
                    column: Column::Always, frame: frame("ratio", 0xff20, 1e-6, 0.0),
                    kept: Some(["prior.cg_ratio", "prior.cg_ratio_std"]), kept_while: OF_EMPTY
                };
                cg_distance (cg_distance) [] "m" "Distance from the front axle to the centre of gravity." {
                    estimated: STATE, column: Column::Always
                };
                spade_force_x (spade_force_x.unwrap_or_default().value) [spade_force_x_std (spade_force_x.unwrap_or_default().std)] "N" "Horizontal spade force, measured plus unknown." {
                    estimated: ESTIMATED_SPADE_FORCE_X, shown: 5, label: "Horizontal bucket force", column: Column::Always
                };
                slope_bias (slope_bias.unwrap_or_default()) [] "rad" "Bias of the slope sensor (true slope = measured - bias)." {
                    estimated: SLOPE_BIAS, shown: 7, label: "Bias of the slope sensor", column: Column::Always
                };
                front_radius_scale (front_radius_scale.unwrap_or_default()) [] "" "Rolling radius of the front wheels over its nominal value." {
                    estimated: RADIUS_SCALES, shown: 8, label: "Front rolling radius over nominal", range: POSITIVE, column: Column::Always
                };
                rear_radius_scale (rear_radius_scale.unwrap_or_default()) [] "" "Rolling radius of the rear wheels over its nominal value." {
                    estimated: RADIUS_SCALES, shown: 9, label: "Rear rolling radius over nominal", range: POSITIVE, column: Column::Always
                };
                nis (nis) [] "" "Normalised innovation squared of this sample per accepted measurement." { column: Column::Always };
                speed_delay (speed_delay.unwrap_or_default().value) [speed_delay_std (speed_delay.unwrap_or_default().std)] "s" "Delay of the measured speed." {
                    estimated: SPEED_DELAY
                };
            }
            later {
                payload (payload.unwrap_or_default().value) [payload_std (payload.unwrap_or_default().std)] "kg" "Payload." {
                    estimated: PAYLOAD, trusted: TRUSTED_PAYLOAD, shown: 3, label: "Payload", range: POSITIVE, is_load: true,
                    column: Column::Last, frame: frame("payload", 0xff22, 0.01, -1e6)
                };
            }
        }
    };
}

/// Passes the reasons to the macro `$then`: code, variant, name in every output, words. The meaning of a code never changes.
#[macro_export]
macro_rules! loader_reasons {
    ($then:ident) => {
        $then! {
            0 None "" "";
            1 Missing "missing" "an input is missing or too old";
            2 StuckSpeed "stuck speed" "the speed never changes";
            3 StuckFrontWheel "stuck front wheel" "the front wheel speed never changes";
            4 StuckRearWheel "stuck rear wheel" "the rear wheel speed never changes";
            5 StuckFrontTorque "stuck front torque" "the front torque never changes";
            6 StuckRearTorque "stuck rear torque" "the rear torque never changes";
            7 StuckSlope "stuck slope" "the slope never changes";
            8 StuckAcceleration "stuck acceleration" "the acceleration never changes";
            9 Unexplained "unexplained" "the motion does not follow the model";
            10 Latency "latency" "the speed arrives later than a sensor may";
            11 Stiffness "stiffness" "the slip stiffness is implausible for a tyre";
            12 Brakes "brakes" "friction brakes seem to act";
            13 Steering "steering" "the machine turns";
            14 Slope "slope" "the slope does not fit the motion";
            15 Torque "torque" "the torques do not fit the motion and the mass";
            16 Load "load" "the load may have changed";
            17 Disagreement "disagreement" "manoeuvres disagree by more than they claim";
            18 AtLimit "limit" "an estimate is at its limit";
            19 Restarted "restarted" "the service was started again";
            20 Locked "locked drive" "both axles turn alike: the reported axle torques are not theirs";
            21 OneWay "one way" "driven one way only: how the tyres give under a load is not known";
            22 Radius "wheel radius" "speed and wheel speeds do not fit the rolling radius that is described";
            23 LiftCylinder "lift cylinder" "the lift cylinder shows a weight that no bucket holds, or that does not fit emptied buckets or the load's motion";
            24 Accelerometer "accelerometer" "no accelerometer tells the slope from the acceleration";
        }
    };
}

/// Passes the methods to the macro `$then`, the default first: index, variant, name, meaning.
#[macro_export]
macro_rules! loader_methods {
    ($then:ident) => {
        $then! {
            0 Full "full" "12 states by sigma points, protected against bad input: the product. They include rolling radii, their load sensitivity, unknown bucket force, slope bias and delay of the speed. Without an accelerometer there are 9.";
            1 IsrUkfPrinted "isr-ukf-printed" "The improved square-root UKF with 6 states exactly as Yang, Wang, Han 2021 print it.";
            2 IsrUkf "isr-ukf" "The same 6 states with gain and covariance that agree with each other.";
            3 Ekf "ekf" "The extended Kalman filter on the same 6 states.";
            4 FullEkf "full-ekf" "`full` by the model's tangent: an extended Kalman filter of the same states, noise, conditions and verdict, at a fourth of the cost.";
        }
    };
}

/// Groups of required signals: a machine must have one of each group.
pub const REQUIRED: &[&[&str]] = &[
    &["speed"],
    &["front_wheel_speed"],
    &["rear_wheel_speed"],
    &["front_torque"],
    &["rear_torque"],
    &["slope"],
];

/// Defaults of the fields that a row does not set.
const EVERY: Quantity = Quantity {
    excited: bits::EXCITED_RATIO,
    ..Quantity::NONE
};

/// First parameter group number of the frames of its loads.
pub const LOADS_GROUP: u16 = 0xff28;

/// Its CAN frame of the verdict.
pub const VERDICT_FRAME: VerdictFrame = VerdictFrame {
    group: 0xff2f,
    simulated: 10,
};

tables!(
    loader_signals,
    loader_flags,
    loader_quantities,
    loader_reasons,
    loader_methods
);
