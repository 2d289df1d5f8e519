//! Properties of the measurements that the model does not contain, and their noise.
//!
//! | file | idea |
//! |---|---|
//! | `conditions` | conditions in which the parameters are held |
//! | `wheel_noise` | noise of the wheel speeds |
//! | `wheel_lag` | lag of the rear wheel speed behind the front one |
//! | `slip_fluctuation` | fluctuation of the slips: rough roads |
//! | `blocks` | means over blocks of rows |
//! | `slip_noise` | noise of the slips by motions between sensors and wheels |
//! | `windup` | wind-up of the tyres under a growing torque |
//! | `quantisation` | quantised wheel speeds |
//! | `accelerometer` | noise of the accelerometer where it is mounted |
//! | `slope` | errors of the slope sensor beside its bias |

pub(super) mod accelerometer;
pub(super) mod blocks;
pub(super) mod conditions;
pub(super) mod quantisation;
pub(super) mod slip_fluctuation;
pub(super) mod slip_noise;
pub(super) mod slope;
pub(super) mod wheel_lag;
pub(super) mod wheel_noise;
pub(super) mod windup;
