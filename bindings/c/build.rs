//! `HEFT_BUILD`: a checksum of everything that determines the memory layout of an estimator. A saved state of another build is
//! refused.

include!("../sources.rs");

fn main() {
    let mut sum = sum_of_sources(&[
        "src",
        "../../services/estimation/src",
        "../../services/sheet/src",
    ]);
    for name in [
        "TARGET",
        "PROFILE",
        "OPT_LEVEL",
        "CARGO_PKG_VERSION",
        "CARGO_CFG_FEATURE",
    ] {
        sum = add(sum, std::env::var(name).unwrap_or_default().as_bytes());
    }
    let compiler =
        std::env::var("RUSTC").map(|rustc| std::process::Command::new(rustc).arg("-vV").output());
    if let Ok(Ok(output)) = compiler {
        sum = add(sum, &output.stdout);
    }
    println!("cargo:rustc-env=HEFT_BUILD={sum:016x}");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../sources.rs");
}
