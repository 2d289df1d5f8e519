//! Allowed imports between crates: the arrows of the design, enforced by a test.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Each crate of this project with those that it depends on, no more and no fewer.
const ARROWS: &[(&str, &str)] = &[
    ("services/sheet", ""),
    ("services/estimation", "sheet"),
    ("services/messages", "sheet"),
    ("services/config", "estimation messages"),
    ("sim", ""),
    ("bench/limits", ""),
    ("services/diagnostics", ""),
    ("services/runtime", "messages"),
    ("services/recording", "config messages sheet"),
    ("services/sensor", "messages recording runtime sim"),
    ("services/steps", "config estimation messages runtime sheet"),
    (
        "services/checks",
        "config estimation messages recording steps",
    ),
    ("services/statistics", "estimation"),
    ("services/logger", "messages recording runtime"),
    (
        "services/view",
        "estimation messages recording sheet statistics steps",
    ),
    // A separate workspace, because of Zenoh.
    (
        "services/gateway",
        "diagnostics messages recording runtime statistics steps view",
    ),
    // Features that both workspaces compile with.
    ("services/alike", ""),
    ("bindings/c", "estimation sheet"),
    ("bindings/fmu", "estimation messages"),
    ("services/calibrate", "config estimation"),
    (
        "services/evaluate",
        "calibrate config estimation sim statistics",
    ),
    (
        "bench",
        "config estimation fuzz limits messages recording runtime sensor sheet sim statistics steps view",
    ),
    ("bench/fuzz", "config messages recording steps view"),
    // The root package: the command line, above everything.
    (
        "",
        "calibrate checks config diagnostics estimation evaluate limits logger messages recording runtime \
         sensor sheet sim statistics steps view",
    ),
];

/// Names at the top of the repository, no more and no fewer.
const TOP: &str = ".ci .dockerignore .github .gitignore ARCHITECTURE.md CHANGELOG.md CITATION.cff CONTRIBUTING.md Cargo.lock \
    Cargo.toml LICENSE-APACHE LICENSE-MIT README.md SECURITY.md bench bindings build.rs clippy.toml deny.toml docs \
    examples services sim tests";

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

/// Every package of this project by its name.
fn ours() -> BTreeSet<&'static str> {
    let folders = ARROWS.iter().map(|(folder, _)| *folder);
    folders.filter_map(|f| f.rsplit('/').next()).collect()
}

#[test]
fn crates_import_along_the_arrows_and_every_arrow_exists() {
    for (folder, arrows) in ARROWS {
        let mut found = dependencies(folder, "[dependencies]");
        found.retain(|name| ours().contains(name.as_str()));
        let arrows = arrows.split_whitespace().map(str::to_owned).collect();
        assert_eq!(found, arrows, "{folder}");
    }
}

#[test]
fn the_top_holds_what_it_should_and_nothing_that_a_command_left_there() {
    let mut git = Command::new("git");
    let listed = git.arg("ls-files").current_dir(root()).output();
    let Some(files) = listed.ok().filter(|o| o.status.success()) else {
        let _ = writeln!(std::io::stderr(), "skipped: this is no checkout of git");
        return;
    };
    let files = String::from_utf8(files.stdout).expect("names in UTF-8");
    let found: BTreeSet<&str> = files.lines().filter_map(|f| f.split('/').next()).collect();
    assert_eq!(found, TOP.split_whitespace().collect());
}

#[test]
fn every_member_of_the_workspace_has_its_arrows() {
    let text = fs::read_to_string(root().join("Cargo.toml")).expect("a manifest");
    let members = text.split("members = [").nth(1).expect("members");
    let members = members.split(']').next().unwrap_or_default();
    for member in members.split('"').skip(1).step_by(2) {
        assert!(
            ARROWS.iter().any(|(folder, _)| *folder == member),
            "{member}"
        );
    }
}

#[test]
fn estimation_depends_on_nalgebra_and_the_sheet_alone_and_has_no_std() {
    let found = dependencies("services/estimation", "[dependencies]");
    let allowed = ["nalgebra", "serde", "sheet"].map(str::to_owned);
    assert_eq!(found, BTreeSet::from(allowed));
    let manifest = fs::read_to_string(root().join("services/estimation/Cargo.toml"));
    let manifest = manifest.expect("a manifest");
    let serde = manifest
        .lines()
        .find(|l| l.starts_with("serde = { version"));
    assert!(serde.is_some_and(|l| l.contains("optional = true")));
    let default = manifest.lines().find(|l| l.starts_with("default = ["));
    assert_eq!(
        default,
        Some("default = [\"every-method\"]"),
        "serde is off by default"
    );
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
fn only_the_gateway_has_zenoh_and_the_workspace_builds_without_it() {
    let is_zenoh = |name: &String| name.starts_with("zenoh");
    for (folder, _) in ARROWS {
        let found = dependencies(folder, "[dependencies]").iter().any(is_zenoh);
        assert_eq!(found, *folder == "services/gateway", "{folder}");
    }
    let text = |file: &str| fs::read_to_string(root().join(file)).expect("a file");
    assert!(!text("Cargo.lock").contains("name = \"zenoh"));
    let workspace = text("Cargo.toml");
    let excluded = workspace.split("exclude = [").nth(1).expect("a list");
    let excluded = excluded.split(']').next().unwrap_or_default();
    assert!(excluded.contains("\"services/gateway\""));
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

/// The files of each target of a package that cargo does not compile for tests.
fn untested(folder: &Path) -> Vec<PathBuf> {
    let text = fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
    let mut files = Vec::new();
    for section in text
        .split("\n[")
        .filter(|s| s.lines().any(|l| l == "test = false"))
    {
        let path = section.lines().find_map(|l| l.strip_prefix("path = "));
        let path = folder.join(path.unwrap_or("src/lib.rs").trim_matches('"'));
        let home = path.parent().expect("a folder");
        if path.ends_with("src/lib.rs") {
            sources(home, &mut files);
            files.retain(|f| !f.ends_with("src/main.rs") && !f.starts_with(home.join("bin")));
        } else if path.ends_with("main.rs") && !path.ends_with("src/main.rs") {
            sources(home, &mut files);
        } else {
            let text = fs::read_to_string(&path).expect("a program");
            let has_module = text
                .lines()
                .any(|l| l.starts_with("mod ") && l.ends_with(';'));
            assert!(!has_module, "{} is not all of it", path.display());
            files.push(path);
        }
    }
    files
}

#[test]
fn targets_that_are_not_compiled_for_tests_have_none() {
    let folders = ARROWS.iter().map(|(folder, _)| root().join(folder));
    let files: Vec<_> = folders.flat_map(|folder| untested(&folder)).collect();
    assert!(files.len() > 10, "{files:?}");
    for file in files {
        let text = fs::read_to_string(&file).expect("a source file");
        let has_tests = ["#[test]", "cfg(test)"].iter().any(|w| text.contains(w));
        assert!(!has_tests, "{} has tests that nobody runs", file.display());
    }
}
