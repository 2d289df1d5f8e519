//! A single version: all published files state that of `Cargo.toml`.

use std::path::Path;

/// Files that contain the version, and the text before it.
const PLACES: &[(&str, &str)] = &[
    (
        "bindings/python/Cargo.toml",
        "name = \"heft_python\"\nversion = \"",
    ),
    (
        "bindings/python/Cargo.lock",
        "name = \"heft_python\"\nversion = \"",
    ),
    (
        "services/gateway/Cargo.toml",
        "name = \"gateway\"\nversion = \"",
    ),
    (
        "services/gateway/Cargo.lock",
        "name = \"gateway\"\nversion = \"",
    ),
    ("Cargo.toml", "path = \"services/sheet\", version = \""),
    ("bindings/c/include/heft.h", "#define HEFT_VERSION \""),
    ("CITATION.cff", "\nversion: "),
    ("docs/run.md", "./heft_"),
    ("docs/fleet.md", "./heft_"),
];

fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    std::fs::read_to_string(path).expect(file)
}

#[test]
fn every_place_that_writes_the_version_writes_this_one() {
    for (file, before) in PLACES {
        let text = text(file);
        let after = text.split_once(before).map(|(_, after)| after);
        let after = after.unwrap_or_else(|| panic!("{file} has no {before:?}"));
        let version: String = after
            .chars()
            .take_while(|c| c.is_ascii_digit() || *c == '.')
            .collect();
        assert_eq!(version, env!("CARGO_PKG_VERSION"), "{file}");
    }
}

#[test]
fn the_changelog_has_a_newer_part_than_the_last_release() {
    let text = text("CHANGELOG.md");
    let heading = text.lines().find_map(|line| line.strip_prefix("## "));
    let heading = heading.expect("a heading");
    assert!(
        heading == "Unreleased" || heading.starts_with(env!("CARGO_PKG_VERSION")),
        "{heading}"
    );
}
