//! States are saved and restored; other versions and headers are detected.

mod common;

#[test]
fn a_saved_state_goes_on_bit_for_bit_and_another_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/state.c", folder.path());
    let output = common::run(&program, &[], Vec::new());
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
}
