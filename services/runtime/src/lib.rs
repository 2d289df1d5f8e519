//! Common parts of the processes of heft: ports, wake-ups, clock, real-time set-up, telemetry.
//!
//! Only this crate uses iceoryx2. A service passes it a [`Step`] (or a [`Source`], a [`Sink`])
//! and is independent of channels, bells and clocks. The supervisor creates and holds every channel
//! ([`Ports::create`]) and passes every worker its bells ([`Control`]). A worker opens its ports,
//! reports `ready` and is driven by [`run_stage`], [`run_source`] or [`run_sink`].
//!
//! | file | what |
//! |---|---|
//! | `stage`, `source`, `live`, `sink`, `probe` | the loops of the processes |
//! | `step` | the interface of a step and of a source |
//! | `ports`, `taps` | channels: one, several |
//! | `bell` | wake-ups |
//! | `worker`, `control`, `requests` | the life cycle of a process, the protocol of the supervisor, its requests |
//! | `domain`, `home`, `cleaner` | files of a run: their place, owner, removal |
//! | `room` | what a run needs in memory, and which file system lacks it |
//! | `window` | view of a run for a group of other users |
//! | `telemetry`, `pulse` | counters, and detection of a step that hangs |
//! | `realtime`, `clock` | scheduling and time |

mod bell;
mod cleaner;
mod clock;
mod control;
mod domain;
mod error;
mod home;
mod keyframes;
mod live;
mod ports;
mod probe;
mod pulse;
pub mod realtime;
mod requests;
mod room;
mod run_sink;
mod sink;
mod source;
mod stage;
mod step;
mod taps;
mod telemetry;
mod window;
mod worker;

pub use bell::Bell;
pub use cleaner::Cleaner;
pub use clock::{now_ns, processor_time, processor_time_of, since_1970, sleep_until};
pub use control::{Control, ControlWord};
pub use domain::{Domain, Owner};
pub use error::Error;
pub use home::make as home;
pub use live::{Live, Polled, run_live};
pub use ports::{ChannelOwner, EventListener, Input, Output, Ports, Received, Teller};
pub use probe::{Arrival, Wake, run_probe};
pub use pulse::is_stopped;
pub use requests::Begin;
pub use room::{Needs, free_shared_memory, lack};
pub use run_sink::run_sink;
pub use sink::Sink;
pub use source::{Pace, run_source};
pub use stage::run_stage;
pub use step::{Source, Step, answer};
pub use taps::{Taps, Visit};
pub use telemetry::Identity;
pub use window::{GroupView, Window, share};
pub use worker::{Setup, Worker};
