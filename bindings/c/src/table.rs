//! The interface of a machine for other languages: its numbers in their order, each with a conversion to
//! or from the types of `estimation`.

use core::fmt::Display;

use estimation::loads;

use crate::settings::Settings;

/// A signal of a row; its bit in `columns` is its position, without the time.
pub struct Signal<T> {
    /// Name in data.
    pub name: &'static str,
    /// Sets a value; NaN is a missing sample.
    pub put: fn(&mut T, f64),
}

/// A number of an answer.
pub struct Value<E> {
    /// Name in data.
    pub name: &'static str,
    /// The number; 0 where the method does not estimate it.
    pub get: fn(&E) -> f64,
}

/// A bit of an answer; its position in the table is the bit number.
pub struct Bit<E> {
    /// Name.
    pub name: &'static str,
    /// Whether it is set.
    pub get: fn(&E) -> bool,
}

/// A machine with an estimator for another language.
pub trait Machine: Sized + Clone + 'static {
    /// Name on the command line.
    const NAME: &'static str;
    /// Its description.
    type Settings: Settings;
    /// A row.
    type Sample: Default;
    /// An answer.
    type Estimate;
    /// All signals; the first is the time.
    const SIGNALS: &'static [Signal<Self::Sample>];
    /// Sensors that a machine must have at least one of, group by group.
    const REQUIRED: &'static [&'static [&'static str]];
    /// All numbers of an answer; the first is the time.
    const VALUES: &'static [Value<Self::Estimate>];
    /// Bits of the verdict.
    const FLAGS: &'static [Bit<Self::Estimate>];
    /// Bits of the quantities that the method estimates.
    const ESTIMATED: &'static [Bit<Self::Estimate>];
    /// Methods by their number.
    const METHODS: &'static [&'static str];

    /// An estimator before its first row. `columns`: bits of the existing signals.
    ///
    /// # Errors
    /// Which setting, method or columns are not valid, as text.
    fn new(settings: &Self::Settings, method: usize, columns: u32) -> Result<Self, impl Display>;

    /// Settings of the ledger of loads for such a machine.
    fn loads(settings: &Self::Settings) -> loads::Settings;

    /// Takes one row and returns an answer in every case.
    fn step(&mut self, sample: &Self::Sample) -> Self::Estimate;

    /// Number of the method that made an answer.
    fn method(estimate: &Self::Estimate) -> usize;

    /// Code of the reason why the answer is not trusted, 0 for none.
    fn reason(estimate: &Self::Estimate) -> u32;

    /// Number of refused rows.
    fn refused(estimate: &Self::Estimate) -> u64;
}

/// An answer in the C interface.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer<const N: usize> {
    /// In the order of [`Machine::VALUES`].
    pub values: [f64; N],
    /// Number of refused rows.
    pub refused: u64,
    /// Verdict bits.
    pub flags: u32,
    /// Bits of the quantities that the method estimates.
    pub estimated: u32,
    /// Number of the method that made the answer.
    pub method: u32,
    /// Code of the reason why it is not trusted, 0 for none.
    pub reason: u32,
}

/// A row from its numbers.
pub fn sample<M: Machine>(numbers: &[f64]) -> M::Sample {
    let mut sample = M::Sample::default();
    for (signal, number) in M::SIGNALS.iter().zip(numbers) {
        (signal.put)(&mut sample, *number);
    }
    sample
}

/// An answer as numbers and bits.
pub fn answer<M: Machine, const N: usize>(estimate: &M::Estimate) -> Answer<N> {
    let mut values = [0.0; N];
    for (value, number) in M::VALUES.iter().zip(&mut values) {
        *number = (value.get)(estimate);
    }
    Answer {
        values,
        refused: M::refused(estimate),
        flags: bits(M::FLAGS, estimate),
        estimated: bits(M::ESTIMATED, estimate),
        method: M::method(estimate) as u32,
        reason: M::reason(estimate),
    }
}

/// These bits as a word.
pub fn bits<E>(bits: &[Bit<E>], estimate: &E) -> u32 {
    let set = bits
        .iter()
        .enumerate()
        .filter(|(_, bit)| (bit.get)(estimate));
    set.fold(0, |all, (i, _)| all | 1 << i)
}

/// A number; none for NaN.
pub(crate) fn present(number: f64) -> Option<f64> {
    (!number.is_nan()).then_some(number)
}

/// `VALUES` of a machine, the time first, and `ESTIMATED`, each at the position of its bit.
macro_rules! quantities {
    (
        estimated { $( $bit:literal $const:ident $bit_name:ident ($($has:tt)*) $bit_doc:tt; )* }
        first { $( $name:ident ($($place:tt)*) [$( $std:ident ($($std_place:tt)*) )?] $unit:tt $doc:tt $facts:tt; )* }
        later { $( $name2:ident ($($place2:tt)*) [$( $std2:ident ($($std_place2:tt)*) )?] $unit2:tt $doc2:tt $facts2:tt; )* }
    ) => {
        const VALUES: &'static [$crate::table::Value<Timed>] = &{
            use $crate::table::Value;
            [
                Value { name: "t", get: |e| e.time },
                $(
                    Value { name: stringify!($name), get: |e| e.estimate.$($place)* },
                    $( Value { name: stringify!($std), get: |e| e.estimate.$($std_place)* }, )?
                )*
                $(
                    Value { name: stringify!($name2), get: |e| e.estimate.$($place2)* },
                    $( Value { name: stringify!($std2), get: |e| e.estimate.$($std_place2)* }, )?
                )*
            ]
        };

        const ESTIMATED: &'static [$crate::table::Bit<Timed>] = &{
            use $crate::table::{Bit, has};
            const NEVER: Bit<Timed> = Bit { name: "", get: |_| false };
            let mut all = [NEVER; [$( $bit ),*].len()];
            $( all[$bit] = Bit { name: stringify!($bit_name), get: |e| e.started() && has!(e, $($has)*) }; )*
            all
        };
    };
}

/// Whether an estimate contains a quantity; always, without a condition.
macro_rules! has {
    ($e:ident,) => {
        true
    };
    ($e:ident, $($place:tt)+) => {
        $e.estimate.$($place)+
    };
}

/// `SIGNALS` of a machine, the time first, then each at the position of its bit.
macro_rules! signals {
    (
        first { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $unit:tt $doc:tt $presence:ident; )* }
        later { $( $bit2:literal $const2:ident $name2:ident ($($place2:tt)*) $unit2:tt $doc2:tt $presence2:ident; )* }
        switches { $( $bit3:literal $const3:ident $name3:ident ($($place3:tt)*) $unit3:tt $doc3:tt $presence3:ident; )* }
    ) => {
        const SIGNALS: &'static [$crate::table::Signal<Sample>] = &{
            use $crate::table::{Signal, present};
            const TIME: Signal<Sample> = Signal { name: "t", put: |s, x| s.time = x };
            let mut all = [TIME; 1 + [$( $bit, )* $( $bit2, )* $( $bit3 ),*].len()];
            $( all[1 + $bit] = Signal { name: stringify!($name), put: |s, x| s.$($place)* = present(x) }; )*
            $( all[1 + $bit2] = Signal { name: stringify!($name2), put: |s, x| s.$($place2)* = present(x) }; )*
            $( all[1 + $bit3] = Signal { name: stringify!($name3), put: |s, x| s.$($place3)* = x > 0.0 }; )*
            all
        };
    };
}

/// `FLAGS` of a machine, each at the position of its bit; flags that only a process can set are never set here.
macro_rules! flags {
    (
        estimator { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $doc:tt $facts:tt; )* }
        process { $( $bit2:literal $const2:ident $name2:ident $doc2:tt $facts2:tt; )* }
    ) => {
        const FLAGS: &'static [$crate::table::Bit<Timed>] = &{
            use $crate::table::Bit;
            const NEVER: Bit<Timed> = Bit { name: "", get: |_| false };
            let mut all = [NEVER; [$( $bit, )* $( $bit2 ),*].len()];
            $( all[$bit] = Bit { name: stringify!($name), get: |e| e.estimate.$($place)* }; )*
            $( all[$bit2] = Bit { name: stringify!($name2), get: |_| false }; )*
            all
        };
    };
}

pub(crate) use {flags, has, quantities, signals};
