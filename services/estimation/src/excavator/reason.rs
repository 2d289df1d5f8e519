//! Why an estimate is not trusted: the rows are in the sheet.

use crate::reasons::reasons;

sheet::excavator_reasons!(reasons);
