//! The excavator: the paper's Table 1, and every mode against its targets.
//!
//! | table (its file documents the JSON) | what |
//! |---|---|
//! | `table1` | Table 1 of Oh, Yi, Seo, Kim, Lee 2017 |
//! | `modes` | all modes, three loads, no disturbance |
//! | `drop` | payload that changes during the swing |
//! | `bad-input` | faulty sensors, wrong parameters |
//! | `identifiability` | Cramer-Rao bounds beside the errors reached |
//! | `attachments` | inertia of bucket and crusher, Fig. 3 |
//! | `calibration` | `heft calibrate` over simulated machines |
//! | `honesty` | wrong values among the trusted, on machines that deviate from their description |
//! | `weighing` | gain from cylinder pressures: narrow intervals, loads |

mod attachments;
mod bad_input;
mod calibrated;
pub mod calibration;
mod case;
mod drop;
mod estimators;
mod honesty;
pub mod honesty_lines;
mod identifiability;
mod information;
mod modes;
mod score;
pub mod table1;
mod target;
mod weighing;

pub use case::Case;
pub use estimators::{Point, Setup};

use crate::tables::{self, NamedTable};
use crate::{Error, Options, Report};

const TABLES: [NamedTable; 9] = [
    NamedTable::new("table1", table1::evaluate),
    NamedTable::new("modes", modes::evaluate),
    NamedTable::new("drop", drop::evaluate),
    NamedTable::new("bad-input", bad_input::evaluate),
    NamedTable::new("identifiability", identifiability::evaluate),
    NamedTable::new("attachments", attachments::evaluate),
    NamedTable::new("calibration", calibration::evaluate),
    NamedTable::new("honesty", honesty::evaluate),
    NamedTable::new("weighing", weighing::evaluate),
];

/// The requested table, or all of them: then the JSON has one key per table.
///
/// # Errors
/// The table is unknown, or the estimators refuse their settings.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    tables::evaluate(&TABLES, options)
}
