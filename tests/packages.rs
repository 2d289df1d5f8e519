//! Packaging: the start of the command, and the package of a fleet, with programs in the place of those of
//! `services/gateway`.

use std::io::Write as _;
use std::path::Path;
use std::process::Command;

/// Runs a program of the system; `None` if it is not installed.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    assert!(
        output.status.success(),
        "{program}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Standard error of a packaging that is refused; `None` without Python.
fn refused(command: &str) -> Option<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let built = Command::new(root.join("services/heft/debian/build"))
        .arg(folder.path())
        .env("HEFT", command)
        .output();
    let Ok(built) = built else {
        let _ = writeln!(std::io::stderr(), "skipped: no python3");
        return None;
    };
    let said = String::from_utf8_lossy(&built.stderr).into_owned();
    assert_eq!(built.status.code(), Some(1), "{said}");
    Some(said)
}

#[test]
fn a_command_of_another_name_is_refused_before_the_package_is_made() {
    if let Some(said) = refused("/bin/true") {
        assert!(
            said.starts_with("HEFT=/") && said.lines().count() == 1,
            "{said}"
        );
    }
}

#[cfg(debug_assertions)]
#[test]
fn a_debug_build_of_the_command_is_not_packaged() {
    if let Some(said) = refused(env!("CARGO_BIN_EXE_heft")) {
        assert!(said.contains("is a debug build"), "{said}");
    }
}

#[test]
fn the_package_of_a_fleet_has_its_programs_units_and_defaults() {
    if output("dpkg-deb", &["--version"]).is_none() || output("python3", &["--version"]).is_none() {
        let _ = writeln!(std::io::stderr(), "skipped: no dpkg-deb, no python3");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let programs = folder.path().join("programs");
    std::fs::create_dir(&programs).expect("a folder");
    for program in ["heft-gateway", "heft-fleet"] {
        std::fs::copy("/bin/true", programs.join(program)).expect("a program");
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let built = Command::new(root.join("services/heft/debian/gateway"))
        .arg(folder.path())
        .env("GATEWAY", &programs)
        .output()
        .expect("it starts");
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{said}");
    let said = String::from_utf8_lossy(&built.stdout);
    let package = said.lines().last().expect("the name of the package");
    assert!(package.ends_with(".deb") && package.contains(env!("CARGO_PKG_VERSION")));

    let files = output("dpkg-deb", &["--contents", package]).expect("its contents");
    for file in [
        "/usr/bin/heft-gateway",
        "/usr/bin/heft-fleet",
        "/usr/lib/systemd/system/heft-router.service",
        "/usr/lib/systemd/system/heft-collector.service",
        "/usr/lib/sysusers.d/heft-gateway.conf",
        "/etc/heft/router",
        "/etc/heft/collector",
        "/usr/share/heft-gateway/keys.sh",
        "/usr/share/doc/heft-gateway/THIRD-PARTY.txt",
    ] {
        assert!(files.contains(&format!(".{file}\n")), "{file}: {files}");
    }
    let conffiles = output("dpkg-deb", &["--info", package, "conffiles"]).expect("a file");
    assert_eq!(conffiles, "/etc/heft/collector\n/etc/heft/router\n");
    let scripts = ["postinst", "prerm", "postrm"];
    for script in scripts {
        let text = output("dpkg-deb", &["--info", package, script]).expect("a script");
        assert!(text.starts_with("#!/bin/sh\nset -e\n"), "{script}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_debug_build_is_not_handed_out() {
    use std::os::unix::fs::PermissionsExt;
    if output("dpkg-deb", &["--version"]).is_none() || output("python3", &["--version"]).is_none() {
        let _ = writeln!(std::io::stderr(), "skipped: no dpkg-deb, no python3");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let program = folder.path().join("heft-gateway");
    std::fs::write(
        &program,
        "#!/bin/sh\necho heft-gateway 0.3.0 '(debug build)'\n",
    )
    .expect("a file");
    let all = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&program, all).expect("a program");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let built = Command::new(root.join("services/heft/debian/gateway"))
        .arg(folder.path().join("out"))
        .env("GATEWAY", folder.path())
        .output()
        .expect("it starts");
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(
        !built.status.success() && said.contains("is a debug build"),
        "{said}"
    );
}

/// Newest glibc that may be required, that of RHEL 9: `GLIBC_2.NEWEST`.
const NEWEST: u32 = 34;

#[test]
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn the_command_starts_where_the_c_library_is_older() {
    let program = std::fs::read(env!("CARGO_BIN_EXE_heft")).expect("the command");
    let mark = b"GLIBC_2.";
    let versions = program.windows(mark.len() + 2).filter_map(|window| {
        let digits = window.strip_prefix(mark)?;
        std::str::from_utf8(digits).ok()?.parse::<u32>().ok()
    });
    let newest = versions.max().expect("it is linked with the C library");
    assert!(
        newest <= NEWEST,
        "GLIBC_2.{newest}: `objdump -T` names the function (f64::hypot was one)"
    );
}

/// The command of a unit, with the options of its file of defaults.
fn command(unit: &str, defaults: &str) -> Vec<String> {
    let line = unit.lines().find_map(|l| l.strip_prefix("ExecStart="));
    let options = defaults.lines().find_map(|l| l.strip_prefix("OPTIONS="));
    let line = line
        .expect("a command")
        .replace("$OPTIONS", options.expect("options"));
    line.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn the_units_of_a_fleet_listen_on_this_host_alone() {
    let router = command(
        include_str!("../services/heft/debian/fleet/heft-router.service"),
        include_str!("../services/heft/debian/fleet/router"),
    );
    assert_eq!(router, ["/usr/bin/heft-fleet", "router"]);
    let collector = command(
        include_str!("../services/heft/debian/fleet/heft-collector.service"),
        include_str!("../services/heft/debian/fleet/collector"),
    );
    let page = collector.iter().position(|word| word == "--page");
    let page = page.and_then(|at| collector.get(at + 1)).expect("a page");
    assert!(page.starts_with("127.0.0.1:"), "{page}");
    let database = collector.iter().find(|word| word.ends_with(".sqlite"));
    assert_eq!(
        database.map(String::as_str),
        Some("/var/lib/heft-fleet/fleet.sqlite")
    );
}

#[test]
fn the_types_for_python_know_every_reason() {
    let types = include_str!("../bindings/python/python/heft/_estimator.pyi");
    for (name, reasons) in [
        ("ExcavatorReason", messages::EXCAVATOR_REASONS),
        ("LoaderReason", messages::LOADER_REASONS),
    ] {
        let known = types.lines().find(|line| line.starts_with(name));
        let known = known.expect("a type for each machine");
        for (reason, _) in reasons {
            assert!(
                known.contains(&format!("\"{reason}\"")),
                "{name} lacks {reason}: bindings/python/build writes the types anew"
            );
        }
    }
}
