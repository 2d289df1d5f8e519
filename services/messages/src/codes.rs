//! Names of bits and codes.

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
    /// The entry of a code; `None` for bits, and for an unknown code.
    pub fn of(&self, code: u32) -> Option<&'static Entry> {
        match self {
            Self::Bits(_) => None,
            Self::Codes(entries) => entries.iter().find(|e| e.number == code),
        }
    }
}

/// Name of an unknown code.
pub const UNKNOWN: &str = "unknown";

impl Words {
    /// The words of the field called `name`.
    pub fn of_field(all: &'static [(&'static str, Self)], name: &str) -> Option<&'static Self> {
        all.iter().find(|(field, _)| *field == name).map(|(_, w)| w)
    }

    /// Name of a code.
    pub fn name(&self, code: u32) -> &'static str {
        self.of(code).map_or(UNKNOWN, |entry| entry.name)
    }
}
