//! A run's private corner of shared memory.
//!
//! Each run has a domain: a folder in `/dev/shm/heft` with the lock of its supervisor, the
//! configuration of iceoryx2 (prefix and root path, both private) and the plan of the run. A
//! domain whose lock nobody holds was left behind by a killed run and can be removed.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use iceoryx2::config::Config;
use iceoryx2::prelude::*;

use crate::Error;

/// Where domains live: memory, because opening an iceoryx2 service is bound by its file system.
const HOME: &str = "/dev/shm/heft";
/// Shared memory that one run may need, with margin; below it a run would end in SIGBUS.
const ROOM_BYTES: u64 = 64 << 20;

/// A domain, by name.
#[derive(Debug, Clone)]
pub struct Domain {
    name: String,
}

/// The right to be the supervisor of a domain; the domain is removed when this is dropped.
#[derive(Debug)]
pub struct Owner {
    domain: Domain,
    _lock: File,
}

impl Domain {
    /// The domain called `name`.
    ///
    /// # Errors
    /// The name is empty, longer than 32 characters, or not of `a-z A-Z 0-9 -`.
    pub fn new(name: &str) -> Result<Self, Error> {
        let fits = !name.is_empty()
            && name.len() <= 32
            && name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'-');
        if !fits {
            return Err(Error::new(
                format!("`{name}` cannot name a domain"),
                "--domain",
                "use 1 to 32 letters, digits and hyphens",
            ));
        }
        Ok(Self {
            name: name.to_owned(),
        })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its folder.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        Path::new(HOME).join(&self.name)
    }

    /// The iceoryx2 configuration that every process of this domain uses.
    #[must_use]
    pub fn config_file(&self) -> PathBuf {
        self.folder().join("iceoryx2.toml")
    }

    /// The plan of the run, written by the supervisor for its workers.
    #[must_use]
    pub fn plan_file(&self) -> PathBuf {
        self.folder().join("plan.json")
    }

    /// First letters of every shared-memory object of this domain.
    fn prefix(&self) -> String {
        format!("heft-{}_", self.name)
    }

    /// Takes the domain, after removing what a killed run may have left in it.
    ///
    /// # Errors
    /// A living supervisor holds it, or shared memory is missing, full or not writable.
    pub fn take(&self) -> Result<Owner, Error> {
        check_room()?;
        let folder = self.folder();
        let failed =
            |action: &str, e: std::io::Error| Error::os(action, folder.display().to_string(), e);
        fs::create_dir_all(&folder).map_err(|e| failed("make the domain", e))?;
        let lock = self
            .open_lock()
            .map_err(|e| failed("open the lock of the domain", e))?;
        if !try_lock(&lock) {
            return Err(Error::new(
                format!("the domain `{}` is in use by another run", self.name),
                folder.display().to_string(),
                "choose another --domain, or end that run",
            ));
        }
        self.wipe();
        let config = format!(
            "[global]\nroot-path = \"{}/root\"\nprefix = \"{}\"\n",
            folder.display(),
            self.prefix()
        );
        File::create(self.config_file())
            .and_then(|mut f| f.write_all(config.as_bytes()))
            .map_err(|e| failed("write the configuration of the domain", e))?;
        Ok(Owner {
            domain: self.clone(),
            _lock: lock,
        })
    }

    /// Makes this domain the one that all iceoryx2 calls of this process use.
    ///
    /// # Errors
    /// There is no such domain.
    pub fn enter(&self) -> Result<(), Error> {
        let file = self.config_file();
        let text = file.display().to_string();
        let no_such = |detail: String| {
            Error::new(
                format!("cannot enter the domain `{}`: {detail}", self.name),
                text.clone(),
                "`heft doctor` lists the domains that exist",
            )
        };
        if !file.exists() {
            return Err(no_such("it does not exist".into()));
        }
        let path = FilePath::new(text.as_bytes()).map_err(|e| no_such(format!("{e:?}")))?;
        Config::setup_global_config_from_file(&path).map_err(|e| no_such(format!("{e:?}")))?;
        Ok(())
    }

    fn open_lock(&self) -> std::io::Result<File> {
        OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(self.folder().join("lock"))
    }

    /// Whether a supervisor holds it.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.folder().exists() && self.open_lock().is_ok_and(|lock| !try_lock(&lock))
    }

    /// Removes everything but the folder and its lock. Errors are not told: what cannot be
    /// removed now is found again by the next run and by `heft doctor`.
    fn wipe(&self) {
        for object in shared_memory_objects(&self.prefix()) {
            let _ = fs::remove_file(object);
        }
        for entry in fs::read_dir(self.folder()).into_iter().flatten().flatten() {
            if entry.file_name() != "lock" {
                let path = entry.path();
                let _ = if path.is_dir() {
                    fs::remove_dir_all(&path)
                } else {
                    fs::remove_file(&path)
                };
            }
        }
    }

    /// Removes a domain that no supervisor holds; false if one does.
    pub fn remove(&self) -> bool {
        if self.is_alive() {
            return false;
        }
        self.wipe();
        let _ = fs::remove_dir_all(self.folder());
        true
    }

    /// All domains on this host, alive or left behind.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all: Vec<Self> = fs::read_dir(HOME)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| Self::new(entry.file_name().to_str()?).ok())
            .collect();
        all.sort_by(|a, b| a.name.cmp(&b.name));
        all
    }

    /// Removes what killed runs left behind; returns the names of their domains.
    pub fn remove_leftovers() -> Vec<String> {
        let dead = Self::all().into_iter().filter(|d| !d.is_alive());
        dead.filter(Self::remove).map(|d| d.name).collect()
    }
}

impl Owner {
    /// The domain.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }
}

impl Drop for Owner {
    fn drop(&mut self) {
        self.domain.wipe();
        let _ = fs::remove_dir_all(self.domain.folder());
    }
}

fn try_lock(lock: &File) -> bool {
    rustix::fs::flock(lock, rustix::fs::FlockOperation::NonBlockingLockExclusive).is_ok()
}

fn shared_memory_objects(prefix: &str) -> Vec<PathBuf> {
    fs::read_dir("/dev/shm")
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix))
        .map(|entry| entry.path())
        .collect()
}

/// Free shared memory [bytes].
#[must_use]
pub fn free_shared_memory() -> u64 {
    rustix::fs::statvfs("/dev/shm").map_or(0, |s| s.f_bavail.saturating_mul(s.f_frsize))
}

fn check_room() -> Result<(), Error> {
    let free = free_shared_memory();
    if free < ROOM_BYTES {
        return Err(Error::new(
            format!(
                "shared memory has {} MiB free, a run needs {} MiB",
                free >> 20,
                ROOM_BYTES >> 20
            ),
            "/dev/shm",
            "run `heft doctor --clean`, remove other files there, or mount it larger (containers: --shm-size)",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_domain_is_held_by_one_owner_and_vanishes_with_it() {
        let domain = Domain::new(&format!("test-{}", std::process::id())).unwrap();
        let owner = domain.take().unwrap();
        assert!(domain.is_alive());
        assert!(domain.take().is_err(), "the second owner is refused");
        assert!(!domain.remove(), "a living domain is not removed");
        drop(owner);
        assert!(!domain.folder().exists());
    }

    #[test]
    fn names_that_could_leave_the_folder_are_refused() {
        for name in ["", "..", "a/b", "a b", &"x".repeat(33)] {
            assert!(Domain::new(name).is_err(), "{name:?}");
        }
    }
}
