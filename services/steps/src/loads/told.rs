//! Loads as a message: what other programs hear of the ledger.

use estimation::loads::Told;
use messages::channels::{Channel, EXCAVATOR_LOADS, LOADER_LOADS};
use messages::{Envelope, ExcavatorLoads, LoaderLoads, Machine, Message, Stamp};

use super::{LoadCounter, REASON};

/// The messages from the rows of the sheet.
macro_rules! fill {
    (
        numbers { $( $name:ident $place:tt $unit:tt $doc:tt; )* }
        codes { $( $code:ident $code_place:tt $code_doc:tt; )* }
    ) => {
        fn excavator(told: &Told) -> ExcavatorLoads {
            let mut message = ExcavatorLoads::default();
            $( message.$name = told.$name; )*
            $( message.$code = told.$code; )*
            message
        }

        fn loader(told: &Told) -> LoaderLoads {
            let mut message = LoaderLoads::default();
            $( message.$name = told.$name; )*
            $( message.$code = told.$code; )*
            message
        }
    };
}

sheet::loads_fields!(fill);

/// What is known of the bucket, the latest load and its truck, as a message beside the estimate of this stamp.
#[must_use]
pub fn message(counter: &LoadCounter, stamp: &Stamp) -> Envelope {
    let mut told = Told::of(counter.ledger(), counter.loads().next_back());
    told.reason &= REASON;
    match counter.machine() {
        Machine::Excavator => ExcavatorLoads {
            stamp: *stamp,
            ..excavator(&told)
        }
        .envelope(),
        Machine::Loader => LoaderLoads {
            stamp: *stamp,
            ..loader(&told)
        }
        .envelope(),
    }
}

/// The channel of a machine's loads.
#[must_use]
pub fn channel(machine: Machine) -> &'static Channel {
    match machine {
        Machine::Excavator => EXCAVATOR_LOADS.any(),
        Machine::Loader => LOADER_LOADS.any(),
    }
}
