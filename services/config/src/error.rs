use std::fmt;

/// A defect of a description. Prints as three lines: what, where, what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// The fault.
    pub what: String,
    /// File name, or the command line option.
    pub file: String,
    /// Line, counted from 1; `None` where there is no line to point at.
    pub line: Option<usize>,
    /// Key with its table, such as `sensors.rate`; empty if none is concerned.
    pub key: String,
    /// The remedy.
    pub remedy: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A name or a key may hold a line break.
        let one_line = |text: &str| text.replace('\n', "\\n");
        write!(
            f,
            "{}\n  where: {}",
            one_line(&self.what),
            one_line(&self.file)
        )?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if !self.key.is_empty() {
            write!(f, ", key {}", one_line(&self.key))?;
        }
        write!(f, "\n  what to do: {}", self.remedy)
    }
}

impl std::error::Error for Error {}

/// All defects found in one description, in the order of the file; never empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Errors(pub Vec<Error>);

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().enumerate() {
            let separator = if i == 0 { "" } else { "\n" };
            write!(f, "{separator}{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Errors {}

impl From<Error> for Errors {
    fn from(error: Error) -> Self {
        Self(vec![error])
    }
}

impl Error {
    /// A contradiction between keys.
    pub(crate) fn between(what: String, key: &str, remedy: &str) -> Self {
        Self {
            what,
            file: String::new(),
            line: None,
            key: key.into(),
            remedy: remedy.into(),
        }
    }
}
