//! Pipes in the place of files, and files after an interruption.

use std::fs;
use std::path::Path;

use crate::common::{self, both, golden, run};

#[test]
fn a_pipe_is_named_and_not_half_read() {
    use std::process::Stdio;
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("out.csv");
    let estimate = |input: &str| {
        let rows = fs::File::open(golden("excavator_input_base_case1.csv")).expect("rows");
        let mut cat = std::process::Command::new("cat");
        let mut cat = cat.stdin(rows).stdout(Stdio::piped()).spawn().expect("cat");
        let pipe = cat.stdout.take().expect("its rows");
        let result = common::heft()
            .args(["estimate", input, "--machine", "excavator", "-o"])
            .arg(&output)
            .stdin(pipe)
            .output()
            .expect("heft");
        cat.wait().expect("cat");
        result
    };
    for input in ["/dev/stdin", "-"] {
        let result = estimate(input);
        let text = both(&result);
        assert_eq!(result.status.code(), Some(2), "{text}");
        assert!(text.contains("heft serve"), "{text}");
    }
    assert!(!output.exists());
}

#[test]
fn estimates_on_standard_output_are_rows_and_nothing_else() {
    let input = golden("excavator_input_base_case1.csv");
    let args = [
        "estimate",
        input.to_str().expect("a path"),
        "--machine",
        "excavator",
    ];
    let estimates = |output: &str| run(&[&args[..], &["-o", output]].concat());
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("out.csv");
    let whole = estimates(file.to_str().expect("a path"));
    assert!(!whole.stdout.is_empty(), "words");
    let rows = fs::read(&file).expect("rows");
    for output in ["-", "/dev/stdout"] {
        let result = estimates(output);
        assert!(result.stdout == rows, "{output}");
        assert!(both(&result).contains("The swing inertia is"), "{output}");
    }
    assert!(!Path::new("-").exists());
    // A reader that leaves early gets no message.
    let heft = env!("CARGO_BIN_EXE_heft");
    let script = format!("{heft} \"$@\" -o /dev/stdout | head -1; echo ${{PIPESTATUS[0]}}");
    let left = std::process::Command::new("bash")
        .args(["-c", &script, "heft"])
        .args(args)
        .output()
        .expect("bash runs");
    let shown = String::from_utf8_lossy(&left.stdout).into_owned();
    let words = String::from_utf8_lossy(&left.stderr).into_owned();
    assert!(shown.ends_with("141\n"), "{shown}");
    assert!(!words.contains("heft:"), "{words}");
    // A file behind the device's name is written, and replaces no other file.
    let behind = folder.path().join("behind.csv");
    let status = common::heft()
        .args(args)
        .args(["-o", "/dev/fd/1"])
        .stdout(fs::File::create(&behind).expect("a file"))
        .status();
    assert_eq!(status.expect("heft").code(), whole.status.code());
    assert!(fs::read(&behind).expect("rows") == rows);
}

#[test]
fn an_estimate_that_is_interrupted_leaves_nothing_behind() {
    use std::os::unix::process::ExitStatusExt as _;
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
    let rows = (0..1_000_000).map(|i| format!("{}.{:03},0.1,0\n", i / 1000, i % 1000));
    let table = "t,swing_velocity,swing_torque\n".to_owned() + &rows.collect::<String>();
    fs::write(&input, table).expect("a file");
    let mut heft = common::heft();
    let heft = heft.args(["estimate", "--machine", "excavator", "-o"]);
    let mut heft = heft.arg(&output).arg(&input).spawn().expect("heft");
    let files = || fs::read_dir(folder.path()).expect("the folder").count();
    let limit = std::time::Duration::from_secs(20);
    common::wait_until("a file in the making", limit, || files() > 1);
    // A shell that starts the tests in the background ignores SIGINT, and so does heft.
    common::kill(heft.id(), rustix::process::Signal::TERM);
    let status = heft.wait().expect("an end");
    assert_eq!(status.signal(), Some(15), "{status}");
    assert_eq!(files(), 1, "the input");
}

#[test]
fn a_copy_that_is_interrupted_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join("copy.mcap");
    // A recording that is cut off is written again.
    let mut big = fs::read(golden("recordings/loader-cfdbb98.mcap")).expect("golden");
    big.truncate(big.len() - 40);
    let input = folder.path().join("cut.mcap");
    fs::write(&input, big).expect("a file");
    for delay in 0..12 {
        let mut heft = common::heft();
        let heft = heft.arg("recover").arg(&input).arg("-o").arg(&copy);
        let mut heft = heft.spawn().expect("heft");
        std::thread::sleep(std::time::Duration::from_millis(5 * delay));
        common::kill(heft.id(), rustix::process::Signal::TERM);
        heft.wait().expect("an end");
        if copy.exists() {
            let said = common::run_ok(&["recover", copy.to_str().expect("a path")]);
            assert!(said.contains("nothing was changed"), "{delay}: {said}");
            fs::remove_file(&copy).expect("writable");
        }
    }
}
