//! Interface of a fit's model: blocks of recordings that give innovations.

use std::ops::Range;

use crate::Parameter;

/// One innovation of a filter, before any gate, and its predicted variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted.
    pub value: f64,
    /// Expected variance.
    pub variance: f64,
}

/// A filter whose innovations depend on parameters.
///
/// A block is a piece of a recording with its own initial state, such as one swing. Blocks are
/// independent given the parameters, so they run in parallel, can be held out, and are left out one by one by
/// the jackknife.
pub trait Model: Sync {
    /// The parameters, in the order of the values.
    fn parameters(&self) -> &[Parameter];

    /// Parameters of which only the sum is of interest, and the name of the sum.
    fn sum(&self) -> Option<(Range<usize>, &'static str)> {
        None
    }

    /// Number of blocks.
    fn blocks(&self) -> usize;

    /// Number of the recording that contains a block.
    fn recording(&self, block: usize) -> usize;

    /// Whether a parameter acts on a block at all.
    fn acts(&self, parameter: usize, block: usize) -> bool;

    /// Appends the innovations of a block at these values of the parameters: always the same number, all finite,
    /// with positive variances.
    fn innovations(&self, block: usize, values: &[f64], out: &mut Vec<Innovation>);
}
