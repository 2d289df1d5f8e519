//! Conversions between `estimation` and the messages, from the rows of the sheet.

/// `sample()` of a machine: needs `Sample` and `SensorsMessage` in scope.
macro_rules! sample_of_message {
    (
        first { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $unit:tt $doc:tt $presence:ident; )* }
        later { $( $bit2:literal $const2:ident $name2:ident ($($place2:tt)*) $unit2:tt $doc2:tt $presence2:ident; )* }
        switches { $( $bit3:literal $const3:ident $name3:ident ($($place3:tt)*) $unit3:tt $doc3:tt $presence3:ident; )* }
    ) => {
        /// The sample in a message; a signal without its bit is missing.
        #[must_use]
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

/// `flags()` of an estimate as bits; those of the process are set by who runs it. Needs `Estimate` in scope.
macro_rules! flags_of_estimate {
    (
        estimator { $( $bit:literal $const:ident $name:ident ($($place:tt)*) $doc:tt; )* }
        process $process:tt
    ) => {
        fn flags(e: &Estimate) -> u32 {
            0 $( | u32::from(e.$($place)*) << $bit )*
        }
    };
}

pub(crate) use {flags_of_estimate, sample_of_message};
