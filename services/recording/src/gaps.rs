//! Gaps in the times of an input.

/// Rows that are further apart have a gap between them \[s\].
const LONG: f64 = 10.0;
/// A row that goes back by more was not late: a clock was set, or another recording begins \[s\].
const BACK: f64 = 1.0;
/// And so many times as far as the nearest.
const MANY: f64 = 100.0;
/// Seconds from 59 of a minute to 0 of the next where times are written as the digits of hours, minutes and seconds; to the
/// next hour there are another 4000.
const MINUTE: f64 = 40.0;
const HOUR: f64 = 4000.0;

/// The gaps so far.
#[derive(Debug, Default)]
pub struct Gaps {
    last: Option<f64>,
    /// The shortest step \[s\].
    shortest: Option<f64>,
    count: u64,
    /// Those from the end of a minute to the next, as `hhmmss` has them.
    at_minutes: u64,
    longest: f64,
    /// Where the longest begins.
    at: f64,
    /// How often the times go back, the first time behind this one and by so much \[s\].
    back: u64,
    first_back: [f64; 2],
}

impl Gaps {
    /// Takes the time of a row \[s\].
    pub fn see(&mut self, time: f64) {
        if !time.is_finite() {
            return;
        }
        let last = self.last.replace(time).unwrap_or(time);
        let gap = time - last;
        if gap < -BACK {
            if self.back == 0 {
                self.first_back = [last, -gap];
            }
            self.back += 1;
        }
        if gap <= 0.0 {
            return;
        }
        let shortest = self.shortest.map_or(gap, |shortest| shortest.min(gap));
        self.shortest = Some(shortest);
        if gap <= LONG.max(MANY * shortest) {
            return;
        }
        self.count += 1;
        let of_minute = time % 100.0;
        let is_at_minute = last % 100.0 < 60.0 && of_minute < LONG;
        let without = (gap - MINUTE).rem_euclid(HOUR);
        self.at_minutes += u64::from(is_at_minute && without < LONG);
        if gap > self.longest {
            (self.longest, self.at) = (gap, last);
        }
    }

    /// Words on them.
    pub fn words(&self) -> Option<String> {
        let (longest, at) = (self.longest, self.at);
        // A time that no clock says would fill three lines with its digits.
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

    /// Why the times are no seconds, and what to do.
    pub fn fault(&self) -> Option<String> {
        (self.count > 1 && self.at_minutes == self.count).then(|| {
            format!(
                "the times seem to be written as hhmmss: they skip {MINUTE} s at each full minute\n  \
                 what to do: write them with colons (01:02:03.5), or in seconds"
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
    fn times_written_as_hours_minutes_and_seconds_are_told_from_a_logger_that_was_off() {
        let digits = |t: f64| {
            let (hours, minutes) = ((t / 3600.0).floor(), (t / 60.0).floor() % 60.0);
            10_000.0 * hours + 100.0 * minutes + t % 60.0
        };
        let day = |from: f64| (0..20_000).map(move |i| from + 0.01 * f64::from(i));
        let found = of(day(7100.0).map(digits));
        assert!(
            found.fault().is_some_and(|said| said.contains("hhmmss")),
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
