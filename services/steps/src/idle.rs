//! Keys that were set and do nothing under the methods of a run.

use config::{Description, Tables};
use estimation::loader::Settings;

use crate::{excavator, loader};

/// A key that has no effect, and the methods under which it has none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Idle {
    /// The key, with its table.
    pub key: String,
    /// The methods of the run.
    pub methods: String,
}

impl std::fmt::Display for Idle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} has no effect under {}", self.key, self.methods)
    }
}

/// The keys of a description that differ from their defaults and do nothing under any of `methods`.
/// Only what is certain: a key that is not told may still do nothing.
#[must_use]
pub fn idle_keys(description: &Description, methods: &[&str]) -> Vec<Idle> {
    let keys = match description {
        Description::Excavator(d) => changed(&**d)
            .into_iter()
            .filter(|change| !methods.iter().any(|m| acts(&change.path, m)))
            .collect(),
        Description::Loader(d) => {
            let idle = |change: &Change| {
                let mut without = (**d).clone();
                change.undo(&mut without);
                methods
                    .iter()
                    .filter_map(|m| loader::method(m).ok())
                    .all(|m| Settings::of(d, m) == Settings::of(&without, m))
            };
            changed(&**d).into_iter().filter(idle).collect::<Vec<_>>()
        }
    };
    let idle = |change: Change| Idle {
        key: change.path,
        methods: methods.join(" and "),
    };
    keys.into_iter().map(idle).collect()
}

/// Whether a key of the excavator may act under a method.
fn acts(path: &str, method: &str) -> bool {
    use estimation::excavator::Method;
    let Ok(method) = excavator::method(method) else {
        return true;
    };
    let key = path.strip_prefix("estimator.").unwrap_or(path);
    if key.starts_with("paper.") || key == "epsilon" {
        method == Method::MultiForgettingRls
    } else if key.starts_with("svf_") || key.starts_with("estimate_") {
        method == Method::SvfRls
    } else if key.starts_with("filter_") || key == "forgetting" {
        method.is_regression()
    } else if key.starts_with("velocity_") {
        matches!(method, Method::Velocity | Method::Auto)
    } else {
        true
    }
}

/// A key that differs from its default.
struct Change {
    path: String,
    table: usize,
    index: usize,
}

impl Change {
    /// Sets the key back to its default.
    fn undo<M: Tables>(&self, machine: &mut M) {
        let default = M::default();
        let value = default.tables()[self.table].get(self.index);
        if let Some(value) = value {
            machine.tables_mut()[self.table].set(self.index, &value);
        }
    }
}

fn changed<M: Tables>(machine: &M) -> Vec<Change> {
    let default = M::default();
    let mut found = Vec::new();
    for (table, (now, then)) in machine.tables().iter().zip(default.tables()).enumerate() {
        let differs = |index: &usize| now.get(*index) != then.get(*index);
        for index in (0..now.keys().len()).filter(differs) {
            let key = now.keys()[index].name;
            found.push(Change {
                path: format!("{}.{key}", now.name()),
                table,
                index,
            });
        }
    }
    found
}
