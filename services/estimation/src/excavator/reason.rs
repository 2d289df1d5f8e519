//! Reasons why an estimate is not trusted; the list is in the sheet.

use crate::reasons::reasons;

sheet::excavator_reasons!(reasons);
