//! What people see of heft: the report, the live page, the terminal dashboard and the papers'
//! figures, all from one set of plots and one set of words.

pub mod number;
pub mod plot;
pub mod statistics;
