//! Recordings in and out: MCAP, CSV, and foreign data through a signal map.
//!
//! | from | by |
//! |---|---|
//! | a run of heft | [`Writer`], [`Reader`], [`recover()`] |
//! | a table with a header | [`csv::read`], with a [`Map`] |
//! | a CAN log | [`load()`], with a [`Map`] that names a DBC file |
//! | an MCAP file of another program | [`load()`], with a [`Map`] that names topics and fields |
//!
//! Schemas, columns and signals all come from [`messages::Message::FIELDS`].

pub mod can;
mod copy;
mod counter;
pub mod csv;
mod error;
mod excavator;
mod file;
mod finding;
pub mod frame;
mod gaps;
mod kind;
mod line_decoder;
mod load;
mod loader;
mod machines;
mod map;
mod mapped;
pub mod measurable;
pub mod output;
mod packed;
mod parts;
pub mod payload;
mod plain;
mod presence;
mod reader;
mod record;
mod recover;
mod sampling;
mod scan;
mod schema;
mod signal;
mod suggest;
mod time;
mod time_unit;
mod together;
mod topics;
mod unit;
mod whole;
mod wide;
mod wire;
mod writer;

pub use csv::EstimateWriter;
pub use error::Error;
pub use finding::Finding;
pub use gaps::Gaps;
pub use kind::{Kind, foreign, unread};
pub use line_decoder::{LineDecoder, MAX_LINE, NameColumn, NamedLine};
pub use load::{Samples, load, open};
pub use map::Map;
pub use output::Output;
pub use parts::{
    PART, changed, exists, files_by_age, is_being_written, is_part_of, next_part, part,
    part_number, recordings, reserve,
};
pub use plain::{OneLine, Plain, Quoted, steers};
pub use reader::{Lacks, Reader, Stream};
pub use recover::{Recovered, join, recover};
pub use scan::has_chunk_at;
pub use schema::RecordedField;
pub use signal::{Row, Sensors, measured};
pub use suggest::{LARGEST_PRESSURES, STEEPEST, Suggestion, suggest};
pub use time::date_and_time;
pub use time_unit::{time_unit, too_fast, too_slow, usual_step};
pub use together::Together;
pub use whole::open_file;
pub use writer::{Metadata, Writer, sha256};
