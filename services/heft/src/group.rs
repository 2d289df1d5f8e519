//! `--group NAME`: the users beside its own that may look at a run.

use std::path::Path;

use crate::failure::Failure;

/// The id of a group, from its name or number.
pub fn id(name: &str) -> Result<u32, Failure> {
    if let Ok(id) = name.parse() {
        return Ok(id);
    }
    let file = Path::new("/etc/group");
    let groups = std::fs::read_to_string(file).map_err(|e| Failure::file("read", file, &e))?;
    // name:password:number:members
    let mut rows = groups
        .lines()
        .map(|line| line.split(':').collect::<Vec<_>>());
    let row = rows.find(|row| row.first() == Some(&name));
    let id = row.and_then(|row| row.get(2)?.parse().ok());
    id.ok_or_else(|| {
        Failure::input(
            format!("this host has no group `{name}`"),
            "--group",
            "name a group of /etc/group, or give the number of one that is kept elsewhere",
        )
    })
}

/// Lets the group read a file, or look into a folder.
pub fn share(path: &Path, group: u32) -> Result<(), Failure> {
    runtime::share(path, group).map_err(|e| {
        Failure::input(
            format!("cannot give it to the group {group}: {e}"),
            path.display(),
            "name a group that this user is in (usermod -aG; SupplementaryGroups= in a unit), or none",
        )
    })
}
