//! Who may import whom: the arrows of the design, held by a test.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Each crate of ours with all the crates of ours that it may depend on.
const ARROWS: &[(&str, &[&str])] = &[
    ("services/estimation", &[]),
    ("services/messages", &[]),
    ("services/config", &["estimation", "messages"]),
    ("sim", &[]),
    ("bench/limits", &[]),
    ("services/runtime", &["messages"]),
    ("services/recording", &["messages", "config"]),
    (
        "services/sensor",
        &["messages", "config", "runtime", "recording", "sim"],
    ),
    (
        "services/steps",
        &["messages", "config", "runtime", "estimation"],
    ),
    ("services/logger", &["messages", "recording", "runtime"]),
    ("services/view", &["messages", "recording", "steps"]),
    ("services/evaluate", &["sim", "estimation"]),
    ("bindings/c", &["estimation"]),
    ("bindings/fmu", &["heft_c", "messages", "estimation"]),
    (
        "bench",
        &[
            "estimation",
            "limits",
            "messages",
            "config",
            "runtime",
            "steps",
            "sim",
        ],
    ),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn dependencies(folder: &str, section: &str) -> BTreeSet<String> {
    let text = fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
    let mut inside = false;
    let mut names = BTreeSet::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            inside = line == section;
        } else if inside && !line.is_empty() && !line.starts_with('#') {
            let name = line.split(['.', ' ', '=']).next().unwrap_or_default();
            names.insert(name.to_owned());
        }
    }
    names
}

fn ours() -> BTreeSet<&'static str> {
    ARROWS.iter().map(|(folder, _)| name(folder)).collect()
}

fn name(folder: &str) -> &str {
    folder.rsplit('/').next().unwrap_or(folder)
}

#[test]
fn crates_import_only_along_the_arrows() {
    for (folder, allowed) in ARROWS {
        for dependency in dependencies(folder, "[dependencies]") {
            assert!(
                !ours().contains(dependency.as_str()) || allowed.contains(&dependency.as_str()),
                "{folder} must not depend on {dependency}"
            );
        }
    }
}

#[test]
fn estimation_depends_on_nalgebra_alone_and_has_no_std() {
    let found = dependencies("services/estimation", "[dependencies]");
    assert_eq!(found, BTreeSet::from(["nalgebra".to_owned()]));
    let lib = fs::read_to_string(root().join("services/estimation/src/lib.rs")).expect("a crate");
    assert!(lib.contains("#![no_std]"));
}

#[test]
fn only_the_runtime_talks_to_iceoryx2() {
    for (folder, _) in ARROWS
        .iter()
        .filter(|(folder, _)| *folder != "services/runtime")
    {
        assert!(
            !dependencies(folder, "[dependencies]").contains("iceoryx2"),
            "{folder}"
        );
    }
    assert!(!dependencies("", "[dependencies]").contains("iceoryx2"));
}

#[test]
fn faer_stays_off_the_hot_path() {
    for folder in ["services/estimation", "services/steps"] {
        assert!(
            !dependencies(folder, "[dependencies]").contains("faer"),
            "{folder}"
        );
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file without its tests.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a source file");
    text.split("#[cfg(test)]")
        .next()
        .unwrap_or_default()
        .to_owned()
}

#[test]
fn steps_do_no_io_and_read_no_clock() {
    let forbidden = [
        "std::fs",
        "std::net",
        "std::time",
        "Instant::now",
        "println!",
        "tracing::",
    ];
    for folder in ["services/estimation", "services/steps", "sim"] {
        let mut files = Vec::new();
        sources(&root().join(folder).join("src"), &mut files);
        // Test modules in files of their own; they read golden vectors.
        files.retain(|file| !file.ends_with("golden.rs"));
        assert!(!files.is_empty(), "{folder} has sources");
        for file in files {
            let text = code(&file);
            for word in forbidden {
                assert!(!text.contains(word), "{} uses {word}", file.display());
            }
        }
    }
}

#[test]
fn truth_and_belief_share_no_code() {
    assert!(!dependencies("sim", "[dependencies]").contains("estimation"));
    assert!(!dependencies("services/estimation", "[dependencies]").contains("sim"));
    let mut files = Vec::new();
    sources(&root().join("services/steps/src"), &mut files);
    for file in files {
        let text = code(&file);
        assert!(
            !text.contains("Truth"),
            "{} reads the truth",
            file.display()
        );
    }
}

#[test]
fn the_product_has_no_unsafe_code() {
    let mut files = Vec::new();
    // `bench` has some: shared pages of the bare chains, vector instructions, a counting allocator.
    for folder in ["services", "sim"] {
        sources(&root().join(folder), &mut files);
    }
    for file in files {
        let path = file.display().to_string();
        let has_unsafe = code(&file).lines().any(|line| {
            let line = line.trim_start();
            !line.starts_with("//") && line.contains("unsafe {")
        });
        assert!(!has_unsafe, "{path}");
    }
}
