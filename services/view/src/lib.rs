//! What people see of heft: the report, the live page, the terminal dashboard and the papers'
//! figures, all from one set of plots and one set of words.

pub mod estimate;
pub mod figures;
pub mod live;
pub mod monitor;
pub mod number;
pub mod panels;
pub mod plot;
mod report;
mod run;
pub mod score;
pub mod stretches;
pub mod top;
pub mod words;

pub use report::{compared, page, report};
pub use run::{Estimator, Input, MachineRun, Run, lost};
