//! Data recorded by others: not ours to ship. The one place that knows where they are, and says so where they are not.

use std::io::Write as _;
use std::path::PathBuf;

/// A file or folder of the data that `HEFT_DATA` names; without that, those in `shared/data` beside the checkout. `None`
/// where it is missing: the test that asked says that it is skipped, and passes.
pub fn data(name: &str) -> Option<PathBuf> {
    let mut beside = std::env::current_dir().expect("the folder of a package");
    while !beside.join("Cargo.lock").exists() && beside.pop() {}
    let root = std::env::var_os("HEFT_DATA").map_or(beside.join("../shared/data"), PathBuf::from);
    let file = root.join(name);
    if !file.exists() {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: {} is not here (set HEFT_DATA to the folder of recorded data)",
            file.display()
        );
    }
    file.exists().then_some(file)
}
