//! The messages that heft's processes exchange, and the table of their channels.
//!
//! Every payload is `repr(C)`, without padding, pointers or destructors, and begins with a
//! [`Stamp`] and the [`Hops`]. The type names are part of the public interface: a Python or C++
//! program subscribes with a structure of the same name, size and alignment. [`Message::FIELDS`]
//! describes each payload, so that the recorder, the CSV writer and the live page need no
//! knowledge of any particular one.

pub mod channels;
mod envelope;
mod excavator;
mod health;
pub mod keyframe;
mod loader;
mod machine;
mod message;
mod stamp;

pub use envelope::{Envelope, Receiver};
pub use excavator::{
    ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, SwingMotion, excavator_bits,
};
pub use health::{Credit, Health, State, fault};
pub use keyframe::{Keyframe, Snapshot};
pub use loader::{LOADER_REASONS, LoaderEstimate, LoaderSensors, LoaderTruth, loader_bits};
pub use machine::Machine;
pub use message::{Field, HEAD, Message, NumberType, SIMULATED, Value};
pub use stamp::{Hop, Hops, Stamp};

/// Reasons of the excavator's estimates by their code, [`ExcavatorEstimate::reason`]: name in the tables, and
/// words. 0 is no reason.
pub const EXCAVATOR_REASONS: &[(&str, &str)] = &[
    ("", ""),
    ("slope", "the ground seems inclined"),
    ("losses", "the swing drive seems to lose torque"),
    ("friction", "the friction differs from the described one"),
    ("gain", "the torque's gain seems not to be 1"),
    ("delay", "velocity and torque do not come together"),
    ("offset", "the torque seems to have an offset"),
    ("damping", "the damping differs from the described one"),
    ("unexplained", "the motion does not follow the model"),
    ("disagreement", "swings disagree by more than they claim"),
    ("limit", "the estimate is at the end of its range"),
    ("content", "the bucket's content may have changed"),
    ("frozen", "a sensor repeats one value"),
    ("sign", "a sensor seems to have the other sign"),
    (
        "method",
        "this method cannot tell the inertia of a machine that is not calibrated",
    ),
    ("restarted", "the service was started again"),
];

/// Names of the excavator estimation methods on the command line and in every output, indexed by
/// [`ExcavatorEstimate::method`].
pub const EXCAVATOR_METHODS: &[&str] = &[
    "auto",
    "multi-forgetting-rls",
    "svf-rls",
    "posture-torque",
    "torque",
    "posture",
    "velocity",
];

/// Names of the loader estimation methods, indexed by [`LoaderEstimate::method`].
pub const LOADER_METHODS: &[&str] = &["full", "isr-ukf-printed", "isr-ukf", "ekf", "full-ekf"];
