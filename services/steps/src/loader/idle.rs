//! Keys without effect under a method.

use config::Loader;
use estimation::loader::Settings;

use crate::idle::Change;

/// Whether a changed key leaves the settings of all `methods` unchanged.
pub(crate) fn is_idle(loader: &Loader, change: &Change, methods: &[&str]) -> bool {
    let mut without = loader.clone();
    change.undo(&mut without);
    let mut methods = methods.iter().filter_map(|m| super::method(m).ok());
    methods.all(|m| Settings::of(loader, m) == Settings::of(&without, m))
}
