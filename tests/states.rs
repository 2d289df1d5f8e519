//! `heft run --state`: remembered parameters outlive versions of heft; a damaged state, or one of a changed description, is refused.

mod common;

use std::fs;
use std::path::Path;

use common::{both, run, says};
use recording::Reader;

/// The line of a run of the excavator on its state.
fn run_with(folder: &Path, name: &str, state: &str, duration: &str, set: &[&str]) -> String {
    let (state, out) = (
        common::path_in(folder, state),
        common::path_in(folder, name),
    );
    let domain = common::domain(name);
    let mut args = vec!["run", "excavator", "--scenario", "cycle", "--pace", "max"];
    args.extend(["--quiet", "--no-report", "--duration", duration]);
    args.extend(["--state", &state, "--out", &out, "--domain", &domain]);
    args.extend(set.iter().flat_map(|key| ["--set", key]));
    let output = run(&args);
    let text = both(&output);
    assert!(output.status.success(), "{name}: {text}");
    let line = text.lines().find(|line| line.contains(&state));
    line.expect("a line of the state").to_owned()
}

/// The text without the fields that the first format did not have, and with its own one.
fn first_format(text: &str, description: &str) -> String {
    let mut state: serde_json::Value = serde_json::from_str(text).expect("JSON");
    let fields = state.as_object_mut().expect("an object");
    for new in ["format", "stated", "sha256"] {
        assert!(fields.remove(new).is_some(), "{new}: {text}");
    }
    let hash = recording::sha256(description);
    fields.insert("description_sha256".into(), hash.into());
    serde_json::to_string_pretty(&state).expect("JSON") + "\n"
}

#[test]
fn a_state_is_read_again_unless_it_is_damaged_or_the_user_changed_the_description() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (read, write) = (
        |name: &str| fs::read_to_string(folder.join(name)).expect("a state"),
        |name: &str, text: &str| fs::write(folder.join(name), text).expect("writable"),
    );
    let set = ["machine.rated_payload=1900"];
    let said = run_with(folder, "first", "s.json", "40", &set);
    assert!(said.contains("nothing to remember yet"), "{said}");
    let learnt = read("s.json");
    let value = "\"value\": 1";
    assert!(learnt.contains(value), "a damping of some 1500: {learnt}");

    // The same description in another notation.
    let other_words = ["machine.rated_payload=1.9e3"];
    let said = run_with(folder, "again", "s.json", "1", &other_words);
    assert!(said.contains("restored damping 1"), "{said}");

    // One digit differs: still a number, and in range.
    write("flipped.json", &learnt.replace(value, "\"value\": 2"));
    let said = run_with(folder, "flipped", "flipped.json", "1", &set);
    assert!(said.contains("not used: damaged: its checksum"), "{said}");
    assert!(said.contains("kept as"), "{said}");
    let kept = read("flipped.json.refused");
    assert!(kept.contains("\"value\": 2"), "as it was: {kept}");

    write("changed.json", &learnt);
    let changed = ["machine.rated_payload=2100"];
    let said = run_with(folder, "changed", "changed.json", "1", &changed);
    let why = "the machine file was changed since: machine.rated_payload;";
    assert!(said.contains(why), "{said}");
    assert_eq!(read("changed.json.refused"), learnt);

    // A state from before formats had versions: its description is in the recording.
    let recorded = Reader::open(folder.join("first/run.mcap")).expect("a recording");
    let description = &recorded.metadata()["description"];
    write("older.json", &first_format(&learnt, description));
    let said = run_with(folder, "older", "older.json", "1", &set);
    assert!(said.contains("restored damping 1"), "{said}");
    let sealed = read("older.json");
    assert!(sealed.contains("\"format\": 2"), "written anew: {sealed}");
    write("older.json", &first_format(&learnt, description));
    let said = run_with(folder, "older-changed", "older.json", "1", &changed);
    assert!(said.contains("an older heft wrote it"), "{said}");
}

#[test]
fn a_state_in_the_place_of_the_recording_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = common::path_in(folder.path(), "run");
    let state = common::path_in(folder.path(), "run/run.mcap");
    let output = run(&[
        "run",
        "excavator",
        "--duration",
        "1",
        "--pace",
        "max",
        "--out",
        &out,
        "--state",
        &state,
    ]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
    says(&output, "have the same name");
}
