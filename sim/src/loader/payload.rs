//! The payload in the bucket, and the machine with it.

use super::plant::Machine;

/// Distance of the payload ahead of the front axle [m].
pub(super) const PAYLOAD_REACH: f64 = 1.35;
/// Height of the payload in the low carrying position [m].
pub(super) const PAYLOAD_HEIGHT: f64 = 0.6;

/// The payload in the bucket at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Payload {
    /// Its mass \[kg\].
    pub mass: f64,
    /// Height of its centre of gravity above ground \[m\].
    pub height: f64,
    /// Distance of its centre of gravity ahead of the front axle \[m\].
    pub reach: f64,
}

impl Payload {
    /// No load, in the low carrying position.
    pub(super) const CARRIED: Self = Self {
        mass: 0.0,
        height: PAYLOAD_HEIGHT,
        reach: PAYLOAD_REACH,
    };
}

/// A machine with its payload: mass \[kg\], height of the centre of gravity \[m\], share of the front axle.
pub fn loaded(machine: &Machine, payload: &Payload) -> (f64, f64, f64) {
    let mass = machine.mass + payload.mass;
    let place = (machine.wheelbase + payload.reach) / machine.wheelbase;
    let mean = |empty: f64, load: f64| (machine.mass * empty + payload.mass * load) / mass;
    (
        mass,
        mean(machine.cg_height, payload.height),
        mean(machine.cg_ratio, place),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_payload_moves_the_centre_of_gravity_forward_and_up() {
        let payload = Payload {
            mass: 1500.0,
            height: 1.5,
            reach: PAYLOAD_REACH,
        };
        let (mass, height, ratio) = loaded(&Machine::NOMINAL, &payload);
        // (4700 * 0.9 + 1500 * 1.5) / 6200 and (4700 * 0.45 + 1500 * 3.65 / 2.3) / 6200.
        assert_eq!(mass, 6200.0);
        assert!((height - 1.045_161_29).abs() < 1e-8);
        assert!((ratio - 0.725_070_13).abs() < 1e-8);
    }
}
