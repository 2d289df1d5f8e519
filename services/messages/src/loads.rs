//! Loads as people count them: the same message for every machine, with the words of its reasons.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use sheet::loads::{FLAGS, STAGES, WITNESSES};

use crate::message::message;
use crate::{Entry, Words};

const FLAG_BITS: &[Entry] = &sheet::flag_entries::<{ FLAGS.len() }>(FLAGS);

/// Names of the bits and codes, those of the reasons from a machine.
const fn words(reasons: &'static [Entry]) -> [(&'static str, Words); 4] {
    [
        ("flags", Words::Bits(FLAG_BITS)),
        ("stage", Words::Codes(STAGES)),
        ("witness", Words::Codes(WITNESSES)),
        ("reason", Words::Codes(reasons)),
    ]
}

const EXCAVATOR_WORDS: &[(&str, Words)] = &words(sheet::excavator::REASONS);
const LOADER_WORDS: &[(&str, Words)] = &words(sheet::loader::REASONS);

/// Bits of the messages of loads.
pub mod loads_bits {
    pub use sheet::loads::bits::*;
}

/// The messages from the rows of the sheet.
macro_rules! loads {
    (
        numbers { $( $name:ident $place:tt $unit:tt $doc:tt; )* }
        codes { $( $code:ident $code_place:tt $code_doc:tt; )* }
    ) => {
        message! {
            /// What an excavator's bucket holds now, the latest load, and its truck: ten times a second, and when a load changes.
            pub struct ExcavatorLoads, "ExcavatorLoads", size 224, marked in flags, words EXCAVATOR_WORDS {
                $( #[doc = $doc] $name: f64, $unit; )*
                $( #[doc = $code_doc] $code: u32, ""; )*
            }
        }

        message! {
            /// What a loader's bucket holds now, the latest load, and its truck: ten times a second, and when a load changes.
            pub struct LoaderLoads, "LoaderLoads", size 224, marked in flags, words LOADER_WORDS {
                $( #[doc = $doc] $name: f64, $unit; )*
                $( #[doc = $code_doc] $code: u32, ""; )*
            }
        }
    };
}

sheet::loads_fields!(loads);
