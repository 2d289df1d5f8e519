//! Independent recordings, which are not shipped. The only place that knows their folder, and reports if they are missing.

use std::io::Write as _;
use std::path::PathBuf;

/// A file or folder of the data in `HEFT_DATA`; without that variable, of `shared/data` beside the checkout. `None`
/// if it is missing: the test reports that it is skipped, and passes.
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
