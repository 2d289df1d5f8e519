//! Tables of each machine: signals, flags, quantities, reasons and methods, one row each.
//!
//! All lists of them are generated from these tables: messages and their bits, samples and reasons of `estimation`,
//! and the conversions between messages and samples. Others are CSV columns and maps, CAN frames and the schema in every
//! language. Pages, terminal and fleet lists, the state stored between runs, and the tables for C and FMI use them too.
//! A row holds facts of the machine, and what at least two readers need. Data that only one output needs belong to that output.
//!
//! | what | where |
//! |---|---|
//! | rows as a macro that passes them to another macro (`excavator_signals!(then)`), which defines structures | [`excavator`], [`loader`] |
//! | rows as constants, to read tables from | the same modules: `SIGNALS`, `FLAGS`, `QUANTITIES`, `REASONS`, `METHODS` |
//! | loads, the same for every machine | [`loads`] |
#![no_std]

/// Condition for a signal to count as present in its source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Always: the machine requires it.
    Required,
    /// If a value arrives within the first second. The machine requires at least one of a group of these.
    OneOf,
    /// If a value arrives within the first second.
    Observed,
    /// If the source has its column.
    Declared,
}

/// A signal of the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signal {
    /// Name in messages, columns, maps.
    pub name: &'static str,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Meaning and sign convention.
    pub doc: &'static str,
    /// Its bit in `valid` and `columns`.
    pub bit: u32,
    /// When it counts as present.
    pub presence: Presence,
    /// Whether it is only a bit of `valid`, without a number.
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
    /// Name in every output; "" for code 0, no reason.
    pub name: &'static str,
    /// Meaning.
    pub doc: &'static str,
}

impl Entry {
    const NONE: Self = Self {
        number: 0,
        name: "",
        doc: "",
    };
}

/// A bit of the verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flag {
    /// The bit, its name, its meaning.
    pub entry: Entry,
    /// Whether it has a column in tables.
    pub column: bool,
    /// Its place in the CAN frame of the verdict; none if it is not sent.
    pub frame: Option<u32>,
}

impl Flag {
    const NONE: Self = Self {
        entry: Entry::NONE,
        column: false,
        frame: None,
    };
}

/// A number of an estimate, with its standard deviation if it has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// Name of the field, the same in the truth.
    pub name: &'static str,
    /// Name of the field of its standard deviation.
    pub std: Option<&'static str>,
    /// SI unit, "" for a pure number.
    pub unit: &'static str,
    /// Meaning and sign convention.
    pub doc: &'static str,
    /// Bits of `estimated` that are set if the method estimates it; 0 for always.
    pub estimated: u32,
    /// Bit of `flags` that is set while it is trusted; 0 if it has no verdict.
    pub trusted: u32,
    /// Whether it is a headline quantity of the machine: `trusted` is then its own verdict.
    pub is_headline: bool,
    /// Bit of `flags` that is set while the motion is informative of it.
    pub excited: u32,
    /// Place in displays, from 1, headline quantities first; 0 if it is not displayed.
    pub shown: u32,
    /// Name in displays.
    pub label: &'static str,
    /// Symbol of a headline.
    pub symbol: &'static str,
    /// Least and largest value that any machine can have.
    pub range: (f64, f64),
    /// Whether it is a constant of the machine, independent of the load, so that days and machines of one type are comparable.
    pub is_of_machine: bool,
    /// Whether it is a load in the bucket, so that its sum over loads is meaningful.
    pub is_load: bool,
    /// Its column in tables.
    pub column: Column,
    /// Its frame on a CAN bus.
    pub frame: Option<Frame>,
    /// Keys of the description that value and standard deviation set in the next run; none if it is not stored.
    pub kept: Option<[&'static str; 2]>,
    /// Bits of `flags` that are set while it is stored, beside `trusted`.
    pub kept_while: u32,
}

impl Quantity {
    const NONE: Self = Self {
        name: "",
        std: None,
        unit: "",
        doc: "",
        estimated: 0,
        trusted: 0,
        is_headline: false,
        excited: 0,
        shown: 0,
        label: "",
        symbol: "",
        range: (f64::NEG_INFINITY, f64::INFINITY),
        is_of_machine: false,
        is_load: false,
        column: Column::Never,
        frame: None,
        kept: None,
        kept_while: 0,
    };
}

/// Range of a quantity that is never negative.
const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

/// Position of the column of a quantity in tables. A cell is empty if the quantity is not estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// No column.
    Never,
    /// In every table, before the flags.
    Always,
    /// In every table, after the flags: columns of a later version do not move earlier ones.
    Last,
}

/// The CAN frame of a quantity: value and standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Name in output maps.
    pub name: &'static str,
    /// Default parameter group number.
    pub group: u16,
    /// Value of one bit, in the unit of the quantity.
    pub scale: f64,
    /// Value at raw 0, in the unit of the quantity; the standard deviation has offset 0.
    pub offset: f64,
}

/// The CAN frame of the verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VerdictFrame {
    /// Default parameter group number.
    pub group: u16,
    /// Place of the flag of simulated samples.
    pub simulated: u32,
}

const fn frame(name: &'static str, group: u16, scale: f64, offset: f64) -> Option<Frame> {
    Some(Frame {
        name,
        group,
        scale,
        offset,
    })
}

/// The bits and names of flags.
pub const fn flag_entries<const N: usize>(flags: &[Flag]) -> [Entry; N] {
    let mut entries = [Entry::NONE; N];
    let mut i = 0;
    while i < N {
        entries[i] = flags[i].entry;
        i += 1;
    }
    entries
}

/// Number of displayed quantities.
pub const fn count_shown(quantities: &[Quantity]) -> usize {
    let (mut count, mut i) = (0, 0);
    while i < quantities.len() {
        count += (quantities[i].shown > 0) as usize;
        i += 1;
    }
    count
}

/// Number of quantities with a CAN frame.
pub const fn count_framed(quantities: &[Quantity]) -> usize {
    let (mut count, mut i) = (0, 0);
    while i < quantities.len() {
        count += quantities[i].frame.is_some() as usize;
        i += 1;
    }
    count
}

/// Number of flags in the frame of the verdict, including that of simulated samples.
pub const fn count_framed_flags(flags: &[Flag]) -> usize {
    let (mut count, mut i) = (1, 0);
    while i < flags.len() {
        count += flags[i].frame.is_some() as usize;
        i += 1;
    }
    count
}

/// The displayed quantities in their order.
pub const fn shown<const N: usize>(quantities: &'static [Quantity]) -> [&'static Quantity; N] {
    let mut all = [&Quantity::NONE; N];
    let mut i = 0;
    while i < quantities.len() {
        if quantities[i].shown > 0 {
            all[quantities[i].shown as usize - 1] = &quantities[i];
        }
        i += 1;
    }
    all
}

/// Bits of all signals with this presence.
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

#[macro_use]
mod rows;
pub mod excavator;
pub mod loader;
pub mod loads;

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
            // The highest bit marks simulated samples.
            assert!(signals.len() < 31);
        }
    }

    #[test]
    fn bits_and_codes_are_used_once_and_in_order() {
        for flags in [excavator::FLAGS, loader::FLAGS] {
            let has_bit = |(i, f): (usize, &Flag)| f.entry.number == 1 << i;
            assert!(flags.iter().enumerate().all(has_bit));
        }
        for bits in [excavator::ESTIMATED, loader::ESTIMATED] {
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

    #[test]
    fn what_people_see_has_one_place_a_label_and_an_interval_where_it_is_judged() {
        for quantities in [excavator::QUANTITIES, loader::QUANTITIES] {
            let shown = quantities.iter().filter(|q| q.shown > 0);
            assert!(shown.clone().all(|q| !q.label.is_empty()));
            let sum: u32 = shown.map(|q| q.shown).sum();
            let count = count_shown(quantities) as u32;
            assert_eq!(sum, count * (count + 1) / 2, "places are 1, 2, 3, ...");
            for q in quantities {
                assert!(q.doc.ends_with('.'), "{}", q.name);
                assert_eq!(q.is_headline, !q.symbol.is_empty(), "{}", q.name);
                let is_judged = q.is_headline || q.frame.is_some() || q.kept.is_some();
                let can_be = q.trusted != 0 && q.std.is_some();
                assert!(!is_judged || can_be, "{}", q.name);
                let same = quantities.iter().filter(|other| other.name == q.name);
                assert_eq!(same.count(), 1, "{}", q.name);
            }
        }
    }

    #[test]
    fn the_frame_of_the_verdict_has_no_gap_and_no_place_twice() {
        for (flags, verdict) in [
            (excavator::FLAGS, excavator::VERDICT_FRAME),
            (loader::FLAGS, loader::VERDICT_FRAME),
        ] {
            let places = flags.iter().filter_map(|f| f.frame);
            let used = places.fold(1 << verdict.simulated, |used: u32, place| {
                assert_eq!(used >> place & 1, 0, "place {place} is used twice");
                used | 1 << place
            });
            assert_eq!(used.trailing_ones(), used.count_ones(), "{used:b}");
        }
    }
}
