//! `heft check`: validates a machine file.

use std::path::{Path, PathBuf};

use clap::Args;
use config::Description;
use messages::Machine;
use recording::{Kind, Reader};

use crate::args::{assignment, class_or_set, is_for, machine, tell_old_names, tonnes};
use crate::drawing;
use crate::failure::Failure;
use crate::machines;
use crate::size;
use crate::small_file;

/// `heft check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The machine file (TOML), or a recording of heft that brings one; with --print the reference machine if absent
    #[arg(required_unless_present = "print")]
    pub file: Option<PathBuf>,
    /// The machine that it is for; needed where the file does not say
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// Size of the machine, such as 21t, where the file does not state its mass
    #[arg(long, value_name = "MASS", value_parser = tonnes)]
    pub class: Option<f64>,
    /// Set one key of it, such as sensors.swing_velocity_std=0.008
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub set: Vec<String>,
    /// Print the complete machine file, every key with its unit, range and meaning
    #[arg(long)]
    pub print: bool,
    /// Name what limits the intervals on these data: the three stated deviations of each quantity that matter most
    #[arg(long, value_name = "DATA", conflicts_with = "print")]
    pub data: Option<PathBuf>,
    /// Signal map of --data (TOML)
    #[arg(long, requires = "data")]
    pub map: Option<PathBuf>,
}

/// `heft check`
pub fn check(args: &CheckArgs) -> Result<(), Failure> {
    if let Some(file) = args.file.as_deref() {
        is_no_machine(file)?;
    }
    let text = args.file.as_deref().map(text_of).transpose()?;
    let text = text.unwrap_or_default();
    let name = args.file.as_ref().map(|file| file.display().to_string());
    let name = name.unwrap_or_else(|| "--print".to_owned());
    let class = class_or_set(args.class, &args.set);
    let mut description = Description::parse_of_class(&text, &name, args.machine, class)?;
    tell_old_names(&config::old_names(description.machine(), &text));
    if let Some(machine) = args.machine {
        is_for(machine, &description, &name)?;
    }
    description.set_all(&args.set)?;
    if args.print {
        print!("{}", description.to_toml());
    } else {
        println!(
            "{name}: a valid machine file of the {}",
            description.machine()
        );
        let size = size::of_reference(&description);
        for words in size.into_iter().chain(remarks(&description)?) {
            eprintln!("note: {words}");
        }
    }
    if let Some(data) = &args.data {
        let entry = machines::entry(description.machine());
        print!(
            "{}",
            (entry.limits)(data, args.map.as_deref(), &description)?
        );
    }
    Ok(())
}

/// The text of a machine file; of a recording, of the one in it.
fn text_of(file: &Path) -> Result<String, Failure> {
    if !Kind::of(file).is_ok_and(|kind| kind == Kind::Recording) {
        return small_file::text(file);
    }
    let reader = Reader::open(file);
    if file.is_dir() && reader.is_err() {
        return Err(Failure::input(
            "this is a folder without a recording",
            file.display(),
            "name a machine file (TOML), or a recording of heft",
        ));
    }
    let found = reader?.metadata().get("description").cloned();
    found.ok_or_else(|| {
        Failure::input(
            "there is no machine file in this recording",
            file.display(),
            "name a recording of heft, or a machine file",
        )
    })
}

/// Refuses the name of a machine in the place of the file: other commands take the machine first.
fn is_no_machine(file: &Path) -> Result<(), Failure> {
    let named = Machine::ALL
        .into_iter()
        .find(|machine| file == Path::new(machine.name()));
    match named.filter(|_| !file.exists()) {
        None => Ok(()),
        Some(machine) => Err(Failure::input(
            "this is a machine, and `heft check` reads a machine file",
            machine,
            format!("for the reference machine: heft check --machine {machine} --print"),
        )),
    }
}

/// Tables of weighing cylinders: name, keys without which it is unused, and key of the rod's area.
const CYLINDERS: &[(&str, &[&str], &str)] = &[
    (
        "machine.boom_cylinder",
        &["head_area", "base_distance", "rod_distance"],
        "rod_area",
    ),
    (
        "machine.lift_arm",
        &[
            "length",
            "cylinder.head_area",
            "cylinder.base_distance",
            "cylinder.rod_distance",
        ],
        "cylinder.rod_area",
    ),
];

/// Remarks on values that are valid, but implausible.
fn remarks(description: &Description) -> Result<Vec<String>, Failure> {
    let mut found = size::odd(description)?;
    for (table, keys, rod_area) in CYLINDERS {
        let is_stated = |key: &&&str| {
            let number = description.number(&format!("{table}.{key}"));
            number.is_none_or(|number| number > 0.0)
        };
        let (stated, open): (Vec<&str>, Vec<&str>) = keys.iter().partition(|key| is_stated(key));
        if !stated.is_empty() && !open.is_empty() {
            found.push(format!("{table} is not used: it lacks {}", open.join(", ")));
        }
        let rod = description.number(&format!("{table}.{rod_area}"));
        if open.is_empty() && rod == Some(0.0) {
            found.push(format!(
                "{table}.{rod_area} is 0: the rod pressure is not used"
            ));
        }
    }
    found.extend(drawing::contradictions(description));
    found.extend(size::of_mass(description));
    found.extend(steps::loads::guessed(description));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str, machine: Machine) -> String {
        let description = Description::parse(text, "x", Some(machine)).expect("a valid file");
        remarks(&description).expect("remarks").join("\n")
    }

    #[test]
    fn what_does_not_fit_a_machine_of_its_mass_is_named() {
        let of = |rest: &str| {
            let text = format!("[machine]\noperating_mass = 21500\n{rest}");
            said(&text, Machine::Excavator)
        };
        let sound =
            "rated_payload = 1900\nswing_torque = 68000\n[machine.geometry]\nboom_length = 5.7\n";
        assert!(!of(sound).contains("check it"), "{}", of(sound));
        for (rest, key) in [
            (
                "[machine.geometry]\nboom_length = 0.57\n",
                "boom_length is 0.57",
            ),
            ("rated_payload = 19000\n", "rated_payload is 19000"),
            ("swing_torque = 100\n", "swing_torque is 100"),
            ("upper_inertia = 1698\n", "upper_inertia is 1698"),
        ] {
            assert!(of(rest).contains(key), "{}", of(rest));
        }
        assert_eq!(said("", Machine::Excavator), "");
        assert_eq!(said("", Machine::Loader), "");
    }

    #[test]
    fn a_folder_gets_a_message_on_what_belongs_in_its_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = text_of(folder.path()).expect_err("nothing in it");
        assert!(error.to_string().contains("machine file"), "{error}");
    }

    #[test]
    fn a_machine_in_the_place_of_its_file_gets_a_message_with_the_option() {
        let said = is_no_machine(Path::new("loader"))
            .expect_err("no file")
            .to_string();
        assert!(
            said.contains("heft check --machine loader --print"),
            "{said}"
        );
        assert!(is_no_machine(Path::new("loader.toml")).is_ok());
    }

    #[test]
    fn a_cylinder_that_is_half_described_is_named() {
        let cylinder = "[machine.boom_cylinder]\nbase_distance = 0.6\nrod_distance = 1.3\n";
        let words = said(cylinder, Machine::Excavator);
        assert_eq!(
            words,
            "machine.boom_cylinder is not used: it lacks head_area"
        );
        let words = said(&format!("{cylinder}head_area = 0.01\n"), Machine::Excavator);
        assert!(
            words.starts_with("machine.boom_cylinder.rod_area is 0"),
            "{words}"
        );
        let words = said("[machine.lift_arm]\nlength = 2.6\n", Machine::Loader);
        let lacks = "it lacks cylinder.head_area, cylinder.base_distance, cylinder.rod_distance";
        assert!(words.contains(lacks), "{words}");
    }
}
