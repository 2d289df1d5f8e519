//! Combines values with times of their own into rows.
//!
//! Times are nanoseconds since the first frame. A value belongs to the time at which it was
//! measured: its arrival minus its delay. A row waits until every value up to its time can
//! have come. Its content depends on the frames alone, so a live bus and its log give the same rows.

use std::collections::VecDeque;

use crate::map::Timing;

pub(crate) const SECOND: i64 = 1_000_000_000;
/// Time without a value after which rows come less often.
const SILENT: i64 = SECOND;
/// Period of the rows then.
const SILENT_PERIOD: i64 = SECOND / 10;
/// Time without a value after which there are no rows until the next value: a gap.
const GAP: i64 = 10 * SECOND;
/// Largest number of values that wait between two rows: more than any bus carries within the longest delay.
const MOST_WAITING: usize = 1 << 16;

/// The values of one signal, in the order of their times.
#[derive(Debug)]
pub(crate) struct Series {
    delay: i64,
    interpolate: bool,
    max_age: i64,
    /// A whole turn of an angle; infinite for what does not turn.
    turn: f64,
    values: VecDeque<(i64, f64)>,
}

impl Series {
    /// Without values; `hold` is the age limit if the timing has none [s]. Values that differ by a `turn` are the same.
    pub(crate) fn new(timing: &Timing, hold: f64, turn: f64) -> Self {
        Self {
            delay: nanoseconds(timing.delay),
            interpolate: timing.interpolate,
            max_age: nanoseconds(timing.max_age.unwrap_or(hold)),
            turn,
            values: VecDeque::new(),
        }
    }

    /// Time of measurement of a value that arrives at `arrival`.
    pub(crate) fn measured(&self, arrival: i64) -> i64 {
        arrival - self.delay
    }

    /// Takes a value; NaN means that there is none from now on. A value before the last one is too late, and ignored.
    pub(crate) fn push(&mut self, arrival: i64, value: f64) {
        let time = self.measured(arrival);
        if self.values.back().is_some_and(|(last, _)| time < *last) {
            return;
        }
        if self.values.len() >= MOST_WAITING {
            self.values.pop_front();
        }
        self.values.push_back((time, value));
    }

    /// Whether no value that arrives after `clock` can change the value at `time`.
    fn is_settled(&self, time: i64, clock: i64) -> bool {
        if clock - self.delay < time {
            return false;
        }
        match self.values.back() {
            Some((last, _)) if self.interpolate && *last < time => {
                clock - self.delay > last + self.max_age
            }
            _ => true,
        }
    }

    /// The value at `time`; NaN for none.
    pub(crate) fn at(&self, time: i64) -> f64 {
        let after = self.values.partition_point(|(t, _)| *t <= time);
        let Some((t0, before)) = after.checked_sub(1).and_then(|i| self.values.get(i)) else {
            return f64::NAN;
        };
        if *t0 == time {
            return *before;
        }
        match self.values.get(after) {
            Some((t1, next)) if self.interpolate && t1 - t0 <= self.max_age => {
                let share = (time - t0) as f64 / (t1 - t0) as f64;
                self.between(*before, *next, share)
            }
            _ if self.interpolate => f64::NAN,
            _ if time - t0 <= self.max_age => *before,
            _ => f64::NAN,
        }
    }

    /// Interpolates an angle the shorter way round: from 359 to 1 degrees over 0.
    fn between(&self, before: f64, next: f64, share: f64) -> f64 {
        let way = next - before;
        if way.abs() <= 0.5 * self.turn {
            return before + way * share;
        }
        let way = way - (way / self.turn).round() * self.turn;
        match share < 0.5 {
            true => before + way * share,
            false => next - way * (1.0 - share),
        }
    }

    /// Drops values that no row from `time` on needs.
    fn forget_before(&mut self, time: i64) {
        while self.values.get(1).is_some_and(|(t, _)| *t <= time) {
            self.values.pop_front();
        }
    }
}

fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// Times of the rows.
#[derive(Debug)]
pub(crate) struct Rows {
    grid: Option<Grid>,
    /// Waiting rows of the master, and the last one that was built.
    waiting: VecDeque<i64>,
    last: Option<i64>,
    /// Time after a row at which another one is added if the master is silent; none without such rows.
    pause: Option<i64>,
    /// End of the last gap.
    resumed: i64,
    /// Latest arrival of all frames, and of those with a value for the map.
    clock: i64,
    newest: Option<i64>,
}

/// Rows at a rate: row n is at n / rate.
#[derive(Debug)]
struct Grid {
    rate: f64,
    next: u64,
}

impl Grid {
    fn time(&self) -> i64 {
        nanoseconds(self.next as f64 / self.rate)
    }

    /// The first row at `time` or later.
    fn skip_to(&mut self, time: i64) {
        let row = (time as f64 / 1e9 * self.rate).ceil() as u64;
        self.next = self.next.max(row);
    }
}

/// Time of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowTime {
    /// [ns]
    pub ns: i64,
    /// [s]
    pub seconds: f64,
}

impl Rows {
    /// Rows only at the times of [`Rows::add`].
    pub(crate) fn of_table() -> Self {
        Self {
            pause: None,
            ..Self::new(None)
        }
    }

    /// Rows at `rate` [Hz], or at the times of [`Rows::add`] and during silence.
    pub(crate) fn new(rate: Option<f64>) -> Self {
        Self {
            grid: rate.map(|rate| Grid { rate, next: 0 }),
            waiting: VecDeque::new(),
            last: None,
            pause: Some(SILENT),
            resumed: i64::MIN,
            clock: 0,
            newest: None,
        }
    }

    /// The first frame comes at `clock`: there are no rows before it.
    pub(crate) fn begin_at(&mut self, clock: i64) {
        if let Some(grid) = &mut self.grid {
            grid.skip_to(clock);
        }
    }

    /// The time is `clock`: no frame from before will come.
    pub(crate) fn pass(&mut self, clock: i64) {
        self.clock = self.clock.max(clock);
    }

    /// A value has come at `clock`.
    pub(crate) fn hear(&mut self, clock: i64) {
        // Before the first value there is silence since 0.
        let silence = self.newest.unwrap_or(0) + GAP;
        self.newest = Some(self.newest.map_or(clock, |newest| newest.max(clock)));
        if self.empty().is_some_and(|empty| empty > silence) {
            self.resumed = clock;
        }
        if let Some(grid) = self.grid.as_mut().filter(|g| g.time() > silence) {
            grid.skip_to(clock);
        }
    }

    /// Time of the next row to add because the master is silent.
    fn empty(&self) -> Option<i64> {
        let (last, pause) = self.last.zip(self.pause)?;
        Some((last + pause).max(self.resumed))
    }

    /// Adds a row of the master at `time`.
    ///
    /// Returns false if it is not after the last one.
    pub(crate) fn add(&mut self, time: i64) -> bool {
        let last = self.waiting.back().copied().or(self.last);
        let is_next = self.grid.is_none() && last.is_none_or(|last| time > last);
        if is_next {
            self.waiting.push_back(time);
        }
        is_next
    }

    /// The next row that later values cannot change; at the end of the data, any that is due.
    pub(crate) fn next(&mut self, series: &mut [Series], at_end: bool) -> Option<RowTime> {
        let clock = self.clock;
        let is_settled =
            |time: i64, clock: i64| at_end || series.iter().all(|s| s.is_settled(time, clock));
        let silence = self.newest.unwrap_or(0) + GAP;
        let row = if let Some(grid) = &mut self.grid {
            let time = grid.time();
            let is_due = time < clock && time <= silence && is_settled(time, clock - 1);
            is_due.then(|| {
                let row = RowTime {
                    ns: time,
                    seconds: grid.next as f64 / grid.rate,
                };
                let thin = (grid.rate / 10.0).round().max(1.0) as u64;
                let is_silent = time > silence - GAP + SILENT;
                grid.next += if is_silent { thin } else { 1 };
                row
            })
        } else {
            let empty = self.empty();
            let next = self.waiting.front().copied();
            let is_empty_due = |time: &i64| {
                let first = next.is_none_or(|next| next > *time);
                first && *time < clock && *time <= silence && is_settled(*time, clock - 1)
            };
            if let Some(time) = empty.filter(is_empty_due) {
                self.pause = Some(SILENT_PERIOD);
                self.last = Some(time);
                Some(RowTime::at(time))
            } else if let Some(time) = next.filter(|time| is_settled(*time, clock)) {
                self.waiting.pop_front();
                self.pause = self.pause.and(Some(SILENT));
                self.last = Some(time);
                Some(RowTime::at(time))
            } else {
                None
            }
        }?;
        for series in series {
            series.forget_before(row.ns);
        }
        Some(row)
    }
}

impl RowTime {
    fn at(ns: i64) -> Self {
        Self {
            ns,
            seconds: ns as f64 / 1e9,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn series(delay: f64, interpolate: bool, max_age: f64) -> Series {
        let timing = Timing {
            delay,
            interpolate,
            max_age: Some(max_age),
        };
        Series::new(&timing, 1.0, f64::INFINITY)
    }

    /// The built rows of a series with a master, as (time [ms], value).
    fn drain(rows: &mut Rows, series: &mut Series, at_end: bool) -> Vec<(i64, f64)> {
        let mut found = Vec::new();
        let series = std::slice::from_mut(series);
        while let Some(row) = rows.next(series, at_end) {
            found.push((row.ns / MS, series[0].at(row.ns)));
        }
        found
    }

    #[test]
    fn an_angle_is_interpolated_over_the_shorter_way_round() {
        let at = |turn: f64, [from, to]: [f64; 2]| {
            let mut angle = series(0.0, true, 1.0);
            angle.turn = turn;
            angle.push(0, from);
            angle.push(10 * MS, to);
            [2, 5, 8].map(|ms| angle.at(ms * MS).rem_euclid(turn.min(1e9)))
        };
        for (found, expected) in [
            (at(360.0, [359.0, 1.0]), [359.4, 0.0, 0.6]),
            (at(360.0, [1.0, 359.0]), [0.6, 0.0, 359.4]),
            (at(360.0, [-170.0, 170.0]), [186.0, 180.0, 174.0]),
            (at(360.0, [10.0, 20.0]), [12.0, 15.0, 18.0]),
            (at(f64::INFINITY, [359.0, 9.0]), [289.0, 184.0, 79.0]),
        ] {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn a_delayed_value_belongs_to_the_time_of_its_measurement() {
        let (mut rows, mut late) = (Rows::new(None), series(0.03, false, 1.0));
        // A ramp of 1 per ms that arrives 30 ms late, each 10 ms; the master at the same instants.
        for n in 0..10 {
            let clock = n * 10 * MS;
            rows.pass(clock);
            rows.hear(clock);
            late.push(clock, (n * 10 - 30) as f64);
            rows.add(clock);
        }
        let found = drain(&mut rows, &mut late, false);
        assert_eq!(found.len(), 7, "the last three wait for what is under way");
        assert!(
            found.iter().all(|(time, value)| *time as f64 == *value),
            "{found:?}"
        );
    }

    #[test]
    fn a_line_between_two_values_waits_for_the_second_and_is_no_longer_than_its_limit() {
        let (mut rows, mut slow) = (Rows::new(None), series(0.0, true, 0.1));
        slow.push(0, 0.0);
        for n in 0..5 {
            rows.pass(n * 20 * MS);
            rows.hear(n * 20 * MS);
            rows.add(n * 20 * MS);
        }
        assert_eq!(drain(&mut rows, &mut slow, false), [(0, 0.0)]);
        slow.push(80 * MS, 8.0);
        let line = [(20, 2.0), (40, 4.0), (60, 6.0), (80, 8.0)];
        assert_eq!(drain(&mut rows, &mut slow, false), line);
        rows.pass(300 * MS);
        rows.add(290 * MS);
        slow.push(300 * MS, 9.0);
        let found = drain(&mut rows, &mut slow, false);
        assert!(
            matches!(found[..], [(290, value)] if value.is_nan()),
            "{found:?}"
        );
    }

    #[test]
    fn silence_is_reported_by_few_rows_and_a_gap_by_none() {
        for rate in [None, Some(100.0)] {
            let (mut rows, mut series) = (Rows::new(rate), series(0.0, false, 0.5));
            rows.hear(0);
            series.push(0, 1.0);
            rows.add(0);
            rows.pass(20 * 365 * 86_400 * SECOND);
            let before = drain(&mut rows, &mut series, false);
            let first = if rate.is_some() { 101 } else { 1 };
            assert!(
                (first + 85..first + 95).contains(&before.len()),
                "{}",
                before.len()
            );
            assert!(
                before
                    .iter()
                    .all(|(time, value)| value.is_nan() == (*time > 500))
            );
            assert!(
                before
                    .last()
                    .is_some_and(|(time, _)| (9_800..=10_000).contains(time))
            );
            rows.hear(20 * 365 * 86_400 * SECOND);
            rows.add(20 * 365 * 86_400 * SECOND);
            rows.pass(20 * 365 * 86_400 * SECOND + 15 * MS);
            let after = drain(&mut rows, &mut series, false);
            assert!((1..=2).contains(&after.len()), "{after:?}");
        }
    }

    #[test]
    fn the_time_before_a_first_value_that_comes_late_is_a_gap() {
        let (mut rows, mut series) = (Rows::new(Some(100.0)), series(0.0, false, 0.5));
        let late = 20 * 365 * 86_400 * SECOND;
        rows.pass(late);
        let before = drain(&mut rows, &mut series, false);
        assert!((100..200).contains(&before.len()), "{}", before.len());
        series.push(late, 1.0);
        rows.hear(late);
        rows.pass(late + 15 * MS);
        let after = drain(&mut rows, &mut series, false);
        assert!((1..=2).contains(&after.len()), "{after:?}");
    }

    #[test]
    fn rows_are_the_same_however_often_one_asks() {
        let run = |patient: bool| {
            let (mut rows, mut series) = (Rows::new(Some(100.0)), series(0.02, true, 0.2));
            let mut found = Vec::new();
            let mut arrival = 0;
            for n in 0..200_i64 {
                let next = arrival + (n * 7_919 % 90) * MS + if n == 100 { 14 * SECOND } else { 0 };
                while !patient && arrival < next {
                    arrival += MS / 2;
                    rows.pass(arrival);
                    found.extend(drain(&mut rows, &mut series, false));
                }
                arrival = next;
                rows.pass(arrival);
                found.extend(drain(&mut rows, &mut series, false));
                series.push(arrival, n as f64);
                rows.hear(arrival);
                found.extend(drain(&mut rows, &mut series, false));
            }
            let bits = |(time, value): (i64, f64)| (time, value.to_bits());
            found.into_iter().map(bits).collect::<Vec<_>>()
        };
        assert_eq!(run(true), run(false));
    }
}
