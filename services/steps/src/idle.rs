//! Stated keys without effect under the methods of a run.

use config::{Description, Tables};

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

macro_rules! idle_keys {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// The keys of a description that differ from the defaults of a machine of its size and have no effect under any of `methods`.
        /// Only certain cases: a key that is not listed may still have no effect.
        pub fn idle_keys(description: &Description, methods: &[&str]) -> Vec<Idle> {
            let mut keys = match description {
                $( Description::$machine(d) => {
                    let mut keys = changed(&**d);
                    keys.retain(|change| crate::$module::is_idle(d, change, methods));
                    keys
                } )*
            };
            let idle = |change: Change| Idle {
                key: change.path.to_owned(),
                methods: methods.join(" and "),
            };
            keys.drain(..).map(idle).collect()
        }
    };
}

messages::machines!(idle_keys);

/// A key that differs from the default of a machine of this size.
pub(crate) struct Change {
    pub path: &'static str,
    table: usize,
    index: usize,
}

impl Change {
    /// Sets the key back to its default.
    pub fn undo<M: Tables>(&self, machine: &mut M) {
        let default = machine.of_its_size();
        let value = default.tables()[self.table].get(self.index);
        if let Some(value) = value {
            machine.tables_mut()[self.table].set(self.index, &value);
        }
    }
}

fn changed<M: Tables>(machine: &M) -> Vec<Change> {
    let default = machine.of_its_size();
    let mut found = Vec::new();
    for (table, (now, then)) in machine.tables().iter().zip(default.tables()).enumerate() {
        let differs = |index: &usize| now.get(*index) != then.get(*index);
        for index in (0..now.keys().len()).filter(differs) {
            found.push(Change {
                path: now.keys()[index].path,
                table,
                index,
            });
        }
    }
    found
}
