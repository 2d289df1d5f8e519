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
mod loader;
mod machine;
mod message;
mod stamp;

pub use envelope::{Envelope, Receiver};
pub use excavator::{
    ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, SwingMotion, excavator_bits,
};
pub use health::{Credit, Health, State, fault};
pub use loader::{LoaderEstimate, LoaderSensors, LoaderTruth, loader_bits};
pub use machine::Machine;
pub use message::{Field, HEAD, Kind, Message, Value};
pub use stamp::{Hop, Hops, Stamp};

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
pub const LOADER_METHODS: &[&str] = &["full", "isr-ukf-printed", "isr-ukf", "ekf"];
