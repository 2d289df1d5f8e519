//! What this crate has of each machine, put aside from its types.

use std::path::{Path, PathBuf};

use messages::Machine;

use crate::can::FrameTable;
use crate::signal::{Signal, signals};
use crate::{Error, suggest};

/// A map that was guessed, after the number of signals that it names.
type Guess = Result<(usize, String), Error>;

/// A machine as this crate sees it.
pub(crate) struct Entry {
    /// All signals, the time first.
    pub signals: fn() -> Vec<Signal>,
    /// Guesses a map from a CAN log with its DBC files, or from a table.
    pub from_log: fn(&Path, &[PathBuf]) -> Guess,
    pub from_table: fn(&Path) -> Guess,
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
                    signals: signals::<messages::$sensors>,
                    from_log: suggest::log::<messages::$sensors>,
                    from_table: suggest::table::suggest::<messages::$sensors>,
                    frames: &crate::$module::FRAMES,
                    reasons: <messages::$estimate as crate::csv::Estimate>::REASONS,
                }, )*
            }
        }
    };
}

messages::machines!(entries);
