//! The effects one at a time, at realistic severities, and together.

use super::effects::Effects;

/// These effects only.
macro_rules! only {
    ($( $effect:ident: $value:expr ),*) => { Effects { $( $effect: $value, )* ..Effects::default() } };
}

/// Deviations of working machines from their description: name, severity in words, effects. The first has none.
pub fn cases() -> Vec<(&'static str, &'static str, Effects)> {
    let none = Effects::default();
    let slope = |degrees: f64| only!(slope: degrees.to_radians());
    let inclined = |degrees: f64| Effects {
        inclinometer: true,
        ..slope(degrees)
    };
    let efficiency = |x| only!(efficiency: x);
    let gain = |x| only!(torque_gain: x);
    let lag = |x| only!(torque_lag: x);
    let late = |x| only!(gyro_delay: x);
    let friction = |x| only!(friction: x);
    let boom = |x| only!(boom_mode: x);
    let swinging = |share, length| only!(pendulum: share, pendulum_length: length);
    let wrong_masses = |masses, lengths| only!(mass_error: masses, length_error: lengths);
    vec![
        ("none", "", none),
        ("slope", "2 deg", slope(2.0)),
        ("slope", "4 deg", slope(4.0)),
        ("slope", "8 deg", slope(8.0)),
        ("slope, inclinometer", "4 deg", inclined(4.0)),
        ("slope, inclinometer", "8 deg", inclined(8.0)),
        ("gear losses", ".97", efficiency(0.97)),
        ("gear losses", ".93", efficiency(0.93)),
        ("torque gain", "+2 %", gain(1.02)),
        ("torque gain", "+5 %", gain(1.05)),
        ("torque gain", "-5 %", gain(0.95)),
        ("torque gain", "+10 %", gain(1.10)),
        ("torque gain", "-10 %", gain(0.90)),
        ("torque filter", "20 ms", lag(0.02)),
        ("torque filter", "50 ms", lag(0.05)),
        ("torque every", "40 ms", only!(torque_period: 0.04)),
        ("torque offset", "1.5 %", only!(torque_offset: 0.015)),
        ("gyro late", "10 ms", late(0.01)),
        ("gyro late", "30 ms", late(0.03)),
        ("gyro filter", "20 ms", only!(gyro_lag: 0.02)),
        ("gyro bias", ".01 rad/s", only!(gyro_bias: 0.01)),
        ("gyro quantum", ".01 rad/s", only!(gyro_quantum: 0.01)),
        ("friction", "x1.3", friction(1.3)),
        ("friction", "x2", friction(2.0)),
        ("friction, Stribeck", "x1.6", only!(stribeck: 1.6)),
        ("friction, overturning", "+50 %", only!(overturning: 0.5)),
        ("damping", "x1.5", only!(damping: 1.5)),
        ("boom mode", "4 Hz", boom(4.0)),
        ("boom mode", "2.5 Hz", boom(2.5)),
        ("swinging load", "20 %", swinging(0.2, 0.8)),
        ("swinging load", "50 %", swinging(0.5, 0.8)),
        ("hook load", "2 m", swinging(1.0, 2.0)),
        ("spill", "10 %", only!(spill: 0.10)),
        ("dump in the swing", "", only!(dumps_swinging: true)),
        ("masses, lengths", "2 %, 1 %", wrong_masses(0.02, 0.01)),
        ("masses, lengths", "3 %, 1.5 %", wrong_masses(0.03, 0.015)),
        (
            "joint angles",
            "1 deg",
            only!(angle_error: 1f64.to_radians()),
        ),
        ("jitter", "3 ms", only!(jitter: 0.003)),
        ("jitter", "10 ms", only!(jitter: 0.01)),
        ("relief valve", "30 %", only!(relief: 0.3)),
        ("good machine", "", Effects::good()),
        ("usual machine", "", Effects::usual()),
        ("worn machine", "", Effects::worn()),
    ]
}
