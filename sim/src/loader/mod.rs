//! The wheel loader: plant, roads, scenarios, sensors and faults.
//!
//! After Yang, Wang, Han 2021, "A Novel Real-Time Center of Gravity Estimation Method for Wheel Loaders with
//! Front/Rear-Axle-Independent Electric Driving". Two entries of their Table 1 are read differently from print. The mass of
//! 4.7 kg is read as 4.7 t. The 50 N m are read as motor torque before a gear of 20 (as wheel torque it would not overcome the
//! rolling resistance). Geometry, roads and sensors are not in the paper and are chosen here.
//!
//! Signs: forward speed and slope uphill are positive; the horizontal spading force is positive pushing the
//! machine backward, the vertical one pushing it down; pitch is positive nose up.
//!
//! ```
//! use sim::loader::{Run, Scenario, Simulation};
//!
//! let run = Run { seed: 7, ..Run::new(Scenario::Bumpy) };
//! let rows: Vec<_> = Simulation::new(&run)?.collect();
//! assert_eq!(rows.len(), 1001);
//! # Ok::<(), sim::loader::InvalidRun>(())
//! ```

mod acts;
mod arm;
mod cases;
mod chance;
mod cycle;
mod driver;
mod effects;
mod faults;
mod lifts;
mod loading;
mod payload;
mod plant;
mod profile;
mod road;
mod row;
mod run;
mod scenario;
mod sensors;
mod simulation;
mod tier;

#[cfg(test)]
mod golden;

pub use arm::{LiftArm, Seen, Stance};
pub use cases::CASES;
pub use effects::{Bend, Effects, PayloadReport};
pub use faults::CHANNELS;
pub use payload::{Payload, loaded};
pub use plant::{GRAVITY, Inputs, Machine, Motion, Plant, State};
pub use road::{Phases, Road, Surface};
pub use row::{Row, Truth};
pub use run::{InvalidRun, Run};
pub use scenario::Scenario;
pub use sensors::Grade;
pub use simulation::Simulation;
pub use tier::{Nominal, Size, Tier};
