//! Failure of a command: a message of three lines, and an exit status.

use std::fmt;
use std::path::Path;

use recording::OneLine;

use crate::out::{Plain, READER_LEFT};

/// A command ended without a result.
#[derive(Debug)]
pub struct Failure {
    message: String,
    /// 1: it ran, but the answer is no. 2: wrong use or bad input. [`READER_LEFT`]: the reader of its output has left; no message.
    pub status: u8,
}

impl Failure {
    /// What is wrong, without place and remedy.
    pub fn what(&self) -> String {
        let line = self.message.lines().next().unwrap_or_default();
        Plain(line).to_string()
    }

    /// Wrong use or bad input: what, where, what to do.
    pub fn input(
        what: impl fmt::Display,
        place: impl fmt::Display,
        remedy: impl fmt::Display,
    ) -> Self {
        Self {
            message: format!(
                "{what}\n  where: {}\n  what to do: {remedy}",
                OneLine(place)
            ),
            status: 2,
        }
    }

    /// Bad input, reported in its three lines by another process.
    pub fn reported(message: String) -> Self {
        Self { message, status: 2 }
    }

    /// The reader of standard output has left: no message.
    pub fn reader_left() -> Self {
        Self {
            message: String::new(),
            status: READER_LEFT,
        }
    }

    /// The command ran, but the answer is no.
    pub fn answer_is_no(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            status: 1,
        }
    }

    /// A file could not be used.
    pub fn file(action: &str, path: &Path, error: &std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::NotFound {
            return Self::input(
                format!("cannot {action} the file: no such file or folder"),
                path.display(),
                recording::Error::where_to_look(path),
            );
        }
        let remedy = match error.kind() {
            std::io::ErrorKind::InvalidData => "name a text file, and save it in UTF-8",
            std::io::ErrorKind::IsADirectory => "name a file, not a folder",
            _ => "check the path, the permissions and the free space",
        };
        Self::input(
            format!("cannot {action} the file: {error}"),
            path.display(),
            remedy,
        )
    }

    /// A folder could not be made.
    pub fn folder(path: &Path, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{AlreadyExists, NotADirectory};
        let (what, remedy) = match error.kind() {
            AlreadyExists | NotADirectory => (
                "a file has this name".to_owned(),
                "name a folder, not a file",
            ),
            _ => (
                error.to_string(),
                "check the path, the permissions and the free space",
            ),
        };
        Self::input(
            format!("cannot make the folder: {what}"),
            path.display(),
            remedy,
        )
    }

    /// A thread could not be started.
    pub fn thread(error: std::io::Error) -> Self {
        runtime::Error::thread(error).into()
    }

    /// Signal handlers could not be installed: they need file descriptors of the process.
    pub fn signals(error: std::io::Error) -> Self {
        Self::input(
            format!("cannot wait for signals: {error}"),
            "the limits of this shell or unit",
            "permit more open files: ulimit -n 4096, or LimitNOFILE=4096 in the systemd unit",
        )
    }

    /// A defect of heft itself.
    pub fn internal(error: impl fmt::Display) -> Self {
        Self::input(
            error,
            "heft itself",
            "please report this with the command you ran",
        )
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Names of columns and files may hold control characters.
        Plain(&self.message).fmt(f)
    }
}

/// Errors of the libraries already state what, where and what to do.
macro_rules! from_errors {
    ($($error:ty),* $(,)?) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self { message: error.to_string(), status: 2 }
            }
        }
    )*};
}
from_errors!(runtime::Error, config::Errors, config::Error,);

impl From<recording::Error> for Failure {
    fn from(error: recording::Error) -> Self {
        let is_left = error.io == Some(std::io::ErrorKind::BrokenPipe);
        Self {
            message: error.to_string(),
            status: if is_left { READER_LEFT } else { 2 },
        }
    }
}

impl From<steps::Error> for Failure {
    fn from(error: steps::Error) -> Self {
        let (place, remedy) = match &error {
            steps::Error::MissingColumn { .. } => (
                "--method",
                "choose another method, or name the column in a signal map (--map)",
            ),
            _ => (
                "the machine file or --method",
                "`heft check FILE --print` shows every key with its range, `heft estimate --help` the methods",
            ),
        };
        Self::input(error, place, remedy)
    }
}
