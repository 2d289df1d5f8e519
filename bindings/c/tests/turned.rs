//! Joint angles that differ by a whole turn are equal.

mod common;

#[test]
fn a_joint_is_where_it_is_whichever_turn_a_sensor_counts() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/turned.c", folder.path());
    let output = common::run(&program, &[], Vec::new());
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
}
