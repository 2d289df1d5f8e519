//! Golden data through C give the bits of the steps that the processes run.

mod common;

use config::{Excavator as ExcavatorDescription, Loader as LoaderDescription, Tables as _};
use heft_c::{Answer, Excavator, Loader, Machine};
use messages::{
    ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, LoaderSensors, Message, Value,
};
use recording::Sensors;
use runtime::{Step, answer};
use steps::{excavator, loader};

fn golden(name: &str) -> String {
    format!(
        "{}/../../tests/golden/{name}.csv",
        env!("CARGO_MANIFEST_DIR")
    )
}

/// The rows as C takes them: NaN where the sample lacks a signal.
fn rows<M: Machine, S: Message>(messages: &[S]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for message in messages {
        let bits = message.bits_of("valid");
        for (i, signal) in M::SIGNALS.iter().enumerate() {
            let there = i == 0 || bits & 1 << (i - 1) != 0;
            let number = match message.number(signal.name) {
                Some(value) if there => value,
                // The boom's motion is only a bit.
                None if there => 1.0,
                _ => f64::NAN,
            };
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes
}

fn columns<S: Message>(messages: &[S]) -> u32 {
    messages[0].bits_of("columns")
}

/// Compares the answers of C with those of the steps, number by number.
fn compare<M: Machine, E: Message, const N: usize>(bytes: &[u8], expected: &[E], what: &str) {
    let size = size_of::<Answer<N>>();
    assert_eq!(
        bytes.len(),
        size * expected.len(),
        "{what}: one answer per row"
    );
    let field = |e: &E, name: &str| e.field(name).expect("a field");
    for (row, (raw, message)) in bytes.chunks_exact(size).zip(expected).enumerate() {
        let word = |at: usize| u64::from_le_bytes(raw[at..at + 8].try_into().expect("8 bytes"));
        let half = |at: usize| u32::from_le_bytes(raw[at..at + 4].try_into().expect("4 bytes"));
        for (i, value) in M::VALUES.iter().enumerate() {
            let ours = f64::from_bits(word(8 * i));
            let theirs = field(message, value.name);
            // A time that is not finite is refused; C gets 0 in its place.
            let no_time = value.name == "t" && !theirs.as_f64().is_finite() && ours == 0.0;
            let same = no_time || theirs.same_bits(Value::F64(ours));
            assert!(
                same && ours.is_finite(),
                "{what}: {} in row {row}: {ours} {theirs:?}",
                value.name
            );
        }
        assert_eq!(
            Value::U64(word(8 * N)),
            field(message, "refused"),
            "{what}: row {row}"
        );
        for (i, name) in ["flags", "estimated", "method", "reason"]
            .into_iter()
            .enumerate()
        {
            let ours = half(8 * N + 8 + 4 * i);
            assert_eq!(
                Value::U32(ours),
                field(message, name),
                "{what}: {name} in row {row}"
            );
        }
    }
}

fn through_c<M: Machine, S: Message>(
    program: &std::path::Path,
    method: &str,
    messages: &[S],
    sets: &[String],
) -> Vec<u8> {
    let method = M::METHODS
        .iter()
        .position(|m| *m == method)
        .expect("a method");
    let mut arguments = vec![
        M::NAME.to_owned(),
        method.to_string(),
        columns(messages).to_string(),
    ];
    arguments.extend_from_slice(sets);
    let output = common::run(program, &arguments, rows::<M, S>(messages));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    output.stdout
}

fn all<S: Step>(mut step: S, inputs: &[S::Input]) -> Vec<S::Output>
where
    S::Input: Message,
    S::Output: Message,
{
    inputs
        .iter()
        .map(|input| answer(&mut step, input))
        .collect()
}

fn excavator_steps(
    d: &ExcavatorDescription,
    method: &str,
    rows: &[ExcavatorSensors],
) -> Vec<ExcavatorEstimate> {
    if method.ends_with("rls") {
        let motions = all(excavator::FilterStep::new(d).expect("a filter"), rows);
        let step = excavator::RegressionStep::new(d, method).expect("a regression");
        all(step, &motions)
    } else {
        all(
            excavator::EstimatorStep::new(d, method).expect("an estimator"),
            rows,
        )
    }
}

fn loader_steps(
    d: &LoaderDescription,
    method: &str,
    rows: &[LoaderSensors],
) -> Vec<LoaderEstimate> {
    all(
        loader::EstimatorStep::new(d, method).expect("an estimator"),
        rows,
    )
}

#[test]
fn every_excavator_method_gives_the_bits_of_the_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/filter.c", folder.path());
    for file in [
        "excavator_input_base_case2",
        "excavator_input_bad",
        "excavator_input_drop",
    ] {
        let rows =
            recording::load::<messages::ExcavatorSensors>(golden(file), None).expect("golden data");
        let rows: Vec<ExcavatorSensors> = rows.into_iter().map(|(sensors, _)| sensors).collect();
        for method in Excavator::METHODS {
            let ours = through_c::<Excavator, _>(&program, method, &rows, &[]);
            let expected = excavator_steps(&ExcavatorDescription::default(), method, &rows);
            compare::<Excavator, _, { Excavator::VALUES.len() }>(
                &ours,
                &expected,
                &format!("{method} on {file}"),
            );
        }
    }
}

#[test]
fn every_loader_method_gives_the_bits_of_the_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/filter.c", folder.path());
    for file in [
        "loader_input_S4_tierB",
        "loader_input_S6_60s_tierA",
        "loader_input_bad_20s",
    ] {
        let rows =
            recording::load::<messages::LoaderSensors>(golden(file), None).expect("golden data");
        let rows: Vec<LoaderSensors> = rows.into_iter().map(|(sensors, _)| sensors).collect();
        for method in Loader::METHODS {
            let ours = through_c::<Loader, _>(&program, method, &rows, &[]);
            let expected = loader_steps(&LoaderDescription::default(), method, &rows);
            compare::<Loader, _, { Loader::VALUES.len() }>(
                &ours,
                &expected,
                &format!("{method} on {file}"),
            );
        }
    }
}

/// A recording of a machine with pressures, and the settings that a competent user states, `KEY=VALUE` each.
fn weighed<S: Sensors>(name: &str) -> (Vec<S>, Vec<String>) {
    let rows = recording::load::<S>(golden(&format!("weighed/{name}")), None).expect("a table");
    let path = golden("weighed/machines").replace(".csv", ".json");
    let text = std::fs::read_to_string(path).expect("the settings");
    let machines: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let sets = machines[name]["sets"].as_object().expect("settings");
    let sets = sets.iter().map(|(key, value)| format!("{key}={value}"));
    (rows.into_iter().map(|row| row.0).collect(), sets.collect())
}

/// The rows without these signals.
fn without<M: Machine, S: Message + Copy>(rows: &[S], signals: &[&str]) -> Vec<S> {
    let bits = M::SIGNALS.iter().skip(1).enumerate();
    let bits = bits.filter(|(_, signal)| signals.contains(&signal.name));
    let mask: u32 = bits.map(|(i, _)| 1 << i).sum();
    let valid = S::index("valid").expect("a field");
    let cleared = rows.iter().map(|row| {
        let mut row = *row;
        assert!(row.set(valid, Value::U32(row.bits_of("valid") & !mask)));
        row
    });
    cleared.collect()
}

/// Whether these signals change the number in more than half of the estimates.
fn moves<E: Message>(with: &[E], without: &[E], field: &str) -> bool {
    let pairs = with.iter().zip(without);
    let moved = pairs.filter(|(with, without)| with.number(field) != without.number(field));
    2 * moved.count() > with.len()
}

#[test]
fn an_excavator_with_cylinder_pressures_gives_the_bits_of_the_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/filter.c", folder.path());
    let name = "excavator_1_7t_held";
    let (rows, sets) = weighed::<ExcavatorSensors>(name);
    let mut description = ExcavatorDescription::default();
    description.set_all(&sets).expect("keys");
    let ours = through_c::<Excavator, _>(&program, "auto", &rows, &sets);
    let expected = excavator_steps(&description, "auto", &rows);
    let signals = [
        "boom_head_pressure",
        "boom_rod_pressure",
        "arm_head_pressure",
        "arm_rod_pressure",
    ];
    let rows = without::<Excavator, _>(&rows, &signals);
    let unpressed = excavator_steps(&description, "auto", &rows);
    assert!(moves(&expected, &unpressed, "payload"));
    compare::<Excavator, _, { Excavator::VALUES.len() }>(&ours, &expected, name);
}

#[test]
fn a_loader_with_a_lift_arm_gives_the_bits_of_the_processes() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = common::compile("tests/filter.c", folder.path());
    let name = "loader_1_5t_good";
    let (rows, sets) = weighed::<LoaderSensors>(name);
    let mut description = LoaderDescription::default();
    description.set_all(&sets).expect("keys");
    let signals = ["lift_angle", "lift_head_pressure", "lift_rod_pressure"];
    let unlifted = without::<Loader, _>(&rows, &signals);
    for method in ["full", "full-ekf"] {
        let ours = through_c::<Loader, _>(&program, method, &rows, &sets);
        let expected = loader_steps(&description, method, &rows);
        let unlifted = loader_steps(&description, method, &unlifted);
        assert!(moves(&expected, &unlifted, "cg_ratio"), "{method}");
        compare::<Loader, _, { Loader::VALUES.len() }>(&ours, &expected, name);
    }
}
