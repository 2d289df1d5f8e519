//! Estimates of one input, row after row.

use std::path::Path;

use checks::Look;
use config::Description;
use messages::channels::Channel;
use messages::{Envelope, Message, Receiver};
use recording::output::Beside;
use recording::{EstimateWriter, Metadata, Reader, Samples, Writer};
use steps::chain::{Chain, chain, method};
use steps::loads::{LoadCounter, Options, guessed};
use steps::stages::{Pipeline, Role};
use view::estimate::{Estimate, Parameter};

use super::args::EstimateArgs;
use super::found::InputSummary;
use super::many;
use crate::args::tell_odd_keys;
use crate::doubts::Doubts;
use crate::failure::Failure;
use crate::fault::counted;
use crate::{page, parts, signals, summary};

/// Passes samples through the stages one by one, so that memory does not grow with the data. `put` may replace a
/// row's estimate by one that uses later rows.
pub fn run<S: Message, T: Message, E: Estimate>(
    args: &EstimateArgs,
    output: &Path,
    description: &Description,
    mut samples: Samples<S, T>,
    mut doubts: Doubts<impl Look<Sensors = S>>,
    put: impl Fn(usize, &mut E),
) -> Result<(), Failure> {
    signals::leave_nothing()?;
    samples.on_progress(parts::progress());
    let method = method(description.machine(), args.with.method.as_deref());
    let mut chain = chain(description, method)?;
    tell_odd_keys(description, &[method]);
    let mut writer = EstimateWriter::<E>::create(output)?;
    let metadata = metadata(args, description);
    let mut found = InputSummary::<E>::new();
    let report = args.report.as_deref();
    let mut notes = report.map(|r| Notes::create(r, &metadata)).transpose()?;
    let mut pressures = LoadCounter::new(description, Options::default());
    let (mut rows, mut last, mut latest) = (0, None::<E>, Latest { trusted: None });
    for (sample, truth) in samples.rows()? {
        rows += 1;
        let message = sample.envelope();
        pressures.see(&message);
        if let Some(notes) = &mut notes {
            notes.add_sample(description, &message, &truth)?;
        }
        let message = last_answer(&mut chain, message, notes.as_mut(), |e| put(rows - 1, e))?;
        let estimate = E::inside(&message);
        doubts.add(&sample, estimate.is_some_and(E::is_refused));
        // The answer to a refused row repeats the estimate before, at a time that may be invalid.
        if let Some(estimate) = estimate.filter(|e| !e.is_refused()) {
            writer.write(estimate)?;
            found.add(estimate);
            latest.add(estimate, last.as_ref());
            last = Some(*estimate);
        }
    }
    samples.check()?;
    if doubts.is_out_of_order() {
        doubts.parted(samples.several());
    }
    doubts.has_rows()?;
    let written = writer.finish()?;
    if let (Some(notes), Some(report)) = (notes, &args.report) {
        notes.report(report)?;
    }
    let last = last.unwrap_or_default();
    let weighs = |p: &Parameter<_, _>| p.is_load && p.value(&last).is_finite();
    let is_weighed = E::PARAMETERS.iter().any(weighs);
    let guessed = guessed(description).filter(|_| is_weighed);
    let mut words = in_words(&last, latest.trusted);
    words.extend(found.in_words());
    words.extend(guessed.clone());
    words.extend(pressures.unused().map(|why| format!("Note: {why}.")));
    tell(args, output, written, rows, &words);
    doubts.tell();
    let is_trusted = match args.require_trust {
        true => summary::require_trust(latest.trusted.map(|(_, age)| age)),
        false => Ok(()),
    };
    let judged = is_trusted.and_then(|()| doubts.judge(&samples.lacks()));
    if let Some(json) = &args.json {
        let made_by = many::identity(args, description, args.with.map.as_deref());
        let refused = rows.saturating_sub(written);
        found.write(
            json,
            refused,
            &made_by,
            guessed.as_deref(),
            judged.as_ref().err(),
        )?;
    }
    judged
}

/// The latest trusted estimate, and the time since \[s\].
struct Latest<E> {
    trusted: Option<(E, f64)>,
}

impl<E: Estimate> Latest<E> {
    /// Takes an estimate; a clock that is set back adds no time.
    fn add(&mut self, estimate: &E, before: Option<&E>) {
        let since = before.map_or(0.0, |e| estimate.stamp().time - e.stamp().time);
        self.trusted = match (estimate.trusted(), self.trusted) {
            (true, _) => Some((*estimate, 0.0)),
            (false, trusted) => trusted.map(|(e, age)| (e, age + since.max(0.0))),
        };
    }
}

/// Passes a sample through the stages, and records the answer of each.
fn last_answer<E: Estimate>(
    chain: &mut Chain,
    mut message: Envelope,
    mut notes: Option<&mut Notes>,
    put: impl Fn(&mut E),
) -> Result<Envelope, Failure> {
    for (channel, step) in chain {
        let Some(mut answer) = step.answer(&message) else {
            break;
        };
        if let Some(mut estimate) = E::inside(&answer).copied() {
            put(&mut estimate);
            answer = estimate.envelope();
        }
        if let Some(notes) = &mut notes {
            notes.add(channel, &answer)?;
        }
        message = answer;
    }
    Ok(message)
}

/// The last trusted estimate with its age, if it is not the last of all. The verdicts of the last row follow, which may differ
/// from it.
fn in_words<E: Estimate>(last: &E, trusted: Option<(E, f64)>) -> Vec<String> {
    match trusted.filter(|(_, age)| *age > 0.0) {
        None if last.trusted() => vec![view::words::verdict(last)],
        None => vec![of_the_last_row(last)],
        Some((trusted, age)) => vec![
            format!(
                "Last trusted, {age:.1} s before the end: {}",
                view::words::verdict(&trusted)
            ),
            of_the_last_row(last),
        ],
    }
}

/// Value and verdict of the last row; remedies are reported for the motion.
fn of_the_last_row<E: Estimate>(last: &E) -> String {
    let said = last.judgements();
    let said: Vec<_> = said
        .iter()
        .map(|j| format!("{}. {}", j.value, j.verdict()))
        .collect();
    format!("In the last row: {}", said.join(" "))
}

/// Whether a truth has any known field.
fn is_known<T: Message>(truth: &T) -> bool {
    truth.bits_of("known") != 0
}

fn tell(args: &EstimateArgs, output: &Path, written: usize, rows: usize, words: &[String]) {
    // With the estimates on standard output, messages would be rows among them.
    let say = |line: &str| match recording::output::is_standard_output(output) {
        true => eprintln!("{line}"),
        false => println!("{line}"),
    };
    for sentence in words {
        for line in view::words::wrapped(sentence, 79) {
            say(&line);
        }
    }
    let refused = rows.saturating_sub(written);
    let refused = if refused == 0 {
        String::new()
    } else {
        let refused = counted(refused as u64, "row", "rows");
        format!(" ({refused} refused: a time is missing or does not increase)")
    };
    say(&format!(
        "{} in {}{refused}",
        counted(written as u64, "estimate", "estimates"),
        output.display()
    ));
    if let Some(report) = &args.report {
        say(&format!("report in {}", report.display()));
    }
}

fn metadata(args: &EstimateArgs, description: &Description) -> Metadata {
    let names = args.files.iter().map(|f| f.display().to_string());
    let text = description.to_toml();
    let mut metadata = Metadata::new();
    for (key, value) in [
        ("heft.version", env!("CARGO_PKG_VERSION").to_owned()),
        (crate::build::KEY, crate::build::IDENTITY.to_owned()),
        ("machine", description.machine().name().to_owned()),
        ("input", names.collect::<Vec<_>>().join(", ")),
        (
            "method",
            method(description.machine(), args.with.method.as_deref()).to_owned(),
        ),
        ("description.sha256", recording::sha256(&text)),
        ("description", text),
    ] {
        metadata.insert(key.to_owned(), value);
    }
    metadata
}

/// A report needs a recording: this one exists only for it.
struct Notes {
    writer: Writer,
    file: Beside,
}

impl Notes {
    fn create(report: &Path, metadata: &Metadata) -> Result<Self, Failure> {
        let failed = |e| Failure::file("write", report, &e);
        let (file, _) = Beside::create(report).map_err(failed)?;
        let writer = Writer::create(file.path(), metadata)?;
        Ok(Self { writer, file })
    }

    fn add(&mut self, channel: &Channel, message: &Envelope) -> Result<(), recording::Error> {
        struct Write<'a>(&'a mut Writer, &'a Channel);

        impl Receiver for Write<'_> {
            type Output = Result<(), recording::Error>;

            fn receive<M: Message>(self, message: &M) -> Self::Output {
                self.0.write(self.1, message)
            }
        }

        message.open(Write(&mut self.writer, channel))
    }

    /// Writes a sample and, if known, the truth.
    fn add_sample<T: Message>(
        &mut self,
        description: &Description,
        sample: &Envelope,
        truth: &T,
    ) -> Result<(), recording::Error> {
        for stage in Pipeline::of(description.machine()).stages {
            if let Role::Source {
                sensors,
                truth: of_truth,
            } = stage.role
            {
                self.add(sensors, sample)?;
                if is_known(truth) {
                    self.add(of_truth, &truth.envelope())?;
                }
            }
        }
        Ok(())
    }

    fn report(self, page: &Path) -> Result<(), Failure> {
        self.writer.finish()?;
        page::write(&Reader::open(self.file.path())?, page)
    }
}
