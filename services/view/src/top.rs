//! The terminal dashboard: for those who have only a terminal.

use std::time::Instant;

use messages::channels::Channel;
use messages::{Message, fault};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Row, Sparkline, Table, Wrap};

use crate::estimate::Estimate;
use crate::monitor::{MachineState, Monitor, ProcessState, Tracked};
use crate::number::{grouped, nanoseconds};
use crate::report::state_name;
use crate::words::Judgement;

/// Lines of an estimator's verdict under its title: value and reasons (three lines at 80 columns), sparkline.
const VERDICT_LINES: u16 = 5;
/// The least: the value with the beginning of the reasons, and the sparkline.
const LEAST_VERDICT_LINES: u16 = 2;

/// What the dashboard knows.
#[derive(Debug, Clone)]
pub struct TopState {
    domain: String,
    monitor: Monitor,
    now: Instant,
}

impl TopState {
    /// Nothing seen yet of `domain`, whose processes are called by `names`.
    #[must_use]
    pub fn new(domain: &str, names: Vec<String>) -> Self {
        Self {
            domain: domain.to_owned(),
            monitor: Monitor::new(names),
            now: Instant::now(),
        }
    }

    /// Takes note of a message that came at `now`.
    pub fn push<M: Message>(&mut self, channel: &Channel, message: &M, now: Instant) {
        self.monitor.push(channel, message, now);
        self.now = now;
    }
}

/// Draws the dashboard; ages are told up to the present.
pub fn draw(frame: &mut Frame, state: &TopState) {
    let now = Instant::now().max(state.now);
    let verdicts = verdicts(&state.monitor.excavator).chain(verdicts(&state.monitor.loader));
    let verdicts: Vec<_> = verdicts.collect();
    let processes = state.monitor.processes.len().max(1) as u16 + 3;
    let channels = state.monitor.channels.len().max(1) as u16 + 3;
    let lines = verdict_lines(
        frame.area().height.saturating_sub(1 + processes + channels),
        verdicts.len() as u16,
    );
    let mut heights = vec![Constraint::Length(1)];
    heights.extend(verdicts.iter().map(|_| Constraint::Length(lines + 1)));
    heights.extend([
        Constraint::Length(processes),
        Constraint::Length(channels),
        Constraint::Min(0),
    ]);
    let areas = Layout::vertical(heights).split(frame.area());
    title(frame, areas[0], state);
    for (verdict, area) in verdicts.iter().zip(&areas[1..]) {
        verdict.draw(frame, *area);
    }
    let rest = 1 + verdicts.len();
    process_table(frame, areas[rest], &state.monitor, now);
    channel_table(frame, areas[rest + 1], &state.monitor, now);
}

/// Lines of each verdict under its title where `room` lines are left for all of them.
fn verdict_lines(room: u16, verdicts: u16) -> u16 {
    (room / verdicts.max(1))
        .saturating_sub(1)
        .clamp(LEAST_VERDICT_LINES, VERDICT_LINES)
}

fn title(frame: &mut Frame, area: Rect, state: &TopState) {
    let waiting = if state.monitor.channels.is_empty() {
        "   waiting for the first message"
    } else {
        ""
    };
    let text = format!(
        "heft top   {}   t = {:.1} s{waiting}   q ends",
        state.domain, state.monitor.time
    );
    frame.render_widget(
        Paragraph::new(text).style(Style::new().add_modifier(Modifier::BOLD)),
        area,
    );
}

/// One quantity of one estimator.
struct Verdict {
    source: String,
    judgement: Judgement,
    trend: Vec<u64>,
}

/// The verdicts of a machine, trend included.
fn verdicts<E: Estimate>(state: &MachineState<E>) -> impl Iterator<Item = Verdict> {
    state
        .estimators
        .iter()
        .rev()
        .flat_map(|(channel, tracked)| {
            let judgements = tracked.last.judgements().into_iter().enumerate();
            judgements.map(move |(i, judgement)| Verdict {
                source: format!("{channel}, {}", tracked.last.method_name()),
                judgement,
                trend: trend(tracked, i),
            })
        })
}

/// Headline parameter `index` from its lowest (1) to its highest (100) over the last seconds.
fn trend<E: Estimate>(tracked: &Tracked<E>, index: usize) -> Vec<u64> {
    let values = tracked.trend.iter().filter_map(|v| v.get(index).copied());
    let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let span = (high - low).max(1e-9 * high.abs()).max(f64::MIN_POSITIVE);
    values
        .iter()
        .map(|v| 1 + (99.0 * (v - low) / span) as u64)
        .collect()
}

impl Verdict {
    fn draw(&self, frame: &mut Frame, area: Rect) {
        let colour = if self.judgement.trusted {
            Color::Green
        } else {
            Color::Yellow
        };
        let word = if self.judgement.trusted {
            " trusted "
        } else {
            " not trusted "
        };
        let head = Line::from(vec![
            Span::styled(word, Style::new().fg(Color::Black).bg(colour)),
            Span::raw(format!(" {} ", self.source)),
        ]);
        let block = Block::default().title(head);
        let inner = block.inner(area);
        frame.render_widget(block, area);
        let [words, line] =
            Layout::vertical([Constraint::Min(1), Constraint::Length(1)]).areas(inner);
        let value = Span::styled(
            format!("{}. ", self.judgement.value),
            Style::new().add_modifier(Modifier::BOLD),
        );
        let text = Line::from(vec![value, Span::raw(self.judgement.verdict())]);
        frame.render_widget(Paragraph::new(text).wrap(Wrap { trim: true }), words);
        let shown = self.trend.len().saturating_sub(usize::from(line.width));
        let sparkline = Sparkline::default()
            .data(&self.trend[shown..])
            .style(Style::new().fg(colour));
        frame.render_widget(sparkline, line);
    }
}

fn process_table(frame: &mut Frame, area: Rect, monitor: &Monitor, now: Instant) {
    let head = [
        "process",
        "state",
        "Hz",
        "age p50",
        "age p99.9",
        "step p50",
        "late",
        "lost",
        "restarts",
        "silent",
        "fault",
    ];
    let rows = monitor
        .processes
        .iter()
        .map(|(i, p)| process_row(&monitor.name(*i), p, now));
    let widths = [9, 9, 7, 9, 9, 9, 7, 7, 8, 7, 20].map(Constraint::Length);
    let table = Table::new(rows, widths).header(header(&head));
    frame.render_widget(table.block(Block::bordered().title(" processes ")), area);
}

fn header<'a>(names: &[&'a str]) -> Row<'a> {
    Row::new(names.to_vec()).style(Style::new().add_modifier(Modifier::DIM))
}

fn process_row(name: &str, p: &ProcessState, now: Instant) -> Row<'static> {
    let (h, ns) = (&p.health, |ns: u64| nanoseconds(ns as f64));
    let trouble = h.lost > 0 || h.restarts > 0 || h.fault != fault::NONE;
    let fault = if h.fault == fault::NONE {
        ""
    } else {
        fault::text(h.fault)
    };
    let style = if trouble {
        Style::new().fg(Color::Yellow)
    } else {
        Style::new()
    };
    Row::new(vec![
        name.to_owned(),
        state_name(h.state).to_owned(),
        grouped(p.rate(), 0),
        ns(h.age_p50_ns),
        ns(h.age_p999_ns),
        ns(h.step_p50_ns),
        h.late.to_string(),
        h.lost.to_string(),
        h.restarts.to_string(),
        silent(p.seen, now),
        fault.to_owned(),
    ])
    .style(style)
}

fn silent(seen: Instant, now: Instant) -> String {
    format!("{:.1} s", now.saturating_duration_since(seen).as_secs_f64())
}

fn channel_table(frame: &mut Frame, area: Rect, monitor: &Monitor, now: Instant) {
    let head = ["channel", "Hz", "received", "lost", "silent"];
    let row = |(name, c): (&&'static str, &crate::monitor::ChannelState)| {
        let counts = [
            grouped(c.rate(), 0),
            c.count.to_string(),
            c.lost.to_string(),
            silent(c.seen, now),
        ];
        Row::new([(*name).to_owned()].into_iter().chain(counts))
    };
    let widths = [24, 8, 10, 8, 8].map(Constraint::Length);
    let table = Table::new(monitor.channels.iter().map(row), widths).header(header(&head));
    frame.render_widget(table.block(Block::bordered().title(" channels ")), area);
}
