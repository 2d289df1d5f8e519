//! `HEFT_SOURCES`: version, and a checksum of the sources to which a saved state belongs. A state of other
//! estimators is refused, even if both have the same version.

include!("../sources.rs");

fn main() {
    let sum = sum_of_sources(&["../../services/estimation/src", "../../services/steps/src"]);
    let version = env!("CARGO_PKG_VERSION");
    println!("cargo:rustc-env=HEFT_SOURCES={version} {sum:016x}");
    println!("cargo:rerun-if-changed=../sources.rs");
}
