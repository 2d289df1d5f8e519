//! `heft loads`: the loads of recordings, one row each.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use evaluate::text::Table;
use messages::Machine;
use serde_json::json;
use steps::loads::{LoadCounter, Options, outage_words, why_words};
use view::loads::{self, Account, Truths};
use view::number::{grouped, interval_95, value_and_std};
use view::words::wrapped;

use crate::args::{EstimationArgs, described, machine};
use crate::drawing;
use crate::failure::Failure;
use crate::results::{self, IsOurs};
use crate::{machines, many, page, quantity, size, target};

/// `heft loads`
#[derive(Debug, Args)]
#[command(after_help = "\
A load is what was in the bucket between filling and dumping; `kg` has a 95 % interval. `left in it` is what was weighed in
the bucket after the dump (carry-back); a truck gets the difference. Errors that all loads share add up in a truck's
interval, those of each load average out. A truck ends where the signal `truck` changes, or after --pause.
Times are those of the recording [s].")]
pub struct LoadsArgs {
    /// Recordings (.mcap), tables (.csv), CAN logs (.log), or folders of them
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// The machine; a recording of heft or the machine file (--config) names it
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// What estimates are made with; a recording of heft brings its machine file
    #[command(flatten)]
    pub with: EstimationArgs,
    /// What a truck shall hold, such as 24t or 24000 (kg)
    #[arg(long, value_name = "MASS", value_parser = target::parsed)]
    pub target: Option<f64>,
    /// A load this long after the one before goes to another truck, such as 300 (s) or 5m; 0: never
    #[arg(long, value_name = "TIME", default_value = "300", allow_negative_numbers = true, value_parser = view::duration::seconds)]
    pub pause: f64,
    /// One line a load (CSV)
    #[arg(short, long, value_name = "LOADS.csv")]
    pub output: Option<PathBuf>,
    /// Loads, trucks and sums (JSON)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// A page to print: a table a truck (HTML)
    #[arg(long, value_name = "R.html")]
    pub report: Option<PathBuf>,
}

/// `heft loads`
pub fn loads(args: &LoadsArgs) -> Result<(), Failure> {
    let inputs = many::inputs(&args.files, true)?;
    check_outputs(args, &inputs)?;
    let mut accounts = Vec::new();
    let mut ends = Vec::new();
    let mut notes = BTreeSet::new();
    for input in &inputs {
        let (account, end) = match count(args, input, &mut notes) {
            Ok((account, end)) => (Some(account), end),
            Err(failure) => (None, Err(failure)),
        };
        let is_one_of_many = inputs.len() > 1;
        if let Some(failure) = end.as_ref().err().filter(|_| is_one_of_many) {
            eprintln!("heft: {}: {failure}", input.display());
        }
        account.iter().for_each(print);
        accounts.extend(account);
        ends.push(end);
    }
    if !accounts.is_empty() {
        write(args, &accounts)?;
    }
    judge(ends)
}

/// The failure of a single input; of many inputs, their number: each was named before.
fn judge(mut ends: Vec<Result<(), Failure>>) -> Result<(), Failure> {
    if ends.len() == 1 {
        return ends.remove(0);
    }
    let all = ends.len();
    let statuses = ends.iter().filter_map(|end| end.as_ref().err());
    let (doubtful, failed): (Vec<u8>, Vec<u8>) =
        statuses.map(|f| f.status).partition(|status| *status == 1);
    match (failed.len(), doubtful.len()) {
        (0, 0) => Ok(()),
        (0, doubtful) => Err(Failure::answer_is_no(format!(
            "{doubtful} of {all} inputs are in doubt, for what is said above; what could be read in them was counted"
        ))),
        (failed, _) => Err(Failure::input(
            format!("{failed} of {all} inputs could not be counted"),
            "the messages above",
            "fix or remove them and run again",
        )),
    }
}

/// The loads of an input, and whether it was read completely; `notes`: those that were printed already.
fn count(
    args: &LoadsArgs,
    input: &Path,
    notes: &mut BTreeSet<String>,
) -> Result<(Account, Result<(), Failure>), Failure> {
    let description = described(args.machine, &args.with.description, input)?;
    let options = Options {
        target: args.target,
        pause: args.pause,
    };
    if let Some(note) = target::doubt(args.target, &description)?
        && notes.insert(note.clone())
    {
        eprintln!("{note}");
    }
    let mut counter = LoadCounter::new(&description, options).remembering_all();
    let (mut trucks, mut truths) = (Vec::new(), Truths::default());
    let entry = machines::entry(description.machine());
    let read = (entry.follow)(&args.with, input, &description, &mut |message| {
        if let Some(kg) = quantity::truth(message, "payload") {
            truths.know(message.stamp().time, kg);
        }
        trucks.extend(counter.see(message).truck);
    });
    // The whole part of a damaged recording counts, and so do the results of doubtful data.
    let read = match read {
        Err(failure) if failure.status != 1 => return Err(failure),
        read => read,
    };
    if let Some(note) = size::assumed(&description, &args.with.description, input)?
        && notes.insert(note.clone())
    {
        eprintln!("{note}");
    }
    for words in drawing::contradictions(&description) {
        if notes.insert(words.clone()) {
            eprintln!("warning: {words}");
        }
    }
    trucks.extend(counter.finish().truck);
    let name = input.display().to_string();
    let account = Account::of(&name, &counter, trucks, &truths);
    if account.is_empty() {
        tell_why_none(&account);
    }
    let read = read.and_then(|()| is_complete(&account));
    Ok((account, read))
}

/// An error if a fault of a sensor left no load weighed for more than a tenth of the time.
fn is_complete(account: &Account) -> Result<(), Failure> {
    let Some(outage) = account.in_doubt() else {
        return Ok(());
    };
    Err(Failure::answer_is_no(format!(
        "the sum may lack loads: no load was weighed for {:.0} s of {:.0} s, because {}\n  where: {}\n  what to do: {}",
        outage.seconds,
        account.seconds,
        outage_words(account.machine, outage),
        account.name,
        loads::outage_advice(account.machine, outage)
    )))
}

fn tell_why_none(account: &Account) {
    eprintln!(
        "{}: no load was clear of the empty bucket, carried and dumped",
        account.name
    );
    if let Some(lacks) = account.lacks {
        eprintln!("  {lacks}");
    }
    eprintln!(
        "  `heft estimate` with --report draws what the bucket held and why it is not trusted"
    );
}

/// Column of the truth of a simulated load, after its interval.
const TRUTH_AT: usize = 5;

fn print(account: &Account) {
    println!("{}", account.name);
    if account.loads.is_empty() {
        println!("no load");
    } else {
        print!("{}", table(account));
    }
    if let Some(load) = &account.carried {
        println!(
            "in the bucket at the end: {}",
            loads::line(account.machine, load)
        );
    }
    for truck in &account.trucks {
        println!("{}", loads::truck_line(truck));
    }
    if let Some(covered) = account.covered_words() {
        println!("{covered}");
    }
    let remarks = account.remarks().into_iter();
    let remarks = remarks.filter(|_| !account.is_empty());
    for sentence in account.doubts().into_iter().chain(remarks) {
        for line in wrapped(&sentence, 79) {
            println!("{line}");
        }
    }
    // A sum of no loads has no interval.
    if account.trucks.len() > 1 {
        println!("all: {}", loads::total_words(&account.all));
    }
}

/// One row a load.
fn table(account: &Account) -> Table {
    let mut header = vec![
        "load",
        "filled",
        "dumped",
        "kg",
        "95 %",
        "left in it",
        "delivered",
        "truck",
        "by",
        "trusted",
    ];
    let is_known = !account.truths.is_empty();
    if is_known {
        header.insert(TRUTH_AT, "truth");
    }
    let mut table = Table::new(&header);
    for load in &account.loads {
        let (kg, _) = value_and_std(load.weight.kg, load.weight.std);
        let (rest, _) = value_and_std(load.carry_back.kg, load.carry_back.std);
        let delivered = load.delivered();
        let (got, _) = value_and_std(delivered.kg, delivered.std);
        let unweighed = if load.carry_back_weighed { "" } else { "?" };
        let mut cells = vec![
            load.number.to_string(),
            loads::clock(load.filled),
            load.dumped.map_or(String::new(), loads::clock),
            kg,
            interval_95(load.weight.kg, load.weight.std),
            format!("{rest}{unweighed}"),
            got,
            load.truck.to_string(),
            load.witness.name().to_owned(),
            match load.trusted {
                true => "yes".to_owned(),
                false => format!("no: {}", why_words(account.machine, load)),
            },
        ];
        if is_known {
            let truth = account.truths.get(&load.number);
            cells.insert(TRUTH_AT, truth.map_or(String::new(), |t| grouped(*t, 0)));
        }
        table.row(cells);
    }
    table
}

fn check_outputs(args: &LoadsArgs, inputs: &[PathBuf]) -> Result<(), Failure> {
    let mut taken: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    taken.extend(args.with.map.as_deref());
    taken.extend(args.with.description.config.as_deref());
    let is_json = results::is_json_of("loads");
    let wanted: [(_, IsOurs); 3] = [
        (args.output.as_deref(), &loads::is_csv),
        (args.json.as_deref(), &is_json),
        (args.report.as_deref(), &page::is_ours),
    ];
    results::check(taken, &wanted)
}

fn write(args: &LoadsArgs, accounts: &[Account]) -> Result<(), Failure> {
    if let Some(file) = &args.output {
        let text = loads::csv(accounts);
        results::text("write the loads", file, &[], loads::is_csv, &text)?;
        println!("loads in {}", file.display());
    }
    if let Some(file) = &args.json {
        let all: Vec<_> = accounts.iter().map(loads::json).collect();
        let by = crate::build::IDENTITY;
        results::json(file, &[], "loads", by, &json!({ "recordings": all }))?;
        println!("summary in {}", file.display());
    }
    if let Some(file) = &args.report {
        page::put(&view::loads_page(accounts), file, &[])?;
        println!("page in {}", file.display());
    }
    Ok(())
}
