//! The live line of a run.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use super::Watch;
use crate::out::Plain;
use crate::tally::Tally;

const SHOW_PERIOD: Duration = Duration::from_millis(200);
const PLAIN_PERIOD: Duration = Duration::from_secs(5);

/// Columns where there is no terminal to ask.
const WIDTH: usize = 80;
/// Columns that the program which draws the lines needs before them.
const PREFIX: usize = 10;

/// First word of a live line on standard output.
pub const LIVE: &str = "live ";

/// First word of a line that stays on the terminal.
pub const STORY: &str = "story ";

/// Where the live line goes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Show {
    /// Nowhere.
    #[default]
    Nothing,
    /// To the terminal, redrawn in place; if there is none, a plain line at intervals.
    Terminal,
    /// To standard output, one line each, for a program that draws them.
    Lines,
}

impl Watch {
    /// Draws the live line, at a limited rate.
    pub(super) fn draw(&mut self) {
        if self.show == Show::Nothing || self.tallies().is_empty() {
            return;
        }
        let in_place = self.show == Show::Terminal && std::io::stderr().is_terminal();
        let period = if in_place || self.show == Show::Lines {
            SHOW_PERIOD
        } else {
            PLAIN_PERIOD
        };
        if self
            .shown
            .or(self.begun)
            .is_some_and(|t| t.elapsed() < period)
        {
            return;
        }
        self.shown = Some(Instant::now());
        let terminal = ratatui::crossterm::terminal::size();
        let columns = terminal.map_or(WIDTH, |(columns, _)| usize::from(columns));
        // Only a line that is drawn again must not wrap.
        let width = if self.show == Show::Terminal && !in_place {
            usize::MAX
        } else {
            columns
        };
        let prefix = if self.show == Show::Lines { PREFIX } else { 0 };
        let width = width.saturating_sub(prefix + 1);
        let line = match (self.show, &self.loads) {
            (Show::Lines, Some(loads)) => self.story.now(&loads.lock()),
            _ => self.line(width),
        };
        let line: String = line.chars().take(width).collect();
        let mut err = std::io::stderr().lock();
        // A closed terminal does not end a run.
        let _ = match self.show {
            Show::Lines => writeln!(std::io::stdout(), "{LIVE}{line}"),
            _ if in_place => write!(err, "\r\x1b[2K{line}").and_then(|()| err.flush()),
            _ => writeln!(err, "{line}"),
        };
    }

    /// Shows an event of a load, for a program that prints them.
    pub(super) fn show_story(&self, line: Option<String>) {
        if let (Show::Lines, Some(line)) = (self.show, line) {
            let _ = writeln!(std::io::stdout(), "{STORY}{line}");
        }
    }

    /// Prints a line once, above the live line.
    pub(super) fn say(&self, text: &str) {
        if self.show != Show::Terminal {
            return;
        }
        let clear = if std::io::stderr().is_terminal() {
            "\r\x1b[2K"
        } else {
            ""
        };
        let _ = writeln!(std::io::stderr(), "{clear}{}", Plain(text));
    }

    /// Ends the live line.
    pub(super) fn end(&self) {
        if self.show == Show::Terminal && self.shown.is_some() && std::io::stderr().is_terminal() {
            eprintln!();
        }
    }

    /// Time, quantities, losses, latency, as far as `width` goes: a line that wraps
    /// cannot be drawn again in place.
    fn line(&self, width: usize) -> String {
        let time = self.headline().next().map_or(0.0, |s| s.latest.time);
        let mut parts = vec![format!("{time:5.1} s")];
        parts.extend(self.is_simulated.then(|| "simulated".to_owned()));
        parts.extend(self.headline().map(Tally::short));
        if self.processes.lost() > 0 {
            parts.push(format!("lost {}", self.processes.lost()));
        }
        if let Some(health) = self
            .processes
            .pipeline()
            .and_then(|p| self.processes.health(p.main))
        {
            parts.push(format!(
                "answers within {:.1} ms",
                health.age_p99_ns as f64 / 1e6
            ));
        }
        let mut line = String::new();
        for part in parts {
            let gap = if line.is_empty() { "" } else { "  " };
            if line.chars().count() + gap.len() + part.chars().count() <= width {
                line = line + gap + &part;
            }
        }
        line
    }
}
