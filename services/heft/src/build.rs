//! Which build of heft this is.

/// Version, commit, target and the processor features that the compiler may use: everything that can
/// change a bit of an estimate.
pub const IDENTITY: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("HEFT_BUILD"), ")");

/// Key of a recording's metadata that holds it.
pub const KEY: &str = "heft.build";

/// Why the estimates of a recording may differ from those of this build; `None` if it is the same one.
pub fn difference(metadata: &recording::Metadata) -> Option<String> {
    let version = metadata.get("heft.version").map_or("?", String::as_str);
    let theirs = match metadata.get(KEY) {
        Some(build) if build == IDENTITY => return None,
        Some(build) => build.clone(),
        None => format!("{version} (a version that did not record its commit)"),
    };
    Some(format!(
        "recorded by heft {theirs}, this is heft {IDENTITY}"
    ))
}
