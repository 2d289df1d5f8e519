//! Log messages of a program on standard error, with the same options for the command and the programs of a fleet.

mod journal;

use std::io::IsTerminal as _;

use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

/// Logs to standard error by `writer`. `HEFT_LOG`, or else `RUST_LOG`, chooses what: levels, of all (`info`) or by target
/// (`heft=debug`), with commas between; else it is `usual`.
/// `HEFT_LOG_FORMAT=json` writes objects with the process in `span`. In the journal of systemd each line has its priority.
/// The processes of a run inherit all of it. A text names its source where a program `stays`; one that a person waits for says what is
/// the matter, and no more.
pub fn start<W>(usual: &str, stays: bool, writer: W)
where
    W: for<'a> MakeWriter<'a> + Send + Sync + 'static,
{
    let chosen = |name| std::env::var(name).ok()?.parse::<Targets>().ok();
    let filter = chosen("HEFT_LOG").or_else(|| chosen("RUST_LOG"));
    let filter = filter.unwrap_or_else(|| usual.parse().unwrap_or_default());
    let lines = tracing_subscriber::fmt()
        .with_max_level(LevelFilter::TRACE)
        .with_writer(writer);
    // A file or a pipe takes no colours: Zenoh's crates enable them.
    let lines = match std::io::stderr().is_terminal() {
        true => lines,
        false => lines.with_ansi(false),
    };
    if std::env::var_os("HEFT_LOG_FORMAT").is_some_and(|format| format == "json") {
        let lines = lines.json().flatten_event(true).with_span_list(false);
        lines.finish().with(filter).init();
    } else if journal::is_journal(std::io::stderr()) {
        let format = tracing_subscriber::fmt::format()
            .with_ansi(false)
            .without_time();
        let lines = lines.event_format(journal::Prioritized(format));
        lines.finish().with(filter).init();
    } else {
        let lines = lines.without_time().with_target(stays);
        lines.finish().with(filter).init();
    }
}
