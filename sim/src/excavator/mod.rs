//! A 5.5 t excavator swinging its upper body: the plant of Oh, Yi, Seo, Kim, Lee 2017. The parameters that the paper does not
//! state are chosen to give its published extremes of inertia, 4380 and 9761 kg m^2.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | w | `velocity` | swing velocity of the upper body | rad/s |
//! | J, J' | `inertia`, `inertia_rate` | inertia about the swing axis, its rate due to posture alone | kg m^2, kg m^2/s |
//! | T_sw | `torque` | swing torque, of the sign of the motion it drives | N m |
//! | b | `damping` | viscous damping, 1500 | N m s/rad |
//! | T_f | `friction` | Coulomb friction, 250 | N m |
//! | m | `payload` | mass in the bucket | kg |
//!
//! The momentum form (`Dynamics::Momentum`) is the physics: `J w' + J' w = T_sw - b w - T_f sgn w`. Material that
//! leaves the bucket takes its own momentum with it, so J' is that of the posture. The paper's form
//! (`Dynamics::Paper`) leaves out `J' w`.

mod calibration;
mod course;
mod cycle;
mod event;
mod front;
mod geometry;
mod path;
mod payload;
mod plant;
mod plants;
mod plateaus;
mod row;
mod scenario;
mod sensors;
mod simulation;
mod story;
mod torque;
mod work;

pub use course::{Course, Exact};
pub use front::cylinders;
pub use geometry::{Attachment, Geometry, Inertia, Link};
pub use path::{Joint, Move, Path, Posture};
pub use payload::{Load, payload};
pub use plant::{Dynamics, Machine, Motion, Plant, Point};
pub use plateaus::{Plateaus, Targets};
pub use row::{Row, Truth};
pub use scenario::Scenario;
pub use sensors::{CHANNELS, Instruments, Sensors};
pub use simulation::{InvalidRun, Run, Simulation};
pub use story::Story;
pub use torque::Swing;
pub use work::{Effects, Size, Work, cases};
