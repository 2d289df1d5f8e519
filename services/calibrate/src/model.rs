//! What a fit works on: blocks of recordings that give innovations.

use std::ops::Range;

use crate::Parameter;

/// One innovation of a filter, before any gate, and the variance the filter expects of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted.
    pub value: f64,
    /// Expected variance.
    pub variance: f64,
}

/// A filter whose innovations depend on parameters.
///
/// A block is a piece of a recording with an initial state of its own, such as one swing: blocks are
/// independent given the parameters, so they run in parallel, can be held out, and are what the
/// jackknife leaves out.
pub trait Model: Sync {
    /// The parameters, in the order of the values.
    fn parameters(&self) -> &[Parameter];

    /// Parameters of which a reader wants the sum alone, and what that is, in words.
    fn sum(&self) -> Option<(Range<usize>, &'static str)> {
        None
    }

    /// Number of blocks.
    fn blocks(&self) -> usize;

    /// Number of the recording that a block is from.
    fn recording(&self, block: usize) -> usize;

    /// Whether a parameter acts on a block at all.
    fn acts(&self, parameter: usize, block: usize) -> bool;

    /// Appends the innovations of a block at these values of the parameters; always as many, all finite,
    /// with positive variances.
    fn innovations(&self, block: usize, values: &[f64], out: &mut Vec<Innovation>);
}
