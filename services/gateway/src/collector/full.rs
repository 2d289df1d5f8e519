//! `heft fleet full`: every estimate of one machine for a while, as a table.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use messages::Envelope;
use recording::payload::take_delimited;
use serde_json::json;
use zenoh::Wait;

use super::intake::decode;
use super::table::{Format, Table};
use crate::key::MachineId;
use crate::link::{LinkArgs, client_unless};
use crate::machine::LONGEST;
use crate::{Failure, error};

/// Timeout of the request to the machine.
const LIMIT: Duration = Duration::from_secs(10);
/// Batches that may wait to be written.
const QUEUE: usize = 1024;

/// `heft fleet full`
#[derive(Debug, Clone, clap::Args)]
pub struct FullArgs {
    /// The router
    #[command(flatten)]
    pub link: LinkArgs,
    /// The site
    #[arg(long)]
    pub site: String,
    /// The machine
    #[arg(long)]
    pub machine: String,
    /// For how long, such as 60s; 600 s at most
    #[arg(long = "for", value_parser = super::query::milliseconds)]
    pub duration: i64,
    /// How it is written
    #[arg(long, value_enum, default_value = "csv")]
    pub format: Format,
}

/// Requests every estimate and writes what arrives until the time is over or `stop` is set. Reports what is missing.
///
/// # Errors
/// The machine does not answer, or nothing can be written.
pub fn full(args: &FullArgs, out: &mut impl Write, stop: &AtomicBool) -> Result<(), Failure> {
    let id = MachineId::new(&args.site, &args.machine);
    let id = id.ok_or_else(|| {
        error(
            "these are no names of a site and a machine",
            "--site, --machine",
            "see the page of the fleet",
        )
    })?;
    let stops = || stop.load(Ordering::Relaxed);
    let Some(session) = client_unless(&args.link, &[], stops)? else {
        return Ok(());
    };
    let failed = |e: zenoh::Error| {
        error(
            format!("Zenoh refuses: {e}"),
            &args.link.connect,
            "please report this",
        )
    };
    let (batches, waiting) = sync_channel(QUEUE);
    let _subscriber = session
        .declare_subscriber(id.key("full/estimate/*"))
        .callback(move |sample| {
            // A batch that does not fit shows as a gap in the numbers.
            let _ = batches.try_send((
                sample.key_expr().as_str().to_owned(),
                sample.payload().to_bytes().into_owned(),
            ));
        })
        .wait()
        .map_err(failed)?;
    let seconds = args.duration as f64 / 1e3;
    ask(&session, &id, seconds).map_err(|why| {
        error(
            format!("the machine does not answer: {why}"),
            &id,
            format!("is it on the page of the fleet? {LONGEST} s at most"),
        )
    })?;
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let mut table = Table::new(args.format);
    let (mut rows, mut missing) = (0u64, 0u64);
    let mut last = std::collections::BTreeMap::new();
    while !stop.load(Ordering::Relaxed) && Instant::now() < end + Duration::from_secs(1) {
        let Ok((key, batch)) = waiting.recv_timeout(Duration::from_millis(200)) else {
            continue;
        };
        let Some((_, stream)) = MachineId::of(&key)
            .and_then(|(id, what)| Some((id, what.strip_prefix("full/")?.to_owned())))
        else {
            continue;
        };
        for message in messages(&stream, &batch) {
            let number = message.stamp().sequence;
            if let Some(before) = last.insert(stream.clone(), number) {
                missing = missing_between(before, number).saturating_add(missing);
            }
            rows += 1;
            let written = table.row(out, &[("stream", json!(stream))], &message);
            written.map_err(|e| Failure::not_written(&e))?;
        }
    }
    eprintln!("{rows} estimates, {missing} missing between them");
    let _ = session.close().wait();
    Ok(())
}

/// Number of messages missing between two numbers; saturates, because a machine may send any number.
fn missing_between(before: u64, number: u64) -> u64 {
    number.saturating_sub(before).saturating_sub(1)
}

/// Repeats the request until the machine answers: a session needs a moment to find its router.
fn ask(session: &zenoh::Session, id: &MachineId, seconds: f64) -> Result<(), String> {
    let begun = Instant::now();
    let mut why = "nobody is there".to_owned();
    while begun.elapsed() < LIMIT {
        let replies = session
            .get(id.key(&format!("control/full?for={seconds}")))
            .wait();
        for reply in replies.map_err(|e| e.to_string())? {
            match reply.result() {
                Ok(_) => return Ok(()),
                Err(error) => {
                    why = String::from_utf8_lossy(&error.payload().to_bytes()).into_owned()
                }
            }
        }
        std::thread::sleep(Duration::from_millis(200));
    }
    Err(why)
}

/// The messages of a batch, up to the first incomplete one.
fn messages(stream: &str, mut batch: &[u8]) -> Vec<Envelope> {
    let mut found = Vec::new();
    while let Some(one) = take_delimited(&mut batch) {
        found.extend(decode(stream, one));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_too_large_to_count() {
        assert_eq!(missing_between(3, 5), 1);
        assert_eq!(missing_between(u64::MAX, 0), 0);
        assert_eq!(missing_between(0, u64::MAX), u64::MAX - 1);
    }

    #[test]
    fn a_batch_is_read_as_far_as_it_is_whole() {
        assert!(messages("estimate/inertia_ukf", &[]).is_empty());
        // An empty message, then one that is cut.
        assert_eq!(messages("estimate/inertia_ukf", &[0, 9, 1]).len(), 1);
        assert!(messages("estimate/inertia_ukf", &[0xff; 8]).is_empty());
        assert!(messages("nothing", &[0]).is_empty());
    }
}
