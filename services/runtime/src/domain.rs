//! Domain: the private part of shared memory of a run.
//!
//! Each domain is a folder in the home of its user (see `home`). It contains the lock of its supervisor,
//! the configuration of iceoryx2 (prefix and root path, both private) and the plan of the run. A
//! domain whose lock is free was left by a killed run and can be removed. Only known contents of a
//! domain are ever deleted, only where this user owns them, and no link is followed.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use iceoryx2::config::Config;
use iceoryx2::prelude::*;
use rustix::fs::OFlags;

use crate::Error;
use crate::home::{self, SHARED_MEMORY};
use crate::room::{self, Needs};

/// Longest time for which a command that only inspects a domain holds its lock.
const LOOK: Duration = Duration::from_millis(500);
/// Files of a domain, next to its lock.
const CONFIG: &str = "iceoryx2.toml";
/// Largest number of dead writers whose last messages a reader has not taken yet: the number of writers of a channel. A reader reserves
/// 4 kB for each.
const DEAD_WRITERS: usize = 16;
const PLAN: &str = "plan.json";
/// Progress of the logger, and the same file before it is renamed.
const MARK: &str = "recorded";
const NEW_MARK: &str = "recorded.new";
const LOCK: &str = "lock";
/// Folder in which iceoryx2 keeps its own files.
const ROOT: &str = "root";

/// A domain, by name.
#[derive(Debug, Clone)]
pub struct Domain {
    name: String,
    /// The home that contains it; `None` where this user has no home yet.
    home: Option<PathBuf>,
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
        if !is_name(name) {
            return Err(Error::new(
                format!("`{name}` cannot name a domain"),
                "--domain",
                "use 1 to 32 letters, digits and hyphens",
            ));
        }
        let homes = home::all();
        let holds_it = |home: &&PathBuf| home.join(name).symlink_metadata().is_ok();
        Ok(Self {
            name: name.to_owned(),
            home: homes.iter().find(holds_it).or(homes.first()).cloned(),
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its folder.
    pub fn folder(&self) -> PathBuf {
        let nowhere = || Path::new(SHARED_MEMORY).join(format!("heft-{}", home::user()));
        self.home.clone().unwrap_or_else(nowhere).join(&self.name)
    }

    /// The iceoryx2 configuration that every process of this domain uses.
    pub fn config_file(&self) -> PathBuf {
        self.folder().join(CONFIG)
    }

    /// File of the run's plan, written by the supervisor for its workers.
    pub fn plan_file(&self) -> PathBuf {
        self.folder().join(PLAN)
    }

    /// File in which the logger marks its progress, for its successor.
    pub fn mark_file(&self) -> PathBuf {
        self.folder().join(MARK)
    }

    /// Prefix of every shared-memory object of this domain, in all its runs.
    pub(crate) fn prefix(&self) -> String {
        format!("heft-{}.{}.", home::user(), self.name)
    }

    /// Takes the domain, after removing the remains of a killed run.
    ///
    /// # Errors
    /// A living supervisor holds it, or shared memory is missing, full or not writable.
    pub fn take(&self) -> Result<Owner, Error> {
        check_places()?;
        let home = home::make()?;
        if let Some(lack) = room::lack(&home, Needs::Run) {
            return Err(lack);
        }
        let domain = Self {
            name: self.name.clone(),
            home: Some(home),
        };
        let folder = domain.folder();
        let failed =
            |action: &str, e: std::io::Error| Error::os(action, folder.display().to_string(), e);
        let lock = domain.lock().map_err(|e| failed("lock the domain", e))?;
        let Some(lock) = lock else {
            return Err(Error::new(
                format!("the domain `{}` is in use by another run", self.name),
                folder.display().to_string(),
                "choose another --domain, or end that run",
            ));
        };
        domain.wipe();
        // The number is random, so that nobody can create an object of this name before the run does.
        let number = random().map_err(|e| failed("choose a name in shared memory", e))?;
        let config = format!(
            "[global]\nroot-path = \"{}\"\nprefix = \"{}{number:016x}_\"\n\
             [defaults.publish-subscribe]\nsubscriber-expired-connection-buffer = {DEAD_WRITERS}\n",
            folder.join(ROOT).display(),
            domain.prefix()
        );
        new_file(&domain.config_file())
            .and_then(|mut f| f.write_all(config.as_bytes()))
            // Created here with mode 0700; iceoryx2 would let the group in.
            .and_then(|()| fs::DirBuilder::new().mode(0o700).create(folder.join(ROOT)))
            .map_err(|e| failed("write the configuration of the domain", e))?;
        Ok(Owner {
            domain,
            _lock: lock,
        })
    }

    /// Selects this domain for all iceoryx2 calls of this process.
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

    /// Creates the folder and locks it; `None` where a run holds the lock. A command that inspects the
    /// domain, or removes its remains, holds the lock only briefly.
    fn lock(&self) -> std::io::Result<Option<File>> {
        let begun = Instant::now();
        loop {
            // The folder may exist already.
            let _ = fs::create_dir(self.folder());
            match self.open_lock() {
                Ok(lock) if try_lock(&lock) && self.is_lock(&lock) => return Ok(Some(lock)),
                Ok(_) if begun.elapsed() > LOOK => return Ok(None),
                Err(e) if begun.elapsed() > LOOK => return Err(e),
                _ => std::thread::sleep(LOOK / 50),
            }
        }
    }

    fn open_lock(&self) -> std::io::Result<File> {
        options().open(self.folder().join(LOCK))
    }

    /// Whether an open lock file is the one in the folder.
    fn is_lock(&self, lock: &File) -> bool {
        let there = fs::symlink_metadata(self.folder().join(LOCK));
        lock.metadata()
            .is_ok_and(|l| there.is_ok_and(|t| t.ino() == l.ino()))
    }

    /// Whether a supervisor holds it.
    pub fn is_alive(&self) -> bool {
        self.folder().join(LOCK).exists() && self.open_lock().is_ok_and(|lock| !try_lock(&lock))
    }

    /// Removes everything but the folder and its lock. Errors are not reported: what cannot be
    /// removed now is found by the next run and by `heft doctor`.
    fn wipe(&self) {
        let prefix = self.prefix();
        for object in objects(|name| name.starts_with(&prefix)) {
            let _ = fs::remove_file(object);
        }
        let folder = self.folder();
        for file in [CONFIG, PLAN, MARK, NEW_MARK] {
            let _ = fs::remove_file(folder.join(file));
        }
        // Follows no link, neither this name nor any below it.
        let _ = fs::remove_dir_all(folder.join(ROOT));
    }

    /// Removes the lock and the folder, unless the folder has unknown contents.
    fn remove_folder(&self) {
        let _ = fs::remove_file(self.folder().join(LOCK));
        let _ = fs::remove_dir(self.folder());
    }

    /// Removes a domain that no supervisor holds; false if one does, or the domain has unknown contents.
    pub fn remove(&self) -> bool {
        // The lock is held during removal: a run that starts meanwhile is refused with the reason.
        let Ok(lock) = self.open_lock() else {
            return false;
        };
        if !try_lock(&lock) || !self.is_lock(&lock) {
            return false;
        }
        self.wipe();
        self.remove_folder();
        !self.folder().exists()
    }

    /// All domains of this user, alive or left by killed runs.
    pub fn all() -> Vec<Self> {
        let mut all: Vec<Self> = home::all()
            .into_iter()
            .flat_map(|home| {
                let entries = fs::read_dir(&home).into_iter().flatten().flatten();
                let folders = entries.filter(|e| e.file_type().is_ok_and(|t| t.is_dir()));
                folders
                    .filter_map(|e| e.file_name().into_string().ok())
                    .filter(|name| is_name(name))
                    .map(|name| Self {
                        name,
                        home: Some(home.clone()),
                    })
                    .collect::<Vec<_>>()
            })
            .collect();
        all.sort_by(|a, b| a.name.cmp(&b.name));
        all
    }

    /// Removes the remains of killed runs; returns the names of their domains.
    pub fn remove_leftovers() -> Vec<String> {
        let dead = Self::all().into_iter().filter(|d| !d.is_alive());
        dead.filter(Self::remove).map(|d| d.name).collect()
    }

    /// Shared-memory objects of this user that belong to no existing domain.
    pub fn strays() -> Vec<PathBuf> {
        let of_domain = |d: &Self| [d.prefix(), format!("heft-{}_", d.name)];
        let known: Vec<String> = Self::all().iter().flat_map(of_domain).collect();
        objects(|name| {
            name.starts_with("heft-") && !known.iter().any(|prefix| name.starts_with(prefix))
        })
    }
}

impl Owner {
    /// The domain.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Closes to other users the objects that iceoryx2 creates open: the segment that numbers its
    /// nodes has mode 0666. No process holds that segment open, so a copy of mode 0600 replaces it,
    /// and a handle on the original is useless.
    ///
    /// # Errors
    /// An object of this domain belongs to another user, or shared memory is full.
    pub fn close_to_others(&self) -> Result<(), Error> {
        let prefix = self.domain.prefix();
        let place = || format!("{SHARED_MEMORY}/{prefix}*");
        let failed = |e: std::io::Error| Error::os("close the domain to other users", place(), e);
        for entry in entries(|name| name.starts_with(&prefix)) {
            let about = entry.metadata().map_err(failed)?;
            if about.uid() != home::user() || !about.is_file() {
                return Err(Error::new(
                    "another user made an object with a name of this domain",
                    entry.path().display().to_string(),
                    "remove it, or choose another --domain",
                ));
            }
            if about.mode() & 0o077 != 0 {
                replace(&entry.path()).map_err(failed)?;
            }
        }
        Ok(())
    }
}

impl Drop for Owner {
    fn drop(&mut self) {
        self.domain.wipe();
        self.domain.remove_folder();
    }
}

pub(crate) fn is_name(name: &str) -> bool {
    !name.is_empty()
        && name.len() <= 32
        && name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'-')
}

/// Options to write a file of this user alone, following no link.
fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).write(true).mode(0o600);
    options.custom_flags(OFlags::NOFOLLOW.bits() as i32);
    options
}

/// Creates a file that must not exist yet.
pub(crate) fn new_file(path: &Path) -> std::io::Result<File> {
    options().create_new(true).open(path)
}

/// Replaces a file by a copy that only this user can open.
fn replace(path: &Path) -> std::io::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".closed");
    let copy = PathBuf::from(name);
    let content = fs::read(path)?;
    new_file(&copy)?.write_all(&content)?;
    fs::rename(&copy, path)
}

pub(crate) fn random() -> std::io::Result<u64> {
    let mut bytes = [0; 8];
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(u64::from_ne_bytes(bytes))
}

fn try_lock(lock: &File) -> bool {
    rustix::fs::flock(lock, rustix::fs::FlockOperation::NonBlockingLockExclusive).is_ok()
}

/// Entries of shared memory with a matching name.
fn entries(is_wanted: impl Fn(&str) -> bool) -> Vec<fs::DirEntry> {
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    entries
        .filter(|entry| entry.file_name().to_str().is_some_and(&is_wanted))
        .collect()
}

/// Those of them that belong to this user. Other users cannot replace them: the folder is sticky.
fn objects(is_wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let ours = |entry: &fs::DirEntry| {
        entry
            .metadata()
            .is_ok_and(|about| about.is_file() && about.uid() == home::user())
    };
    let entries = entries(is_wanted).into_iter().filter(ours);
    entries.map(|entry| entry.path()).collect()
}

fn check_places() -> Result<(), Error> {
    for (place, remedy) in [
        (
            SHARED_MEMORY,
            "mount it: mount -t tmpfs -o size=256m tmpfs /dev/shm",
        ),
        ("/proc/self", "mount it: mount -t proc proc /proc"),
        (
            "/dev/urandom",
            "give this root the devices of the computer: mount --rbind /dev ...",
        ),
    ] {
        if !Path::new(place).exists() {
            let what = "a run needs what this root does not have";
            return Err(Error::new(what, place, remedy));
        }
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
