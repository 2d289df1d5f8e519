//! Macros that define the constants of a machine from its rows.

/// Defines `SIGNALS`, each row at the index of its bit.
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

/// Defines `FLAGS`, each row at the index of its bit.
macro_rules! flags {
    (
        estimator { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $doc:tt { $( $fact:ident: $is:expr ),* }; )* }
        process { $( $bit2:literal $const2:ident $name2:ident $doc2:tt { $( $fact2:ident: $is2:expr ),* }; )* }
    ) => {
        /// Bits of `flags` in an estimate, in their order.
        #[allow(clippy::needless_update, reason = "a row may say everything")]
        pub const FLAGS: &[Flag] = &{
            let mut all = [Flag::NONE; [$( $bit, )* $( $bit2 ),*].len()];
            $( all[$bit] = Flag { $( $fact: $is, )* entry: entry(1 << $bit, stringify!($name), $doc), ..Flag::NONE }; )*
            $( all[$bit2] = Flag { $( $fact2: $is2, )* entry: entry(1 << $bit2, stringify!($name2), $doc2), ..Flag::NONE }; )*
            all
        };
    };
}

/// Defines `QUANTITIES` and `ESTIMATED`.
macro_rules! quantities {
    (
        estimated { $( $bit:literal $const:ident $bit_name:ident ($($has:tt)*) $bit_doc:tt; )* }
        first { $( $name:ident ($($place:tt)*) [$( $std:ident ($($std_place:tt)*) )?] $unit:tt $doc:tt { $( $fact:ident: $is:expr ),* }; )* }
        later { $( $name2:ident ($($place2:tt)*) [$( $std2:ident ($($std_place2:tt)*) )?] $unit2:tt $doc2:tt { $( $fact2:ident: $is2:expr ),* }; )* }
    ) => {
        /// Bits of `estimated` in an estimate.
        pub const ESTIMATED: &[Entry] = &[$( entry(1 << $bit, stringify!($bit_name), $bit_doc) ),*];

        /// The numbers of an estimate, in the order of its message.
        pub const QUANTITIES: &[Quantity] = &{
            use bits::*;
            [
                $( Quantity {
                    $( $fact: $is, )*
                    $( std: Some(stringify!($std)), )?
                    name: stringify!($name), unit: $unit, doc: $doc, ..EVERY
                }, )*
                $( Quantity {
                    $( $fact2: $is2, )*
                    $( std: Some(stringify!($std2)), )?
                    name: stringify!($name2), unit: $unit2, doc: $doc2, ..EVERY
                }, )*
            ]
        };
    };
}

/// Defines the bit constants of the signals.
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

/// Defines the bit constants of the flags.
macro_rules! flag_bits {
    (
        estimator { $( $bit:literal $const:ident $name:ident $place:tt $doc:tt $facts:tt; )* }
        process { $( $bit2:literal $const2:ident $name2:ident $doc2:tt $facts2:tt; )* }
    ) => {
        $( #[doc = $doc] pub const $const: u32 = 1 << $bit; )*
        $( #[doc = $doc2] pub const $const2: u32 = 1 << $bit2; )*
    };
}

/// Defines the bit constants of `estimated`.
macro_rules! estimated_bits {
    (
        estimated { $( $bit:literal $const:ident $name:ident $has:tt $doc:tt; )* }
        first $first:tt
        later $later:tt
    ) => {
        $( #[doc = $doc] pub const $const: u32 = 1 << $bit; )*
    };
}

/// Defines `REASONS`.
macro_rules! reasons {
    ($( $code:literal $variant:ident $name:literal $words:literal; )*) => {
        /// Reasons by their code; 0 is none.
        pub const REASONS: &[Entry] = &[$( entry($code, $name, $words) ),*];
    };
}

/// Defines `METHODS`.
macro_rules! methods {
    ($( $index:literal $variant:ident $name:literal $doc:literal; )*) => {
        /// Methods by their index, the default first.
        pub const METHODS: &[Entry] = &[$( entry($index, $name, $doc) ),*];
    };
}

/// Defines all constants of a machine from its rows.
macro_rules! tables {
    ($signals:ident, $flags:ident, $quantities:ident, $reasons:ident, $methods:ident) => {
        use $crate::{
            Column, Entry, Flag, POSITIVE, Presence, Quantity, Signal, VerdictFrame, entry, frame,
            signal,
        };

        /// Bit constants by name.
        pub mod bits {
            $signals!(signal_bits);
            $flags!(flag_bits);
            $quantities!(estimated_bits);
        }

        $signals!(signals);
        $flags!(flags);
        $quantities!(quantities);
        $reasons!(reasons);
        $methods!(methods);
    };
}
