//! `heft` without a command: a demonstration of both machines in real time, each a pipeline of processes.

use std::io::{BufRead, BufReader, IsTerminal, Write};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

use messages::Machine;

use crate::commands::run::folder;
use crate::failure::Failure;
use crate::image;
use crate::machines;
use crate::signals::Signals;
use crate::watch::{LIVE, STORY};

/// Duration of the demonstration \[s\].
const DURATION: &str = "28";
/// Period of the live lines.
const REDRAWN: Duration = Duration::from_millis(250);

/// A line of one of the two runs; `None` at its end.
type Line = (usize, Option<String>);

/// `heft`
pub fn demo(is_verbose: bool) -> Result<(), Failure> {
    println!(
        "heft {}: an excavator and a wheel loader at work, simulated in real time for {DURATION} s.\n\
         heft sees the sensors only: motion, torque, cylinder pressures. It says what each bucket holds with\n\
         a 95 % interval, and whether the number can be trusted. The true value stands beside it.\n\
         Neither machine was calibrated; the loader stood on axle scales once, empty.\n",
        env!("CARGO_PKG_VERSION")
    );
    // Ctrl-C reaches both runs as well: they end in order, and this process waits for them.
    let _signal = Signals::catch()?;
    let folder = folder(None, "demo")?;
    let (sender, lines) = channel::<Line>();
    let mut runs: Vec<Child> = Vec::new();
    for (index, machine) in Machine::ALL.into_iter().enumerate() {
        match start(machine, &folder, index, is_verbose, sender.clone()) {
            Ok(run) => runs.push(run),
            Err(failure) => {
                // Without this reader no output of the other runs would be read.
                for run in &mut runs {
                    let _ = run.kill();
                    let _ = run.wait();
                }
                return Err(failure);
            }
        }
    }
    drop(sender);
    let mut screen = Screen::default();
    let mut summaries = Machine::ALL.map(|_| String::new());
    for (index, line) in lines {
        match line {
            Some(line) => match (line.strip_prefix(LIVE), line.strip_prefix(STORY)) {
                (Some(live), _) => screen.show(index, live),
                (_, Some(event)) => screen.tell(index, event),
                _ => summaries[index] += &(line + "\n"),
            },
            None => screen.ended += 1,
        }
    }
    screen.finish();
    let mut failed = false;
    for mut run in runs {
        failed |= !run.wait().map_err(Failure::internal)?.success();
    }
    if failed {
        print!("{}", summaries.concat());
        return Err(Failure::answer_is_no(
            "a pipeline of the demonstration failed; see above",
        ));
    }
    print!("{}", summaries.concat());
    println!(
        "\nOpen the reports in a browser. With your own data:\n  \
         heft map data.csv -o map.toml                  a first signal map: check it\n  \
         heft loads data.csv --machine excavator --map map.toml --class 21t\n  \
         heft estimate data.csv --machine excavator --map map.toml --class 21t -o out.csv --report out.html\n\
         21t stands for the operating mass of your machine. docs/sensors.md says which sensors, docs/your-data.md how to map them, and\n\
         which six numbers to state beside the class."
    );
    Ok(())
}

fn start(
    machine: Machine,
    folder: &Path,
    index: usize,
    is_verbose: bool,
    sender: Sender<Line>,
) -> Result<Child, Failure> {
    let mut child = image::command()
        .args([
            "run",
            machine.name(),
            "--scenario",
            machines::entry(machine).shown_scenario,
            "--duration",
            DURATION,
        ])
        .args(
            machines::entry(machine)
                .shown_settings
                .iter()
                .flat_map(|setting| ["--set", setting]),
        )
        .args(is_verbose.then_some("--verbose"))
        .args(["--live-lines", "--out"])
        .arg(folder.join(machine.name()))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(Failure::internal)?;
    let Some(stdout) = child.stdout.take() else {
        return Err(Failure::internal("a run has no standard output"));
    };
    let body = move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            if sender.send((index, Some(line))).is_err() {
                return;
            }
        }
        let _ = sender.send((index, None));
    };
    let thread = std::thread::Builder::new();
    thread.spawn(body).map_err(Failure::thread)?;
    Ok(child)
}

/// Lines printed for good; on a terminal, a live line per machine below them, redrawn in place.
#[derive(Default)]
struct Screen {
    lines: [String; Machine::ALL.len()],
    drawn: bool,
    shown: Option<Instant>,
    ended: usize,
}

impl Screen {
    fn show(&mut self, index: usize, live: &str) {
        self.lines[index] = named(index, live);
        let is_due = self.shown.is_none_or(|t| t.elapsed() >= REDRAWN);
        if is_due && std::io::stdout().is_terminal() {
            self.draw("");
        }
    }

    /// Prints a line that stays.
    fn tell(&mut self, index: usize, event: &str) {
        let event = named(index, event) + "\n";
        if std::io::stdout().is_terminal() {
            self.draw(&event);
        } else {
            print!("{event}");
            let _ = std::io::stdout().flush();
        }
    }

    /// Redraws the live lines, with `above` before them.
    fn draw(&mut self, above: &str) {
        self.shown = Some(Instant::now());
        let mut text = self.erased();
        text += above;
        for line in &self.lines {
            text += &format!("\x1b[2K{line}\n");
        }
        let mut out = std::io::stdout().lock();
        let _ = out.write_all(text.as_bytes());
        let _ = out.flush();
        self.drawn = true;
    }

    /// The control characters that erase the live lines.
    fn erased(&self) -> String {
        if self.drawn {
            format!("\x1b[{}A\x1b[J", self.lines.len())
        } else {
            String::new()
        }
    }

    fn finish(&mut self) {
        let mut out = std::io::stdout().lock();
        let _ = out.write_all(self.erased().as_bytes());
        let _ = out.flush();
    }
}

fn named(index: usize, text: &str) -> String {
    format!("{:<9} {text}", Machine::ALL[index].name())
}
