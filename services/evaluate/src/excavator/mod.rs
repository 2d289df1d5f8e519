//! The excavator: the paper's Table 1, and every mode against its targets.

use crate::{Error, Options, Report};

pub(crate) fn evaluate(_options: &Options) -> Result<Report, Error> {
    Err(Error::NoSeeds)
}
