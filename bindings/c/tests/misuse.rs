//! Wrong pointers, memory, settings and rows end in a code, never in a crash.

mod common;

#[test]
fn whatever_a_caller_does_wrong_is_answered_by_a_code() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/misuse.c", folder.path());
    let output = common::run(&program, &[], Vec::new());
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
}
