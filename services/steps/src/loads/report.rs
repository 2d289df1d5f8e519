//! Report of the ledger as a message for other programs.

use estimation::loads::LoadReport;
use messages::channels::{Channel, EXCAVATOR_LOADS, LOADER_LOADS};
use messages::{Envelope, ExcavatorLoads, LoaderLoads, Machine, Message, Stamp, loads_bits};

use super::LoadCounter;
use super::outage::are_doubtful;
use super::why::REASON;

/// The messages from the rows of the sheet.
macro_rules! fill {
    (
        numbers { $( $name:ident $place:tt $unit:tt $doc:tt; )* }
        codes { $( $code:ident $code_place:tt $code_doc:tt; )* }
    ) => {
        fn excavator(report: &LoadReport) -> ExcavatorLoads {
            let mut message = ExcavatorLoads::default();
            $( message.$name = report.$name; )*
            $( message.$code = report.$code; )*
            message
        }

        fn loader(report: &LoadReport) -> LoaderLoads {
            let mut message = LoaderLoads::default();
            $( message.$name = report.$name; )*
            $( message.$code = report.$code; )*
            message
        }
    };
}

sheet::loads_fields!(fill);

/// State of the bucket, the latest load and its truck, as a message beside the estimate of this stamp.
pub fn message(counter: &LoadCounter, stamp: &Stamp) -> Envelope {
    let mut report = LoadReport::of(counter.ledger(), counter.loads().next_back());
    report.reason &= REASON;
    if are_doubtful(&counter.outages(), counter.seconds()) {
        report.flags |= loads_bits::OUTAGE;
    }
    match counter.machine() {
        Machine::Excavator => ExcavatorLoads {
            stamp: *stamp,
            ..excavator(&report)
        }
        .envelope(),
        Machine::Loader => LoaderLoads {
            stamp: *stamp,
            ..loader(&report)
        }
        .envelope(),
    }
}

/// The channel of a machine's loads.
pub fn channel(machine: Machine) -> &'static Channel {
    match machine {
        Machine::Excavator => EXCAVATOR_LOADS.any(),
        Machine::Loader => LOADER_LOADS.any(),
    }
}
