use std::fmt;
use std::io;
use std::path::Path;

use messages::Machine;

use crate::OneLine;

/// Why a file could not be read or written. Prints as three lines: what, where, what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// What is wrong.
    pub what: String,
    /// File, with line and column if known.
    pub place: String,
    /// The remedy.
    pub remedy: String,
    /// The system's error, if the system refused.
    pub io: Option<io::ErrorKind>,
}

impl Error {
    /// An error found in the content of a file.
    pub(crate) fn new(
        what: impl Into<String>,
        place: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            what: what.into(),
            place: place.into(),
            remedy: remedy.into(),
            io: None,
        }
    }

    /// The system refused to open, read or write `path`.
    pub(crate) fn system(doing: &str, path: &Path, error: &io::Error) -> Self {
        use io::ErrorKind as Kind;
        let remedy = match error.kind() {
            Kind::NotFound => Self::where_to_look(path),
            Kind::PermissionDenied => "check the rights of the file and of its folder",
            Kind::StorageFull | Kind::QuotaExceeded | Kind::FileTooLarge => {
                "make room, or choose another folder"
            }
            Kind::ReadOnlyFilesystem => "choose another folder: this disk cannot be written",
            Kind::InvalidFilename => "choose a shorter name for the result (-o), or for its input",
            Kind::IsADirectory => "give a file, not a folder",
            Kind::NotSeekable => {
                "write it to a file (a packed .csv.gz is read as it is); `heft serve` and `heft run --input -` read pipes"
            }
            Kind::InvalidData | Kind::InvalidInput => {
                "its content is damaged, the disk is not: mend it, or get the file anew"
            }
            _ => "check the file and the disk",
        };
        let what = match error.kind() {
            Kind::NotFound => format!("cannot {doing}: no such file or folder"),
            Kind::NotSeekable => format!(
                "cannot {doing}: this is a pipe or a device, and heft reads a file more than once"
            ),
            _ => format!("cannot {doing}: {error}"),
        };
        Self {
            what,
            place: path.display().to_string(),
            remedy: remedy.into(),
            io: Some(error.kind()),
        }
    }

    /// Remedy for a missing file; `-` means a pipe in other programs, and a machine's name the machine.
    pub fn where_to_look(path: &Path) -> &'static str {
        match path.to_str() {
            Some("-") => "name a file; `heft serve` and `heft run --input -` read pipes",
            Some(name) if Machine::from_name(name).is_some() => {
                "name files only: this is a machine, and --machine names it"
            }
            _ => "check the name and the folder",
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}\n  where: {}\n  what to do: {}",
            OneLine(&self.what),
            OneLine(&self.place),
            OneLine(&self.remedy)
        )
    }
}

impl std::error::Error for Error {}
