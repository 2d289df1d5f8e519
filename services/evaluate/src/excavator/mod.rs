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

use crate::{Error, Options, Report};
use serde_json::{Map, Value};
use std::sync::atomic::Ordering;

type Evaluation = fn(&Options) -> Result<Report, Error>;

const TABLES: [(&str, Evaluation); 9] = [
    ("table1", table1::evaluate),
    ("modes", modes::evaluate),
    ("drop", drop::evaluate),
    ("bad-input", bad_input::evaluate),
    ("identifiability", identifiability::evaluate),
    ("attachments", attachments::evaluate),
    ("calibration", calibration::evaluate),
    ("honesty", honesty::evaluate),
    ("weighing", weighing::evaluate),
];

/// The table asked for, or all of them: then the JSON has one key per table.
///
/// # Errors
/// The table is unknown, or the estimators refuse their settings.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    match &options.table {
        Some(name) => named(name)?(options),
        None => everything(options),
    }
}

fn named(name: &str) -> Result<Evaluation, Error> {
    let found = TABLES.iter().find(|(known, _)| *known == name);
    found
        .map(|(_, evaluation)| *evaluation)
        .ok_or_else(|| Error::UnknownTable {
            name: name.to_owned(),
            known: TABLES.iter().map(|(known, _)| *known).collect(),
        })
}

fn everything(options: &Options) -> Result<Report, Error> {
    let mut report = Report {
        text: String::new(),
        json: Value::Null,
        met: true,
    };
    let mut json = Map::new();
    for (name, evaluation) in TABLES {
        if options.stop.load(Ordering::Relaxed) {
            report.text += "interrupted: the remaining tables are left out\n";
            report.met = false;
            break;
        }
        let table = evaluation(options)?;
        report.text += &table.text;
        report.text.push('\n');
        report.met &= table.met;
        json.insert(name.to_owned(), table.json);
    }
    report.json = Value::Object(json);
    Ok(report)
}
