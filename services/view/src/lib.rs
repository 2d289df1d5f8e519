//! The presentation of heft's results: the report, the live page, the terminal dashboard and the papers' figures, all from one
//! set of plots and one set of words.
//!
//! | module | what |
//! |---|---|
//! | `report`, [`live`], [`top`], [`figures`] | page of a run, live page, terminal, figures of the papers |
//! | [`estimate`] | the presented properties of a machine: parameters, flags, innovation |
//! | [`excavator`], [`loader`] | those of one machine, with its words, panels and figures |
//! | [`loads`] | loads and trucks: table, JSON, words |
//! | `run`, [`monitor`] | a run in memory; the latest of everything |
//! | [`panels`], [`plot`] | the plots of a run, and their drawing |
//! | [`words`], [`number`] | verdicts in sentences, numbers rounded to their uncertainty |
//! | [`duration`] | durations as people write them |
//! | [`score`], [`stretches`] | errors against the truth; swings and loads |

mod counted;
pub mod duration;
pub mod estimate;
pub mod excavator;
pub mod figures;
mod judgement;
pub mod live;
pub mod loader;
pub mod loads;
pub mod monitor;
pub mod number;
pub mod panels;
pub mod plot;
pub mod posture;
mod report;
mod run;
pub mod score;
pub mod stretches;
pub mod top;
pub mod words;

pub use judgement::Judgement;
pub use report::{NOT_WHOLE, compared, loads_page, page, picture, report};
pub use run::{Estimator, Input, MachineRun, Parts, Run, Thinned, lost};

/// A layout of Foxglove for recordings of both machines.
pub const FOXGLOVE_LAYOUT: &str = include_str!("../assets/foxglove-layout.json");
