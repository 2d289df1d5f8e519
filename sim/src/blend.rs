//! Smooth transitions from 0 to 1.

/// The quintic blend u^3 (10 - 15 u + 6 u^2): 0 before u = 0, 1 after u = 1, with zero first and second
/// derivative at both ends.
pub fn quintic(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
}

/// The derivative of [`quintic`]: 30 u^2 (1 - u)^2 inside, 0 outside.
pub fn quintic_rate(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    30.0 * (u * (1.0 - u)).powi(2)
}

/// Progress at `time` of a transition from `from` to `to` \[s\], 0 to 1. A transition without duration is a step.
pub fn transition(time: f64, from: f64, to: f64) -> f64 {
    if to > from {
        quintic((time - from) / (to - from))
    } else {
        f64::from(time >= to)
    }
}

/// The rate of [`transition`] [1/s].
pub fn transition_rate(time: f64, from: f64, to: f64) -> f64 {
    if to > from {
        quintic_rate((time - from) / (to - from)) / (to - from)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_blend_goes_from_zero_to_one_and_is_antisymmetric_about_its_middle() {
        assert_eq!(
            (quintic(-1.0), quintic(0.0), quintic(1.0), quintic(2.0)),
            (0.0, 0.0, 1.0, 1.0)
        );
        for u in [0.1, 0.25, 0.5] {
            assert!((quintic(u) + quintic(1.0 - u) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_rate_is_the_derivative() {
        for i in -2..13 {
            let (u, h) = (f64::from(i) * 0.1, 1e-5);
            let difference = (quintic(u + h) - quintic(u - h)) / (2.0 * h);
            // Central difference: h^2/6 times a third derivative of at most 60.
            assert!((difference - quintic_rate(u)).abs() < 2e-9, "u = {u}");
        }
    }
}
