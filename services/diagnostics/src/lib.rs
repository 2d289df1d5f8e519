//! What a program says of itself on standard error: the same choices for the command and for the programs of a fleet.

mod journal;

use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

/// Logs to standard error by `writer`. `HEFT_LOG`, or else `RUST_LOG`, chooses what, in the syntax of `env_logger`; else it is `usual`.
/// `HEFT_LOG_FORMAT=json` writes objects with the process in `span`. In the journal of systemd each line has its priority.
/// The processes of a run inherit all of it.
pub fn start<W>(usual: &str, writer: W)
where
    W: for<'a> MakeWriter<'a> + Send + Sync + 'static,
{
    let filter = EnvFilter::try_from_env("HEFT_LOG")
        .or_else(|_| EnvFilter::try_from_env("RUST_LOG"))
        .unwrap_or_else(|_| EnvFilter::new(usual));
    let lines = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(writer);
    if std::env::var_os("HEFT_LOG_FORMAT").is_some_and(|format| format == "json") {
        lines
            .json()
            .flatten_event(true)
            .with_span_list(false)
            .init();
    } else if journal::is_journal(std::io::stderr()) {
        let format = tracing_subscriber::fmt::format()
            .with_ansi(false)
            .without_time();
        lines.event_format(journal::Prioritized(format)).init();
    } else {
        lines.without_time().init();
    }
}
