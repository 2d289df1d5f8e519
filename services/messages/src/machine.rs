//! The machines, a row each, from which every crate makes its own table.

use core::fmt;

/// The machines, a row each: name, module of that name in every crate, its messages of sensors, truth and estimate, and further
/// messages. Calls the macro `$then` with all rows. So a crate defines its part of a machine once, in the file of that machine,
/// and the compiler reports what a new row lacks.
#[macro_export]
macro_rules! machines {
    ($then:ident) => {
        $then! {
            Excavator, excavator, ExcavatorSensors, ExcavatorTruth, ExcavatorEstimate, [SwingMotion, ExcavatorLoads];
            Loader, loader, LoaderSensors, LoaderTruth, LoaderEstimate, [LoaderLoads];
        }
    };
}

macro_rules! names {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// A machine.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[allow(missing_docs, reason = "each is the machine of its name")]
        pub enum Machine { $( $machine, )* }

        impl Machine {
            /// All of them, in the order of the table.
            pub const ALL: [Self; [$( stringify!($module) ),*].len()] = [$( Self::$machine ),*];

            /// Name on the command line, in channels and in `machine.kind`.
            pub const fn name(self) -> &'static str {
                match self {
                    $( Self::$machine => stringify!($module), )*
                }
            }

            /// The numbers of its estimates.
            pub const fn quantities(self) -> &'static [sheet::Quantity] {
                match self {
                    $( Self::$machine => sheet::$module::QUANTITIES, )*
                }
            }
        }
    };
}

crate::machines!(names);

impl Machine {
    /// The numbers of its estimates that are shown to people, in order.
    pub fn shown(self) -> impl Iterator<Item = &'static sheet::Quantity> {
        let all = self.quantities().iter();
        (1..).map_while(move |place| all.clone().find(|q| q.shown == place))
    }

    /// The machine called `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|machine| machine.name() == name)
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
