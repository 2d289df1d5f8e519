//! Warnings on the size of a machine: it differs between simulation and description, or is not stated.

use std::path::Path;

use config::Description;
use messages::Machine;
use recording::Quoted;
use view::number::significant;

use crate::args::{DescriptionArgs, is_of_heft, states};
use crate::failure::Failure;
use crate::machines;
use crate::plan::Plan;
use crate::small_file;
use crate::sources::is_simulated;

/// Relative difference of simulated and described mass above which they are different machines.
const SAME_SIZE: f64 = 0.1;

/// Keys whose values follow from the mass if they are not stated: the key of the data sheet, and the key that follows from it.
const ALIKE: &[(&str, &str)] = &[
    (
        "machine.geometry.boom_length",
        "machine.geometry.boom_length",
    ),
    ("machine.geometry.arm_length", "machine.geometry.arm_length"),
    ("machine.geometry.boom_mass", "machine.geometry.boom_mass"),
    ("machine.geometry.arm_mass", "machine.geometry.arm_mass"),
    ("machine.upper_inertia", "machine.upper_inertia"),
    ("machine.rated_payload", "prior.payload"),
    ("machine.swing_torque", "machine.nominal_damping"),
    ("machine.wheelbase", "machine.wheelbase"),
    ("machine.wheel_radius", "machine.wheel_radius"),
];

/// Warns if the described machine has another size than the simulated one.
pub fn tell_other_size(plan: &Plan, description: &Description) {
    if !is_simulated(plan) {
        return;
    }
    let (key, simulated) = machines::entry(plan.machine).simulated_mass;
    let described = description.number(key);
    if let Some(kg) = described.filter(|kg| (kg / simulated - 1.0).abs() > SAME_SIZE) {
        let [simulated, described] = [simulated, kg].map(|kg| kg / 1000.0);
        eprintln!(
            "warning: the simulated {} has {simulated} t, and {described} t are described ({key}): the estimates are those of a wrong \
             machine file; leave out --class and --config, or give data of your machine (--input)",
            plan.machine
        );
    }
}

/// Ratio to the usual value of machines of this size, or its inverse, above which a number is in another unit or of another machine.
const ODD: f64 = 2.5;

/// Remarks on stated values that do not fit a machine of the stated mass.
///
/// # Errors
/// The mass is out of range.
pub fn odd(description: &Description) -> Result<Vec<String>, Failure> {
    let mut found = Vec::new();
    let mass_key = config::mass_key(description.machine());
    let Some(mass) = description.number(mass_key) else {
        return Ok(found);
    };
    let mut class = Description::default_of(description.machine());
    class.set(&format!("{mass_key}={mass:?}"))?;
    for (key, follows) in ALIKE {
        let ratio = description.number(follows).zip(class.number(follows));
        let Some(ratio) = ratio.map(|(own, usual)| own / usual) else {
            continue;
        };
        let stated = description.number(key);
        if let Some(stated) = stated.filter(|_| ratio.max(1.0 / ratio) > ODD) {
            let usual = significant(stated / ratio, 2);
            found.push(format!(
                "{key} is {stated}, and machines of {:.1} t have about {usual}: check it, and {mass_key}",
                mass / 1000.0
            ));
        }
    }
    Ok(found)
}

/// What to know of a machine file that has the size of the reference machine: `heft check --print` writes all of its values, and so
/// does the example of the package.
pub fn of_reference(description: &Description) -> Option<String> {
    let machine = description.machine();
    let (key, kg) = machines::entry(machine).simulated_mass;
    let is_reference = description.number(key).is_none_or(|stated| stated == kg);
    is_reference.then(|| {
        format!(
            "this is the size of the reference {machine}, {} t; if yours is another, state {key}: what is as printed follows it",
            kg / 1000.0
        )
    })
}

/// The size assumed for an input's machine, what follows from it, and stated values that do not fit it. A recording of heft brings its
/// machine file.
///
/// # Errors
/// The machine file cannot be read.
pub fn assumed(
    description: &Description,
    args: &DescriptionArgs,
    input: &Path,
) -> Result<Option<String>, Failure> {
    if is_of_heft(input) {
        return Ok(None);
    }
    let machine = description.machine();
    let (key, kg) = machines::entry(machine).simulated_mass;
    let is_reference = description.number(key).is_none_or(|stated| stated == kg);
    let is_told = states_any(machine, args)? || args.class.is_some() || states(machine, args, key)?;
    if is_reference && !is_told {
        return Ok(Some(format!(
            "note: the {machine} is taken for the reference machine of {} t; say how large yours is (--class 21t), or give its machine file \
             (--config)",
            kg / 1000.0
        )));
    }
    let mut notes = odd(description)?;
    let usual = match of_mass(description) {
        None if args.config.is_none() && is_reference => Some(format!(
            "values that nobody has stated are those of the reference {machine}, whose mass this is"
        )),
        words => words,
    };
    let all = shown_by(description, args);
    notes.extend(usual.map(|words| format!("{words}; {all} shows all")));
    let notes: Vec<String> = notes.iter().map(|words| format!("note: {words}")).collect();
    Ok((!notes.is_empty()).then(|| notes.join("\n")))
}

/// Whether the machine file states any value: it may hold comments alone.
fn states_any(machine: Machine, args: &DescriptionArgs) -> Result<bool, Failure> {
    let Some(file) = &args.config else {
        return Ok(false);
    };
    let text = small_file::text(file)?;
    let stated = Description::parse(&text, &file.display().to_string(), Some(machine))?;
    Ok(stated.to_toml() != Description::default_of(machine).to_toml())
}

/// The values that are not stated and follow from the machine's mass; the first of them by name.
pub fn of_mass(description: &Description) -> Option<String> {
    let mass = description.number(config::mass_key(description.machine()))?;
    let found = description.of_mass();
    // A value that follows from another stated number of the data sheet is not among these.
    let is_open = |key: &str, follows: &str| key == follows || description.number(key).is_none();
    let is_first = |path: &str| {
        let mut alike = ALIKE.iter();
        alike.any(|(key, follows)| *follows == path && is_open(key, follows))
    };
    let first = found.iter().filter(|(key, _)| is_first(key.path));
    let first = first.map(|(key, value)| {
        let value = significant(*value, 3);
        let text = format!("{} {value} {}", key.path, key.unit);
        text.trim_end().to_owned()
    });
    let first: Vec<String> = first.collect();
    (!first.is_empty()).then(|| {
        format!(
            "{} values that nobody has stated are those of a usual {} of {} t, as {}",
            found.len(),
            description.machine(),
            (mass / 100.0).round() / 10.0,
            first.join(", ")
        )
    })
}

/// Number of keys above which the printed command is unreadable.
const MOST_SETS: usize = 5;

/// The command that prints every value of the described machine.
fn shown_by(description: &Description, args: &DescriptionArgs) -> String {
    let file = args.config.iter().map(|f| Quoted(f.display()).to_string());
    let machine = [format!("--machine {}", description.machine())];
    let class = args.class.map(|kg| format!("--class {kg}kg"));
    let are_many = args.set.len() > MOST_SETS;
    let sets = args.set.iter().filter(|_| !are_many);
    let sets = sets.map(|set| format!("--set {}", Quoted(set)));
    let words = file.chain(machine).chain(class).chain(sets);
    let command = words.collect::<Vec<_>>().join(" ");
    let same = if are_many { " with the same --set" } else { "" };
    format!("`heft check {command} --print`{same}")
}
