//! Builds the FMUs: `cargo run -p heft_fmu [FOLDER]`, by default `target/fmu`.
//!
//! One library serves both machines; it is built here in the profile `bindings`, for this platform and, where its target
//! and linker are installed, for Windows. Libraries for others, or made elsewhere, are given: `--library PLATFORM=PATH`.
//! `--notices FILE` puts the licences of the crates that are linked into them (`services/heft/notices heft_fmu`).

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use heft_c::{Excavator, Loader};
use heft_fmu::description::{Words, identifier, page, xml};
use heft_fmu::zip::Zip;

const LICENCES: &str = concat!(
    "MIT or Apache-2.0, at your option.\n\n",
    include_str!("../../../LICENSE-MIT"),
    "\n\n",
    include_str!("../../../LICENSE-APACHE")
);

/// Icon of a block in an importer, and its size.
const ICON: [(&str, &[u8]); 3] = [
    ("icon.svg", include_bytes!("../icon/icon.svg")),
    ("icon.png", include_bytes!("../icon/icon.png")),
    (
        "terminalsAndIcons.xml",
        include_bytes!("../icon/terminalsAndIcons.xml"),
    ),
];

/// A platform of FMI.
struct Platform {
    name: &'static str,
    /// File name of the library built by cargo.
    library: &'static str,
    /// Target triple if it is not this machine's own, and its linker.
    target: Option<(&'static str, &'static str)>,
}

const HERE: Platform = if cfg!(target_arch = "aarch64") {
    Platform {
        name: "aarch64-linux",
        library: "libheft_fmu.so",
        target: None,
    }
} else {
    Platform {
        name: "x86_64-linux",
        library: "libheft_fmu.so",
        target: None,
    }
};

const WINDOWS: Platform = Platform {
    name: "x86_64-windows",
    library: "heft_fmu.dll",
    target: Some(("x86_64-pc-windows-gnu", "x86_64-w64-mingw32-gcc")),
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
    let mut notices = None;
    while let Some(argument) = arguments.next() {
        if argument == "--library" {
            let given = arguments.next().unwrap_or_default();
            let (platform, path) = given
                .split_once('=')
                .ok_or("--library wants PLATFORM=PATH, such as x86_64-windows=heft_fmu.dll")?;
            libraries.push((platform.to_owned(), read(Path::new(path))?));
        } else if argument == "--notices" {
            notices = Some(read(Path::new(&arguments.next().unwrap_or_default()))?);
        } else {
            folder = Some(PathBuf::from(argument));
        }
    }
    let target = target();
    for platform in [HERE, WINDOWS] {
        if libraries.iter().any(|(name, _)| name == platform.name) {
            continue;
        }
        match platform.target {
            Some((name, linker)) if !can_build(name, linker) => eprintln!(
                "without {}: it takes `rustup target add {name}` and {linker} (Debian: gcc-mingw-w64-x86-64)",
                platform.name
            ),
            _ => libraries.push((platform.name.to_owned(), library(&target, &platform)?)),
        }
    }
    let folder = folder.unwrap_or_else(|| target.join("fmu"));
    std::fs::create_dir_all(&folder).map_err(|e| file_error("create", &folder, &e))?;
    write::<Excavator>(&folder, &libraries, notices.as_deref())?;
    write::<Loader>(&folder, &libraries, notices.as_deref())
}

/// The target folder: that of this program, without the profile.
fn target() -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    program
        .ancestors()
        .nth(2)
        .unwrap_or(Path::new("target"))
        .to_owned()
}

/// Whether the core library of a target and its linker are installed.
fn can_build(target: &str, linker: &str) -> bool {
    let said = Command::new("rustc").args(["--print", "sysroot"]).output();
    let root = said.ok().and_then(|o| String::from_utf8(o.stdout).ok());
    let installed = root.is_some_and(|root| {
        let libraries = Path::new(root.trim()).join("lib/rustlib");
        libraries.join(target).join("lib").is_dir()
    });
    let version = Command::new(linker).arg("--version").output();
    installed && version.is_ok_and(|o| o.status.success())
}

/// Builds the library for a platform.
fn library(folder: &Path, platform: &Platform) -> Result<Vec<u8>, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    let fixed = ["build", "--profile", "bindings", "-p", "heft_fmu", "--lib"];
    command.args(fixed).arg("--target-dir").arg(folder);
    let mut made = folder.to_owned();
    if let Some((target, _)) = platform.target {
        command.args(["--target", target]);
        made.push(target);
    }
    let status = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    if !status.success() {
        return Err("the library does not build; see above".to_owned());
    }
    read(&made.join("bindings").join(platform.library))
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| file_error("read", path, &e))
}

fn file_error(what: &str, path: &Path, error: &std::io::Error) -> String {
    format!("cannot {what} {}: {error}", path.display())
}

fn write<M: Words>(
    folder: &Path,
    libraries: &[(String, Vec<u8>)],
    notices: Option<&[u8]>,
) -> Result<(), String> {
    let name = identifier::<M>();
    let mut zip = Zip::default();
    zip.add("modelDescription.xml", xml::<M>().as_bytes());
    zip.add("documentation/index.html", page::<M>().as_bytes());
    for (file, content) in ICON {
        zip.add(&format!("terminalsAndIcons/{file}"), content);
    }
    let licences = "documentation/licenses";
    zip.add(&format!("{licences}/license.txt"), LICENCES.as_bytes());
    if let Some(notices) = notices {
        zip.add(&format!("{licences}/THIRD-PARTY.txt"), notices);
    }
    for (platform, library) in libraries {
        let ending = if platform.ends_with("windows") {
            "dll"
        } else {
            "so"
        };
        zip.add(&format!("binaries/{platform}/{name}.{ending}"), library);
    }
    let path = folder.join(format!("{name}.fmu"));
    std::fs::write(&path, zip.finish()).map_err(|e| file_error("write", &path, &e))?;
    println!("{}", path.display());
    Ok(())
}
