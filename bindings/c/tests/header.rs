//! The committed header is the one generated from the tables.

#[path = "../examples/header.rs"]
mod generator;

#[test]
fn the_committed_header_comes_from_the_tables() {
    let committed = std::fs::read_to_string(generator::FILE).expect("include/heft.h");
    assert!(
        committed == generator::header(),
        "run `cargo run -p heft_c --example header` and commit include/heft.h"
    );
}
