use std::fmt;

use rustix::process::{Resource, getrlimit};

/// An error: what happened, where, and the remedy, one line each.
#[derive(Debug, Clone)]
pub struct Error {
    /// What happened.
    pub what: String,
    /// Channel, process, file or limit.
    pub place: String,
    /// Remedy for the user.
    pub remedy: String,
}

impl Error {
    /// Combines the three lines.
    pub fn new(
        what: impl Into<String>,
        place: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            what: what.into(),
            place: place.into(),
            remedy: remedy.into(),
        }
    }

    /// An error of iceoryx2 on a channel or node.
    pub(crate) fn ipc(action: &str, name: &str, error: impl fmt::Debug) -> Self {
        let limit = getrlimit(Resource::As).current;
        let memory = limit.map_or(String::new(), |bytes| {
            format!(
                "allow a process more memory than {} MiB (ulimit -v); ",
                bytes >> 20
            )
        });
        Self::new(
            format!("cannot {action}: {error:?}"),
            format!("shared memory, {name}"),
            format!(
                "{memory}run `heft doctor --clean`; if another run uses this domain, choose another --domain"
            ),
        )
    }

    /// A thread could not be started.
    pub fn thread(error: std::io::Error) -> Self {
        Self::new(
            format!("cannot start a thread: {error}"),
            "the limits of this user",
            "check the limits on processes (ulimit -u) and memory",
        )
    }

    /// An error of the operating system.
    pub(crate) fn os(action: &str, place: impl Into<String>, error: impl fmt::Display) -> Self {
        Self::new(
            format!("cannot {action}: {error}"),
            place,
            "run `heft doctor`",
        )
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}\n  where: {}\n  what to do: {}",
            self.what, self.place, self.remedy
        )
    }
}

impl std::error::Error for Error {}
