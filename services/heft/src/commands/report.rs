//! `heft report`: one offline HTML page of a recording, or of several side by side; or its picture.

use std::path::{Path, PathBuf};

use clap::Args;
use recording::Reader;
use view::Run;

use crate::args::ManyArgs;
use crate::failure::Failure;
use crate::many::{self, Job};
use crate::page::{put, tells_damage, write};
use crate::parts;
use crate::results;

/// `heft report`
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// The recording, or its folder; several of the same machine are compared
    #[arg(required_unless_present = "foxglove")]
    pub files: Vec<PathBuf>,
    /// Page to write; if absent the recording's name with .html, or compared.html beside the first
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Write a layout of Foxglove with the main plots instead (there: Layouts, Import from file)
    #[arg(long, value_name = "LAYOUT.json", conflicts_with_all = ["output", "each"])]
    pub foxglove: Option<PathBuf>,
    /// A page of its own beside each recording, and beside every recording of a folder
    #[arg(long, conflicts_with = "output")]
    pub each: bool,
    /// How many inputs are treated
    #[command(flatten)]
    pub many: ManyArgs,
}

/// `heft report`
pub fn report(args: &ReportArgs) -> Result<(), Failure> {
    if let Some(layout) = &args.foxglove {
        results::text(
            "write the layout",
            layout,
            &[],
            |_| false,
            view::FOXGLOVE_LAYOUT,
        )?;
        println!(
            "{}: import it in Foxglove, then open a recording",
            layout.display()
        );
        return Ok(());
    }
    match args.files.as_slice() {
        _ if args.each => each(args),
        [file] => one(file, args.output.as_deref()),
        files => side_by_side(files, args.output.as_deref()),
    }
}

/// A page beside each recording, each in a process of its own.
fn each(args: &ReportArgs) -> Result<(), Failure> {
    let inputs = many::inputs(&args.files, false)?;
    let pages = many::beside(&inputs, "html");
    let job = |(input, page): (&PathBuf, &PathBuf)| {
        let reader = Reader::open(input).ok();
        let sources: Vec<&Path> = reader.iter().flat_map(Reader::files).collect();
        let arguments = [
            "report".into(),
            "--output".into(),
            page.into(),
            "--".into(),
            input.into(),
        ];
        Job {
            input: input.clone(),
            arguments: arguments.into(),
            // A damaged recording is read again, so that its damage is reported every time.
            is_done: !args.many.again
                && !sources.is_empty()
                && many::is_newer(page, &sources)
                && !tells_damage(page),
        }
    };
    let jobs: Vec<Job> = inputs.iter().zip(&pages).map(job).collect();
    let ends = many::run(&jobs, args.many.jobs);
    for (page, end) in pages.iter().zip(&ends) {
        println!("{}: {}", page.display(), end.word());
    }
    many::judge(&ends)
}

fn one(file: &Path, output: Option<&Path>) -> Result<(), Failure> {
    let reader = parts::open(file)?;
    parts::check_content(&reader)?;
    let first = reader.files().next().unwrap_or(file);
    let page = output.map_or_else(|| first.with_extension("html"), PathBuf::from);
    write(&reader, &page)?;
    println!("{}", page.display());
    parts::check_whole(&reader)
}

/// Compares recordings of the same machine on a page beside the first of them.
fn side_by_side(files: &[PathBuf], output: Option<&Path>) -> Result<(), Failure> {
    let readers = files.iter().map(|file| parts::open(file));
    let readers = readers.collect::<Result<Vec<_>, _>>()?;
    readers.iter().try_for_each(parts::check_content)?;
    are_of_one_machine(files, &readers)?;
    let mut runs = Vec::new();
    for (name, reader) in names(files).into_iter().zip(&readers) {
        runs.push((name, Run::from_recording(reader)?));
    }
    let inputs: Vec<&Path> = readers.iter().flat_map(Reader::files).collect();
    let first = inputs.first().copied().unwrap_or(Path::new("."));
    let page = output.map_or_else(|| first.with_file_name("compared.html"), PathBuf::from);
    put(&view::compared(&runs), &page, &inputs)?;
    println!("{}", page.display());
    readers.iter().try_for_each(parts::check_whole)
}

/// Refuses recordings of different machines.
fn are_of_one_machine(files: &[PathBuf], readers: &[Reader]) -> Result<(), Failure> {
    let machines = readers.iter().filter_map(|r| r.metadata().get("machine"));
    let distinct: std::collections::BTreeSet<&String> = machines.collect();
    if distinct.len() < 2 {
        return Ok(());
    }
    let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
    Err(Failure::input(
        "these are recordings of different machines: there is nothing to compare",
        names.join(", "),
        "name recordings of one machine, or add --each for a page of each",
    ))
}

/// The names of the files, whole paths where two have the same name.
fn names(files: &[PathBuf]) -> Vec<String> {
    let short = |file: &PathBuf| file.file_stem().map(|s| s.to_string_lossy().into_owned());
    let stems: Vec<Option<String>> = files.iter().map(short).collect();
    let distinct: std::collections::BTreeSet<_> = stems.iter().collect();
    if distinct.len() == files.len() && !stems.contains(&None) {
        return stems.into_iter().flatten().collect();
    }
    files
        .iter()
        .map(|file| file.display().to_string())
        .collect()
}
