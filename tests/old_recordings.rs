//! Recordings of earlier versions: read for ever; replayed, or the difference explained by the build.

mod common;

use std::path::PathBuf;

use common::both;
use messages::{ExcavatorSensors, LoaderSensors, Message};
use recording::Reader;

fn old(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/recordings");
    folder.join(name)
}

const ALL: [&str; 3] = [
    "excavator-cfdbb98.mcap",
    "excavator-rls-killed-cfdbb98.mcap",
    "loader-cfdbb98.mcap",
];

fn count<M: Message>(name: &str, channel: &str) -> usize {
    let reader = Reader::open(old(name)).expect("a recording");
    let count = reader.stream::<M>(channel).expect("the channel").count();
    assert!(reader.is_complete() && reader.damage().is_empty());
    count
}

#[test]
fn every_sample_of_an_old_recording_is_read() {
    assert_eq!(count::<ExcavatorSensors>(ALL[0], "excavator/sensors"), 1601);
    assert_eq!(count::<LoaderSensors>(ALL[2], "loader/sensors"), 1401);
    let killed = count::<ExcavatorSensors>(ALL[1], "excavator/sensors");
    assert!((550..=601).contains(&killed), "{killed}");
}

#[test]
fn an_old_recording_is_reported_and_exported() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ALL {
        let file = old(name);
        let file = file.to_str().expect("a path");
        let page = folder.path().join(format!("{name}.html"));
        let output = common::run(&["report", file, "-o", page.to_str().expect("a path")]);
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
        let page = std::fs::read_to_string(page).expect("a page");
        assert!(page.contains("0.1.0") && page.contains("Latency and loss"));
        let tables = folder.path().join(name);
        let output = common::run(&["export", file, "-o", tables.to_str().expect("a path")]);
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
        assert!(std::fs::read_dir(&tables).expect("tables").count() >= 5);
    }
}

#[test]
fn an_old_recording_replays_bit_for_bit_or_the_build_explains_why_not() {
    for name in ALL {
        let output = common::run(&["replay", old(name).to_str().expect("a path"), "--verify"]);
        let text = both(&output);
        match output.status.code() {
            Some(0) => assert!(
                text.contains("bit-identical") && !text.contains("differ"),
                "{text}"
            ),
            Some(1) => {
                let why = "recorded by heft 0.1.0";
                assert!(
                    text.contains("differ") && text.contains(why),
                    "{name}: {text}"
                );
                assert!(text.contains("what to do"), "{name}: {text}");
            }
            other => panic!("{name}: {other:?} {text}"),
        }
    }
}
