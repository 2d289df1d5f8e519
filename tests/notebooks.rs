//! The notebooks of `examples/notebooks` run from the first cell to the last, where a Python has the package.

use std::io::Write as _;
use std::path::Path;
use std::process::Command;

/// The interpreter of `HEFT_PYTHON=venv/bin/python cargo test --workspace --test notebooks`, or the default one.
fn python() -> Option<String> {
    let python = std::env::var("HEFT_PYTHON").unwrap_or_else(|_| "python3".into());
    let needed = "import heft, pandas, matplotlib, nbconvert, ipykernel; print(heft.__version__)";
    let reported = Command::new(&python).args(["-c", needed]).output().ok()?;
    let ours = String::from_utf8_lossy(&reported.stdout).trim() == env!("CARGO_PKG_VERSION");
    ours.then_some(python)
}

#[test]
fn the_notebooks_run_where_python_has_this_heft() {
    let Some(python) = python() else {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: no python3 with this heft, pandas, matplotlib, nbconvert and ipykernel"
        );
        return;
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/notebooks");
    let scratch = tempfile::tempdir().expect("a folder");
    let files = std::fs::read_dir(folder).expect("notebooks").flatten();
    let notebooks = files
        .map(|file| file.path())
        .filter(|path| path.extension().is_some_and(|e| e == "ipynb"));
    let mut count = 0;
    for notebook in notebooks {
        let name = notebook.file_name().expect("a name");
        std::fs::copy(&notebook, scratch.path().join(name)).expect("copied");
        let run = Command::new(&python)
            .args("-m nbconvert --to notebook --execute --stdout".split(' '))
            .arg(name)
            .current_dir(&scratch)
            .output()
            .expect("python runs");
        assert!(
            run.status.success(),
            "{}: {}",
            notebook.display(),
            String::from_utf8_lossy(&run.stderr)
        );
        count += 1;
    }
    assert!(count >= 2, "{count} notebooks");
}
