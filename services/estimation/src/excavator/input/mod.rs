//! Conditioning of the sensor rows: grid of 100 Hz; missing, late, held, noisy, coarse, frozen and jumping signals; encoder; standstill.

pub(in crate::excavator) mod angle;
pub(in crate::excavator) mod calibration;
pub(in crate::excavator) mod delay;
pub(in crate::excavator) mod encoder;
pub(in crate::excavator) mod frozen;
pub(in crate::excavator) mod grid;
pub(in crate::excavator) mod hold;
pub(in crate::excavator) mod jump;
pub(in crate::excavator) mod lag;
pub(in crate::excavator) mod motion;
pub(in crate::excavator) mod quantisation;
pub(in crate::excavator) mod range;
pub(in crate::excavator) mod repeated;
pub(in crate::excavator) mod screen;
pub(in crate::excavator) mod standstill;
pub(in crate::excavator) mod steady;
pub(in crate::excavator) mod swing_angle;
