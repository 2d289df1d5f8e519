//! Recordings of earlier versions are readable for ever; a replay agrees, or the difference is explained by the build. The present
//! estimates of them are stored in `tests/golden/recordings/numbers.csv`, with the reason of each change.

mod common;

use std::path::PathBuf;

use std::collections::BTreeMap;
use std::fmt;

use common::both;
use config::Description;
use messages::{ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, LoaderSensors, Message};
use recording::{Reader, Sensors};
use statistics::judge::is_wrong;
use steps::chain::{chain, last_answer};
use steps::stages::Pipeline;
use view::estimate::Estimate;

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

/// Of a quantity: number of rows, of trusted ones, of wrong ones among these; means over all rows.
#[derive(Clone, Copy, Default)]
struct Numbers {
    rows: f64,
    trusted: f64,
    wrong: f64,
    value: f64,
    std: f64,
}

impl Numbers {
    fn add(&mut self, trusted: bool, value: f64, std: f64, truth: f64) {
        self.rows += 1.0;
        self.trusted += f64::from(u8::from(trusted));
        self.wrong += f64::from(u8::from(trusted && is_wrong(value, std, truth)));
        self.value += (value - self.value) / self.rows;
        self.std += (std - self.std) / self.rows;
    }

    /// A row of the file.
    fn read(cells: &[&str]) -> Self {
        let [rows, trusted, wrong, value, std] =
            std::array::from_fn(|i| cells[i].parse().expect("a number"));
        Self {
            rows,
            trusted,
            wrong,
            value,
            std,
        }
    }

    /// Tolerances: a hundredth of the rows in trust, a tenth of the standard deviation in the value, and a twentieth of it in itself.
    fn is_like(&self, kept: &Self) -> bool {
        let few = |a: f64, b: f64| (a - b).abs() <= 0.01 * kept.rows;
        let is_near = |a: f64, b: f64, most: f64| (a - b).abs() <= most * kept.std;
        self.rows == kept.rows
            && few(self.trusted, kept.trusted)
            && few(self.wrong, kept.wrong)
            && is_near(self.value, kept.value, 0.1)
            && is_near(self.std, kept.std, 0.05)
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            rows,
            trusted,
            wrong,
            value,
            std,
        } = self;
        write!(f, "{rows},{trusted},{wrong},{value:.6e},{std:.3e}")
    }
}

/// Numbers by recording, method and quantity.
type All = BTreeMap<String, Numbers>;

/// The estimates of every method for the samples of a recording.
fn replayed<S: Sensors, E: Estimate<Truth = S::Truth>>(name: &str, all: &mut All) {
    let reader = Reader::open(old(name)).expect("a recording");
    let text = &reader.metadata()["description"];
    let description = Description::parse(text, name, Some(S::MACHINE)).expect("a machine file");
    let truths = reader.stream::<S::Truth>(S::TRUTH.name).expect("truth");
    let truths: BTreeMap<u64, S::Truth> = truths.map(|t| (t.stamp().sequence, t)).collect();
    let pipeline = Pipeline::of(S::MACHINE);
    let methods = pipeline.stages.iter().flat_map(|stage| stage.methods());
    for method in methods.copied() {
        let mut chain = chain(&description, method).expect("steps");
        for sample in reader.stream::<S>(S::SENSORS.name).expect("samples") {
            let truth = truths.get(&sample.stamp().sequence);
            let last = last_answer(&mut chain, sample.envelope());
            let last = last.expect("an answer");
            let estimate = E::inside(&last).expect("an estimate");
            for p in E::headlines() {
                let (value, std) = (p.value(estimate), p.std(estimate));
                let truth = truth.map_or(f64::NAN, |t| p.truth(t));
                let numbers = all.entry(format!("{name},{method},{}", p.key)).or_default();
                if value.is_finite() {
                    numbers.add(estimate.flags() & p.trusted != 0, value, std, truth);
                }
            }
        }
    }
}

#[test]
fn an_old_recording_gives_the_stored_numbers_and_trust_or_the_file_states_why_not() {
    let mut all = All::new();
    replayed::<ExcavatorSensors, ExcavatorEstimate>(ALL[0], &mut all);
    replayed::<LoaderSensors, LoaderEstimate>(ALL[2], &mut all);
    let kept = std::fs::read_to_string(old("numbers.csv")).expect("the numbers");
    // The last row of a key is valid; rows before it are its history, each with the reason.
    let mut last = BTreeMap::new();
    for line in kept.lines().skip(1) {
        let cells: Vec<&str> = line.splitn(9, ',').collect();
        assert!(!cells[8].is_empty(), "without a reason: {line}");
        last.insert(cells[..3].join(","), Numbers::read(&cells[3..8]));
    }
    let new = all
        .iter()
        .filter(|(key, numbers)| !last.get(*key).is_some_and(|kept| numbers.is_like(kept)));
    let new: Vec<String> = new.map(|(key, n)| format!("{key},{n},")).collect();
    assert!(
        new.is_empty(),
        "other numbers or trust; append these to numbers.csv, each with the reason:\n{}",
        new.join("\n")
    );
    assert_eq!(all.len(), last.len(), "a method or quantity is gone");
}
