//! Contents of the terminal dashboard, on a terminal in memory.

mod common;

use std::time::{Duration, Instant};

use messages::channels;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use view::top::{TopState, draw};

fn screen(state: &TopState, width: u16, height: u16) -> String {
    let mut terminal =
        Terminal::new(TestBackend::new(width, height)).expect("a terminal in memory");
    terminal.draw(|frame| draw(frame, state)).expect("drawn");
    let buffer = terminal.backend().buffer();
    let rows = buffer.content().chunks(usize::from(width));
    let lines: Vec<String> = rows
        .map(|r| r.iter().map(|c| c.symbol()).collect())
        .collect();
    lines.join("\n").replace('\u{a0}', " ")
}

fn running() -> TopState {
    let mut state = TopState::new("test", common::PROCESSES.map(str::to_owned).to_vec());
    let (start, mut noise) = (Instant::now() - Duration::from_secs(4), common::Noise(5));
    for n in (0..400).filter(|n| *n != 100) {
        let now = start + Duration::from_millis(10 * n as u64);
        let estimate = common::excavator_estimate(n, 100.0, &mut noise, false);
        state.push(&channels::EXCAVATOR_INERTIA_UKF, &estimate, now);
        state.push(
            &channels::LOADER_CG_UKF,
            &common::loader_estimate(n, 100.0, &mut noise, 0),
            now,
        );
        for process in 0..5 {
            state.push(&channels::HEALTH, &common::health(process, n as u64), now);
        }
    }
    state
}

#[test]
fn the_dashboard_shows_verdicts_processes_rates_ages_and_losses() {
    let text = screen(&running(), 110, 44);
    println!("{text}");
    for part in [
        "heft top   test",
        "trusted  excavator/inertia_ukf, posture-torque",
        "The swing inertia is",
        "heft trusts it",
        "above the ground",
        "heft does not trust it, because",
        "kalman",
        "running",
        "22.0 µs",
        "95.0 µs",
        "loader/cg_ukf",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert!(text.chars().any(|c| "▁▂▃▄▅▆▇█".contains(c)), "a sparkline");
    let row = text
        .lines()
        .find(|l| l.contains("│excavator/inertia_ukf"))
        .expect("a row for the channel");
    assert!(
        row.contains("100") && row.split_whitespace().any(|w| w == "1"),
        "100 Hz, one lost: {row}"
    );
}

#[test]
fn on_a_small_terminal_every_value_has_its_reason_and_no_line_is_cut() {
    let text = screen(&running(), 80, 24);
    for part in [
        "The swing inertia is",
        "heft trusts it:",
        "heft does not trust it, because",
        "kalman",
        "age p99.9",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    // A truncated sentence would have no full stop: three verdicts end with one, each at the end of a line.
    let ends = |line: &&str| line.trim_end().ends_with(").") || line.trim_end().ends_with('.');
    assert!(text.lines().filter(ends).count() >= 3, "{text}");
}

#[test]
fn on_a_small_terminal_a_trend_has_its_range_its_unit_and_its_time() {
    let mut state = TopState::new("test", common::PROCESSES.map(str::to_owned).to_vec());
    let (start, mut noise) = (Instant::now() - Duration::from_secs(9), common::Noise(5));
    for n in 0..900 {
        let now = start + Duration::from_millis(10 * n as u64);
        for (channel, paper) in [
            (&channels::EXCAVATOR_INERTIA_RLS, true),
            (&channels::EXCAVATOR_INERTIA_UKF, false),
        ] {
            let estimate = common::excavator_estimate(n, 100.0, &mut noise, paper);
            state.push(channel, &estimate, now);
        }
        state.push(&channels::HEALTH, &common::health(0, n as u64), now);
    }
    let text = screen(&state, 80, 24);
    let bar = |c: char| "▁▂▃▄▅▆▇█".contains(c);
    let line = text.lines().find(|l| l.contains(bar));
    let line = line.unwrap_or_else(|| panic!("a trend in\n{text}"));
    assert!(line.contains(" to ") && line.contains("kg m²"), "{text}");
    // 46 columns of a tenth of a second, scaled to the visible range.
    assert!(line.contains("5 s") && line.contains('█'), "{text}");
    assert!(
        !text.contains("inertia_rls, "),
        "the default method alone: {text}"
    );
}

#[test]
fn an_empty_state_and_a_tiny_terminal_can_be_drawn() {
    let empty = TopState::new("test", Vec::new());
    assert!(screen(&empty, 80, 24).contains("waiting for the first message"));
    for (width, height) in [(1, 1), (20, 5), (40, 12)] {
        screen(&running(), width, height);
    }
}
