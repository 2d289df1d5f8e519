//! Dependencies that are shipped: compatible licences, few duplicates.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::process::Command;

use serde_json::Value;

/// Licences that may be linked into MIT or Apache-2.0 code.
const LICENCES: &[&str] = &[
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
    "0BSD",
];

/// Accepted duplicates in the tree, with the reason. The peers of `bench`, and dependencies for
/// builds or tests only, are not shipped and not counted.
const TWICE: &[&str] = &[
    // At build time only: iceoryx2 and ratatui, serde and tracing.
    "darling",
    "darling_core",
    "darling_macro",
    "syn",
    // faer, beside its own nano-gemm.
    "equator",
    "equator-macro",
    // iceoryx2: postcard names both, and its configuration is read by an older toml.
    "embedded-io",
    "toml_datetime",
    "winnow",
    // Features of nalgebra that no crate enables.
    "glam",
];

fn metadata() -> Value {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--offline"])
        .args(["--filter-platform", "x86_64-unknown-linux-gnu"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs the test, so it is there");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Ids of the packages in the binary `heft`.
fn shipped(metadata: &Value) -> BTreeSet<&str> {
    let nodes: BTreeMap<&str, &Value> = metadata["resolve"]["nodes"]
        .as_array()
        .expect("nodes")
        .iter()
        .filter_map(|node| Some((node["id"].as_str()?, node)))
        .collect();
    let mut waiting = vec![
        metadata["resolve"]["root"]
            .as_str()
            .expect("the root package"),
    ];
    let mut seen = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        if !seen.insert(id) {
            continue;
        }
        for dependency in nodes[id]["deps"].as_array().into_iter().flatten() {
            let kinds = dependency["dep_kinds"].as_array().expect("kinds");
            if kinds.iter().any(|kind| kind["kind"].is_null()) {
                waiting.extend(dependency["pkg"].as_str());
            }
        }
    }
    seen
}

fn packages(metadata: &Value) -> Vec<&Value> {
    let ids = shipped(metadata);
    let packages = metadata["packages"].as_array().expect("packages").iter();
    packages
        .filter(|p| p["id"].as_str().is_some_and(|id| ids.contains(id)))
        .collect()
}

/// Whether one of the licences of each alternative is compatible.
fn fits(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ").replace(['(', ')'], "");
    expression
        .split(" AND ")
        .all(|part| part.split(" OR ").any(|one| LICENCES.contains(&one.trim())))
}

#[test]
fn every_licence_fits() {
    let metadata = metadata();
    let packages = packages(&metadata);
    assert!(packages.len() > 50, "the tree was read");
    for package in packages {
        let licence = package["license"].as_str().unwrap_or_default();
        assert!(fits(licence), "{}: `{licence}`", package["name"]);
    }
    assert!(fits("MIT OR GPL-3.0") && !fits("GPL-3.0") && !fits("MIT AND GPL-3.0") && !fits(""));
}

#[test]
fn nothing_is_shipped_in_two_versions_without_a_reason() {
    let metadata = metadata();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for package in packages(&metadata) {
        let text = |key: &str| package[key].as_str().unwrap_or_default();
        versions
            .entry(text("name"))
            .or_default()
            .insert(text("version"));
    }
    versions.retain(|_, versions| versions.len() > 1);
    let found: BTreeSet<&str> = versions.keys().copied().collect();
    assert_eq!(found, TWICE.iter().copied().collect(), "{versions:?}");
}

/// Packages that fleets compile with other features, if only our crates depend on them or they run at compile time.
const UNLIKE: &[&str] = &["anyhow", "fastrand", "flate2", "libc", "tracing-subscriber"];

/// Each package with its features in the tests of a workspace; none if the registry's part of it is not available.
fn compiled(manifest: &str) -> Option<BTreeSet<(String, String)>> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--manifest-path", manifest, "--workspace", "-e"])
        .args(["normal,build,dev", "--prefix", "none", "-f", "{p}|{f}"])
        .args(["--locked", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs the test, so it is there");
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let of_others = lines.lines().filter(|line| !line.contains(" (/"));
    let parts = of_others.filter_map(|line| line.trim_end_matches(" (*)").split_once('|'));
    let found = parts.map(|(p, f)| (p.replace(" (proc-macro)", ""), f.to_owned()));
    output.status.success().then(|| found.collect())
}

/// Each table of a profile of tests, by the package that it is for.
fn profiles(manifest: &str) -> BTreeMap<String, String> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(manifest);
    let text = std::fs::read_to_string(path).expect("a manifest");
    let tables = text.split("\n[").filter_map(|table| {
        let (name, settings) = table
            .strip_prefix("profile.dev.package.")?
            .split_once("]\n")?;
        let settings = settings.lines().filter(|line| line.contains(" = "));
        Some((name.to_owned(), settings.collect::<Vec<_>>().join(", ")))
    });
    tables.collect()
}

#[test]
fn what_both_workspaces_compile_is_compiled_once() {
    let fleets = "services/gateway/Cargo.toml";
    let (Some(main), Some(fleet)) = (compiled("Cargo.toml"), compiled(fleets)) else {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: what fleets stand on was never fetched"
        );
        return;
    };
    let ours: BTreeSet<&String> = main.iter().map(|(package, _)| package).collect();
    let both = fleet.iter().filter(|(package, _)| ours.contains(package));
    let name = |package: &str| package.split(' ').next().unwrap_or_default().to_owned();
    let unlike = both.clone().filter(|&unit| !main.contains(unit));
    let unlike: BTreeSet<String> = unlike.map(|(package, _)| name(package)).collect();
    assert_eq!(
        unlike,
        UNLIKE.iter().map(|&name| name.to_owned()).collect(),
        "services/alike/Cargo.toml asks for the features of both"
    );
    let [ours, theirs] = ["Cargo.toml", fleets].map(profiles);
    for name in both.map(|(package, _)| name(package)) {
        assert_eq!(ours.get(&name), theirs.get(&name), "the profile of {name}");
    }
}
