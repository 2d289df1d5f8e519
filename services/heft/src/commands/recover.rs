//! `heft recover`: mends a recording that was cut off. Commands that read one do so by themselves.

use std::path::Path;

use crate::failure::Failure;

/// `heft recover`
pub fn recover(file: &Path) -> Result<(), Failure> {
    if recording::is_complete(file)? {
        println!("{} is complete; nothing was changed", file.display());
    } else {
        mend(file)?;
    }
    Ok(())
}

/// Mends `file` if it needs it, and says so. A recording that is still being written is left alone
/// by those who write it: see `heft top` for a running pipeline.
pub fn mend(file: &Path) -> Result<(), Failure> {
    if file.extension().is_some_and(|e| e == "mcap") && !recording::is_complete(file)? {
        println!("{}: {}", file.display(), recording::recover(file)?);
    }
    Ok(())
}
