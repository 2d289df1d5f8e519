//! What the measurements show beside the model, and how noisy they are.
//!
//! | file | idea |
//! |---|---|
//! | `conditions` | when the parameters are held |
//! | `wheel_noise` | how noisy the wheels are |
//! | `wheel_lag` | how much later the rear wheel speed comes than the front one |
//! | `slip_fluctuation` | slips that fluctuate: rough roads |
//! | `windup` | tyres wind up under a growing torque |
//! | `quantisation` | wheel speeds in steps |
//! | `accelerometer` | its noise where it is mounted |
//! | `slope` | how far the slope sensor is to be believed |

pub(super) mod accelerometer;
pub(super) mod conditions;
pub(super) mod quantisation;
pub(super) mod slip_fluctuation;
pub(super) mod slope;
pub(super) mod wheel_lag;
pub(super) mod wheel_noise;
pub(super) mod windup;
