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

/// The examples of this crate, called without what they need.
#[test]
fn an_example_without_arguments_says_how_it_is_called() {
    for (example, args) in [
        ("swarm", &[][..]),
        ("swarm", &["here", "two"]),
        ("stand_in", &[]),
    ] {
        let program = common::beside(&format!("examples/{example}"));
        let output = std::process::Command::new(program).args(args).output();
        let output = output.expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.starts_with(&format!("usage: {example} ")), "{said}");
        assert_eq!(output.status.code(), Some(2), "{said}");
    }
}

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
