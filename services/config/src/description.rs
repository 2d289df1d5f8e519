//! A description of any machine.

use messages::Machine;

use crate::{Error, Errors, Excavator, Loader, Tables, parse};

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
    /// keys do. `machine` is taken where neither does.
    ///
    /// # Errors
    /// Everything that is wrong with the text, each with its line; or that the machine is unclear.
    pub fn parse(text: &str, file_name: &str, machine: Option<Machine>) -> Result<Self, Errors> {
        let Some(machine) = parse::machine(text, file_name)?.or(machine) else {
            return Err(unclear(file_name).into());
        };
        Ok(match machine {
            Machine::Excavator => Self::Excavator(Box::new(Excavator::parse(text, file_name)?)),
            Machine::Loader => Self::Loader(Box::new(Loader::parse(text, file_name)?)),
        })
    }

    /// The defaults of a machine.
    #[must_use]
    pub fn default_of(machine: Machine) -> Self {
        match machine {
            Machine::Excavator => Self::Excavator(Box::default()),
            Machine::Loader => Self::Loader(Box::default()),
        }
    }

    /// Which machine.
    #[must_use]
    pub fn machine(&self) -> Machine {
        match self {
            Self::Excavator(_) => Excavator::MACHINE,
            Self::Loader(_) => Loader::MACHINE,
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
