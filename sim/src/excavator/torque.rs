//! The swing torque: accelerate, reverse, brake, release.

use crate::blend::transition;

/// Time in which the torque builds up, and in which it fades out at the end [s].
const RAMP: f64 = 0.25;
/// Time of the reversal [s].
const REVERSAL: f64 = 0.20;

/// One swing from rest to rest.
///
/// ```text
/// D = s5((t - turn)/0.20)
/// T_sw = Ta s5((t - start)/0.25) (1 - D) - Tb D (1 - s5((t - end + 0.25)/0.25))
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Begin of the acceleration \[s\].
    pub start: f64,
    /// Begin of the braking \[s\].
    pub turn: f64,
    /// End of the torque \[s\].
    pub end: f64,
    /// Plateau Ta while accelerating, negative for a swing clockwise [N m].
    pub accelerate: f64,
    /// Plateau Tb while braking, of the sign of `accelerate` [N m]. With the opposite sign the drive continues with less torque
    /// instead of braking.
    pub brake: f64,
}

impl Swing {
    /// The torque at a time [N m]; zero outside the swing.
    pub fn torque(&self, time: f64) -> f64 {
        if time <= self.start || time >= self.end {
            return 0.0;
        }
        let turned = transition(time, self.turn, self.turn + REVERSAL);
        let driven = transition(time, self.start, self.start + RAMP);
        let faded = transition(time, self.end - RAMP, self.end);
        self.accelerate * driven * (1.0 - turned) - self.brake * turned * (1.0 - faded)
    }
}
