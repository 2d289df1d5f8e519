//! `--target`: the mass that a truck shall hold.

use config::Description;
use steps::loads::{LoadCounter, Options};
use view::number::grouped;

use crate::args::mass;
use crate::failure::Failure;

/// A mass such as 24t, 24 t, 24000kg or 24000 \[kg\].
///
/// # Errors
/// The text is no mass, or not above 0.
pub fn parsed(text: &str) -> Result<f64, String> {
    mass(text)
        .0
        .filter(|mass| mass.is_finite() && *mass > 0.0)
        .ok_or_else(|| "a mass above 0, like 24t, 24000kg or 24000".into())
}

/// Refuses a target below the smallest load: it is in another unit. `Some`: a note on a target that one full bucket reaches.
///
/// # Errors
/// The target is below the smallest load.
pub fn doubt(target: Option<f64>, machine: &Description) -> Result<Option<String>, Failure> {
    let counter = LoadCounter::new(machine, Options::default());
    let (least, full) = (counter.smallest(), counter.ledger().rated());
    let Some(target) = target.filter(|target| *target < full) else {
        return Ok(None);
    };
    if target > least {
        let full = grouped(full, 0);
        return Ok(Some(format!(
            "note: a truck that shall hold {target} kg is full with one bucket of {full} kg; tonnes are written like 24t"
        )));
    }
    Err(Failure::input(
        format!(
            "a truck that shall hold {target} kg is full with any load: what counts as a load of this machine is more than {} kg",
            grouped(least, 0)
        ),
        "--target",
        format!("write the unit, such as --target {target}t"),
    ))
}

#[cfg(test)]
mod tests {
    use messages::Machine;

    use super::*;

    #[test]
    fn a_target_is_in_tonnes_or_kilograms() {
        for text in ["24t", "24 t", "24000kg", "24000 KG", "24000", " 2.4e4 "] {
            assert_eq!(parsed(text), Ok(24_000.0), "{text}");
        }
        for wrong in ["", "t", "0", "0t", "-24t", "nan", "inf", "24 tons", "24,5t"] {
            let words = parsed(wrong).expect_err(wrong);
            assert!(words.contains("24t"), "{words}");
        }
    }

    #[test]
    fn tonnes_without_their_unit_are_refused_of_any_machine() {
        for machine in Machine::ALL {
            for mass in ["1500", "36000", "120000"] {
                let mut machine = Description::default_of(machine);
                let key = config::mass_key(machine.machine());
                machine.set(&format!("{key}={mass}")).expect("a mass");
                let failure = doubt(Some(1.5), &machine).expect_err("no load");
                assert!(failure.to_string().contains("--target 1.5t"), "{failure}");
                let mass = mass.parse::<f64>().expect("a number");
                let said = |target| doubt(Some(target), &machine).expect("a load");
                let note = said(mass / 30.0).expect("less than a bucket");
                assert!(note.contains("full with one bucket"), "{note}");
                assert_eq!(said(mass), None);
                assert_eq!(doubt(None, &machine).expect("none"), None);
            }
        }
    }
}
