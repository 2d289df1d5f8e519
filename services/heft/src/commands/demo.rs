//! `heft` without a command: both machines at work in real time, each a pipeline of processes.

use std::io::{BufRead, BufReader, IsTerminal, Write};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::time::Instant;

use messages::Machine;

use crate::commands::run::folder;
use crate::failure::Failure;
use crate::image;
use crate::machines;
use crate::signals::Signals;
use crate::watch::LIVE;

/// Length of the demonstration [s].
const DURATION: &str = "26";

/// A line of one of the two runs; `None` at its end.
type Line = (usize, Option<String>);

/// `heft`
pub fn demo() -> Result<(), Failure> {
    println!(
        "heft {}: an excavator and a wheel loader at work, simulated in real time for {DURATION} s.\n\
         Each machine is five processes (sensor, kalman, rls or ukf, logger) that exchange samples\n\
         through shared memory; the estimators never see the truth printed beside them.\n\
         ✓: heft trusts its estimate. ?: it does not, yet.\n",
        env!("CARGO_PKG_VERSION")
    );
    // Ctrl-C reaches both runs as well: they end in order, and this process waits for them.
    let _signal = Signals::catch()?;
    let folder = folder(None, "demo")?;
    let (sender, lines) = channel::<Line>();
    let mut runs = Vec::new();
    for (index, machine) in Machine::ALL.into_iter().enumerate() {
        runs.push(start(machine, &folder, index, sender.clone())?);
    }
    drop(sender);
    let mut screen = Screen::default();
    let mut summaries = Machine::ALL.map(|_| String::new());
    for (index, line) in lines {
        match line {
            Some(line) => match line.strip_prefix(LIVE) {
                Some(live) => screen.show(index, live),
                None => summaries[index] += &(line + "\n"),
            },
            None => screen.ended += 1,
        }
    }
    screen.finish();
    print!("{}", summaries.concat());
    let mut failed = false;
    for mut run in runs {
        failed |= !run.wait().map_err(Failure::internal)?.success();
    }
    if failed {
        return Err(Failure::answer_is_no(
            "a pipeline of the demonstration failed; see above",
        ));
    }
    println!("\nOpen the reports in a browser, or go on with `heft run --help`.");
    Ok(())
}

fn start(
    machine: Machine,
    folder: &Path,
    index: usize,
    sender: Sender<Line>,
) -> Result<Child, Failure> {
    let mut child = image::command()
        .args([
            "run",
            machine.name(),
            "--scenario",
            machines::entry(machine).shown_scenario(),
            "--duration",
            DURATION,
        ])
        .args(["--live-lines", "--out"])
        .arg(folder.join(machine.name()))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(Failure::internal)?;
    let Some(stdout) = child.stdout.take() else {
        return Err(Failure::internal("a run has no standard output"));
    };
    std::thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            if sender.send((index, Some(line))).is_err() {
                return;
            }
        }
        let _ = sender.send((index, None));
    });
    Ok(child)
}

/// The live lines, one per machine: redrawn in place on a terminal, every five seconds elsewhere.
#[derive(Default)]
struct Screen {
    lines: [String; Machine::ALL.len()],
    drawn: bool,
    shown: Option<Instant>,
    ended: usize,
}

impl Screen {
    fn show(&mut self, index: usize, live: &str) {
        self.lines[index] = format!("{:<9} {live}", Machine::ALL[index].name());
        let terminal = std::io::stdout().is_terminal();
        let pause = if terminal { 0.1 } else { 5.0 };
        if self
            .shown
            .is_some_and(|t| t.elapsed().as_secs_f64() < pause)
            || self.lines.iter().any(String::is_empty)
        {
            return;
        }
        self.shown = Some(Instant::now());
        let mut out = std::io::stdout().lock();
        let clear = if terminal { "\x1b[2K" } else { "" };
        let mut text = if terminal && self.drawn {
            format!("\x1b[{}A", self.lines.len())
        } else {
            String::new()
        };
        for line in &self.lines {
            text += &format!("{clear}{line}\n");
        }
        let _ = out.write_all(text.as_bytes());
        let _ = out.flush();
        self.drawn = true;
    }

    fn finish(&mut self) {
        let _ = std::io::stdout().flush();
    }
}
