//! Gaps in the times of an input.

use crate::Finding;

/// Step of the times above which there is a gap \[s\].
const LONG: f64 = 10.0;
/// Step back above which a row was not merely late: a clock was set, or another recording begins \[s\].
const BACK: f64 = 1.0;
/// Least ratio of a gap to the shortest step.
const MANY: f64 = 100.0;
/// Apparent seconds from 59 of a minute to 0 of the next, if times are written as the digits of hours, minutes and seconds. At a new
/// hour there are 4000 more.
const MINUTE: f64 = 40.0;
const HOUR: f64 = 4000.0;

/// Rows without a jump of their times.
#[derive(Debug, Default, Clone, Copy)]
struct Stretch {
    /// Times of the first and the last row \[s\].
    begin: f64,
    end: f64,
    rows: u64,
}

impl Stretch {
    fn from(time: f64) -> Self {
        Self {
            begin: time,
            end: time,
            rows: 1,
        }
    }

    /// Whether these rows end where the other ones begin: both are parts of the same recording, in the wrong order.
    fn belongs_before(&self, other: &Self) -> bool {
        let are_parts = [self, other]
            .iter()
            .all(|part| part.end - part.begin > BACK);
        are_parts && (0.0..=LONG).contains(&(other.begin - self.end))
    }
}

/// Gaps in the times up to now.
#[derive(Debug, Default)]
pub struct Gaps {
    last: Option<f64>,
    /// The rows since the last jump of the times, and those before it if the times jumped back.
    stretch: Stretch,
    before: Option<Stretch>,
    /// A stretch that comes after the rows that it belongs before, and these rows.
    misplaced: Option<[Stretch; 2]>,
    /// The shortest step \[s\].
    shortest: Option<f64>,
    count: u64,
    /// Number of gaps from the end of a minute to the next, as in `hhmmss`.
    at_minutes: u64,
    longest: f64,
    /// Begin of the longest one.
    at: f64,
    /// Number of steps back; time before the first one, and its size \[s\].
    back: u64,
    first_back: [f64; 2],
}

impl Gaps {
    /// Takes the time of a row \[s\].
    pub fn see(&mut self, time: f64) {
        if !time.is_finite() {
            return;
        }
        if self.last.is_none() {
            self.stretch = Stretch::from(time);
        }
        let last = self.last.replace(time).unwrap_or(time);
        let gap = time - last;
        if gap < -BACK {
            self.misplaced = self.misplaced();
            self.before = Some(self.stretch);
            self.stretch = Stretch::from(time);
            if self.back == 0 {
                self.first_back = [last, -gap];
            }
            self.back += 1;
        }
        if gap <= 0.0 {
            return;
        }
        self.stretch.end = time;
        self.stretch.rows += 1;
        let shortest = self.shortest.map_or(gap, |shortest| shortest.min(gap));
        self.shortest = Some(shortest);
        if gap <= LONG.max(MANY * shortest) {
            return;
        }
        self.count += 1;
        self.stretch.end = last;
        self.stretch.rows -= 1;
        self.misplaced = self.misplaced();
        self.before = None;
        self.stretch = Stretch::from(time);
        let of_minute = time % 100.0;
        let is_at_minute = last % 100.0 < 60.0 && of_minute < LONG;
        let without = (gap - MINUTE).rem_euclid(HOUR);
        self.at_minutes += u64::from(is_at_minute && without < LONG);
        if gap > self.longest {
            (self.longest, self.at) = (gap, last);
        }
    }

    fn misplaced(&self) -> Option<[Stretch; 2]> {
        let latest = self.before.map(|before| [self.stretch, before]);
        let latest = latest.filter(|[part, before]| part.belongs_before(before));
        self.misplaced.or(latest)
    }

    /// Whether the times go back.
    pub fn goes_back(&self) -> bool {
        self.back > 0
    }

    /// Message on gaps and steps back.
    pub fn words(&self) -> Option<String> {
        let (longest, at) = (self.longest, self.at);
        // An implausible time would fill three lines with its digits.
        let digits = |number: f64, plain: String| match number.abs() {
            ..1e10 => plain,
            _ => format!("{number:e}"),
        };
        let back = (self.back > 0).then(|| {
            let [at, by] = self.first_back;
            format!(
                "the times go back by {} s behind t = {}, {} in all: are these several recordings, or was the clock set? estimate each part by itself",
                digits(by, format!("{by:.0}")),
                digits(at, at.to_string()),
                match self.back {
                    1 => "once".into(),
                    count => format!("{count} times"),
                }
            )
        });
        let gaps = (self.count > 0).then(|| {
            let longest = digits(longest, format!("{longest:.0}"));
            let at = digits(at, at.to_string());
            format!(
                "the times have {} of more than {LONG} s, the longest of {longest} s behind t = {at}: was the logger off, or its clock set?",
                match self.count {
                    1 => "a gap".into(),
                    count => format!("{count} gaps"),
                }
            )
        });
        match (gaps, back) {
            (Some(gaps), Some(back)) => Some(format!("{gaps}\n{back}")),
            (gaps, back) => gaps.or(back),
        }
    }

    /// Why the times are not in seconds or not in order, and the remedy.
    pub fn fault(&self) -> Option<Finding> {
        if let Some([part, before]) = self.misplaced() {
            return Some(Finding::new(
                format!(
                    "the rows are not in the order of their times: behind t = {} come {} rows from {} to {}, which belong before t = {}",
                    before.end, part.rows, part.begin, part.end, before.begin
                ),
                "sort the rows by their time, or put the parts in order; what is estimated across the seam is of no use",
            ));
        }
        (self.count > 1 && self.at_minutes == self.count).then(|| {
            Finding::new(
                format!("the times seem to be written as hhmmss: they skip {MINUTE} s at each full minute"),
                "write them with colons (01:02:03.5), or in seconds",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(times: impl Iterator<Item = f64>) -> Gaps {
        let mut gaps = Gaps::default();
        times.for_each(|time| gaps.see(time));
        gaps
    }

    #[test]
    fn times_that_go_back_are_named_and_rows_that_arrive_late_are_not() {
        let rows = |k: u32| f64::from(k) / 100.0;
        let twice = (0..3000).chain(0..3000).map(rows);
        let said = of(twice).words().unwrap_or_default();
        assert!(
            said.starts_with("the times go back by 30 s behind t = 29.99, once"),
            "{said}"
        );
        let set = (0..2000).chain(1700..3000).map(rows);
        let said = of(set).words().unwrap_or_default();
        assert!(said.contains("go back by 3 s"), "{said}");
        assert_eq!(of((0..3000).map(|k| rows(k ^ 7))).words(), None);
    }

    #[test]
    fn parts_in_the_wrong_order_are_a_fault_and_a_clock_that_was_set_is_none() {
        let rows = |k: u32| f64::from(k) / 100.0;
        let fault = of((2000..4000).chain(0..2000).map(rows)).fault();
        let fault = fault.expect("halves in the wrong order").to_string();
        for words in [
            "behind t = 39.99 come 2000 rows from 0 to 19.99, which belong before t = 20",
            "sort the rows",
        ] {
            assert!(fault.contains(words), "{fault}");
        }
        // Three parts, the last two exchanged, followed by a fourth.
        let parts = [0..2000, 6000..8000, 4000..6000, 9000..9500];
        let fault = of(parts.into_iter().flatten().map(rows)).fault();
        assert!(
            fault.is_some_and(|said| said.what.contains("2000 rows from 40 to 59.99")),
            "the middle"
        );
        let in_order: [Vec<u32>; 5] = [
            // Twice the same, a clock that is set back by a little and by years, one wrong time at the begin, late rows.
            (0..3000).chain(0..3000).collect(),
            (0..2000).chain(1700..3000).collect(),
            (900_000_000..900_003_000).chain(0..3000).collect(),
            [3000].into_iter().chain(0..3000).collect(),
            (0..3000).map(|k| k ^ 7).collect(),
        ];
        for times in in_order {
            assert_eq!(of(times.into_iter().map(rows)).fault(), None);
        }
    }

    #[test]
    fn times_written_as_hours_minutes_and_seconds_are_distinguished_from_a_logger_that_was_off() {
        let digits = |t: f64| {
            let (hours, minutes) = ((t / 3600.0).floor(), (t / 60.0).floor() % 60.0);
            10_000.0 * hours + 100.0 * minutes + t % 60.0
        };
        let day = |from: f64| (0..20_000).map(move |i| from + 0.01 * f64::from(i));
        let found = of(day(7100.0).map(digits));
        assert!(
            found
                .fault()
                .is_some_and(|said| said.what.contains("hhmmss")),
            "{found:?}"
        );
        let off = of(day(7100.0).map(|t| if t > 7150.0 { t + 3600.0 } else { t }));
        assert_eq!(off.fault(), None);
        assert!(off.words().is_some_and(
            |said| said.contains("a gap of more") && said.contains("of 3600 s behind t = 7150")
        ));
        let torn = of([0.0, 0.01, 1e308].into_iter());
        assert!(
            torn.words()
                .is_some_and(|said| said.contains("of 1e308 s behind t = 0.01:"))
        );
        for whole in [
            of(day(0.0)),
            of(day(0.0).map(|t| 1000.3 * t)),
            of([f64::NAN, 1.0, 0.5, 2.0].into_iter()),
        ] {
            assert_eq!((whole.words(), whole.fault()), (None, None));
        }
    }
}
