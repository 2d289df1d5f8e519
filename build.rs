//! Tells the program which build it is: recordings carry it, so that a replay by another build can
//! say why it differs. Without git, as in a container, HEFT_COMMIT says it; else, as in a source archive, it is "unknown".

use std::process::Command;

fn main() {
    let git = |args: &[&str]| {
        // It looks, and writes nothing: a refreshed index would be news for the next build.
        let mut git = Command::new("git");
        let output = git
            .env("GIT_OPTIONAL_LOCKS", "0")
            .args(args)
            .output()
            .ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    // Only a commit of this very source: not of a repository that an archive was unpacked into.
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let is_ours = git(&["rev-parse", "--show-toplevel"]).is_some_and(|top| top == here);
    let commit = is_ours
        .then(|| git(&["rev-parse", "--short=7", "HEAD"]))
        .flatten();
    let commit = commit.map(|commit| {
        let paths = [
            "status",
            "--porcelain",
            "--untracked-files=no",
            "--",
            "services",
            "sim",
        ];
        let changed = git(&paths).is_some_and(|text| !text.is_empty());
        commit + if changed { "-changed" } else { "" }
    });
    // An image is built without git: its build sets HEFT_COMMIT.
    let given = std::env::var("HEFT_COMMIT").ok();
    let commit = commit.or(given.filter(|commit| !commit.is_empty()));
    let variable = |name: &str| std::env::var(name).unwrap_or_else(|_| "unknown".into());
    println!(
        "cargo::rustc-env=HEFT_BUILD={}, {} {}, {}",
        commit.as_deref().unwrap_or("unknown"),
        variable("TARGET"),
        variable("PROFILE"),
        variable("CARGO_CFG_TARGET_FEATURE"),
    );
    if let (true, Some(folder)) = (is_ours, git(&["rev-parse", "--absolute-git-dir"])) {
        println!("cargo::rerun-if-changed={folder}/HEAD");
        // Uncommitted changes. Not the index, because each `git status` writes it again.
        let crates = std::fs::read_dir("services")
            .into_iter()
            .flatten()
            .flatten();
        for folder in crates.map(|entry| entry.path()).chain(["sim".into()]) {
            let sources = folder.join("src");
            if sources.is_dir() {
                println!("cargo::rerun-if-changed={}", sources.display());
            }
        }
        if let Some(common) = git(&["rev-parse", "--path-format=absolute", "--git-common-dir"]) {
            println!("cargo::rerun-if-changed={common}/refs/heads");
            // A file that is not there would be news each time.
            let packed = format!("{common}/packed-refs");
            if std::fs::exists(&packed).is_ok_and(|exists| exists) {
                println!("cargo::rerun-if-changed={packed}");
            }
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=HEFT_COMMIT");
}
