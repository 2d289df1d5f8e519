//! The effects one at a time, at realistic severities, and together.

use super::effects::{Effects, PayloadReport};

const NONE: Effects = Effects {
    speed_delay: 0.0,
    spins: false,
    brakes: 0.0,
    brakes_reported: true,
    steering: 0.0,
    steering_reported: true,
    hinge: 0.0,
    locked_drive: false,
    slope_follows: 0.0,
    slope_lag: 0.0,
    gear_delay: 0.0,
    stiffness_difference: 0.0,
    stiffness_exponent: 0.0,
    radius_sensitivity: 0.0,
    braking_stiffness: 0.0,
    roughness: 0.0,
    rolling_resistance: 0.0,
    reverses: false,
    torque_gain: 0.0,
    rear_torque_gain: 0.0,
    speed_gain: 0.0,
    front_speed_gain: 0.0,
    torque_delay: 0.0,
    slope_bias: 0.0,
    acceleration_offset: 0.0,
    speed_period: 0.0,
    jitter: 0.0,
    mass_error: 0.0,
    radius_error: 0.0,
    payload_reported: PayloadReport::All,
};

/// Rows of name, severity in words, effects.
macro_rules! cases {
    ($( $name:literal $severity:literal: $( $effect:ident: $value:expr ),*; )*) => {
        [$( ($name, $severity, Effects { $( $effect: $value, )* ..NONE }) ),*]
    };
}

/// Deviations of working machines from their description: name, severity in words, effects. The first has none.
pub const CASES: [(&str, &str, Effects); 39] = cases! {
    "none" "":;
    "late speed" "30 ms": speed_delay: 0.03;
    "late speed" "100 ms": speed_delay: 0.1;
    "brakes" "20 %": brakes: 0.2;
    "brakes" "50 %": brakes: 0.5;
    "brakes, not stated" "50 %": brakes: 0.5, brakes_reported: false;
    "steering" "10 deg": steering: 0.175, hinge: 0.1;
    "steering" "20 deg": steering: 0.349, hinge: 0.1;
    "locked drive" "": locked_drive: true;
    "slope sensor follows" "30 %, 0.2 s": slope_follows: 0.3, slope_lag: 0.2;
    "gear changes late" "50 ms": gear_delay: 0.05;
    "stiffness of the axles" "10 %": stiffness_difference: 0.1;
    "stiffness falls with load" "p .2": stiffness_exponent: 0.2;
    "radius sensitivity" "+.005": radius_sensitivity: 0.005;
    "braking stiffness" "-10 %": braking_stiffness: -0.1;
    "braking stiffness" "+10 %": braking_stiffness: 0.1;
    "rough road" "ISO 8608 C": roughness: 256e-6;
    "rough road" "ISO 8608 D": roughness: 1024e-6;
    "rolling resistance" "+.03 in patches": rolling_resistance: 0.03;
    "reversing" "": reverses: true;
    "torque gain" "+6 %": torque_gain: 0.06;
    "torque gain" "-6 %": torque_gain: -0.06;
    "rear axle torque" "+20 %": rear_torque_gain: 0.2;
    "rear axle torque" "-15 %": rear_torque_gain: -0.15;
    "rear axle torque" "-30 %": rear_torque_gain: -0.3;
    "speed too low" "5 %": speed_gain: -0.05;
    "front wheel speed" "+10 %": front_speed_gain: 0.1;
    "late torque" "20 ms": torque_delay: 0.02;
    "slope bias" "4 deg": slope_bias: 0.07;
    "speed every" "200 ms": speed_period: 0.2;
    "jitter" "10 ms": jitter: 0.01;
    "mass" "+20 %": mass_error: 0.2;
    "mass" "-20 %": mass_error: -0.2;
    "radius" "+2 %": radius_error: 0.02;
    "radius" "-2 %": radius_error: -0.02;
    "reversing" "radius sensitivity -.005": reverses: true, radius_sensitivity: -0.005;
    "payload" "mass stated": payload_reported: PayloadReport::Mass;
    "payload" "not stated": payload_reported: PayloadReport::Nothing;
    "good machine" "all a little":
        speed_delay: 0.02, brakes: 0.15, steering: 0.12, hinge: 0.05, slope_follows: 0.1,
        slope_lag: 0.05, stiffness_difference: 0.03, stiffness_exponent: 0.05, radius_sensitivity: 0.001;
};
