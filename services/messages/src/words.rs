//! Meaning of the numbers of a message that are bits or codes, from the sheet.

use std::borrow::Cow;

pub use crate::codes::{Entry, UNKNOWN, Words};
use crate::{Message, Shape, Value};

/// A field, or a bit of one, as shown to people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Said {
    /// A number.
    Number(Value),
    /// A flag.
    Flag(bool),
    /// A code by its name; "" for none.
    Word(&'static str),
    /// An absent number: not measured, or not estimated.
    Missing,
}

/// Presence of the numbers of a message: an absent one is 0, and its bit is not set.
#[derive(Debug, Clone, Copy)]
pub struct Presence {
    /// The field with these bits.
    pub field: &'static str,
    entries: &'static [Entry],
    /// Earlier versions recorded estimates without their bits: there, a nonzero number is present.
    is_estimate: bool,
}

impl Presence {
    /// The presence bits of a message; `None` if all its numbers are always present.
    pub fn of(message: &Shape) -> Option<Self> {
        let of = |field, is_estimate| match message.words_of(field) {
            Some(Words::Bits(entries)) => Some(Self {
                field,
                entries,
                is_estimate,
            }),
            _ => None,
        };
        of("valid", false).or_else(|| of("estimated", true))
    }

    /// The bit of a number or of its standard deviation; 0 for one that is always present.
    pub fn bit(&self, field: &str) -> u32 {
        let name = field.strip_suffix("_std").unwrap_or(field);
        let entry = self.entries.iter().find(|entry| entry.name == name);
        entry.map_or(0, |entry| entry.number)
    }

    /// Whether a number with this bit is absent, given the bits that are set.
    pub fn is_missing(&self, value: Value, bit: u32, set: u32) -> bool {
        bit & !set != 0 && (!self.is_estimate || value == Value::F64(0.0))
    }
}

/// The flags of a message by their names in every output, each with its mask and meaning. A flag with the name of a field gets
/// the suffix `_now`.
pub fn flags(message: Shape) -> impl Iterator<Item = (Cow<'static, str>, &'static Entry)> {
    let flags = match message.words_of("flags") {
        Some(Words::Bits(entries)) => *entries,
        _ => &[],
    };
    let simulated = Some(&SIMULATED_ENTRY).filter(|_| !flags.is_empty());
    flags.iter().chain(simulated).map(move |entry| {
        let name = match message.index(entry.name) {
            Some(_) => Cow::Owned(format!("{}_now", entry.name)),
            None => Cow::Borrowed(entry.name),
        };
        (name, entry)
    })
}

/// The flag that every message of a machine can have.
pub const SIMULATED_ENTRY: Entry = Entry {
    number: crate::SIMULATED,
    name: "simulated",
    doc: "Made from simulated samples, nothing was measured.",
};

/// All fields of a message without the reserved ones, with codes by their names, then its flags.
pub fn said<M: Message>(message: &M) -> impl Iterator<Item = (Cow<'static, str>, Said)> {
    let shape = Shape::of::<M>();
    let presence = Presence::of(&shape);
    let set = presence.map_or(0, |p| message.bits_of(p.field));
    let is_missing =
        move |name, value| presence.is_some_and(|p| p.is_missing(value, p.bit(name), set));
    let fields = M::FIELDS.iter().enumerate();
    let fields = fields.filter(|(_, field)| !field.name.starts_with("reserved"));
    let fields = fields.filter_map(move |(i, field)| {
        let value = message.get(i)?;
        let said = match (shape.words_of(field.name), value) {
            (Some(words @ Words::Codes(_)), Value::U32(code)) => Said::Word(words.name(code)),
            _ if is_missing(field.name, value) => Said::Missing,
            // The time of a row without a time is not finite, although its bit is set.
            (_, Value::F64(number)) if !number.is_finite() => Said::Missing,
            _ => Said::Number(value),
        };
        Some((Cow::Borrowed(field.name), said))
    });
    let bits = message.bits_of("flags");
    let flags = flags(shape).map(move |(name, f)| (name, Said::Flag(bits & f.number != 0)));
    fields.chain(flags)
}

/// The message of a machine's sensors: numbers, the bits, and the numbers of later versions.
macro_rules! sensors {
    (
        $(#[doc = $about:literal])*
        $message:ident, $type_name:tt, size $size:literal, words $words:ident
        first { $( $bit:literal $const:ident $name:ident $place:tt $unit:tt $doc:tt $presence:ident; )* }
        later { $( $bit2:literal $const2:ident $name2:ident $place2:tt $unit2:tt $doc2:tt $presence2:ident; )* }
        switches $switches:tt
    ) => {
        $crate::message::message! {
            $(#[doc = $about])*
            pub struct $message, $type_name, size $size, marked in columns, words $words {
                $( #[doc = $doc] $name: f64, $unit; )*
                /// Bits of the signals that this sample carries.
                valid: u32, "";
                /// Bits of the signals that the source has at all.
                columns: u32, "";
                $( #[doc = $doc2] $name2: f64, $unit2; )*
            }
        }
    };
}

/// The message of a machine's estimates: numbers, the bits and codes, and the numbers of later versions.
macro_rules! estimates {
    (
        $(#[doc = $about:literal])*
        $message:ident, $type_name:tt, size $size:literal, words $words:ident { $($bits:tt)* }
        estimated $estimated:tt
        first { $( $name:ident $place:tt [$( $std:ident $std_place:tt )?] $unit:tt $doc:tt $facts:tt; )* }
        later { $( $name2:ident $place2:tt [$( $std2:ident $std_place2:tt )?] $unit2:tt $doc2:tt $facts2:tt; )* }
    ) => {
        $crate::message::message! {
            $(#[doc = $about])*
            pub struct $message, $type_name, size $size, marked in flags, words $words {
                $(
                    #[doc = $doc] $name: f64, $unit;
                    $( #[doc = concat!("Standard deviation of `", stringify!($name), "`, as reported.")] $std: f64, $unit; )?
                )*
                $($bits)*
                $(
                    #[doc = $doc2] $name2: f64, $unit2;
                    $( #[doc = concat!("Standard deviation of `", stringify!($name2), "`, as reported.")] $std2: f64, $unit2; )?
                )*
            }
        }
    };
}

/// Name and words of each reason by its code.
macro_rules! reason_pairs {
    ($( $code:literal $variant:ident $name:literal $words:literal; )*) => { &[$( ($name, $words) ),*] };
}

/// Name of each method by its index.
macro_rules! method_names {
    ($( $index:literal $variant:ident $name:literal $doc:literal; )*) => { &[$( $name ),*] };
}

/// Signals as bits with names.
pub(crate) const fn signal_entries<const N: usize>(signals: &[sheet::Signal]) -> [Entry; N] {
    let mut entries = [Entry {
        number: 0,
        name: "",
        doc: "",
    }; N];
    let mut i = 0;
    while i < N {
        entries[i] = Entry {
            number: signals[i].bit,
            name: signals[i].name,
            doc: signals[i].doc,
        };
        i += 1;
    }
    entries
}

pub(crate) use {estimates, method_names, reason_pairs, sensors};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, excavator_bits};

    fn of<M: Message>(message: &M, name: &str) -> Option<Said> {
        said(message).find(|(n, _)| n == name).map(|(_, said)| said)
    }

    #[test]
    fn a_verdict_is_said_in_words() {
        let message = ExcavatorEstimate {
            flags: excavator_bits::TRUSTED | excavator_bits::REFUSED,
            reason: 11,
            method: 3,
            refused: 7,
            ..ExcavatorEstimate::default()
        };
        assert_eq!(of(&message, "trusted"), Some(Said::Flag(true)));
        assert_eq!(of(&message, "fresh"), Some(Said::Flag(false)));
        assert_eq!(of(&message, "reason"), Some(Said::Word("content")));
        assert_eq!(of(&message, "method"), Some(Said::Word("posture-torque")));
        let count = Said::Number(Value::U64(7));
        assert_eq!(of(&message, "refused"), Some(count));
        assert_eq!(of(&message, "refused_now"), Some(Said::Flag(true)));
        assert_eq!(of(&message, "simulated"), Some(Said::Flag(false)));
        assert_eq!(of(&message, "reserved_2"), None);
        let unknown = LoaderEstimate {
            reason: 4_000,
            ..LoaderEstimate::default()
        };
        assert_eq!(of(&unknown, "reason"), Some(Said::Word(UNKNOWN)));
        assert_eq!(of(&ExcavatorSensors::default(), "simulated"), None);
    }

    #[test]
    fn a_number_without_its_bit_is_missing_and_a_measured_zero_is_not() {
        let message = ExcavatorSensors {
            valid: 1,
            ..ExcavatorSensors::default()
        };
        let zero = Some(Said::Number(Value::F64(0.0)));
        assert_eq!(of(&message, "swing_velocity"), zero);
        assert_eq!(of(&message, "pitch"), Some(Said::Missing));
        let message = ExcavatorEstimate {
            inertia: 7e3,
            ..ExcavatorEstimate::default()
        };
        assert_eq!(of(&message, "friction_std"), Some(Said::Missing));
        assert_eq!(of(&message, "velocity"), zero);
        // Earlier recordings had no bit for it, and it is not 0.
        let inertia = Some(Said::Number(Value::F64(7e3)));
        assert_eq!(of(&message, "inertia"), inertia);
    }

    #[test]
    fn no_two_columns_have_one_name() {
        fn names<M: Message>() -> usize {
            let names: std::collections::BTreeSet<_> =
                said(&M::default()).map(|(name, _)| name).collect();
            said(&M::default()).count() - names.len()
        }
        assert_eq!(names::<ExcavatorEstimate>(), 0);
        assert_eq!(names::<LoaderEstimate>(), 0);
    }
}
