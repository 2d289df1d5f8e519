//! A C program against the library that cargo has just built.

#![allow(dead_code)] // each test uses some of it

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// The static library: cargo puts it beside the tests.
pub fn library() -> PathBuf {
    let test = std::env::current_exe().expect("a path");
    let folder = test.parent().expect("a folder");
    let libraries = std::fs::read_dir(folder).expect("a folder").flatten();
    let ours = libraries.map(|entry| entry.path()).filter(|path| {
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or_default();
        name.starts_with("libheft_c") && name.ends_with(".a")
    });
    ours.max_by_key(|path| path.metadata().and_then(|m| m.modified()).ok())
        .expect("cargo builds the static library with the tests")
}

/// Compiles `source` (relative to the crate) without a warning, as C.
pub fn compile(source: &str, folder: &Path) -> PathBuf {
    compile_as(&["cc", "-std=c99"], source, folder)
}

/// The same with this compiler and language.
pub fn compile_as(compiler: &[&str], source: &str, folder: &Path) -> PathBuf {
    let program = folder.join("program");
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let compiled = Command::new(compiler[0])
        .args(&compiler[1..])
        .args(["-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"])
        .args(["-Wshadow", "-Wconversion"])
        .arg(format!("-I{}", package.join("include").display()))
        .arg(package.join(source))
        .arg(library())
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output()
        .expect("a C compiler");
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );
    program
}

/// Runs a program with these bytes as its input.
pub fn run(program: &Path, arguments: &[String], input: Vec<u8>) -> Output {
    use std::io::Write;
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a program");
    let mut stdin = child.stdin.take().expect("a pipe");
    let writer = std::thread::spawn(move || {
        let _ = stdin.write_all(&input);
    });
    let output = child.wait_with_output().expect("an end");
    writer.join().expect("a writer");
    output
}
