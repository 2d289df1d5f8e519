//! What a step costs: ours and the peers, on the same data, in the same run.
//!
//! | module | what it holds |
//! |---|---|
//! | [`problem`] | the problems, their models and their data |
//! | [`ours`] | this project's filters on those problems |
//! | [`peers`] | other crates and textbook nalgebra on those problems |
//! | [`groups`] | what is compared with what, and the targets |
//! | [`measure`] | interleaved blocks, minimum and median, single calls |
//! | [`bounds`] | what the machine could do at best |
//! | [`real`] | the steps of the product on the simulators' rows |
//! | [`scale`] | machines per core |
//! | [`batch`], [`wide`] | eight machines at once: the step in lanes, and the registers |
//! | [`counts`] | instructions a step |
//! | [`report`] | table and JSON |
//!
//! A comparison is fair when both sides are given the same numbers, return the same numbers (a test holds them to it), and neither
//! can be worked out at compile time: every parameter is a run-time value, and each block of steps is a function of its own that is
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
