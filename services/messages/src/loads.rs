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

macro_rules! loads {
    ($message:ident, $type_name:tt, $words:ident) => {
        message! {
            /// What the bucket holds now, the latest load, and its truck: ten times a second, and when a load changes.
            pub struct $message, $type_name, size 224, marked in flags, words $words {
                /// What the bucket holds now: always a value, the last known one where nothing weighs it.
                payload: f64, "kg";
                /// Its standard deviation, which grows with time and by what may have changed.
                payload_std: f64, "kg";
                /// Time since it was last weighed; 1e9 if it never was.
                payload_age: f64, "s";
                /// The latest load: what was in the bucket.
                mass: f64, "kg";
                /// Its standard deviation.
                mass_std: f64, "kg";
                /// The part of `mass_std` that all loads share: it does not average out.
                common_std: f64, "kg";
                /// What stayed in the bucket.
                carry_back: f64, "kg";
                /// Its standard deviation.
                carry_back_std: f64, "kg";
                /// What the truck got of this load.
                delivered: f64, "kg";
                /// Its standard deviation.
                delivered_std: f64, "kg";
                /// Since when the bucket is known to hold the load.
                filled: f64, "s";
                /// When it began to leave; 0 while it is carried.
                dumped: f64, "s";
                /// What the truck holds.
                truck_mass: f64, "kg";
                /// Its standard deviation.
                truck_mass_std: f64, "kg";
                /// What the truck shall hold; 0 if nobody said.
                target: f64, "kg";
                /// What is missing to the target, negative where there is too much; 0 without a target.
                remaining: f64, "kg";
                /// Number of the latest load, from 1; 0 before the first one.
                load: u32, "";
                /// Number of the truck that is being loaded, from 1.
                truck: u32, "";
                /// Loads that it holds.
                truck_loads: u32, "";
                /// Of them those that may not be believed.
                truck_untrusted: u32, "";
                /// Code of how far the load has come.
                stage: u32, "";
                /// Code of what told its mass.
                witness: u32, "";
                /// Code of the reason why it is not trusted.
                reason: u32, "";
                /// Bits of this message.
                flags: u32, "";
            }
        }
    };
}

loads!(ExcavatorLoads, "ExcavatorLoads", EXCAVATOR_WORDS);
loads!(LoaderLoads, "LoaderLoads", LOADER_WORDS);
