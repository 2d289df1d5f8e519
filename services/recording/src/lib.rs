//! Recordings in and out: MCAP, CSV, and foreign data through a signal map.

mod error;
mod reader;
mod recover;
mod scan;
mod schema;
mod wire;
mod writer;

pub use error::Error;
pub use reader::Reader;
pub use recover::{Recovered, is_complete, recover};
pub use schema::RecordedField;
pub use writer::{Metadata, Writer};
