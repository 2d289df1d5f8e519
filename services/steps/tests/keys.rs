//! The keys of the descriptions: each has an effect, and errors name only existing keys.

use std::collections::BTreeSet;
use std::path::Path;

use config::{Description, Excavator, Form, Loader, Tables, Value};
use estimation::{excavator, loader};
use steps::idle_keys;

/// One description per key, in which this key has another value than the default.
fn changes<M: Tables>() -> Vec<(String, M)> {
    let default = M::default();
    let mut all = Vec::new();
    for (t, table) in default.tables().iter().enumerate() {
        for (i, key) in table.keys().iter().enumerate() {
            let mut changed = default.clone();
            let other = match (key.form, table.get(i).expect("a value")) {
                (Form::Choice(words), Value::Word(now)) => {
                    let other = words.iter().find(|w| **w != now);
                    Value::Word(other.expect("a choice has two words"))
                }
                (_, Value::Flag(now)) => Value::Flag(!now),
                (_, Value::Number(now)) => Value::Number(now + 1.0),
                (_, Value::None) => Value::Number(0.5),
                (_, Value::Numbers(list)) if list.is_empty() => Value::Number(0.5),
                (_, Value::Numbers(list)) => {
                    let more: Vec<f64> = list.iter().map(|x| x + 0.5).collect();
                    Value::Numbers(config::Numbers::new(&more).expect("as many"))
                }
                (form, value) => panic!("{form:?} {value:?}"),
            };
            assert!(changed.tables_mut()[t].set(i, &other), "{}", key.name);
            all.push((format!("{}.{}", table.name(), key.name), changed));
        }
    }
    all
}

fn names<M: Tables>() -> BTreeSet<String> {
    changes::<M>().into_iter().map(|(name, _)| name).collect()
}

/// Keys that the estimators do not use directly.
const ELSEWHERE: &[&str] = &[
    // For the simulator, and for the detection of late samples.
    "sensors.rate",
    // Other defaults scale with them (`config::excavator`), and the estimators read those.
    "machine.operating_mass",
    "machine.rated_payload",
    "machine.swing_torque",
];

#[test]
fn every_key_of_the_excavator_reaches_its_settings_or_is_reported_to_do_nothing() {
    // A key of the boom cylinder acts only if the cylinder is described, a correlation only if a calibration has identified it.
    let described = |description: &Excavator| {
        let mut described = description.clone();
        let cylinder = &mut described.boom_cylinder;
        for needed in [
            &mut cylinder.head_area,
            &mut cylinder.base_distance,
            &mut cylinder.rod_distance,
        ] {
            *needed = if *needed > 0.0 { *needed } else { 0.5 };
        }
        described.machine.links_gain_correlation.get_or_insert(-0.5);
        described
            .machine
            .bucket_gain_correlation
            .get_or_insert(-0.5);
        excavator::Settings::of(&described)
    };
    let default = excavator::Settings::of(&Excavator::default());
    let with_cylinder = described(&Excavator::default());
    for (name, changed) in changes::<Excavator>() {
        let reaches =
            excavator::Settings::of(&changed) != default || described(&changed) != with_cylinder;
        let reported = idle(Description::Excavator(Box::new(changed)), METHODS);
        assert_ne!(
            reaches || ELSEWHERE.contains(&name.as_str()),
            reported == [name.as_str()],
            "{name}"
        );
    }
}

/// Methods of the excavator: every key that has an effect has one under at least one of them.
const METHODS: &[&str] = &["auto", "svf-rls", "multi-forgetting-rls"];

#[test]
fn every_key_of_the_loader_reaches_the_settings_of_some_method() {
    let methods = loader::Method::ALL;
    // Some keys act only under this tuning.
    let tuned = Loader {
        estimator: loader::keys::Estimator {
            tuning: config::Tuning::Tuned,
            ..Loader::default().estimator
        },
        ..Loader::default()
    };
    for (name, changed) in changes::<Loader>() {
        let mut also = changed.clone();
        also.estimator.tuning = tuned.estimator.tuning;
        let reaches = methods.iter().any(|&m| {
            loader::Settings::of(&changed, m) != loader::Settings::of(&Loader::default(), m)
                || loader::Settings::of(&also, m) != loader::Settings::of(&tuned, m)
        });
        assert!(reaches || ELSEWHERE.contains(&name.as_str()), "{name}");
    }
}

#[test]
fn the_algorithms_name_only_keys_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../estimation/src");
    for (folder, known) in [
        ("excavator", names::<Excavator>()),
        ("loader", names::<Loader>()),
    ] {
        let mut named = 0;
        for text in sources(&root.join(folder)) {
            for literal in text.split('"').skip(1).step_by(2) {
                let table = literal.split('.').next().unwrap_or_default();
                let is_key = ["machine", "sensors", "prior", "estimator"].contains(&table)
                    && literal.contains('.')
                    && literal
                        .chars()
                        .all(|c| c.is_ascii_lowercase() || "._0123456789".contains(c));
                // The name of a table inside another table is no key.
                if is_key && !known.iter().any(|k| k.starts_with(&format!("{literal}."))) {
                    assert!(known.contains(literal), "{folder} names {literal}");
                    named += 1;
                }
            }
        }
        assert!(named > 5, "{folder} names keys in its errors");
    }
}

fn sources(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else {
            found.push(std::fs::read_to_string(&path).expect("a source"));
        }
    }
    found
}

fn idle(description: Description, methods: &[&str]) -> Vec<String> {
    let keys = idle_keys(&description, methods);
    keys.into_iter().map(|idle| idle.key).collect()
}

fn with(machine: messages::Machine, set: &str) -> Description {
    let mut description = Description::default_of(machine);
    description.set(set).expect("a key");
    description
}

#[test]
fn a_key_without_effect_under_the_methods_is_reported() {
    use messages::Machine::{Excavator, Loader};
    let paper = || with(Excavator, "estimator.paper.torque=1000");
    assert_eq!(
        idle(paper(), &["svf-rls", "auto"]),
        ["estimator.paper.torque"]
    );
    assert!(idle(paper(), &["multi-forgetting-rls", "auto"]).is_empty());
    let lag = || with(Loader, "estimator.c_t=0.7");
    assert_eq!(idle(lag(), &["ekf"]), ["estimator.c_t"]);
    assert!(idle(lag(), &["ekf", "full"]).is_empty());
    assert!(idle(Description::default_of(Loader), &["ekf"]).is_empty());
}
