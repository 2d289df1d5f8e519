//! Home: the folder in memory with one user's domains, closed to all other users.
//!
//! `/dev/shm` is open to everybody: whoever creates a name there first owns it, and may make it a link
//! to another place. A home is therefore checked before use: it must be a folder, not a link, of
//! this user, and closed to all others. Every user has a home of their own.

use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};

use crate::Error;

/// POSIX shared memory; the objects of iceoryx2 are always here.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// Folder of the per-user runtime folders of the system.
const RUNTIME: &str = "/run/user";
/// Folder of the per-unit runtime folders of the system.
const UNITS: &str = "/run";
/// Number of random names that are tried for a home.
const ATTEMPTS: usize = 16;
/// Folder of the domains of all users in early versions; still read to clean up.
const EARLY: &str = "/dev/shm/heft";
/// File system type of a file system in memory in `statfs`.
const TMPFS: i64 = 0x0102_1994;

/// Effective user id of this process.
pub(crate) fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Opens a folder without following a link in its last place.
fn open(folder: &Path) -> std::io::Result<File> {
    let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    Ok(rustix::fs::open(folder, flags, Mode::empty())?.into())
}

/// Whether `folder` is a folder of this user whose permissions for others are within `allowed`.
fn is_ours(folder: &Path, allowed: u32) -> std::io::Result<bool> {
    let about = open(folder)?.metadata()?;
    Ok(about.uid() == user() && about.mode() & 0o077 & !allowed == 0)
}

/// Whether `folder` is a runtime folder of this user, in memory.
fn is_runtime_folder(folder: &Path) -> bool {
    let in_memory = |f: File| rustix::fs::fstatfs(f).is_ok_and(|s| s.f_type == TMPFS);
    folder.is_absolute() && is_ours(folder, 0).unwrap_or(false) && open(folder).is_ok_and(in_memory)
}

/// Possible places of a home, best first.
fn places() -> Vec<PathBuf> {
    let given = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let usual = Path::new(RUNTIME).join(user().to_string());
    let mut places: Vec<PathBuf> = given
        .into_iter()
        .chain([usual])
        .filter(|folder| is_runtime_folder(folder))
        .map(|folder| folder.join("heft"))
        .collect();
    places.dedup();
    places.push(Path::new(SHARED_MEMORY).join(format!("heft-{}", user())));
    places
}

/// The home for new domains, created if necessary.
///
/// # Errors
/// Its name is taken by a link, a file, or a folder that other users own or can enter.
pub fn make() -> Result<PathBuf, Error> {
    let mut refused = None;
    for place in places() {
        // An existing folder is checked below.
        let made = rustix::fs::mkdir(&place, Mode::RWXU);
        match is_ours(&place, 0) {
            Err(absent) if absent.kind() == std::io::ErrorKind::NotFound => {
                let why = made.err().map_or(absent, Into::into);
                refused = Some((place, format!("cannot be made: {why}")));
            }
            Ok(true) => return Ok(place),
            Ok(false) => refused = Some((place, "belongs to, or is open to, another user".into())),
            Err(e) => refused = Some((place, format!("is no folder of this user: {e}"))),
        }
    }
    // A process that occupies the usual name cannot know a random one in advance.
    if let Some(spare) = spares().into_iter().next() {
        return Ok(spare);
    }
    for _ in 0..ATTEMPTS {
        let spare = Path::new(SHARED_MEMORY).join(format!("{}{:016x}", spare_prefix(), chance()));
        if rustix::fs::mkdir(&spare, Mode::RWXU).is_ok() && is_ours(&spare, 0).unwrap_or(false) {
            return Ok(spare);
        }
    }
    let (place, why) = refused.unwrap_or_default();
    Err(Error::new(
        format!("the folder for the domains of this user {why}"),
        place.display().to_string(),
        format!(
            "remove what is there, let this user write in {SHARED_MEMORY} (a tmpfs), \
             or set XDG_RUNTIME_DIR to a folder of mode 0700 on a tmpfs"
        ),
    ))
}

/// Prefix of the random names of homes.
fn spare_prefix() -> String {
    format!("heft-{}-", user())
}

/// Homes of this user with random names, used because the usual name was taken.
fn spares() -> Vec<PathBuf> {
    named(Path::new(SHARED_MEMORY), &spare_prefix())
        .into_iter()
        .filter(|folder| is_ours(folder, 0).unwrap_or(false))
        .collect()
}

/// Entries of a folder whose names begin with `prefix`, sorted.
fn named(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix))
        .map(|entry| entry.path())
        .collect();
    found.sort();
    found
}

fn chance() -> u64 {
    use std::hash::{BuildHasher, Hasher, RandomState};
    // Each instance has its own keys, from the system's random source.
    RandomState::new().build_hasher().finish()
}

/// Every home of this user that exists and is safe.
pub(crate) fn all() -> Vec<PathBuf> {
    let trusted = |place: &PathBuf| is_ours(place, 0).unwrap_or(false);
    let of_units = named(Path::new(UNITS), "heft-").into_iter();
    let of_units = of_units.filter(|folder| is_runtime_folder(folder));
    let units = of_units.map(|folder| folder.join("heft"));
    let mut homes: Vec<PathBuf> = Vec::new();
    for place in places()
        .into_iter()
        .filter(trusted)
        .chain(spares())
        .chain(units.filter(trusted))
    {
        if !homes.contains(&place) {
            homes.push(place);
        }
    }
    // Early versions let other users read it, but never write.
    if is_ours(Path::new(EARLY), 0o055).unwrap_or(false) {
        homes.push(EARLY.into());
    }
    homes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_link_and_an_open_folder_are_no_homes() {
        let folder = tempfile::tempdir().unwrap();
        let (own, link) = (folder.path().join("own"), folder.path().join("link"));
        fs::create_dir(&own).unwrap();
        fs::set_permissions(&own, fs::Permissions::from_mode(0o700)).unwrap();
        std::os::unix::fs::symlink(&own, &link).unwrap();
        assert!(is_ours(&own, 0).unwrap());
        assert!(is_ours(&link, 0).is_err(), "a link is not followed");
        fs::set_permissions(&own, fs::Permissions::from_mode(0o755)).unwrap();
        assert!(!is_ours(&own, 0).unwrap());
        assert!(is_ours(&own, 0o055).unwrap());
    }
}
