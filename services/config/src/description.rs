use std::fmt;

use crate::{Error, Errors, Excavator, Loader, Machine, parse};

/// Which machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Excavator.
    Excavator,
    /// Wheel loader.
    Loader,
}

impl Kind {
    /// Both, in the order of the names on the command line.
    pub const ALL: [Self; 2] = [Self::Excavator, Self::Loader];

    /// Name on the command line, in channels and in `machine.kind`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Excavator => "excavator",
            Self::Loader => "loader",
        }
    }

    /// The machine called `name`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A description of either machine.
#[derive(Debug, Clone, PartialEq)]
pub enum Description {
    /// Excavator.
    Excavator(Box<Excavator>),
    /// Wheel loader.
    Loader(Box<Loader>),
}

impl Description {
    /// Reads a description of whichever machine the text is for: `machine.kind` says so, or the
    /// keys do. `kind` is taken where neither does.
    ///
    /// # Errors
    /// Everything that is wrong with the text, each with its line; or that the machine is unclear.
    pub fn parse(text: &str, file_name: &str, kind: Option<Kind>) -> Result<Self, Errors> {
        let Some(kind) = parse::kind(text, file_name)?.or(kind) else {
            return Err(unclear(file_name).into());
        };
        Ok(match kind {
            Kind::Excavator => Self::Excavator(Box::new(Excavator::parse(text, file_name)?)),
            Kind::Loader => Self::Loader(Box::new(Loader::parse(text, file_name)?)),
        })
    }

    /// The defaults of a machine.
    #[must_use]
    pub fn default_of(kind: Kind) -> Self {
        match kind {
            Kind::Excavator => Self::Excavator(Box::default()),
            Kind::Loader => Self::Loader(Box::default()),
        }
    }

    /// Which machine.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Excavator(_) => Excavator::KIND,
            Self::Loader(_) => Loader::KIND,
        }
    }

    /// Sets one key, as `--set` does.
    ///
    /// # Errors
    /// No such key, or a value that it cannot have.
    pub fn set(&mut self, assignment: &str) -> Result<(), Error> {
        self.set_all(&[assignment])
    }

    /// Sets several keys in their order, as several `--set` do.
    ///
    /// # Errors
    /// No such key, a value that it cannot have, or an outcome that contradicts itself.
    pub fn set_all(&mut self, assignments: &[impl AsRef<str>]) -> Result<(), Error> {
        match self {
            Self::Excavator(m) => m.set_all(assignments),
            Self::Loader(m) => m.set_all(assignments),
        }
    }

    /// The whole description with its comments.
    #[must_use]
    pub fn to_toml(&self) -> String {
        match self {
            Self::Excavator(m) => m.to_toml(),
            Self::Loader(m) => m.to_toml(),
        }
    }
}

fn unclear(file_name: &str) -> Error {
    Error {
        what: "the description does not say which machine it is for".into(),
        file: file_name.into(),
        line: None,
        key: "machine.kind".into(),
        remedy: "write kind = \"excavator\" or kind = \"loader\" under [machine]".into(),
    }
}
