//! Recordings in and out: MCAP, CSV, and foreign data through a signal map.
//!
//! | from | by |
//! |---|---|
//! | a run of heft | [`Writer`], [`Reader`], [`recover()`] |
//! | a table with a header | [`csv::read_excavator`], [`csv::read_loader`], with a [`Map`] |
//! | a CAN log | [`load_excavator`], [`load_loader`], with a [`Map`] that names a DBC file |
//!
//! Schemas, columns and signals all come from [`messages::Message::FIELDS`].

pub mod can;
pub mod csv;
mod error;
pub mod frame;
mod load;
mod map;
mod reader;
mod recover;
mod sampling;
mod scan;
mod schema;
mod signal;
mod time;
mod unit;
mod wire;
mod writer;

pub use csv::EstimateWriter;
pub use error::Error;
pub use load::{load_excavator, load_loader};
pub use map::Map;
pub use reader::Reader;
pub use recover::{Recovered, is_complete, recover};
pub use schema::RecordedField;
pub use signal::{Excavator, Loader, Machine, Row};
pub use writer::{Metadata, Writer, sha256};
