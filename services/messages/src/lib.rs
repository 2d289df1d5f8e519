//! The messages that heft's processes exchange, and the table of their channels.
//!
//! Every payload is `repr(C)`, without padding, pointers or destructors, and begins with a
//! [`Stamp`] and the [`Hops`]. The type names are part of the public interface: a Python or C++
//! program subscribes with a structure of the same name, size and alignment. [`Message::FIELDS`]
//! describes each payload, so that the recorder, the CSV writer and the live page need no code for any particular one.
//!
//! | file | what |
//! |---|---|
//! | `excavator`, `loader` | of a machine: messages, a row per field; channels; names of methods and reasons |
//! | `loads` | the message of loads, one a machine |
//! | `health`, [`keyframe`] | the messages of every process |
//! | `machine` | the machines, a row each: every crate makes its table from it |
//! | [`channels`] | the table of channels: name, payload, depth, rate |
//! | `words` | names of bits and codes, from the sheet |
//! | `field`, `stamp` | the description of a field, and what every payload begins with |
//! | `fnv` | the sum by which states, channels and names are told apart |
//! | `message` | the interface of every payload, and an enum of them all |

pub mod channels;
mod codes;
mod excavator;
mod field;
mod fnv;
mod health;
pub mod keyframe;
mod loader;
mod loads;
mod machine;
mod message;
mod stamp;
pub mod words;

pub use codes::{Entry, Words};
pub use field::{Field, HEAD, NumberType, Value};
pub use fnv::{fnv32, fnv64};
pub use health::{Credit, Health, State, fault};
pub use keyframe::{Keyframe, Snapshot};
pub use loads::{ExcavatorLoads, LoaderLoads, loads_bits};
pub use machine::Machine;
pub use message::{Carries, Envelope, Message, Receiver, SIMULATED, Shape};
pub use stamp::{Hop, Hops, Stamp};

macro_rules! messages_of_machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        $( pub use $module::*; )*
    };
}

machines!(messages_of_machines);
