//! The excavator: the paper's Table 1, and every mode against its targets.
//!
//! | table | what | JSON |
//! |---|---|---|
//! | `table1` | Table 1 of Oh, Yi, Seo, Kim, Lee 2017 | [`table1`] |
//! | `modes` | all modes, three loads, no disturbance | [`modes`] |
//! | `drop` | payload that changes in mid-swing | [`mod@drop`] |
//! | `bad-input` | faulty sensors, wrong parameters | [`bad_input`] |
//! | `identifiability` | Cramer-Rao bounds beside what is reached | [`identifiability`] |
//! | `attachments` | inertia of bucket and crusher, Fig. 3 | [`attachments`] |
//! | `calibration` | `heft calibrate` over simulated machines | [`calibration`] |
//! | `honesty` | what is trusted on machines that are not what they are said to be | [`honesty`] |
//! | `weighing` | what cylinder pressures add: narrow intervals, loads | [`weighing`] |

pub mod attachments;
pub mod bad_input;
mod calibrated;
pub mod calibration;
mod case;
pub mod drop;
mod estimators;
pub mod honesty;
pub mod honesty_lines;
pub mod identifiability;
mod information;
pub mod modes;
mod score;
pub mod table1;
mod target;
pub mod weighing;

pub use case::Case;
pub use estimators::{Point, Setup, series};
pub use score::{Score, Summary, Window};
pub use target::Target;

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

/// The table asked for, or all of them: then the JSON has one key per table.
///
/// # Errors
/// The table is unknown, or the estimators refuse their settings.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    tables::evaluate(&TABLES, options)
}
