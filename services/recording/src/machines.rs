//! Data of each machine in this crate, independent of its types.

use messages::Machine;

use crate::can::FrameTable;

/// A machine as this crate sees it.
pub(crate) struct Entry {
    /// Its estimates as CAN frames.
    pub frames: &'static FrameTable,
    /// Names and words of the reasons of its estimates.
    pub reasons: &'static [(&'static str, &'static str)],
}

macro_rules! entries {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The entry of a machine.
        pub(crate) fn of(machine: Machine) -> Entry {
            match machine {
                $( Machine::$machine => Entry {
                    frames: &crate::$module::FRAMES,
                    reasons: <messages::$estimate as crate::csv::Estimate>::REASONS,
                }, )*
            }
        }
    };
}

messages::machines!(entries);
