//! What the numbers of a message mean that are bits or codes, from the sheet.

pub use sheet::Entry;

/// The names of a field's bits, or of its codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Words {
    /// Each entry is a bit.
    Bits(&'static [Entry]),
    /// Each entry is a value.
    Codes(&'static [Entry]),
}

impl Words {
    /// The entry of a code; `None` for bits, and for a code that this version does not know.
    #[must_use]
    pub fn of(&self, code: u32) -> Option<&'static Entry> {
        match self {
            Self::Bits(_) => None,
            Self::Codes(entries) => entries.iter().find(|e| e.number == code),
        }
    }
}

/// Constants of the bits of signals.
macro_rules! signal_bits {
    (
        first { $( $bit:literal $const:ident $name:ident $place:tt $unit:tt $doc:tt $presence:ident; )* }
        later { $( $bit2:literal $const2:ident $name2:ident $place2:tt $unit2:tt $doc2:tt $presence2:ident; )* }
        switches { $( $bit3:literal $const3:ident $name3:ident $place3:tt $unit3:tt $doc3:tt $presence3:ident; )* }
    ) => {
        $( #[doc = $doc] pub const $const: u32 = 1 << $bit; )*
        $( #[doc = $doc2] pub const $const2: u32 = 1 << $bit2; )*
        $( #[doc = $doc3] pub const $const3: u32 = 1 << $bit3; )*
    };
}

/// Constants of the bits of flags.
macro_rules! flag_bits {
    (
        estimator { $( $bit:literal $const:ident $name:ident $place:tt $doc:literal; )* }
        process { $( $bit2:literal $const2:ident $name2:ident $doc2:literal; )* }
    ) => {
        $( #[doc = $doc] pub const $const: u32 = 1 << $bit; )*
        $( #[doc = $doc2] pub const $const2: u32 = 1 << $bit2; )*
    };
}

/// Constants of the bits of quantities.
macro_rules! quantity_bits {
    ($( $bit:literal $const:ident $name:ident $doc:literal; )*) => {
        $( #[doc = $doc] pub const $const: u32 = 1 << $bit; )*
    };
}

/// The message of a machine's sensors: numbers, the bits, and the numbers that came later.
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

pub(crate) use {flag_bits, method_names, quantity_bits, reason_pairs, sensors, signal_bits};
