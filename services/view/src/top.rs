//! The terminal dashboard.

use std::time::{Duration, Instant};

use messages::channels::Channel;
use messages::{Message, fault};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Row, Sparkline, Table, Wrap};

use crate::estimate::Estimate;
use crate::judgement::Judgement;
use crate::monitor::{Each, MachineState, Monitor, ProcessState, TREND_PERIOD, Tracked};
use crate::number::{decimals, grouped, nanoseconds, unit, with_std};
use crate::report::state_name;
use crate::words::wrapped;

/// State of the dashboard.
#[derive(Debug, Clone)]
pub struct TopState {
    domain: String,
    monitor: Monitor,
    now: Instant,
}

impl TopState {
    /// An empty state of `domain`, with the processes' `names`.
    pub fn new(domain: &str, names: Vec<String>) -> Self {
        Self {
            domain: domain.to_owned(),
            monitor: Monitor::new(names),
            now: Instant::now(),
        }
    }

    /// Takes a message received at `now`.
    pub fn push<M: Message>(&mut self, channel: &Channel, message: &M, now: Instant) {
        self.monitor.push(channel, message, now);
        self.now = now;
    }
}

/// Period of the values of a trend [s].
const TREND_SECONDS: f64 = TREND_PERIOD.as_millis() as f64 / 1000.0;

/// Height of a terminal below which only the default method is shown [lines].
const SMALL: u16 = 34;

/// Draws the dashboard, with ages at the present time.
pub fn draw(frame: &mut Frame, state: &TopState) {
    let now = Instant::now().max(state.now);
    let is_small = frame.area().height < SMALL;
    let machines = state.monitor.machines.each(Verdicts);
    let verdicts = machines.into_iter().flat_map(|mut verdicts| {
        // The default method comes first; others only if there is room for trends and processes too.
        let default = verdicts.first().map(|v| v.source.clone());
        verdicts.retain(|v| !is_small || Some(&v.source) == default.as_ref());
        verdicts
    });
    let verdicts: Vec<Verdict> = verdicts.collect();
    let heights = Heights::of(frame.area(), &verdicts, &state.monitor);
    let parts = [1].iter().chain(&heights.verdicts).copied();
    let tables = [heights.processes, heights.channels];
    let parts = parts.chain(tables).map(Constraint::Length);
    let areas = Layout::vertical(parts.chain([Constraint::Min(0)])).split(frame.area());
    title(frame, areas[0], state);
    for (verdict, area) in verdicts.iter().zip(&areas[1..]) {
        verdict.draw(frame, *area, heights.trend);
    }
    let rest = 1 + verdicts.len();
    process_table(frame, areas[rest], &state.monitor, now);
    if heights.channels > 0 {
        channel_table(frame, areas[rest + 1], &state.monitor, now);
    }
}

/// Lines of each part below the title. Order of priority: values with all their reasons, processes, trends, channels.
struct Heights {
    verdicts: Vec<u16>,
    trend: bool,
    processes: u16,
    channels: u16,
}

impl Heights {
    fn of(area: Rect, verdicts: &[Verdict], monitor: &Monitor) -> Self {
        let rows = monitor.processes.len().max(1) as u16 + 1;
        let mut left = area.height.saturating_sub(1 + rows);
        // Each verdict has a title, and at least one line.
        let fair = (left / (verdicts.len().max(1) as u16)).max(2);
        let mut heights: Vec<u16> = verdicts
            .iter()
            .map(|v| {
                // The remedy is left out if there is no room for it.
                let whole = 1 + v.lines(area.width, true);
                let short = 1 + v.lines(area.width, false);
                if whole <= fair {
                    whole
                } else {
                    short.min(fair)
                }
            })
            .collect();
        left = left.saturating_sub(heights.iter().sum());
        let mut spare = |lines: u16| {
            let there = left >= lines;
            left -= if there { lines } else { 0 };
            there
        };
        let borders = spare(2);
        let trend = spare(verdicts.len() as u16);
        if trend {
            heights.iter_mut().for_each(|h| *h += 1);
        }
        // Head, a channel, and the frame.
        let channels = monitor.channels.len().max(1) as u16 + 3;
        Self {
            verdicts: heights,
            trend,
            processes: rows + if borders { 2 } else { 0 },
            channels: if left >= 4 { channels.min(left) } else { 0 },
        }
    }
}

fn title(frame: &mut Frame, area: Rect, state: &TopState) {
    let waiting = if state.monitor.channels.is_empty() {
        "   waiting for the first message"
    } else {
        ""
    };
    let simulated = if state.monitor.is_simulated {
        "   simulated"
    } else {
        ""
    };
    let text = format!(
        "heft top   {}   t = {:.1} s{simulated}{waiting}   q ends",
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
    /// Last trusted value and its age, if the present one is not trusted.
    last: Option<String>,
    trend: Trend,
}

/// A quantity over the last seconds.
struct Trend {
    values: Vec<f64>,
    unit: String,
}

/// The verdicts of a machine, trend included.
struct Verdicts;

impl Each for Verdicts {
    type Output = Vec<Verdict>;

    fn of<E: Estimate>(&mut self, state: &MachineState<E>) -> Vec<Verdict> {
        state
            .estimators
            .iter()
            .rev()
            .flat_map(|(channel, tracked)| {
                let judgements = tracked.last.judgements().into_iter().enumerate();
                judgements.map(move |(i, judgement)| Verdict {
                    source: format!("{channel}, {}", tracked.last.method_name()),
                    last: last_trusted(tracked, i).filter(|_| !judgement.trusted),
                    judgement,
                    trend: trend(tracked, i),
                })
            })
            .collect()
    }
}

/// "8 020 ± 160 kg m², 3.2 s ago".
fn last_trusted<E: Estimate>(tracked: &Tracked<E>, index: usize) -> Option<String> {
    let parameter = E::headlines().nth(index)?;
    let last = tracked.trusted.get(index)?.as_ref()?;
    let age = tracked.last.stamp().time - last.stamp().time;
    let value = with_std(
        parameter.value(last),
        parameter.std(last),
        &unit(parameter.unit),
    );
    Some(format!("{value}, {} s ago", grouped(age, 1)))
}

/// Headline parameter `index` over the last seconds.
fn trend<E: Estimate>(tracked: &Tracked<E>, index: usize) -> Trend {
    let values = tracked.trend.iter().filter_map(|v| v.get(index).copied());
    let headline = E::headlines().nth(index);
    Trend {
        values: values.filter(|v| v.is_finite()).collect(),
        unit: headline.map_or(String::new(), |p| unit(p.unit)),
    }
}

/// Columns of the axis of a trend.
const AXIS: u16 = 34;

impl Trend {
    /// The newest values that fit into `columns`: their axis in words (lowest, highest, unit, seconds), and each value scaled
    /// from the lowest (1) to the highest (100).
    fn shown(&self, columns: u16) -> (String, Vec<u64>) {
        let newest = self.values.len().saturating_sub(usize::from(columns));
        let values = &self.values[newest..];
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if values.is_empty() {
            return (String::new(), Vec::new());
        }
        let span = (high - low).max(1e-9 * high.abs()).max(f64::MIN_POSITIVE);
        let height = |v: &f64| 1 + (99.0 * (v - low) / span) as u64;
        let places = decimals(span / 10.0);
        let seconds = (values.len() as f64 * TREND_SECONDS).round();
        let (low, high) = (grouped(low, places), grouped(high, places));
        let axis = format!("{low} to {high} {}", self.unit);
        (
            format!("{}, {seconds} s", axis.trim_end()),
            values.iter().map(height).collect(),
        )
    }
}

impl Verdict {
    /// Emphasised text (the last trusted value if it is not the present one), and explanation: reasons, and the remedy if
    /// `is_whole`.
    fn words(&self, is_whole: bool) -> (String, String) {
        let value = &self.judgement.value;
        let mut verdict = self.judgement.verdict();
        if is_whole {
            verdict = format!("{verdict} {}", self.judgement.what_to_do());
        }
        let verdict = verdict.trim_end();
        match &self.last {
            Some(last) => (
                format!("Last trusted: {last}. "),
                format!("Now: {value}. {verdict}"),
            ),
            None => (format!("{value}. "), verdict.to_owned()),
        }
    }

    /// Number of lines of its words.
    fn lines(&self, width: u16, is_whole: bool) -> u16 {
        let (bold, plain) = self.words(is_whole);
        wrapped(&(bold + &plain), usize::from(width)).len() as u16
    }

    fn draw(&self, frame: &mut Frame, area: Rect, trend: bool) {
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
            Layout::vertical([Constraint::Min(1), Constraint::Length(u16::from(trend))])
                .areas(inner);
        let (bold, plain) = self.words(self.lines(words.width, true) <= words.height);
        let value = Span::styled(bold, Style::new().add_modifier(Modifier::BOLD));
        let text = Line::from(vec![value, Span::raw(plain)]);
        frame.render_widget(Paragraph::new(text).wrap(Wrap { trim: true }), words);
        if !trend {
            return;
        }
        let [marks, bars] =
            Layout::horizontal([Constraint::Length(AXIS), Constraint::Min(0)]).areas(line);
        let (axis, heights) = self.trend.shown(bars.width);
        let dim = Style::new().add_modifier(Modifier::DIM);
        frame.render_widget(Paragraph::new(axis).style(dim), marks);
        let sparkline = Sparkline::default()
            .data(&heights)
            .max(100)
            .style(Style::new().fg(colour));
        frame.render_widget(sparkline, bars);
    }
}

/// Columns of the process table with their widths; marked columns are shown only if there is room.
const PROCESS_COLUMNS: [(&str, u16, bool); 11] = [
    ("process", 8, false),
    ("state", 8, false),
    ("Hz", 7, false),
    ("age p50", 8, false),
    ("age p99.9", 9, false),
    ("step p50", 8, true),
    ("late", 6, true),
    ("lost", 6, false),
    ("restarts", 8, false),
    ("silent", 7, true),
    ("fault", 16, false),
];
/// Width of all columns.
const WIDE: u16 = 104;

fn process_table(frame: &mut Frame, area: Rect, monitor: &Monitor, now: Instant) {
    let shown = |i: &usize| area.width >= WIDE || !PROCESS_COLUMNS[*i].2;
    let columns: Vec<usize> = (0..PROCESS_COLUMNS.len()).filter(shown).collect();
    let rows = monitor.processes.iter().map(|(i, p)| {
        let (cells, style) = process_row(&monitor.name(*i), p, now);
        Row::new(
            columns
                .iter()
                .map(|i| cells[*i].clone())
                .collect::<Vec<_>>(),
        )
        .style(style)
    });
    let widths = columns
        .iter()
        .map(|i| Constraint::Length(PROCESS_COLUMNS[*i].1));
    let names: Vec<&str> = columns.iter().map(|i| PROCESS_COLUMNS[*i].0).collect();
    let count = monitor.processes.len().max(1) as u16;
    let table = Table::new(rows, widths).header(header(&names));
    if area.height >= count + 3 {
        frame.render_widget(table.block(Block::bordered().title(" processes ")), area);
    } else {
        frame.render_widget(table, area);
    }
}

fn header<'a>(names: &[&'a str]) -> Row<'a> {
    Row::new(names.to_vec()).style(Style::new().add_modifier(Modifier::DIM))
}

/// Silence after which a report is stale: a process reports some times a second.
const SILENT: Duration = Duration::from_secs(2);

fn process_row(name: &str, p: &ProcessState, now: Instant) -> ([String; 11], Style) {
    let (h, ns) = (&p.health, |ns: u64| nanoseconds(ns as f64));
    let trouble = h.lost > 0 || h.restarts > 0 || h.fault != fault::NONE;
    let fault = if h.fault == fault::NONE {
        ""
    } else {
        fault::text(h.fault)
    };
    let is_silent = now.saturating_duration_since(p.seen) > SILENT;
    let style = if trouble || is_silent {
        Style::new().fg(Color::Yellow)
    } else {
        Style::new()
    };
    let (state, rate) = if is_silent {
        ("silent".to_owned(), "-".to_owned())
    } else {
        (state_name(h.state).to_owned(), grouped(p.rate(), 0))
    };
    let cells = [
        name.to_owned(),
        state,
        rate,
        ns(h.age_p50_ns),
        ns(h.age_p999_ns),
        ns(h.step_p50_ns),
        h.late.to_string(),
        h.lost.to_string(),
        h.restarts.to_string(),
        silent(p.seen, now),
        fault.to_owned(),
    ];
    (cells, style)
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
