//! Reasons of a machine by their names, from the sheet: why an estimate is not trusted, or how the machine deviates from its description.

/// Defines `Reason`.
macro_rules! reasons {
    ($( $code:literal $variant:ident $name:literal $words:literal; )*) => {
        /// Why an estimate is not trusted, or how the machine deviates from its description. Codes never change their meaning.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u32)]
        #[non_exhaustive]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum Reason { $( #[doc = concat!("`", $name, "`: ", $words, ".")] $variant = $code, )* }

        impl Reason {
            /// All, in the order of their codes.
            pub const ALL: [Self; Self::NAMES.len()] = [$( Self::$variant ),*];

            /// Names by code; the first is empty.
            pub const NAMES: &[&str] = &[$( $name ),*];

            /// Code in the messages.
            pub const fn code(self) -> u32 {
                self as u32
            }

            /// The reason with this code; `None` for an unknown code.
            pub fn of(code: u32) -> Self {
                Self::ALL.get(code as usize).copied().unwrap_or_default()
            }

            /// Name in every output; empty where there is no reason.
            pub const fn name(self) -> &'static str {
                Self::NAMES[self as usize]
            }

            /// The cause in words.
            pub const fn words(self) -> &'static str {
                match self {
                    $( Self::$variant => $words, )*
                }
            }
        }

        impl Default for Reason {
            fn default() -> Self {
                Self::None
            }
        }
    };
}

pub(crate) use reasons;
