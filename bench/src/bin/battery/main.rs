//! `cargo run -p bench --bin battery -- --minutes N --seed S`: attacks whole pipelines in turn, and prints for each attack the
//! numbers of attempts and survivals.
//!
//! A pipeline survives if the run ends in order and in time, losses are reported and set the status, and nothing is left behind.
//! The gap is measured in the recorded data, not by the lifetime of a process.

mod attack;
mod doubled;
mod files;
mod fleet;
mod floods;
mod full;
mod fuzz;
mod ground;
mod kills;
mod parts;
mod readers;
mod sizes;
mod soak;
mod squatter;
mod states;
mod stops;
mod storm;
mod supply;
mod trust;
mod users;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;

use attack::{Attack, Outcome, Rng};
use ground::Ground;

/// Period of the table in a long run: an interruption costs only the rest.
const INTERIM: Duration = Duration::from_secs(600);

/// The table of attacks, a row each.
fn attacks() -> Vec<Box<dyn Attack>> {
    let mut attacks: Vec<Box<dyn Attack>> = Vec::new();
    attacks.extend(kills::all());
    attacks.extend(stops::all());
    attacks.extend(files::all());
    attacks.extend(fuzz::all());
    attacks.push(Box::new(parts::Parts::default()));
    attacks.push(Box::new(doubled::Doubled));
    attacks.push(Box::new(storm::Storm));
    attacks.push(Box::new(trust::Trust));
    attacks.push(Box::new(floods::Flood));
    attacks.push(Box::new(users::SecondUser));
    attacks.push(Box::new(fleet::Clocks));
    attacks.push(Box::new(readers::Readers::default()));
    attacks.push(Box::new(sizes::Sizes));
    attacks.push(Box::new(states::States));
    attacks.push(Box::new(squatter::Squatter));
    attacks.push(Box::new(full::SharedMemory));
    attacks.push(Box::new(supply::Supply));
    attacks
}

/// Attacks whole pipelines in turn, and prints per attack how often it was tried and survived.
#[derive(Parser)]
struct Arguments {
    /// How long
    #[arg(long, value_name = "N", default_value_t = 1.0)]
    minutes: f64,
    /// What chance begins with
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// The attacks whose name holds this word
    #[arg(long, value_name = "WORD", default_value = "")]
    only: String,
    /// The program that is attacked; the one beside this if absent
    #[arg(long, value_name = "PATH")]
    heft: Option<PathBuf>,
    /// One target of the fuzzer alone, in this folder, for --seconds
    #[arg(long, value_name = "TARGET")]
    fuzz: Option<String>,
    /// The cells of the trust matrix whose name contains this word, as a table, with the fault from --from seconds on
    #[arg(long, value_name = "WORD")]
    trust: Option<String>,
    /// Both machines in real time for this number of minutes, with the slopes of memory, descriptors and disk
    #[arg(long, value_name = "MINUTES")]
    soak: Option<f64>,
    /// With --fuzz
    #[arg(long, value_name = "N", default_value_t = 1.0)]
    seconds: f64,
    /// With --trust
    #[arg(long, value_name = "SECONDS", default_value_t = trust::FROM)]
    from: f64,
}

impl Arguments {
    fn heft(&self) -> PathBuf {
        let beside = || std::env::current_exe().map(|own| own.with_file_name("heft"));
        let named = self.heft.clone();
        named.unwrap_or_else(|| beside().unwrap_or_default())
    }
}

/// Counts of one attack.
#[derive(Default)]
struct Tally {
    tried: u32,
    survived: u32,
    skipped: u32,
    worst_gap: u64,
}

impl Tally {
    /// Counts an attempt; returns the description of a damage.
    fn count(&mut self, outcome: Result<Outcome, String>) -> Option<String> {
        match outcome {
            Ok(Outcome::Skipped) => self.skipped += 1,
            Ok(Outcome::Survived { gap }) => {
                self.tried += 1;
                self.survived += 1;
                self.worst_gap = self.worst_gap.max(gap);
            }
            Err(why) => {
                self.tried += 1;
                return Some(why);
            }
        }
        None
    }
}

type Rows = Vec<(Box<dyn Attack>, Tally)>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let heft = arguments.heft();
    let needs_heft = arguments.fuzz.is_none() && arguments.trust.is_none();
    if needs_heft && !heft.exists() {
        let place = heft.display();
        eprintln!("{place} is not there: run `cargo build` first");
        return ExitCode::from(2);
    }
    match run(&arguments, &heft) {
        Ok(good) => ExitCode::from(u8::from(!good)),
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// Executes the arguments; returns whether all attempts survived.
fn run(arguments: &Arguments, heft: &Path) -> Result<bool, String> {
    if let Some(target) = &arguments.fuzz {
        return fuzz::run(target, arguments.seconds, arguments.seed).map(|()| true);
    }
    if let Some(word) = &arguments.trust {
        return trust::print(word, arguments.seed, arguments.from);
    }
    if let Some(minutes) = arguments.soak {
        return soak::run(heft, minutes);
    }
    let begun = Instant::now();
    let rows = attempts(arguments, heft, begun);
    if rows.is_empty() {
        return Err(format!(
            "no attack has `{}` in its name; without --only all of them are tried",
            arguments.only
        ));
    }
    print(&rows);
    println!(
        "{} attacks in {:.1} minutes, seed {}; gaps in samples at {} Hz",
        rows.iter().map(|(_, t)| t.tried).sum::<u32>(),
        begun.elapsed().as_secs_f64() / 60.0,
        arguments.seed,
        ground::RATE
    );
    Ok(rows.iter().all(|(_, tally)| tally.tried == tally.survived))
}

/// Runs the attacks in turn, until the time is over.
fn attempts(arguments: &Arguments, heft: &Path, begun: Instant) -> Rows {
    let mut rng = Rng::new(arguments.seed);
    let chosen = attacks().into_iter();
    let chosen = chosen.filter(|a| a.name().contains(&arguments.only));
    let mut rows: Rows = chosen.map(|a| (a, Tally::default())).collect();
    let limit = Duration::from_secs_f64(60.0 * arguments.minutes.max(0.0));
    let mut number = 0;
    let mut printed = begun;
    while !rows.is_empty() {
        if printed.elapsed() >= INTERIM {
            printed = Instant::now();
            println!("after {:.0} minutes:", begun.elapsed().as_secs_f64() / 60.0);
            print(&rows);
        }
        for (attack, tally) in &mut rows {
            if begun.elapsed() >= limit {
                return rows;
            }
            number += 1;
            let ground = Ground::new(heft, number);
            if let Some(why) = tally.count(attack.attempt(&mut rng, &ground)) {
                println!("{} (number {number}): {why}", attack.name());
            }
        }
    }
    rows
}

fn print(rows: &Rows) {
    println!(
        "{:<34} {:>6} {:>9} {:>8} {:>10}",
        "attack", "tried", "survived", "skipped", "worst gap"
    );
    for (attack, tally) in rows {
        println!(
            "{:<34} {:>6} {:>9} {:>8} {:>10}",
            attack.name(),
            tally.tried,
            tally.survived,
            tally.skipped,
            tally.worst_gap
        );
    }
    let notes = rows.iter().filter_map(|(attack, _)| attack.note());
    notes.for_each(|note| println!("{note}"));
}
