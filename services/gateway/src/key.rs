//! Keys: `heft/v1/SITE/MACHINE/KIND/NAME`.

use std::fmt;

/// Prefix of all keys.
pub const ROOT: &str = "heft/v1";
/// All streams of all machines.
pub const STREAMS: &str = "heft/v1/*/*/*/*";
/// The kind of the streams whose messages Zenoh numbers.
pub const ESTIMATE: &str = "estimate";
/// The keys of these streams.
pub const ESTIMATES: &str = "heft/v1/*/*/estimate/*";
/// The status of all machines.
pub const STATUS: &str = "heft/v1/*/*/status";
/// A site's estimates from a machine's samples: `SITE_ESTIMATE/CHANNEL`.
pub const SITE_ESTIMATE: &str = "site";
/// The tokens of all machines.
pub const TOKENS: &str = "heft/v1/*/*/alive";

/// Identifier of a machine: its site and its name there.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MachineId {
    /// The site.
    pub site: String,
    /// The machine.
    pub machine: String,
}

impl MachineId {
    /// A machine with names that are valid in a key: 1 to 64 of `a-z A-Z 0-9 . _ -` each.
    pub fn new(site: &str, machine: &str) -> Option<Self> {
        let is_name = |text: &str| {
            (1..=64).contains(&text.len())
                && text
                    .bytes()
                    .all(|b| b.is_ascii_alphanumeric() || b"._-".contains(&b))
        };
        (is_name(site) && is_name(machine)).then(|| Self {
            site: site.to_owned(),
            machine: machine.to_owned(),
        })
    }

    /// The key `what` below this machine.
    pub fn key(&self, what: &str) -> String {
        format!("{ROOT}/{}/{}/{what}", self.site, self.machine)
    }

    /// The machine of `key`, and the rest of the key.
    pub fn of(key: &str) -> Option<(Self, &str)> {
        let rest = key.strip_prefix(ROOT)?.strip_prefix('/')?;
        let (site, rest) = rest.split_once('/')?;
        let (machine, what) = rest.split_once('/')?;
        Some((Self::new(site, machine)?, what))
    }
}

impl fmt::Display for MachineId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.site, self.machine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_names_its_machine_and_nothing_else_passes() {
        let id = MachineId::new("north", "ex-17").expect("names");
        let key = id.key("estimate/inertia_ukf");
        assert_eq!(key, "heft/v1/north/ex-17/estimate/inertia_ukf");
        assert_eq!(MachineId::of(&key), Some((id, "estimate/inertia_ukf")));
        for bad in ["heft/v1/a", "heft/v2/a/b/c", "heft/v1/a/*/c", "x"] {
            assert_eq!(MachineId::of(bad), None, "{bad}");
        }
        assert_eq!(MachineId::new("a/b", "c"), None);
        assert_eq!(MachineId::new("a", ""), None);
        assert_eq!(MachineId::new("a", &"x".repeat(65)), None);
    }
}
