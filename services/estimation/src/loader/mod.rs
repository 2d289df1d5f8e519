//! Centre of gravity of a wheel loader from its motion: Yang, Wang, Han 2021, as printed, corrected, and made to survive
//! a real machine.
//!
//! The load on each axle shows in its slip: quasi-steadily K F_z = T/(r slip). The sum over the axles gives the slip
//! stiffness K, their ratio the share lam of the weight in front, less the load h a_x/(g l) that acceleration moves
//! backward. So lam needs traction and accurate slips, and the height h needs *changes* of acceleration.
//!
//! | file | idea |
//! |---|---|
//! | `sample`, `estimate`, `settings`, `method` | what goes in and comes out |
//! | [`keys`] | the keys of a description |
//! | [`axle_loads`] | (6), (7), (10), (11) |
//! | [`wheel_dynamics`] | (1)-(5), (8), (9), (12)-(14), (18): the process |
//! | [`cg_model`] | (15)-(17): states and measurements |
//! | `layout` | where each stands in the state |
//! | `tangent` | the derivatives of the process |
//! | `windup` | tyres wind up under a growing torque |
//! | `load` | a load that the mass tells |
//! | `known_load` | a load that is reported, or weighed by the lift pressure |
//! | `inclinometer` | a slope sensor that is late and follows the acceleration |
//! | `slope` | how far the slope sensor is to be believed |
//! | `manoeuvres` | independent manoeuvres must agree |
//! | `quantisation` | wheel speeds in steps |
//! | `slip_fluctuation` | slips that fluctuate: rough roads |
//! | `accelerometer` | its noise where it is mounted |
//! | `inertia` | force over acceleration |
//! | `stated_mass` | whether the machine is as heavy as stated: a load that nobody tells |
//! | `unreported_load` | how probable it is that the bucket was filled or emptied since |
//! | `stuck` | a sensor whose value never changes |
//! | `relearning` | what was learnt wrongly: the start, the radii under another load |
//! | `coupling` | a centre drive that is locked |
//! | `curves` | curves that nobody reports |
//! | `directions` | whether the load sensitivity of the radii can be learnt |
//! | `gain` | force on the body over the torques' |
//! | `disturbance` | brakes, steering, forces that nobody measures |
//! | `lift_arm` | the second witness: lift pressure and arm geometry |
//! | `witnesses` | slips and weight: the sharper answers, the other checks it |
//! | `inputs`, `conditions` | inputs between rows; freezing and wheel noise |
//! | `filter`, `estimator` | one row |
//! | `answer` | what is said after it |
//! | `verdict`, `reason` | whether to believe it, and why not |
//! | `floors` | errors that cannot be learnt on line |
//! | [`payload`] | a load that is known |
//! | [`weigh`] | the static reference |

mod accelerometer;
mod answer;
pub mod axle_loads;
pub mod cg_model;
mod conditions;
mod coupling;
mod curves;
mod directions;
mod disturbance;
mod estimate;
mod estimator;
mod filter;
mod floors;
mod gain;
mod inclinometer;
mod inertia;
mod inputs;
pub mod keys;
mod known_load;
mod layout;
mod lift_arm;
mod load;
mod machine;
mod manoeuvres;
mod method;
pub mod payload;
mod quantisation;
mod reason;
mod relearning;
mod sample;
pub mod settings;
mod shared_slip;
mod slip_fluctuation;
mod slope;
mod stated_mass;
mod stuck;
mod tangent;
mod unreported_load;
mod verdict;
pub mod weigh;
pub mod wheel_dynamics;
mod windup;
mod witnesses;

pub use estimate::{Estimate, Status};
pub use estimator::CgEstimator;
pub use lift_arm::{LiftKnown, LiftMoment, Lifts};
pub use method::Method;
pub use payload::Payload;
pub use reason::Reason;
pub use sample::{Columns, Sample};
pub use settings::{LoadTransfer, Machine, MustBe, Prior, Sensors, Settings, SettingsError};

/// Rated payload in machine masses, half of what tips a loader (ISO 14397-1): .29 to .33 for machines of 5 to 25 t (makers' sheets).
pub const RATED_SHARE: f64 = 0.32;
