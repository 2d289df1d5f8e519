//! The machines that heft knows.

use core::fmt;

/// Everything that must be said once per machine.
macro_rules! machines {
    ($( $(#[$doc:meta])* $name:ident = $text:literal, )*) => {
        /// Which machine.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Machine { $( $(#[$doc])* $name, )* }

        impl Machine {
            /// All of them, in the order of the names on the command line.
            pub const ALL: [Self; [$( $text ),*].len()] = [$( Self::$name ),*];

            /// Name on the command line, in channels and in `machine.kind`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $( Self::$name => $text, )*
                }
            }
        }
    };
}

machines! {
    /// Excavator.
    Excavator = "excavator",
    /// Wheel loader.
    Loader = "loader",
}

impl Machine {
    /// The machine called `name`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|machine| machine.name() == name)
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
