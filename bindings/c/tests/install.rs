//! The installed library is found by pkg-config and by CMake, also after its folder was moved.

mod common;

use std::io::Write as _;
use std::path::Path;
use std::process::Command;

fn succeeds(command: &mut Command) -> String {
    let output = command
        .output()
        .unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {error}");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

fn is_there(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output();
    found.is_ok_and(|output| output.status.success())
}

/// The static library that cargo has just built, installed and moved.
fn installed(folder: &Path) -> std::path::PathBuf {
    let libraries = folder.join("libraries");
    std::fs::create_dir(&libraries).expect("a folder");
    std::fs::copy(common::library(), libraries.join("libheft_c.a")).expect("a copy");
    let first = folder.join("first");
    succeeds(
        Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/install"))
            .arg(&first)
            .env("LIBRARIES", &libraries)
            .env("SHARED", "0")
            .env_remove("DESTDIR"),
    );
    let moved = folder.join("moved");
    std::fs::rename(first, &moved).expect("the same disk");
    moved
}

#[test]
fn a_program_finds_the_installed_library_by_pkg_config_and_by_cmake() {
    let folder = tempfile::tempdir().expect("a folder");
    let prefix = installed(folder.path());
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/example.c");
    let data = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/golden/excavator_input_base_case2.csv"
    );
    let mut said = Vec::new();
    if is_there("pkg-config") {
        let flags = succeeds(
            Command::new("pkg-config")
                .args(["--cflags", "--libs", "heft"])
                .env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")),
        );
        let program = folder.path().join("by-pkg-config");
        let mut compiler = Command::new("cc");
        compiler.arg(example).args(flags.split_whitespace());
        succeeds(compiler.arg("-o").arg(&program));
        said.push(common::run(
            &program,
            &[],
            std::fs::read(data).expect("data"),
        ));
    }
    if is_there("cmake") {
        let project = folder.path().join("project");
        std::fs::create_dir(&project).expect("a folder");
        let version = env!("CARGO_PKG_VERSION");
        let text = format!(
            "cmake_minimum_required(VERSION 3.13)\nproject(example C)\nfind_package(heft {version} REQUIRED)\n\
             add_executable(example {example})\ntarget_link_libraries(example heft::heft)\n"
        );
        std::fs::write(project.join("CMakeLists.txt"), text).expect("a file");
        let build = project.join("build");
        let path = format!("-DCMAKE_PREFIX_PATH={}", prefix.display());
        succeeds(
            Command::new("cmake")
                .arg("-S")
                .arg(&project)
                .arg("-B")
                .arg(&build)
                .arg(path),
        );
        succeeds(Command::new("cmake").arg("--build").arg(&build));
        let program = build.join("example");
        said.push(common::run(
            &program,
            &[],
            std::fs::read(data).expect("data"),
        ));
    }
    if said.is_empty() {
        let _ = writeln!(std::io::stderr(), "skipped: neither pkg-config nor cmake");
    }
    for output in said {
        assert!(output.status.success() && output.stdout.starts_with(b"inertia "));
    }
}
