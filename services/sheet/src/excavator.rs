//! Tables of the excavator: sensor signals, and flags, quantities, reasons and methods of its estimates.

/// Passes the signals to the macro `$then`: bit, name of the bit, name, place in a `Sample` of `estimation`, unit,
/// meaning with sign, presence.
/// The message has the numbers of `first` before its bit fields and those of `later` after them. A new signal goes to the end of `later`,
/// with the next free bit. `switches` have a bit and no number.
#[macro_export]
macro_rules! excavator_signals {
    ($then:ident) => {
        $then! {
            first {
                0 SWING_VELOCITY swing_velocity (velocity) "rad/s" "Swing rate, positive anticlockwise from above." OneOf;
                1 SWING_ANGLE swing_angle (angle) "rad" "Swing angle, same sign." OneOf;
                2 SWING_TORQUE swing_torque (torque) "N m" "Swing torque at the upper body, positive in the direction of positive motion." Observed;
                3 BOOM_ANGLE boom_angle (posture[0]) "rad" "Boom angle to the horizontal, up positive." Observed;
                4 ARM_ANGLE arm_angle (posture[1]) "rad" "Arm angle relative to the boom." Observed;
                5 BUCKET_ANGLE bucket_angle (posture[2]) "rad" "Bucket angle relative to the arm." Observed;
            }
            later {
                6 PITCH pitch (inclination[0]) "rad" "Pitch of the upper body, nose up positive." Observed;
                7 ROLL roll (inclination[1]) "rad" "Roll of the upper body, left side low positive." Observed;
                8 BOOM_HEAD_PRESSURE boom_head_pressure (boom_head_pressure) "Pa" "Pressure at the head side of the boom cylinders, their mean." Observed;
                9 BOOM_ROD_PRESSURE boom_rod_pressure (boom_rod_pressure) "Pa" "Pressure at the rod side of the boom cylinders, their mean." Observed;
                10 ARM_HEAD_PRESSURE arm_head_pressure (arm_head_pressure) "Pa" "Pressure at the head side of the arm cylinder." Observed;
                11 ARM_ROD_PRESSURE arm_rod_pressure (arm_rod_pressure) "Pa" "Pressure at the rod side of the arm cylinder." Observed;
                12 TRUCK truck (truck) "" "Number of the truck that is loaded; another number begins the next truck." Observed;
            }
            switches {
            }
        }
    };
}

/// Passes the flags to the macro `$then`: bit, name of the bit, name, place in an estimate of `estimation`, meaning, other
/// fields of [`Flag`]. The flags of `process` are set by the process that runs the estimator.
#[macro_export]
macro_rules! excavator_flags {
    ($then:ident) => {
        $then! {
            estimator {
                0 EXCITED excited (flags.excited) "The motion carries information about the inertia." { column: true, frame: Some(1) };
                1 CONSISTENT consistent (flags.consistent) "Innovations agree with their predicted size." { column: true, frame: Some(2) };
                2 FRESH fresh (flags.fresh) "Inputs are recent and complete." { column: true, frame: Some(3) };
                3 CONVERGED converged (flags.converged) "The interval is narrower than the stated limit." { column: true, frame: Some(4) };
                4 IDENTIFIABLE identifiable (flags.identifiable) "These inputs can determine the inertia at all." { column: true, frame: Some(5) };
                5 HELD held (flags.held) "Standstill: the estimate is held." { column: true };
                6 CHANGING changing (flags.changing) "The payload is changing." { column: true, frame: Some(6) };
                7 RESET reset (flags.reset) "The filter was reset at this sample." { column: true };
                8 TRUSTED trusted (flags.trusted()) "The estimate may be believed: excited, consistent, fresh, converged and identifiable, the payload not changing, the row not refused." { column: true, frame: Some(0) };
                9 NOMINAL nominal (flags.nominal) "Paper mode: the nominal-parameter rule acted (Eqs. 28-29)." {};
                10 WINDOW window (flags.window) "Paper mode: inside a change window (section 3.5)." {};
                11 REFUSED refused (flags.refused) "The row was refused (time not increasing or not finite); the state is untouched." {};
            }
            process {
                12 RESTARTED restarted "The service was started again and has not been trusted since." {};
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
macro_rules! excavator_quantities {
    ($then:ident) => {
        $then! {
            estimated {
                0 DAMPING damping (damping.is_some()) "Damping.";
                1 TORQUE torque (torque.is_some()) "Torque.";
                2 PAYLOAD payload (payload.is_some()) "Payload.";
                3 FRICTION friction (friction.is_some()) "Coulomb friction.";
                4 OFFSET offset (offset.is_some()) "Torque offset.";
                5 INERTIA inertia () "Inertia (every method has it; 0 until the first accepted row).";
                6 ACCELERATION acceleration () "Acceleration.";
            }
            first {
                inertia (inertia) [inertia_std (inertia_std)] "kg m^2" "Swing inertia." {
                    estimated: INERTIA, trusted: TRUSTED, is_headline: true, shown: 1, label: "Swing inertia", symbol: "J", range: POSITIVE,
                    column: Column::Always, frame: frame("inertia", 0xff10, 0.1, 0.0)
                };
                damping (damping.unwrap_or_default().value) [damping_std (damping.unwrap_or_default().std)] "N m s/rad" "Viscous damping." {
                    estimated: DAMPING, trusted: TRUSTED, shown: 4, label: "Damping", range: POSITIVE, is_of_machine: true,
                    column: Column::Always, frame: frame("damping", 0xff12, 0.1, 0.0),
                    kept: Some(["machine.nominal_damping", "prior.damping_std"])
                };
                torque (torque.unwrap_or_default().value) [torque_std (torque.unwrap_or_default().std)] "N m" "Torque." {
                    estimated: TORQUE, shown: 3, label: "Torque", column: Column::Always
                };
                payload (payload.unwrap_or_default().value) [payload_std (payload.unwrap_or_default().std)] "kg" "Payload." {
                    estimated: PAYLOAD, trusted: TRUSTED, shown: 2, label: "Payload", range: POSITIVE, is_load: true,
                    column: Column::Always, frame: frame("payload", 0xff11, 0.01, -1e6)
                };
                velocity (velocity) [] "rad/s" "Swing velocity." { shown: 7, label: "Swing velocity", column: Column::Always };
                acceleration (acceleration) [] "rad/s^2" "Swing acceleration." {
                    estimated: ACCELERATION, shown: 8, label: "Swing acceleration", column: Column::Always
                };
                friction (friction.unwrap_or_default().value) [friction_std (friction.unwrap_or_default().std)] "N m" "Coulomb friction torque." {
                    estimated: FRICTION, shown: 5, label: "Coulomb friction", range: POSITIVE, column: Column::Last
                };
                offset (offset.unwrap_or_default().value) [offset_std (offset.unwrap_or_default().std)] "N m" "Torque offset." {
                    estimated: OFFSET, shown: 6, label: "Torque offset", column: Column::Last
                };
                nis (nis) [] "" "Normalised innovation squared of this sample, 0 where none was accepted." {};
                forgetting_inertia (forgetting[0]) [] "" "Forgetting factor of the inertia (regressions; else 0)." {};
                forgetting_damping (forgetting[1]) [] "" "Forgetting factor of the damping." {};
                forgetting_torque (forgetting[2]) [] "" "Forgetting factor of the torque." {};
            }
            later {
            }
        }
    };
}

/// Passes the reasons to the macro `$then`: code, variant, name in every output, words. The meaning of a code never changes.
#[macro_export]
macro_rules! excavator_reasons {
    ($then:ident) => {
        $then! {
            0 None "" "";
            1 Slope "slope" "the ground seems inclined";
            2 Loss "losses" "the swing drive seems to lose torque";
            3 Friction "friction" "the friction differs from that of the machine file";
            4 Gain "gain" "the torque reads too high or too low by a factor";
            5 Delay "delay" "velocity and torque do not arrive together";
            6 Offset "offset" "the torque seems to have an offset";
            7 Damping "damping" "the damping differs from that of the machine file";
            8 Unexplained "unexplained" "the motion does not follow the model";
            9 Disagreement "disagreement" "swings disagree by more than they claim";
            10 Limit "limit" "the estimate is at the end of its range";
            11 Content "content" "the bucket's content may have changed";
            12 Frozen "frozen" "a sensor repeats one value";
            13 Sign "sign" "a sensor seems to have the other sign";
            14 Method "method" "this method cannot determine the inertia of an uncalibrated machine";
            15 Restarted "restarted" "the service was started again";
            16 Jump "jump" "a joint angle has jumped further than a joint moves";
            17 Contradiction "contradiction" "an emptied bucket or the friction contradicts what a sensor says";
            18 Hanging "hanging" "the load hangs or swings";
            19 Attachment "attachment" "the bucket's mass differs from that of the machine file";
        }
    };
}

/// Passes the methods to the macro `$then`, the default first: index, variant, name, meaning.
#[macro_export]
macro_rules! excavator_methods {
    ($then:ident) => {
        $then! {
            0 Auto "auto" "By the columns that exist.";
            1 MultiForgettingRls "multi-forgetting-rls" "The paper: velocity only, multiple forgetting.";
            2 SvfRls "svf-rls" "Measured torque, both sides equally filtered.";
            3 PostureTorque "posture-torque" "Torque and posture: inertia and payload (D).";
            4 Torque "torque" "Torque, momentum form (BM).";
            5 Posture "posture" "Posture, torque unknown but constant for a while (C).";
            6 Velocity "velocity" "Velocity and nominal damping only (A).";
        }
    };
}

/// Groups of required signals: a machine must have one of each group.
pub const REQUIRED: &[&[&str]] = &[&["swing_velocity", "swing_angle"]];

/// Defaults of the fields that a row does not set.
const EVERY: Quantity = Quantity {
    excited: bits::EXCITED,
    ..Quantity::NONE
};

/// First parameter group number of the frames of its loads.
pub const LOADS_GROUP: u16 = 0xff18;

/// Its CAN frame of the verdict.
pub const VERDICT_FRAME: VerdictFrame = VerdictFrame {
    group: 0xff1f,
    simulated: 7,
};

tables!(
    excavator_signals,
    excavator_flags,
    excavator_quantities,
    excavator_reasons,
    excavator_methods
);
