//! Conversions between `estimation` and the messages, from the rows of the sheet.

/// `sample()` of a machine: needs `Sample` and `SensorsMessage` in scope.
macro_rules! sample_of_message {
    (
        first { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $unit:tt $doc:tt $presence:ident; )* }
        later { $( $bit2:literal $const2:ident $name2:ident ($($place2:tt)*) $unit2:tt $doc2:tt $presence2:ident; )* }
        switches { $( $bit3:literal $const3:ident $name3:ident ($($place3:tt)*) $unit3:tt $doc3:tt $presence3:ident; )* }
    ) => {
        /// The sample in a message; a signal without its bit is missing.
        pub fn sample(m: &SensorsMessage) -> Sample {
            let valid = |bit: u32, value: f64| (m.valid & (1 << bit) != 0).then_some(value);
            let mut sample = Sample {
                time: m.stamp.time,
                ..Sample::default()
            };
            $( sample.$($place)* = valid($bit, m.$name); )*
            $( sample.$($place2)* = valid($bit2, m.$name2); )*
            $( sample.$($place3)* = m.valid & (1 << $bit3) != 0; )*
            sample
        }
    };
}

/// `flags()` of an estimate as bits; the caller sets those of the process. Needs `Estimate` in scope.
macro_rules! flags_of_estimate {
    (
        estimator { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $doc:tt $facts:tt; )* }
        process $process:tt
    ) => {
        fn flags(e: &Estimate) -> u32 {
            0 $( | u32::from(e.$($place)*) << $bit )*
        }
    };
}

/// `numbers()` of an estimate as its message, and `estimated()`, the bits of the numbers that it has. Needs `Estimate`
/// and `EstimateMessage` in scope.
macro_rules! numbers_of_estimate {
    (
        estimated { $( $bit:literal $const:ident $bit_name:ident ($($has:tt)*) $bit_doc:tt; )* }
        first { $( $name:ident ($($place:tt)*) [$( $std:ident ($($std_place:tt)*) )?] $unit:tt $doc:tt $facts:tt; )* }
        later { $( $name2:ident ($($place2:tt)*) [$( $std2:ident ($($std_place2:tt)*) )?] $unit2:tt $doc2:tt $facts2:tt; )* }
    ) => {
        /// Numbers that the method does not estimate stay 0.
        fn numbers(e: &Estimate) -> EstimateMessage {
            EstimateMessage {
                $( $name: e.$($place)*, $( $std: e.$($std_place)*, )? )*
                $( $name2: e.$($place2)*, $( $std2: e.$($std_place2)*, )? )*
                ..EstimateMessage::default()
            }
        }

        /// `started`: a row has been accepted.
        fn estimated(e: &Estimate, started: bool) -> u32 {
            0 $( | u32::from(started && $crate::rows::has!(e, $($has)*)) << $bit )*
        }
    };
}

/// Whether an estimate has a number; always, where the sheet states no condition.
macro_rules! has {
    ($e:ident,) => {
        true
    };
    ($e:ident, $($place:tt)+) => {
        $e.$($place)+
    };
}

pub(crate) use {flags_of_estimate, has, numbers_of_estimate, sample_of_message};
