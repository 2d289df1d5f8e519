//! All tests of fleets in one program. Each test waits for processes and messages most of its time, so all run in parallel, and Zenoh
//! is linked once.

mod clocks;
mod closed;
mod common;
mod crossing;
mod fleet;
mod hostile;
mod links;
mod python;
mod serve;

/// A test file that is not a module here would not be compiled.
#[test]
fn every_file_of_tests_is_in_this_program() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for file in folder.read_dir().expect("this folder").flatten() {
        let name = file.file_name().to_string_lossy().replace(".rs", "");
        let module = format!("\nmod {name};");
        assert!(
            name == "main" || include_str!("main.rs").contains(&module),
            "{name}"
        );
    }
}
