//! The arguments that commands share, and their parsers.

use std::ffi::OsString;
use std::fmt::Display;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use config::Description;
use messages::Machine;
use recording::{Kind, Reader};
use steps::Idle;
use steps::stages::Pipeline;

use crate::drawing;
use crate::failure::Failure;
use crate::small_file;

/// The machines by their names.
pub fn machine() -> impl TypedValueParser<Value = Machine> {
    let names = Machine::ALL
        .map(|machine| PossibleValue::new(machine.name()).help(Pipeline::of(machine).about));
    PossibleValuesParser::new(names)
        .try_map(|name| Machine::from_name(&name).ok_or("there is no such machine"))
}

/// What is known of the machine.
#[derive(Debug, Clone, Args)]
pub struct DescriptionArgs {
    /// Machine file (TOML)
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Size of the machine, such as 21t: what is not stated has the values of machines of this mass
    #[arg(long, value_name = "MASS", value_parser = tonnes)]
    pub class: Option<f64>,
    /// Set one key of the machine file, such as sensors.swing_velocity_std=0.008
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub set: Vec<String>,
}

impl DescriptionArgs {
    /// The arguments again, for another process of heft.
    pub fn again(&self) -> Vec<OsString> {
        let config = self.config.iter().map(|file| {
            let mut option = OsString::from("--config=");
            option.push(file);
            option
        });
        let class = self.class.map(|mass| format!("--class={mass}kg").into());
        let set = self.set.iter().map(|set| format!("--set={set}").into());
        config.chain(class).chain(set).collect()
    }
}

/// A key and its value. The text after a blank would be parsed as an input.
pub fn assignment(text: &str) -> Result<String, String> {
    match text.contains('=') {
        true => Ok(text.to_owned()),
        false => Err("write it without blanks, like sensors.rate=100".into()),
    }
}

/// A mass such as 21t, 21.5 t or 21500kg \[kg\].
pub fn tonnes(text: &str) -> Result<f64, String> {
    let mass = match mass(text) {
        (_, false) => return Err("write it like 21t or 21500kg".into()),
        (mass, true) => mass.ok_or("write it like 21.5t or 21500kg")?,
    };
    match (200.0..=1e6).contains(&mass) {
        true => Ok(mass),
        false => Err("a mass from 200kg to 1000t".into()),
    }
}

/// A load such as 300, 300kg or 0.3t \[kg\].
pub fn kilograms(text: &str) -> Result<f64, String> {
    let number = mass(text).0;
    number.ok_or_else(|| "write it in kg, such as 300, 300kg or 0.3t".into())
}

/// A number in `t` or `kg`, or in kilograms without a unit \[kg\]; and whether it has a unit.
pub fn mass(text: &str) -> (Option<f64>, bool) {
    let text = text.trim().to_lowercase();
    let (number, unit) = match (text.strip_suffix("kg"), text.strip_suffix('t')) {
        (Some(number), _) => (number, Some(1.0)),
        (None, Some(number)) => (number, Some(1000.0)),
        (None, None) => (text.as_str(), None),
    };
    let number = number.trim().parse::<f64>().ok();
    (number.map(|n| n * unit.unwrap_or(1.0)), unit.is_some())
}

/// Help of `--method`: the methods of each machine, the default first.
fn methods() -> String {
    let of = |machine: Machine| {
        let pipeline = Pipeline::of(machine);
        let stages = pipeline.stages.iter().rev();
        let names: Vec<&str> = stages.flat_map(|stage| stage.methods()).copied().collect();
        format!("{}: {}", machine.name(), names.join(", "))
    };
    let all = Machine::ALL.map(of).join("; ");
    format!("Method; the usual one if absent ({all})")
}

/// What estimates are made with.
#[derive(Debug, Args)]
pub struct EstimationArgs {
    /// Signal map (TOML)
    #[arg(long)]
    pub map: Option<PathBuf>,
    #[arg(long, help = methods())]
    pub method: Option<String>,
    /// What is known of the machine
    #[command(flatten)]
    pub description: DescriptionArgs,
}

/// Many inputs in one command.
#[derive(Debug, Args)]
pub struct ManyArgs {
    /// Many inputs: recompute results that are up to date
    #[arg(long, conflicts_with = "output")]
    pub again: bool,
    /// Many inputs: processes at the same time; as many as there are processors if absent
    #[arg(long, value_name = "N", conflicts_with = "output")]
    pub jobs: Option<NonZeroUsize>,
}

/// Reads the description from `--config`, `--class` and `--set`. Without `machine`, the file of `--config` must name it.
///
/// # Errors
/// The file cannot be read or is not valid, it is of another machine, or nothing names the machine.
pub fn description(
    machine: Option<Machine>,
    args: &DescriptionArgs,
) -> Result<Description, Failure> {
    let class = class_or_set(args.class, &args.set);
    let mut description = match (&args.config, machine) {
        (Some(path), _) => {
            let text = small_file::text(path)?;
            let description =
                Description::parse_of_class(&text, &path.display().to_string(), machine, class)?;
            tell_old_names(&config::old_names(description.machine(), &text));
            let machine = machine.unwrap_or(description.machine());
            is_for(machine, &description, path.display())?;
            description
        }
        (None, Some(machine)) => Description::parse_of_class("", "--class", Some(machine), class)?,
        (None, None) => {
            return Err(Failure::input(
                "the machine is not known",
                "no --machine, no --config",
                "add --machine excavator or --machine loader",
            ));
        }
    };
    let keys = args.set.iter().filter_map(|set| set.split_once('='));
    let machine = description.machine();
    let keys = keys
        .map(|(key, _)| key.trim())
        .filter(|key| config::renamed(key).is_some() || config::is_retired(machine, key));
    tell_old_names(&keys.collect::<Vec<_>>());
    description.set_all(&args.set)?;
    Ok(description)
}

/// Whether `--config` or `--set` states a key, at whatever value.
pub fn states(machine: Machine, args: &DescriptionArgs, key: &str) -> Result<bool, Failure> {
    let text = args.config.as_deref().map(small_file::text).transpose()?;
    let of_file = text.is_some_and(|text| Description::states(machine, &text, key));
    Ok(of_file || sets(&args.set, key))
}

/// Mass by `--set`, or else by `--class` \[kg\]: the file is checked as one of this machine.
pub fn class_or_set(class: Option<f64>, set: &[String]) -> Option<f64> {
    let is_mass = |key: &str| Machine::ALL.iter().any(|m| config::mass_key(*m) == key);
    let masses = set.iter().filter_map(|set| set.split_once('='));
    let mut masses = masses.filter(|(key, _)| is_mass(key.trim()));
    match masses.next_back() {
        Some((_, mass)) => mass.trim().parse().ok(),
        None => class,
    }
}

/// Whether one of these assignments is of a key.
fn sets(set: &[String], key: &str) -> bool {
    let mut keys = set.iter().filter_map(|set| set.split_once('='));
    keys.any(|(set, _)| set.trim() == key)
}

/// Refuses a machine file of another machine.
pub fn is_for(
    machine: Machine,
    description: &Description,
    file: impl Display,
) -> Result<(), Failure> {
    let its = description.machine();
    if its == machine {
        return Ok(());
    }
    Err(Failure::input(
        format!("the machine file is for the {its}, not for the {machine}"),
        file,
        "give the file of this machine, or name the other machine",
    ))
}

/// The description of an input's machine. A recording of heft brings its own, to which `--set` applies, unless `--config` or `--class`
/// replaces it.
///
/// # Errors
/// The description cannot be read or is not valid, or nothing names the machine.
pub fn described(
    machine: Option<Machine>,
    args: &DescriptionArgs,
    input: &Path,
) -> Result<Description, Failure> {
    let is_recording = match Kind::of(input) {
        // The name of a machine would not make this input readable.
        Err(error) if machine.is_none() && args.config.is_none() => return Err(error.into()),
        kind => kind.is_ok_and(|kind| kind == Kind::Recording),
    };
    let mut known = machine;
    if is_recording {
        let reader = Reader::open(input)?;
        let its = reader.machine();
        if let (Some(its), Some(asked)) = (its, machine)
            && its != asked
        {
            let name = input.display();
            eprintln!(
                "{name}: it is of the {its}, and is read so; --machine {asked} is for tables"
            );
        }
        known = its.or(machine);
        if let Some(text) = reader.metadata().get("description")
            && args.class.is_none()
            && args.config.is_none()
        {
            let mut found = Description::parse(text, "the machine file in the recording", known)?;
            found.set_all(&args.set)?;
            return Ok(found);
        }
    }
    description(known, args)
}

/// Whether an input is a recording of heft: it brings its machine and needs no signal map.
pub fn is_of_heft(input: &Path) -> bool {
    let is_recording = Kind::of(input).is_ok_and(|kind| kind == Kind::Recording);
    is_recording && Reader::open(input).is_ok_and(|reader| reader.machine().is_some())
}

/// Notes keys of earlier versions.
pub fn tell_old_names(keys: &[&str]) {
    for key in keys {
        match config::renamed(key) {
            Some(today) => {
                eprintln!(
                    "note: the key {key} is called {today} today; the old name is still read"
                );
            }
            None => eprintln!("note: the key {key} has no effect any more"),
        }
    }
}

/// Warns of keys that are set without effect, and of keys that exclude each other.
pub fn tell_odd_keys(description: &Description, methods: &[&str]) {
    for words in drawing::contradictions(description) {
        eprintln!("warning: {words}");
    }
    for words in idle_words(&steps::idle_keys(description, methods)) {
        eprintln!("warning: {words}");
    }
}

/// Text on idle keys, a line for each table of them.
fn idle_words(keys: &[Idle]) -> Vec<String> {
    let table = |idle: &Idle| {
        idle.key
            .rsplit_once('.')
            .map_or(String::new(), |(table, _)| table.to_owned())
    };
    let of_table = keys.chunk_by(|a, b| table(a) == table(b));
    let words = |keys: &[Idle]| match keys {
        [one] => one.to_string(),
        [first, rest @ ..] => {
            let rest = rest
                .iter()
                .map(|idle| idle.key.rsplit('.').next().unwrap_or_default());
            let rest: Vec<&str> = rest.collect();
            format!(
                "{}, {} have no effect under {}",
                first.key,
                rest.join(", "),
                first.methods
            )
        }
        [] => String::new(),
    };
    of_table.map(words).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idle_keys_of_one_table_are_one_line() {
        let idle = |key: &str| Idle {
            key: key.into(),
            methods: "auto".into(),
        };
        let keys = ["machine.a", "machine.boom.x", "machine.boom.y"].map(idle);
        assert_eq!(
            idle_words(&keys),
            [
                "machine.a has no effect under auto",
                "machine.boom.x, y have no effect under auto"
            ]
        );
    }

    #[test]
    fn a_mass_is_accepted_in_usual_forms_or_its_form_is_explained() {
        for text in ["300", "300kg", "0.3t", " 0.3 T "] {
            assert_eq!(kilograms(text), Ok(300.0), "{text}");
        }
        assert!(kilograms("a lot").is_err_and(|e| e.contains("300kg")));
        assert_eq!(tonnes("21.5t"), Ok(21_500.0));
        // The message for a text that is no number does not state the range.
        assert!(tonnes("21,5t").is_err_and(|e| e.contains("like 21.5t")));
        assert!(tonnes("5000t").is_err_and(|e| e.contains("to 1000t")));
    }

    #[test]
    fn a_class_leaves_what_the_machine_file_states() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("loader.toml");
        let wheelbase = |text: &str| {
            std::fs::write(&file, text).unwrap();
            let args = DescriptionArgs {
                config: Some(file.clone()),
                class: Some(12_500.0),
                set: Vec::new(),
            };
            let described = description(Some(Machine::Loader), &args).unwrap();
            let number = |key| described.number(key).unwrap();
            ["machine.mass", "machine.wheel_radius", "machine.wheelbase"].map(number)
        };
        let [mass, radius, length] = wheelbase("[machine]\nwheel_radius = 0.666\n");
        assert_eq!((mass, radius), (12_500.0, 0.666));
        assert!(length > 3.0, "{length}");
        assert_eq!(wheelbase("[machine]\nmass = 12000\n")[0], 12_000.0);
        // Also that of the reference machine.
        assert_eq!(wheelbase("[machine]\nmass = 4700\n")[0], 4700.0);
    }

    #[test]
    fn a_class_counts_before_the_file_is_checked() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("long.toml");
        std::fs::write(
            &file,
            "[machine.geometry]\nboom_length = 6.6\narm_length = 3.2\n",
        )
        .unwrap();
        let of = |class: Option<f64>, set: &[&str]| {
            let args = DescriptionArgs {
                config: Some(file.clone()),
                class,
                set: set.iter().map(|set| (*set).to_owned()).collect(),
            };
            description(Some(Machine::Excavator), &args)
                .map(|d| d.number("machine.operating_mass").unwrap())
        };
        assert_eq!(of(Some(36_000.0), &[]).ok(), Some(36_000.0));
        for class in [None, Some(14_000.0)] {
            let set = of(class, &["machine.operating_mass=34000"]);
            assert_eq!(set.ok(), Some(34_000.0));
        }
        assert!(of(Some(14_000.0), &["machine.operating_mass=heavy"]).is_err());
    }
}
