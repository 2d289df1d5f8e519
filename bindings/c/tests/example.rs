//! The example of the header compiles without a warning and says what the command line says.

mod common;

#[test]
fn the_example_compiles_and_weighs_the_golden_load() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("example.c", folder.path());
    let data = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/golden/excavator_input_base_case2.csv"
    );
    let said = common::run(&program, &[], std::fs::read(data).expect("golden data"));
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    // The file ends with the load dropped: the inertia is that of the empty machine.
    assert!(said.starts_with("inertia "), "{said}");
    assert!(said.contains("payload"), "{said}");
}
