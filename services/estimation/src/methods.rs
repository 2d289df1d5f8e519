//! Methods of a machine by their names in files and on the command line: one table per machine, the default first.

/// Defines `Method` from the rows of the sheet; their order is the index in the messages.
macro_rules! methods {
    ($( $index:literal $method:ident $name:literal $method_doc:literal; )+) => {
        /// Estimation method of the machine.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[non_exhaustive]
        pub enum Method { $( #[doc = $method_doc] $method = $index, )+ }

        impl Method {
            /// Every method, the default first.
            pub const ALL: [Self; Self::NAMES.len()] = [$(Self::$method),+];

            /// Their names.
            pub const NAMES: &[&str] = &[$($name),+];

            /// The name in files and on the command line.
            pub const fn name(self) -> &'static str {
                Self::NAMES[self as usize]
            }

            /// The method of that name.
            pub fn parse(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|method| method.name() == name)
            }

            /// Position in [`Method::ALL`].
            pub const fn index(self) -> u32 {
                self as u32
            }
        }

        impl Default for Method {
            fn default() -> Self {
                Self::ALL[0]
            }
        }

        impl core::fmt::Display for Method {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

pub(crate) use methods;
