//! `heft serve` as a child process: its input, its output, its end.

use std::io::{BufReader, BufWriter, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::Receiver;

use super::ServeArgs;
use crate::{Failure, error};

/// The process with both its ends.
type ChildPipes = (Child, BufWriter<ChildStdin>, BufReader<ChildStdout>);

/// Starts the child.
pub(super) fn start(args: &ServeArgs) -> Result<ChildPipes, String> {
    let program = args.heft.clone().unwrap_or_else(beside);
    let mut command = Command::new(&program);
    command.args(["serve", &args.kind, "--messages", "--every"]);
    command.arg(args.every.to_string());
    if let Some(method) = &args.method {
        command.args(["--method", method]);
    }
    // A separate process group: Ctrl-C reaches only this process, which then closes the child's input.
    command.args(&args.rest).process_group(0);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|e| {
        let remedy = "build heft, and put it beside heft-fleet or name it with --heft";
        error(format!("cannot start heft: {e}"), program.display(), remedy)
    })?;
    let pipes = child.stdin.take().zip(child.stdout.take());
    let (input, output) = pipes.ok_or_else(|| error("no pipe", "heft serve", "report this"))?;
    Ok((
        child,
        BufWriter::with_capacity(1 << 16, input),
        BufReader::with_capacity(1 << 16, output),
    ))
}

/// The program heft: beside this one, else in the search path.
fn beside() -> PathBuf {
    let own = std::env::current_exe().ok();
    let folder = own.as_deref().and_then(Path::parent);
    let beside = folder.map(|f| f.join("heft"));
    beside
        .filter(|f| f.is_file())
        .unwrap_or_else(|| "heft".into())
}

/// Writes batches until there are no more, or the child has ended. Flushes whenever the queue is empty.
pub(super) fn feed(mut input: BufWriter<ChildStdin>, batches: &Receiver<Vec<u8>>) {
    while let Ok(first) = batches.recv() {
        for batch in std::iter::once(first).chain(batches.try_iter()) {
            // The reader of the child's output reports its end.
            if input.write_all(&batch).is_err() {
                return;
            }
        }
        if input.flush().is_err() {
            return;
        }
    }
}

/// Waits for the child's end, which follows from the end of its input.
pub(super) fn end(mut child: Child) -> Result<(), Failure> {
    drop(child.stdin.take());
    let ended = child
        .wait()
        .map_err(|e| error(e, "heft serve", "check the system"))?;
    // Status 1: the samples of some machines are faulty, which the child has reported.
    if ended.success() || ended.code() == Some(1) {
        return Ok(());
    }
    let what = format!("`heft serve` ended: {ended}");
    let failed = error(what, "heft fleet serve", "see what it said above");
    // Status 2: the child cannot use its arguments or its input.
    Err(if ended.code() == Some(2) {
        failed.into()
    } else {
        Failure::passing(failed)
    })
}
