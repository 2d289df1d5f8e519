//! `heft estimate`: the steps of the pipeline in one thread, on recorded data.

use std::path::Path;

use config::Description;
use messages::channels::Channel;
use messages::{Envelope, ExcavatorEstimate, LoaderEstimate, Message, Receiver};
use recording::{EstimateWriter, Metadata, Writer};
use steps::Error;
use steps::stages::{Pipeline, Role};
use view::estimate::Estimate;

use crate::cli::EstimateArgs;
use crate::commands::run::{description, tell_idle_keys};
use crate::failure::Failure;
use crate::{sources, summary};

/// `heft estimate`
pub fn estimate(args: &EstimateArgs) -> Result<(), Failure> {
    let map = sources::map(args.map.as_deref())?;
    let description = description(args.machine, &args.description)?;
    match &description {
        Description::Excavator(d) => {
            let rows = recording::load_excavator(&args.file, map.as_ref())?;
            if let Some((first, _)) = rows.first() {
                steps::excavator::check_columns(d, method(args), first)?;
            }
            run::<_, _, ExcavatorEstimate>(args, &description, &rows)
        }
        Description::Loader(_) => {
            let rows = recording::load_loader(&args.file, map.as_ref())?;
            run::<_, _, LoaderEstimate>(args, &description, &rows)
        }
    }
}

/// The method that was asked for, or that of the process whose estimate is told first.
fn method(args: &EstimateArgs) -> &str {
    let pipeline = Pipeline::of(args.machine);
    let main = pipeline
        .stage(pipeline.main)
        .map_or(&[][..], |s| s.methods());
    let asked = args.method.as_deref();
    asked.unwrap_or(main.first().copied().unwrap_or_default())
}

/// What one process answered.
struct Answers {
    channel: &'static Channel,
    messages: Vec<Envelope>,
}

/// Runs the stages that lead to a method's estimate over samples; the estimates come last.
fn answers<S: Message, T>(
    description: &Description,
    method: &str,
    rows: &[(S, T)],
) -> Result<Vec<Answers>, Error> {
    let pipeline = Pipeline::of(description.machine());
    let stage = pipeline.with_method(method);
    let stage = stage.ok_or_else(|| pipeline.unknown(method))?;
    let mut all: Vec<Answers> = Vec::new();
    let samples: Vec<Envelope> = rows.iter().map(|(s, _)| s.envelope()).collect();
    for row in pipeline.way_to(stage) {
        let mut step = row.start(description, method)?;
        let input = all.last().map_or(&samples, |before| &before.messages);
        let messages = input.iter().filter_map(|m| step.answer(m)).collect();
        all.push(Answers {
            channel: row.output(),
            messages,
        });
    }
    Ok(all)
}

fn run<S: Message, T: Message, E: Estimate + recording::csv::Estimate>(
    args: &EstimateArgs,
    description: &Description,
    rows: &[(S, T)],
) -> Result<(), Failure> {
    let answers = answers(description, method(args), rows)?;
    tell_idle_keys(description, &[method(args)]);
    let estimates = answers.last().map_or(&[][..], |a| &a.messages);
    let estimates = || estimates.iter().filter_map(E::inside);
    let mut writer = EstimateWriter::<E>::create(&args.output)?;
    estimates().try_for_each(|e| writer.write(e))?;
    let written = writer.finish()?;
    if let Some(report) = &args.report {
        let metadata = metadata(args, description, method(args));
        write_report(report, &metadata, |w| {
            write_rows(w, description, rows)?;
            answers
                .iter()
                .try_for_each(|a| write_all(w, a.channel, a.messages.iter().copied()))
        })?;
    }
    let last = estimates().last().copied().unwrap_or_default();
    tell(args, written, rows.len(), &view::words::verdict(&last));
    let trusted = estimates().filter(|e| Estimate::trusted(*e)).last();
    let age = trusted.map(|e| last.stamp().time - e.stamp().time);
    if let Some((trusted, age)) = trusted.zip(age).filter(|(_, age)| *age > 0.0) {
        println!(
            "last trusted {age:.1} s before the end: {}",
            view::words::verdict(trusted)
        );
    }
    if args.require_trust {
        summary::require_trust(age)?;
    }
    Ok(())
}

/// The samples and, where it is known, the truth.
fn write_rows<S: Message, T: Message>(
    writer: &mut Writer,
    description: &Description,
    rows: &[(S, T)],
) -> Result<(), recording::Error> {
    let stages = Pipeline::of(description.machine()).stages.iter();
    for stage in stages {
        if let Role::Source { sensors, truth } = stage.role {
            write_all(writer, sensors, rows.iter().map(|(s, _)| s.envelope()))?;
            let known = rows.iter().map(|(_, t)| t).filter(|t| is_known(*t));
            write_all(writer, truth, known.map(Message::envelope))?;
        }
    }
    Ok(())
}

/// Whether a truth says anything.
fn is_known<T: Message>(truth: &T) -> bool {
    let known = T::index("known").and_then(|i| truth.get(i));
    known.is_some_and(|bits| bits.as_f64() != 0.0)
}

fn tell(args: &EstimateArgs, written: usize, rows: usize, verdict: &str) {
    for line in view::words::wrapped(verdict, 79) {
        println!("{line}");
    }
    let refused = rows.saturating_sub(written);
    let refused = if refused == 0 {
        String::new()
    } else {
        format!(" ({refused} rows refused: their time is missing or does not increase)")
    };
    println!("{written} estimates in {}{refused}", args.output.display());
    if let Some(report) = &args.report {
        println!("report in {}", report.display());
    }
}

fn metadata(args: &EstimateArgs, description: &Description, method: &str) -> Metadata {
    let text = description.to_toml();
    let mut metadata = Metadata::new();
    for (key, value) in [
        ("heft.version", env!("CARGO_PKG_VERSION").to_owned()),
        ("machine", description.machine().name().to_owned()),
        ("input", args.file.display().to_string()),
        ("method", method.to_owned()),
        ("description.sha256", recording::sha256(&text)),
        ("description", text),
    ] {
        metadata.insert(key.to_owned(), value);
    }
    metadata
}

fn write_all(
    writer: &mut Writer,
    channel: &Channel,
    messages: impl IntoIterator<Item = Envelope>,
) -> Result<(), recording::Error> {
    struct Write<'a>(&'a mut Writer, &'a Channel);

    impl Receiver for Write<'_> {
        type Output = Result<(), recording::Error>;

        fn receive<M: Message>(self, message: &M) -> Self::Output {
            self.0.write(self.1, message)
        }
    }

    messages
        .into_iter()
        .try_for_each(|m| m.open(Write(writer, channel)))
}

/// A report is made from a recording, here from one that exists only for it.
fn write_report(
    report: &Path,
    metadata: &Metadata,
    fill: impl FnOnce(&mut Writer) -> Result<(), recording::Error>,
) -> Result<(), Failure> {
    let recording = report.with_extension("mcap.tmp");
    let mut writer = Writer::create(&recording, metadata)?;
    fill(&mut writer)?;
    writer.finish()?;
    let done = super::report::write(&recording, report);
    let _ = std::fs::remove_file(&recording);
    done
}
