//! What a step costs: ours and the peers, on the same data, in the same run.
//!
//! | module | what it holds |
//! |---|---|
//! | [`problem`] | the four problems, their models and their data |
//! | [`ours`] | this project's filters on those problems |
//! | [`peers`] | other crates and textbook nalgebra on those problems |
//! | [`measure`] | interleaved blocks, minimum and median, worst case of single calls |

//!
//! A comparison is fair when both sides are given the same numbers, return the same numbers (a test holds them to it), and neither
//! can be worked out at compile time: every parameter is a run-time value, and each block of steps is a function of its own that is
//! never inlined.

pub mod measure;
pub mod ours;
pub mod peers;
pub mod problem;
