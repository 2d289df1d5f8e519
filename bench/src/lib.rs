//! Cost of a step: ours and the peers', on the same data, in the same run.
//!
//! | module | contents |
//! |---|---|
//! | [`problem`] | the problems, their models and their data |
//! | [`ours`] | this project's filters on those problems |
//! | [`peers`] | other crates and textbook nalgebra on those problems |
//! | [`groups`] | groups of compared filters, and the targets |
//! | [`measure`] | interleaved blocks, minimum and median, single calls |
//! | [`bounds`] | lower bounds of this machine |
//! | [`real`] | the steps of the product on the simulators' rows |
//! | [`scale`] | machines per core |
//! | [`batch`], [`wide`] | eight machines at once: the step in lanes, and the registers |
//! | [`counts`] | instructions a step |
//! | [`report`] | table and JSON |
//!
//! A comparison is fair if both sides have the same inputs and the same outputs (a test checks them), and neither can be
//! evaluated at compile time. So every parameter is a run-time value, and each block of steps is a separate function that is
//! never inlined.

pub mod batch;
pub mod bounds;
pub mod counts;
pub mod groups;
pub mod measure;
pub mod ours;
pub mod peers;
pub mod pipelines;
pub mod problem;
pub mod real;
pub mod report;
pub mod scale;
pub mod wide;
