//! A program in C counts loads.

mod common;

#[test]
fn a_program_in_c_counts_loads_and_always_has_a_payload() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/loads.c", folder.path());
    let output = common::run(&program, &[], Vec::new());
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
}
