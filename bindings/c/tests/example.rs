//! The example of the header compiles without a warning and prints the same as the command line.

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
    // While it swung with its load, it was trusted.
    let trusted = said.lines().find(|line| line.starts_with("last trusted: "));
    assert!(
        trusted.is_some_and(|line| line.ends_with(", trusted")),
        "{said}"
    );
}

#[test]
fn the_example_is_cpp_too() {
    let folder = tempfile::tempdir().expect("a folder");
    for standard in ["-std=c++11", "-std=c++17"] {
        let source = folder.path().join("example.cpp");
        let text = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/example.c"));
        std::fs::write(&source, text.expect("the example")).expect("a file");
        let source = source.to_str().expect("UTF-8");
        common::compile_as(&["c++", standard], source, folder.path());
    }
}

/// Whoever plans a controller reads it there; `bindings/c/cost` makes the tables again.
#[test]
fn the_readme_has_the_memory_of_an_estimator() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("size.c");
    let text = "#include <stdio.h>\n#include \"heft.h\"\nint main(void) {\n  \
                printf(\"%u %u\\n\", (unsigned)heft_excavator_size(), (unsigned)heft_loader_size());\n  return 0;\n}\n";
    std::fs::write(&source, text).expect("a file");
    let program = common::compile(source.to_str().expect("UTF-8"), folder.path());
    let said = common::run(&program, &[], Vec::new());
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    let sizes = said
        .split_whitespace()
        .map(|s| s.parse::<f64>().expect("bytes"));
    let readme = include_str!("../README.md");
    for (row, size) in ["| excavator, `auto`", "| loader, `full`"]
        .iter()
        .zip(sizes)
    {
        let line = readme.lines().find(|l| l.starts_with(row)).expect(row);
        let stated: f64 = line
            .split('|')
            .nth(2)
            .expect("memory")
            .trim()
            .parse()
            .expect(line);
        assert!((stated / size - 1.0).abs() < 0.01, "{line}: {size} bytes");
    }
}
