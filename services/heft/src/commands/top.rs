//! `heft top`: attaches to a running pipeline and shows it in the terminal.

use std::time::{Duration, Instant};

use clap::Args;
use messages::Message;
use messages::channels::{Channel, of_machine};
use ratatui::crossterm::event::{self, Event, KeyCode, KeyModifiers};
use runtime::Sink;
use steps::stages::Pipeline;
use view::top::{TopState, draw};

use crate::attached::{Attached, find};
use crate::failure::Failure;
use crate::signals::Signals;

/// Time between two pictures.
const PERIOD: Duration = Duration::from_millis(100);
/// Time for which a single picture as text reads the channels first.
const ONCE: Duration = Duration::from_millis(1500);
/// Size of that picture.
const ONCE_SIZE: (u16, u16) = (110, 36);

/// State of the dashboard.
struct Screen(TopState);

impl Sink for Screen {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        self.0.push(channel, message, Instant::now());
    }
}

/// `heft top`
#[derive(Debug, Args)]
pub struct TopArgs {
    /// Name of the run (`--domain` of `heft run`); the only one there is if absent
    #[arg(long)]
    pub domain: Option<String>,
    /// Print one picture as text and end
    #[arg(long)]
    pub once: bool,
}

/// `heft top`
pub fn top(args: &TopArgs) -> Result<(), Failure> {
    let found = find(args.domain.as_deref())?;
    let machine = found.machine()?;
    let name = found.name().to_owned();
    let channels: Vec<_> = of_machine(machine).collect();
    let mut run = found.attach("top", &channels)?;
    let names = Pipeline::of(machine)
        .stages
        .iter()
        .map(|p| p.name.to_owned())
        .collect();
    let mut seen = Screen(TopState::new(&name, names));
    if args.once {
        print_once(&mut run, &mut seen)
    } else {
        show(&name, &mut run, &mut seen)
    }
}

fn print_once(run: &mut Attached<Screen>, seen: &mut Screen) -> Result<(), Failure> {
    let begun = Instant::now();
    while begun.elapsed() < ONCE {
        run.drain(seen);
        std::thread::sleep(Duration::from_millis(10));
    }
    let backend = ratatui::backend::TestBackend::new(ONCE_SIZE.0, ONCE_SIZE.1);
    let mut terminal = ratatui::Terminal::new(backend).map_err(Failure::internal)?;
    terminal
        .draw(|frame| draw(frame, &seen.0))
        .map_err(Failure::internal)?;
    let buffer = terminal.backend().buffer();
    for row in buffer.content().chunks(usize::from(ONCE_SIZE.0)) {
        let line: String = row.iter().map(|cell| cell.symbol()).collect();
        println!("{}", line.trim_end());
    }
    Ok(())
}

fn show(name: &str, run: &mut Attached<Screen>, seen: &mut Screen) -> Result<(), Failure> {
    // A signal also restores the terminal.
    let stop = Signals::catch()?;
    let mut terminal = ratatui::try_init().map_err(|e| {
        Failure::input(
            format!("cannot draw here: {e}"),
            "the terminal",
            "use a terminal, or `heft top --once` for one picture as text",
        )
    })?;
    let mut looked = Instant::now();
    let result = loop {
        run.drain(seen);
        if let Err(e) = terminal.draw(|frame| draw(frame, &seen.0)) {
            break Err(Failure::internal(e));
        }
        if looked.elapsed() > Duration::from_secs(1) {
            looked = Instant::now();
            if !run.is_alive() {
                break Ok(());
            }
        }
        if stop.came() || wants_to_quit() {
            break Ok(());
        }
    };
    ratatui::restore();
    if result.is_ok() && !run.is_alive() {
        println!("the run `{name}` has ended");
    }
    result
}

/// Whether the user wants to quit, or the terminal is gone.
fn wants_to_quit() -> bool {
    match event::poll(PERIOD) {
        Ok(false) => return false,
        Ok(true) => {}
        Err(_) => return true,
    }
    match event::read() {
        Ok(Event::Key(key)) => {
            matches!(key.code, KeyCode::Char('q') | KeyCode::Esc)
                || (key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL))
        }
        Err(_) => true,
        Ok(_) => false,
    }
}
