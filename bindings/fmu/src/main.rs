//! Builds the FMUs: `cargo run -p heft_fmu [FOLDER]`, by default `target/fmu`.
//!
//! One library serves both machines; it is built here in the profile `bindings`, unless one is given.
//! Further platforms are added in the same way: `--library x86_64-windows=PATH`.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use heft_c::{Excavator, Loader};
use heft_fmu::description::{Words, identifier, xml};
use heft_fmu::zip::Zip;

/// Platform of FMI, name of the library that cargo makes, ending inside the FMU.
const HERE: (&str, &str) = if cfg!(target_arch = "aarch64") {
    ("aarch64-linux", "libheft_fmu.so")
} else {
    ("x86_64-linux", "libheft_fmu.so")
};

fn main() -> ExitCode {
    match build(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn build(mut arguments: impl Iterator<Item = String>) -> Result<(), String> {
    let mut folder = None;
    let mut libraries = Vec::new();
    while let Some(argument) = arguments.next() {
        if argument == "--library" {
            let given = arguments.next().unwrap_or_default();
            let (platform, path) = given
                .split_once('=')
                .ok_or("--library wants PLATFORM=PATH, such as x86_64-windows=heft_fmu.dll")?;
            libraries.push((platform.to_owned(), read(Path::new(path))?));
        } else {
            folder = Some(PathBuf::from(argument));
        }
    }
    let target = target();
    if !libraries.iter().any(|(platform, _)| platform == HERE.0) {
        libraries.push((HERE.0.to_owned(), library(&target)?));
    }
    let folder = folder.unwrap_or_else(|| target.join("fmu"));
    std::fs::create_dir_all(&folder).map_err(|e| told("create", &folder, &e))?;
    write::<Excavator>(&folder, &libraries)?;
    write::<Loader>(&folder, &libraries)
}

/// The folder of this program without the profile.
fn target() -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    program
        .ancestors()
        .nth(2)
        .unwrap_or(Path::new("target"))
        .to_owned()
}

/// Builds the library for this platform.
fn library(target: &Path) -> Result<Vec<u8>, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args([
            "build",
            "--profile",
            "bindings",
            "-p",
            "heft_fmu",
            "--lib",
            "--target-dir",
        ])
        .arg(target)
        .current_dir(env!("CARGO_MANIFEST_DIR"));
    let status = command
        .status()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    if !status.success() {
        return Err("the library does not build; see above".to_owned());
    }
    read(&target.join("bindings").join(HERE.1))
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| told("read", path, &e))
}

fn told(what: &str, path: &Path, error: &std::io::Error) -> String {
    format!("cannot {what} {}: {error}", path.display())
}

fn write<M: Words>(folder: &Path, libraries: &[(String, Vec<u8>)]) -> Result<(), String> {
    let name = identifier::<M>();
    let mut zip = Zip::default();
    zip.add("modelDescription.xml", xml::<M>().as_bytes());
    for (platform, library) in libraries {
        let ending = if platform.ends_with("windows") {
            "dll"
        } else {
            "so"
        };
        zip.add(&format!("binaries/{platform}/{name}.{ending}"), library);
    }
    let path = folder.join(format!("{name}.fmu"));
    std::fs::write(&path, zip.finish()).map_err(|e| told("write", &path, &e))?;
    println!("{}", path.display());
    Ok(())
}
