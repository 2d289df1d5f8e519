//! One finite sample of any size, through every method of the C interface: every number stays finite, and after ten seconds the
//! answer is the same as without that sample.

use heft_c::{Excavator, Loader, Machine, answer, sample};
use messages::Message;
use runtime::Source;

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

/// Time of the sample, and time after which it must have no effect \[s\].
const AT: f64 = 12.0;
const FORGOTTEN: f64 = 10.0;
const DURATION: f64 = 30.0;
/// Largest remaining effect, in standard deviations of both answers.
const ROOM: f64 = 2.0;

/// The paper's filter with its misprints diverges by itself, so only finiteness is checked.
const AS_PRINTED: &str = "isr-ukf-printed";

pub struct Sizes;

impl Attack for Sizes {
    fn name(&self) -> String {
        "a finite sample of any size, in C".into()
    }

    fn attempt(&mut self, rng: &mut Rng, _ground: &Ground) -> Result<Outcome, String> {
        let seed = 1 + rng.between(0, 1000);
        let sizes = |rng: &mut Rng| {
            let power = rng.between(3, 309) as i32;
            let size = 10f64.powi(rng.one(&[power, -power]));
            rng.one(&[size, -size])
        };
        let size = sizes(rng);
        if rng.between(0, 2) == 0 {
            let source = sensor::excavator::Simulator::at_usual_work(DURATION, seed);
            let rows = rows::<Excavator, _>(source.map_err(|e| e.to_string())?);
            all_methods::<Excavator, { Excavator::VALUES.len() }>(&rows, size, rng)?;
        } else {
            let source = sensor::loader::Simulator::at_usual_work(DURATION, seed);
            let rows = rows::<Loader, _>(source.map_err(|e| e.to_string())?);
            all_methods::<Loader, { Loader::VALUES.len() }>(&rows, size, rng)?;
        }
        Ok(Outcome::Survived { gap: 0 })
    }
}

/// The samples of a source in the form of the C interface: numbers in the order of the header, the time first.
fn rows<M: Machine, S: Source>(mut source: S) -> Vec<Vec<f64>> {
    let row = |(sensors, _): (S::Sensors, S::Truth)| {
        let number = |name: &str| match name {
            "time" => sensors.stamp().time,
            _ => sensors.number(name).unwrap_or(f64::NAN),
        };
        M::SIGNALS
            .iter()
            .map(|signal| number(signal.name))
            .collect()
    };
    std::iter::from_fn(|| source.next()).map(row).collect()
}

/// Replaces one signal of one row, for each method.
fn all_methods<M: Machine, const N: usize>(
    rows: &[Vec<f64>],
    size: f64,
    rng: &mut Rng,
) -> Result<(), String> {
    let at = rows
        .iter()
        .position(|row| row[0] >= AT)
        .ok_or("a short source")?;
    let signal = rng.between(1, M::SIGNALS.len() as u64) as usize;
    let mut spoiled = rows.to_vec();
    spoiled[at][signal] = size;
    for (method, name) in M::METHODS.iter().enumerate() {
        let explained = |why| {
            format!(
                "{} {name}, {} = {size:e}: {why}",
                M::NAME,
                M::SIGNALS[signal].name
            )
        };
        let clean = answers::<M, N>(method, rows).map_err(explained)?;
        let found = answers::<M, N>(method, &spoiled).map_err(explained)?;
        if *name != AS_PRINTED {
            is_forgotten::<M, N>(&clean, &found).map_err(explained)?;
        }
    }
    Ok(())
}

/// Every answer of a method; `Err` if a number is not finite.
fn answers<M: Machine, const N: usize>(
    method: usize,
    rows: &[Vec<f64>],
) -> Result<Vec<heft_c::Answer<N>>, String> {
    let columns = rows[0].iter().skip(1).enumerate();
    let columns = columns.fold(0, |bits, (bit, number)| {
        bits | u32::from(!number.is_nan()) << bit
    });
    let settings = M::Settings::default();
    let mut machine = M::new(&settings, method, columns).map_err(|e| e.to_string())?;
    let mut answers = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let found = answer::<M, N>(&machine.step(&sample::<M>(row)));
        if let Some(i) = found.values.iter().position(|number| !number.is_finite()) {
            return Err(format!(
                "{} is {} in row {k}",
                M::VALUES[i].name,
                found.values[i]
            ));
        }
        answers.push(found);
    }
    Ok(answers)
}

/// Checks that each value with a standard deviation has returned to its value without the sample. Only rows count in which the
/// answer without it is consistent, because a paper's filter may diverge by itself.
fn is_forgotten<M: Machine, const N: usize>(
    clean: &[heft_c::Answer<N>],
    found: &[heft_c::Answer<N>],
) -> Result<(), String> {
    let mut flags = M::FLAGS.iter();
    let consistent = flags.position(|flag| flag.name == "consistent");
    let consistent = consistent.ok_or("no flag of consistency")?;
    let names: Vec<&str> = M::VALUES.iter().map(|value| value.name).collect();
    let pairs = names.iter().enumerate().filter_map(|(value, name)| {
        let std = names
            .iter()
            .position(|other| *other == format!("{name}_std"))?;
        Some((value, std))
    });
    for (value, std) in pairs {
        let judged =
            |c: &heft_c::Answer<N>| c.values[0] >= AT + FORGOTTEN && c.flags & 1 << consistent != 0;
        let later = clean.iter().zip(found).filter(|(c, _)| judged(c));
        for (clean, found) in later {
            let off = (clean.values[value] - found.values[value]).abs();
            let room = ROOM * clean.values[std].hypot(found.values[std]);
            if off > room {
                let (was, is) = (clean.values[value], found.values[value]);
                return Err(format!(
                    "{} is {is}, without it {was}, at {} s",
                    names[value], clean.values[0]
                ));
            }
        }
    }
    Ok(())
}
