//! `heft estimate`: the steps of the pipeline in one thread, on recorded data.

use std::path::Path;

use config::{Description, Kind};
use messages::channels::{
    Channel, EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_MOTION, EXCAVATOR_SENSORS,
    EXCAVATOR_TRUTH, LOADER_CG_EKF, LOADER_CG_UKF, LOADER_SENSORS, LOADER_TRUTH,
};
use messages::{
    ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, LoaderEstimate, LoaderSensors,
    LoaderTruth, Message, SwingMotion, excavator_bits, loader_bits,
};
use recording::{EstimateWriter, Metadata, Reader, Writer, output};
use runtime::{Step, answer};

use crate::cli::EstimateArgs;
use crate::commands::run::description;
use crate::failure::Failure;
use crate::pipeline;
use crate::sources;

/// `heft estimate`
pub fn estimate(args: &EstimateArgs) -> Result<(), Failure> {
    let kind = Kind::from(args.machine);
    check_outputs(args)?;
    let map = sources::map(args.map.as_deref())?;
    match description(kind, &args.description)? {
        Description::Excavator(d) => {
            let rows = recording::load_excavator(&args.file, map.as_ref())?;
            excavator(args, &d, &rows)
        }
        Description::Loader(d) => {
            let rows = recording::load_loader(&args.file, map.as_ref())?;
            loader(args, &d, &rows)
        }
    }
}

/// Refuses to write over what is read, or over something else of value.
fn check_outputs(args: &EstimateArgs) -> Result<(), Failure> {
    let config = args.description.config.as_deref();
    let inputs = [Some(args.file.as_path()), args.map.as_deref(), config];
    let mut inputs: Vec<&Path> = inputs.into_iter().flatten().collect();
    output::check(&args.output, &inputs, recording::csv::is_estimates)?;
    inputs.push(&args.output);
    if let Some(report) = &args.report {
        output::check(report, &inputs, super::report::is_page)?;
        if std::path::absolute(report).ok() == std::path::absolute(&args.output).ok() {
            return Err(Failure::input(
                "estimates and report cannot have the same name",
                report.display(),
                "choose two names",
            ));
        }
    }
    Ok(())
}

/// Estimates of one excavator method, with the motion that a regression worked on.
pub struct ExcavatorRun {
    /// Channel that a process would have published them on.
    pub channel: &'static Channel,
    /// One per sample.
    pub estimates: Vec<ExcavatorEstimate>,
    /// One per sample; empty for state-space methods.
    pub motions: Vec<SwingMotion>,
}

/// Runs one method over samples.
pub fn run_excavator(
    d: &config::Excavator,
    method: &str,
    rows: &[(ExcavatorSensors, ExcavatorTruth)],
) -> Result<ExcavatorRun, Failure> {
    let samples = rows.iter().map(|(s, _)| s);
    if pipeline::REGRESSIONS.contains(&method) {
        let mut filter = pipeline::excavator_filter(d)?;
        let mut regression = pipeline::excavator_regression(d, method)?;
        let motions: Vec<SwingMotion> = samples.map(|s| answer(&mut filter, s)).collect();
        let estimates = motions.iter().map(|m| answer(&mut regression, m)).collect();
        Ok(ExcavatorRun {
            channel: &EXCAVATOR_INERTIA_RLS,
            estimates,
            motions,
        })
    } else {
        let mut estimator = pipeline::excavator_estimator(d, method)?;
        let estimates = samples.map(|s| answer(&mut estimator, s)).collect();
        Ok(ExcavatorRun {
            channel: &EXCAVATOR_INERTIA_UKF,
            estimates,
            motions: Vec::new(),
        })
    }
}

fn excavator(
    args: &EstimateArgs,
    d: &config::Excavator,
    rows: &[(ExcavatorSensors, ExcavatorTruth)],
) -> Result<(), Failure> {
    let method = args.method.as_deref().unwrap_or("auto");
    if let Some((first, _)) = rows.first() {
        pipeline::check_columns(d, method, first)?;
    }
    let run = run_excavator(d, method, rows)?;
    let mut writer = EstimateWriter::excavator(&args.output)?;
    for estimate in run
        .estimates
        .iter()
        .filter(|e| e.flags & excavator_bits::REFUSED == 0)
    {
        writer.write_excavator(estimate)?;
    }
    let written = writer.finish()?;
    if let Some(report) = &args.report {
        let description = Description::Excavator(Box::new(d.clone()));
        write_report(report, &metadata(args, &description, method), |w| {
            write_all(w, &EXCAVATOR_SENSORS, rows.iter().map(|r| &r.0))?;
            write_all(
                w,
                &EXCAVATOR_TRUTH,
                rows.iter().map(|r| &r.1).filter(|t| t.known != 0),
            )?;
            write_all(w, &EXCAVATOR_MOTION, &run.motions)?;
            write_all(w, run.channel, &run.estimates)
        })?;
    }
    let last = run.estimates.last().copied().unwrap_or_default();
    tell(
        args,
        written,
        rows.len(),
        &view::words::excavator_verdict(&last),
    );
    require_trust(args, last.flags & excavator_bits::TRUSTED != 0)
}

/// Runs one method over samples.
pub fn run_loader(
    d: &config::Loader,
    method: &str,
    rows: &[(LoaderSensors, LoaderTruth)],
) -> Result<(&'static Channel, Vec<LoaderEstimate>), Failure> {
    fn all<S>(mut step: S, rows: &[(LoaderSensors, LoaderTruth)]) -> Vec<LoaderEstimate>
    where
        S: Step<Input = LoaderSensors, Output = LoaderEstimate>,
    {
        rows.iter().map(|(s, _)| answer(&mut step, s)).collect()
    }
    Ok(if method == "ekf" {
        (&LOADER_CG_EKF, all(pipeline::loader_baseline(d)?, rows))
    } else {
        (
            &LOADER_CG_UKF,
            all(pipeline::loader_estimator(d, method)?, rows),
        )
    })
}

fn loader(
    args: &EstimateArgs,
    d: &config::Loader,
    rows: &[(LoaderSensors, LoaderTruth)],
) -> Result<(), Failure> {
    let method = args.method.as_deref().unwrap_or("full");
    let (channel, estimates) = run_loader(d, method, rows)?;
    let mut writer = EstimateWriter::loader(&args.output)?;
    for estimate in estimates
        .iter()
        .filter(|e| e.flags & loader_bits::REFUSED == 0)
    {
        writer.write_loader(estimate)?;
    }
    let written = writer.finish()?;
    if let Some(report) = &args.report {
        let description = Description::Loader(Box::new(d.clone()));
        write_report(report, &metadata(args, &description, method), |w| {
            write_all(w, &LOADER_SENSORS, rows.iter().map(|r| &r.0))?;
            write_all(
                w,
                &LOADER_TRUTH,
                rows.iter().map(|r| &r.1).filter(|t| t.known != 0),
            )?;
            write_all(w, channel, &estimates)
        })?;
    }
    let last = estimates.last().copied().unwrap_or_default();
    tell(
        args,
        written,
        rows.len(),
        &view::words::loader_verdict(&last),
    );
    let both = loader_bits::TRUSTED_RATIO | loader_bits::TRUSTED_HEIGHT;
    require_trust(args, last.flags & both == both)
}

fn tell(args: &EstimateArgs, written: usize, rows: usize, verdict: &str) {
    println!("{verdict}");
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

fn require_trust(args: &EstimateArgs, trusted: bool) -> Result<(), Failure> {
    if args.require_trust && !trusted {
        return Err(Failure::answer_is_no("the last verdict is not `trusted`"));
    }
    Ok(())
}

fn metadata(args: &EstimateArgs, description: &Description, method: &str) -> Metadata {
    let text = description.to_toml();
    let mut metadata = Metadata::new();
    for (key, value) in [
        ("heft.version", env!("CARGO_PKG_VERSION").to_owned()),
        (crate::build::KEY, crate::build::IDENTITY.to_owned()),
        ("machine", description.kind().name().to_owned()),
        ("input", args.file.display().to_string()),
        ("method", method.to_owned()),
        ("description.sha256", recording::sha256(&text)),
        ("description", text),
    ] {
        metadata.insert(key.to_owned(), value);
    }
    metadata
}

fn write_all<'a, M: Message>(
    writer: &mut Writer,
    channel: &Channel,
    messages: impl IntoIterator<Item = &'a M>,
) -> Result<(), recording::Error> {
    messages
        .into_iter()
        .try_for_each(|m| writer.write(channel, m))
}

/// A report is made from a recording, here from one that exists only for it.
fn write_report(
    report: &Path,
    metadata: &Metadata,
    fill: impl FnOnce(&mut Writer) -> Result<(), recording::Error>,
) -> Result<(), Failure> {
    let mut name = report.as_os_str().to_owned();
    name.push(format!(".partial-{}.mcap", std::process::id()));
    let recording = std::path::PathBuf::from(name);
    let written = Writer::create(&recording, metadata).and_then(|mut writer| {
        fill(&mut writer)?;
        writer.finish()?;
        Reader::open(&recording)
    });
    let done = written
        .map_err(Failure::from)
        .and_then(|reader| super::report::write(&reader, report));
    let _ = std::fs::remove_file(&recording);
    done
}
