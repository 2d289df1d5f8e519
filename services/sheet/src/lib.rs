//! A machine is one sheet: its signals, flags, quantities, reasons and methods, a row each.
//!
//! Everything that lists them reads it here: messages and their bits, samples and reasons of `estimation`, the
//! conversions between both, CSV columns and maps, the schema in every language, the tables for C and FMI.
//! A row says what is a fact of the machine, or what two readers need; what one output needs stands there.
//!
//! | what | where |
//! |---|---|
//! | rows as a macro that hands them to another (`excavator_signals!(then)`): structures are made of them | [`excavator`], [`loader`] |
//! | rows as constants: tables are read from them | the same modules: `SIGNALS`, `FLAGS`, `QUANTITIES`, `REASONS`, `METHODS` |
#![no_std]

/// When a signal counts as one that the source has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// The machine needs it.
    Required,
    /// The machine needs one of these; each counts where a value comes within the first second.
    OneOf,
    /// Where a value comes within the first second.
    Observed,
    /// Where the source has its column.
    Declared,
}

/// A signal of the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signal {
    /// Name in messages, columns, maps.
    pub name: &'static str,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// What it is, with its sign.
    pub doc: &'static str,
    /// Its bit in `valid` and `columns`.
    pub bit: u32,
    /// When it counts as there.
    pub presence: Presence,
    /// It is a bit of `valid` alone, without a number.
    pub is_switch: bool,
}

impl Signal {
    const NONE: Self = Self {
        name: "",
        unit: "",
        doc: "",
        bit: 0,
        presence: Presence::Declared,
        is_switch: false,
    };
}

/// A bit or a code with its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// The bit as a mask, or the code.
    pub number: u32,
    /// Name in every output; "" where there is nothing to say.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
}

impl Entry {
    const NONE: Self = Self {
        number: 0,
        name: "",
        doc: "",
    };
}

/// Bits of the signals of this presence.
#[must_use]
pub const fn bits(signals: &[Signal], presence: Presence) -> u32 {
    let (mut bits, mut i) = (0, 0);
    while i < signals.len() {
        if signals[i].presence as u32 == presence as u32 {
            bits |= signals[i].bit;
        }
        i += 1;
    }
    bits
}

/// `SIGNALS` of rows, each at the place of its bit.
macro_rules! signals {
    (
        first { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $unit:literal $doc:literal $presence:ident; )* }
        later { $( $bit2:literal $const2:ident $name2:ident ($($place2:tt)*) $unit2:literal $doc2:literal $presence2:ident; )* }
        switches { $( $bit3:literal $const3:ident $name3:ident ($($place3:tt)*) $unit3:literal $doc3:literal $presence3:ident; )* }
    ) => {
        /// The signals in the order of their bits.
        pub const SIGNALS: &[Signal] = &{
            let mut all = [Signal::NONE; [$( $bit, )* $( $bit2, )* $( $bit3 ),*].len()];
            $( all[$bit] = signal(stringify!($name), $unit, $doc, $bit, Presence::$presence, false); )*
            $( all[$bit2] = signal(stringify!($name2), $unit2, $doc2, $bit2, Presence::$presence2, false); )*
            $( all[$bit3] = signal(stringify!($name3), $unit3, $doc3, $bit3, Presence::$presence3, true); )*
            all
        };
    };
}

const fn signal(
    name: &'static str,
    unit: &'static str,
    doc: &'static str,
    bit: u32,
    presence: Presence,
    is_switch: bool,
) -> Signal {
    Signal {
        name,
        unit,
        doc,
        bit: 1 << bit,
        presence,
        is_switch,
    }
}

const fn entry(number: u32, name: &'static str, doc: &'static str) -> Entry {
    Entry { number, name, doc }
}

/// `FLAGS` of rows, each at the place of its bit.
macro_rules! flags {
    (
        estimator { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $doc:literal; )* }
        process { $( $bit2:literal $const2:ident $name2:ident $doc2:literal; )* }
    ) => {
        /// Bits of `flags` in an estimate, in their order.
        pub const FLAGS: &[Entry] = &{
            let mut all = [Entry::NONE; [$( $bit, )* $( $bit2 ),*].len()];
            $( all[$bit] = entry(1 << $bit, stringify!($name), $doc); )*
            $( all[$bit2] = entry(1 << $bit2, stringify!($name2), $doc2); )*
            all
        };
    };
}

/// `QUANTITIES` of rows.
macro_rules! quantities {
    ($( $bit:literal $const:ident $name:ident $doc:literal; )*) => {
        /// Bits of `estimated` in an estimate.
        pub const QUANTITIES: &[Entry] = &[$( entry(1 << $bit, stringify!($name), $doc) ),*];
    };
}

/// `REASONS` of rows.
macro_rules! reasons {
    ($( $code:literal $variant:ident $name:literal $words:literal; )*) => {
        /// Reasons by their code; 0 is none.
        pub const REASONS: &[Entry] = &[$( entry($code, $name, $words) ),*];
    };
}

/// `METHODS` of rows.
macro_rules! methods {
    ($( $index:literal $variant:ident $name:literal $doc:literal; )*) => {
        /// Methods by their index, the default first.
        pub const METHODS: &[Entry] = &[$( entry($index, $name, $doc) ),*];
    };
}

/// All constants of a machine from its rows.
macro_rules! tables {
    ($signals:ident, $flags:ident, $quantities:ident, $reasons:ident, $methods:ident) => {
        use $crate::{Entry, Presence, Signal, entry, signal};
        $signals!(signals);
        $flags!(flags);
        $quantities!(quantities);
        $reasons!(reasons);
        $methods!(methods);
    };
}

pub mod excavator;
pub mod loader;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_signal_has_one_bit_and_what_is_needed_says_so() {
        for (signals, required) in [
            (excavator::SIGNALS, excavator::REQUIRED),
            (loader::SIGNALS, loader::REQUIRED),
        ] {
            for (i, s) in signals.iter().enumerate() {
                assert_eq!(s.bit, 1 << i, "a row is missing at bit {i}, or two have it");
                assert!(s.doc.ends_with('.'), "{}", s.name);
                let groups = required.iter().filter(|group| group.contains(&s.name));
                let lengths: usize = groups.map(|group| group.len()).sum();
                let expected = match s.presence {
                    Presence::Required => lengths == 1,
                    Presence::OneOf => lengths > 1,
                    Presence::Observed | Presence::Declared => lengths == 0,
                };
                assert!(expected, "{}", s.name);
            }
            // The highest bit says that samples are simulated.
            assert!(signals.len() < 31);
        }
    }

    #[test]
    fn bits_and_codes_are_used_once_and_in_order() {
        for flags in [excavator::FLAGS, loader::FLAGS] {
            assert!(flags.iter().enumerate().all(|(i, f)| f.number == 1 << i));
        }
        for bits in [excavator::QUANTITIES, loader::QUANTITIES] {
            assert!(bits.iter().enumerate().all(|(i, b)| b.number == 1 << i));
        }
        for codes in [
            excavator::REASONS,
            loader::REASONS,
            excavator::METHODS,
            loader::METHODS,
        ] {
            for (i, code) in codes.iter().enumerate() {
                assert_eq!(code.number as usize, i, "{}", code.name);
                let same = codes.iter().filter(|c| c.name == code.name);
                assert_eq!(same.count(), 1, "{}", code.name);
            }
        }
    }
}
