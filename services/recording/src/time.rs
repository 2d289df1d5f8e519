//! Reads dates, clock times, durations and time stamps in the forms that people and programs write.

use std::ops::Range;

use crate::unit;

/// Nanoseconds of a time: seconds with a decimal part (`1397165409.500000`, `000.012`), or a date
/// with a time (`2014-04-10 21:30:09.5`, `2014-04-10T21:30:09,5+02:00`, `...Z`). A date without a
/// zone is taken as UTC: only differences count. `None` for other text.
pub(crate) fn nanoseconds(text: &str) -> Option<i64> {
    date(text).or_else(|| seconds(text))
}

/// Start of the years 2000 and 2100, since 1970 [s].
const CENTURY: [i128; 2] = [946_684_800, 4_102_444_800];

/// Nanoseconds of a logger's time stamp. A number too large for seconds is read as milliseconds, microseconds or nanoseconds
/// since 1970, whichever gives a time of this century.
pub(crate) fn stamp(text: &str) -> Option<i64> {
    nanoseconds(text).or_else(|| {
        let (whole, part) = text.split_once(['.', ',']).unwrap_or((text, ""));
        fraction(part)?;
        let digits: i128 = i128::from(digits(whole)?);
        let [first, last] = CENTURY;
        let mut units = [1_000_000, 1_000, 1].into_iter();
        let ns = units.find(|ns| (first..last).contains(&(digits * ns / i128::from(SECOND))))?;
        let part = part.get(..6).unwrap_or(part);
        let of_part = self::fraction(part)? as i128 * ns / i128::from(SECOND);
        i64::try_from(digits * ns + of_part).ok()
    })
}

/// Reads `whole.fraction` in seconds; nine digits of the fraction count.
fn seconds(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once(['.', ',']).unwrap_or((text, ""));
    let negative = whole.starts_with('-');
    let whole = whole.strip_prefix('-').unwrap_or(whole);
    let ns = digits(whole)?
        .checked_mul(1_000_000_000)?
        .checked_add(self::fraction(fraction)?)?;
    Some(if negative { -ns } else { ns })
}

/// Nanoseconds of the digits after the decimal point.
fn fraction(text: &str) -> Option<i64> {
    if text.is_empty() {
        return Some(0);
    }
    text.bytes().all(|b| b.is_ascii_digit()).then_some(())?;
    let counted = text.get(..9).unwrap_or(text);
    Some(digits(counted)? * 10_i64.pow(9 - counted.len() as u32))
}

/// Reads a number of decimal digits, and nothing else.
fn digits(text: &str) -> Option<i64> {
    let plain = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    plain.then(|| text.parse().ok())?
}

/// Reads the times of a table that are not plain numbers, row by row:
/// - dates with a time,
/// - times of day with seconds, which continue after midnight or count more than 24 hours,
/// - minutes and seconds as Excel shows them, which continue after the full hour,
/// - durations.
///
/// A date of unclear order (`03/04/26`) is accepted while it is unchanged, or if it changes at midnight.
#[derive(Debug, Default)]
pub(crate) struct Dates {
    first: Option<i64>,
    order: Option<Order>,
    /// Last time of day [ns] and number of midnights before it; or time within an hour and number of hours before it.
    last: i64,
    periods: i64,
    /// The date of the previous row, if its order is unclear.
    day: String,
    /// Time and time of day of the previous row without a zone [ns], and the sum by which the clock was set back [ns].
    local: Option<[i64; 2]>,
    set_back: i64,
    /// Whether a leap second has occurred: later rows are one second later than their date gives.
    has_leapt: bool,
}

const SECOND: i64 = 1_000_000_000;
const HOUR: i64 = 3600 * SECOND;
/// Largest hour \[h\], a year: no recording is longer. `[h]:mm:ss` of a spreadsheet and an operating hours counter exceed 24.
const LONGEST: i64 = 8784;
/// Largest step between rows at the end of summer time \[ns\]. `SET_BACK`: times of day from which the clock may be set back an hour
/// \[ns\]. That is at 3:00 or 2:00, in Lisbon at 2:00 and in the Azores at 1:00.
const STEP: i64 = 10_000_000_000;
const SET_BACK: Range<i64> = HOUR - STEP..3 * HOUR;

impl Dates {
    /// Seconds since the first time of the table.
    pub(crate) fn seconds(&mut self, text: &str) -> Option<f64> {
        // Days counted at midnights and calendar dates have no common origin, so a table has only one of them.
        let ns = match self.day.is_empty() {
            true => compact(text)
                .or_else(|| dated(text, &mut self.order))
                .map(|ns| self.through_summer_time(text, ns) + self.leap(text)),
            false => None,
        };
        let is_counted = self.first.is_none() || !self.day.is_empty();
        let ns = ns.or_else(|| self.day_and_clock(text).filter(|_| is_counted));
        let ns = ns.or_else(|| self.clock(text));
        let ns = ns.or_else(|| duration(text))?;
        let first = *self.first.get_or_insert(ns);
        Some(ns.saturating_sub(first) as f64 / 1e9)
    }

    /// Continues local time at the end of summer time: a clock that goes back one hour between two close rows is corrected by one hour.
    fn through_summer_time(&mut self, text: &str, ns: i64) -> i64 {
        if has_zone(text) {
            return ns;
        }
        let in_day = ns.rem_euclid(24 * HOUR);
        if let Some([last, then]) = self.local.replace([ns, in_day])
            && SET_BACK.contains(&then)
            && (HOUR - STEP..HOUR).contains(&last.saturating_sub(ns))
        {
            self.set_back += HOUR;
        }
        ns + self.set_back
    }

    /// Correction for a leap second [ns]. Second 60 of a minute has the same number as the second after it.
    fn leap(&mut self, text: &str) -> i64 {
        let ends = |at: usize| !text[at + 3..].starts_with(|c: char| c.is_ascii_digit());
        let is_leap = text.find(":60").is_some_and(ends);
        let has_leapt = self.has_leapt;
        self.has_leapt |= is_leap;
        if has_leapt && !is_leap { SECOND } else { 0 }
    }

    /// Time of a date whose day or year is unclear, with its time of day. Counts midnights instead of reading the date.
    fn day_and_clock(&mut self, text: &str) -> Option<i64> {
        let (day, clock) = split_day(text).filter(|_| !is_ambiguous(text))?;
        let (clock, _) = zone(clock)?;
        let clock = of_day(clock)?;
        let is_midnight = clock < self.last - 12 * HOUR;
        if day != self.day && !self.day.is_empty() && !is_midnight {
            return None;
        }
        self.periods += i64::from(is_midnight);
        self.last = clock;
        self.day.clear();
        self.day.push_str(day);
        Some(self.periods * 24 * HOUR + clock)
    }

    fn clock(&mut self, text: &str) -> Option<i64> {
        let (period, clock) = match text.matches(':').count() {
            0 => return None,
            1 if text.contains(['.', ',']) => (HOUR, of_day(&format!("0:{text}"))?),
            1 => return None,
            _ => (24 * HOUR, of_hours(text, 0..LONGEST)?),
        };
        // A clock that was set back by less than half a period did not pass midnight or the full hour.
        self.periods += i64::from(clock < self.last - period / 2);
        self.last = clock;
        Some(self.periods * period + clock)
    }
}

/// Whether a date states its time zone.
fn has_zone(text: &str) -> bool {
    let clock = text.split_once(['T', ' ']).map_or("", |(_, clock)| clock);
    let is_named = clock.trim_end().ends_with(['Z', 'C', 'T', ']']);
    is_named || clock.contains(['+', '-'])
}

/// Splits off the time of day from day, month and year in any order, separated by blanks, points, slashes, hyphens or commas.
fn split_day(text: &str) -> Option<(&str, &str)> {
    let colon = text.find(':')?;
    let clock = text[..colon]
        .trim_end_matches(|c: char| c.is_ascii_digit())
        .len();
    let (day, clock) = text.split_at_checked(clock)?;
    let day = day.trim_end_matches([' ', 'T', ',']);
    let parts: Vec<&str> = day
        .split([' ', '.', '/', '-', ','])
        .filter(|part| !part.is_empty())
        .collect();
    let is_number = |part: &&&str| digits(part).is_some() && matches!(part.len(), 1 | 2 | 4);
    let numbers = parts.iter().filter(is_number).count();
    let words = parts
        .iter()
        .filter(|part| part.chars().all(char::is_alphabetic))
        .count();
    // The words are the name of the month and the day of the week.
    let is_day =
        numbers + words == parts.len() && matches!((numbers, words), (3, 0 | 1) | (2, 1 | 2));
    is_day.then_some((day, clock))
}

/// Reads a duration: `4.25 sec` of MATLAB, or `1 days 00:00:04.25` of pandas.
fn duration(text: &str) -> Option<i64> {
    let (count, rest) = text.split_once(' ')?;
    let (unit, clock) = rest.split_once(' ').unwrap_or((rest, "0:00"));
    let unit = unit::guess(unit).filter(|unit| unit.si == "s")?;
    let count: f64 = count.replace(',', ".").parse().ok()?;
    let clock = of_day(clock.trim_start_matches('+'))?;
    Some(((count * unit.factor * 1e9).round() as i64).saturating_add(clock))
}

/// Order of a date whose year is last: the part that comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Day,
    Month,
}

/// English abbreviations of the months.
const MONTHS: [&str; 12] = [
    "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec",
];

/// Reads `YYYY-MM-DD[T ]hh:mm[:ss[.fraction]][ AM| PM][zone]`, the same with `/` for `-`, and `DD.MM.YYYY`.
/// Also reads `MM/DD/YYYY`, `DD/MM/YYYY` and `DD-Mon-YYYY` if the month is clear.
pub(crate) fn date(text: &str) -> Option<i64> {
    dated(text, &mut None)
}

/// Whether a cell may be a date of fourteen digits without separators: `20141004213009.5`.
pub(crate) fn is_compact(cell: &[u8]) -> bool {
    let digits = cell.iter().take_while(|b| b.is_ascii_digit()).count();
    let of_century = cell.starts_with(b"19") || cell.starts_with(b"20");
    of_century
        && digits == 14
        && std::str::from_utf8(cell).is_ok_and(|text| compact(text).is_some())
}

/// Reads a date without separators.
fn compact(text: &str) -> Option<i64> {
    let (day, clock) = text.split_at_checked(8)?;
    let parted = clock.as_bytes().first().is_some_and(u8::is_ascii_digit);
    parted.then(|| basic(&format!("{day}T{clock}")))?
}

/// Reads `20141004T213009.5`, the basic form of ISO 8601.
fn basic(text: &str) -> Option<i64> {
    let (day, clock) = (text.get(..8)?, text.get(9..)?);
    if !text.get(8..9)?.starts_with(['T', '_', ' ']) || digits(day).is_none() {
        return None;
    }
    let (whole, rest) = (clock.get(..6)?, clock.get(6..)?);
    digits(whole)?;
    let [h, m, s] = [0, 2, 4].map(|at| &whole[at..at + 2]);
    let [year, month, of_month] = [&day[..4], &day[4..6], &day[6..]];
    dated(
        &format!("{year}-{month}-{of_month} {h}:{m}:{s}{rest}"),
        &mut None,
    )
}

/// Like [`date`]. Uses the order of day and month of an earlier date, and sets it if this date shows it.
fn dated(text: &str, order: &mut Option<Order>) -> Option<i64> {
    let (day, clock) = text.split_once(['T', ' ', '_'])?;
    if day.len() == 8 && digits(day).is_some() {
        return basic(text);
    }
    let (separator, [a, b, c]) = parts(day)?;
    let [year, month, of_month] = match separator {
        '-' | '/' if a.len() == 4 => [digits(a)?, digits(b)?, digits(c)?],
        '.' if c.len() == 4 => [digits(c)?, digits(b)?, digits(a)?],
        '-' | '/' if c.len() == 4 => {
            let [month, day] = month_and_day(a, b, order)?;
            [digits(c)?, month, day]
        }
        _ => return None,
    };
    let (clock, zone) = zone(clock.trim())?;
    let minutes = days(year, month, of_month)? * 1440 - zone;
    minutes
        .checked_mul(60_000_000_000)?
        .checked_add(of_day(clock)?)
}

/// The separator of a date, and its three parts.
fn parts(day: &str) -> Option<(char, [&str; 3])> {
    let separator = day.chars().find(|c| !c.is_ascii_digit())?;
    let parts: Vec<&str> = day.split(separator).collect();
    Some((separator, parts.try_into().ok()?))
}

/// Month and day from the two parts before the year, in either order.
fn month_and_day(a: &str, b: &str, order: &mut Option<Order>) -> Option<[i64; 2]> {
    let named = |month: &&str| b.len() == 3 && b.eq_ignore_ascii_case(month);
    if let Some(month) = MONTHS.iter().position(named) {
        return Some([month as i64 + 1, digits(a)?]);
    }
    let (a, b) = (digits(a)?, digits(b)?);
    let clear = match (a > 12, b > 12) {
        (true, false) => Some(Order::Day),
        (false, true) => Some(Order::Month),
        _ => None,
    };
    *order = order.or(clear);
    match order {
        Some(Order::Day) => Some([b, a]),
        Some(Order::Month) => Some([a, b]),
        None => (a == b).then_some([a, b]),
    }
}

/// Whether day and month of a date may be exchanged.
pub(crate) fn is_ambiguous(text: &str) -> bool {
    let day = text.split(['T', ' ']).next().unwrap_or_default();
    let small = |text| digits(text).is_some_and(|x| (1..=12).contains(&x));
    parts(day).is_some_and(|(separator, [a, b, c])| {
        matches!(separator, '/' | '-') && c.len() == 4 && small(a) && small(b) && a != b
    })
}

/// Marks of the halves of a day: English, Spanish, Japanese, Chinese, Korean.
const MORNING: [&str; 6] = ["AM", "A.M.", "A. M.", "午前", "上午", "오전"];
const AFTERNOON: [&str; 6] = ["PM", "P.M.", "P. M.", "午後", "下午", "오후"];

/// Nanoseconds since midnight: `hh:mm[:ss[.fraction]]` or `hh:mm:ss:fraction`, also of a 12-hour clock with AM or PM. `24:00:00` is
/// the end of a day by ISO 8601.
fn of_day(clock: &str) -> Option<i64> {
    let end = |ns: &i64| *ns == 24 * HOUR;
    of_hours(clock, 0..24).or_else(|| of_hours(clock, 24..25).filter(end))
}

/// Like [`of_day`], with these hours allowed on a clock without AM or PM.
fn of_hours(clock: &str, hours: Range<i64>) -> Option<i64> {
    let upper = clock.to_uppercase();
    let half = |mark: &str| {
        let clock = upper
            .strip_suffix(mark)
            .or_else(|| upper.strip_prefix(mark));
        Some(clock?.trim())
    };
    let halves = |marks: [&str; 6]| marks.into_iter().find_map(half);
    let (clock, hours, noon) = match (halves(MORNING), halves(AFTERNOON)) {
        (Some(clock), _) => (clock, 1..13, 0),
        (_, Some(clock)) => (clock, 1..13, 12),
        (None, None) => (clock, hours, 0),
    };
    let mut parts = clock.split(':');
    let (hour, minute) = (digits(parts.next()?)?, digits(parts.next()?)?);
    let second = seconds(parts.next().unwrap_or("0"))?;
    // Some programs write a colon before the milliseconds too.
    let below = match parts.next() {
        Some(digits) => fraction(digits).filter(|_| matches!(digits.len(), 3 | 6))?,
        None => 0,
    };
    let second = second.checked_add(below)?;
    let in_day = hours.contains(&hour)
        && (0..60).contains(&minute)
        && (0..61_000_000_000).contains(&second)
        && parts.next().is_none();
    // On a 12-hour clock, 12 is the first hour.
    let hour = if hours.start == 1 {
        hour % 12 + noon
    } else {
        hour
    };
    in_day.then_some((hour * 60 + minute) * 60_000_000_000 + second)
}

/// The clock without its zone, and the offset of the zone from UTC, east positive [min].
fn zone(clock: &str) -> Option<(&str, i64)> {
    // Java appends the name of the zone in brackets.
    let clock = clock.split('[').next()?.trim_end();
    let utc = ["Z", "UTC", "GMT"].into_iter();
    if let Some(clock) = utc.filter_map(|name| clock.strip_suffix(name)).next() {
        return Some((clock.trim_end(), 0));
    }
    let Some(at) = clock.rfind(['+', '-']) else {
        return Some((clock, 0));
    };
    let (clock, zone) = clock.split_at(at);
    let ahead = zone.starts_with('+');
    let zone = zone.get(1..)?.replace(':', "");
    let (hours, minutes) = (digits(zone.get(..2)?)?, zone.get(2..).unwrap_or("00"));
    let minutes = if minutes.is_empty() {
        0
    } else {
        digits(minutes)?
    };
    let minutes = (hours * 60).checked_add(minutes)?;
    (minutes <= 1440).then_some((clock.trim_end(), if ahead { minutes } else { -minutes }))
}

/// Days from 1970-01-01 (the proleptic Gregorian calendar, after H. Hinnant).
fn days(year: i64, month: i64, day: i64) -> Option<i64> {
    let sane = (1..=9999).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    sane.then_some(())?;
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468)
}

/// Formats seconds since 1970 as date and time: `2026-11-22T04:44:17Z` (the inverse of `days`, after H. Hinnant).
pub fn date_and_time(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let of_month = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    format!(
        "{:04}-{month:02}-{of_month:02}T{:02}:{:02}:{:02}Z",
        era * 400 + year + next,
        rest / 3600,
        rest / 60 % 60,
        rest % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_that_is_written_is_read_as_the_same_moment() {
        assert_eq!(date_and_time(0), "1970-01-01T00:00:00Z");
        assert_eq!(date_and_time(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(date_and_time(1_709_208_000), "2024-02-29T12:00:00Z");
        for day in (0..100_000_u64).step_by(17) {
            let seconds = day * 86_400 + 3661;
            let read = date(&date_and_time(seconds)).map(|ns| ns / 1_000_000_000);
            assert_eq!(read, Some(seconds as i64));
        }
    }

    #[test]
    fn the_same_instant_in_every_form() {
        let instant = Some(1_397_165_409_470_000_000);
        for text in [
            "1397165409.470000",
            "1397165409,47",
            "2014-04-10 21:30:09.470000",
            "2014-04-10T21:30:09.47Z",
            "2014-04-10T23:30:09,47+02:00",
            "2014-04-10T17:00:09.47-0430",
            "10.04.2014 21:30:09,47",
            "2014/04/10 21:30:09.47",
            "2014-04-10 09:30:09.47 PM",
            "10.04.2014 9:30:09,47pm",
            "2014-04-10 23:30:09.47 +0200",
            "2014-04-10 21:30:09.47 UTC",
            "2014-04-10 21:30:09:470",
            "10-Apr-2014 21:30:09.47",
            "2014-04-10T23:30:09.47+02:00[Europe/Berlin]",
            "20140410T213009.47",
            "20140410 213009,47Z",
            "20140410_233009.47+0200",
            "2014-04-10 09:30:09.47 p.m.",
            "10.04.2014 9:30:09,47 p. m.",
            "2014/04/10 午後 9:30:09.47",
            "2014/04/10 下午9:30:09.47",
        ] {
            assert_eq!(nanoseconds(text), instant, "{text}");
        }
        assert_eq!(nanoseconds("1970-01-01 00:00"), Some(0));
        assert_eq!(
            nanoseconds("2000-02-29 00:00:00"),
            Some(951_782_400_000_000_000)
        );
        let noon = nanoseconds("2000-02-29 12:00:00 PM");
        assert_eq!(noon, nanoseconds("2000-02-29 12:00:00"));
        let midnight = nanoseconds("2000-02-29 12:00:00 AM");
        assert_eq!(midnight, nanoseconds("2000-02-29 00:00:00"));
        assert_eq!(nanoseconds("-0.5"), Some(-500_000_000));
        assert_eq!(nanoseconds("000.0000000019"), Some(1));
    }

    #[test]
    fn day_and_month_are_distinguished_if_one_exceeds_twelve() {
        let same = date("2026-11-26 01:02:03.5");
        for text in [
            "11/26/2026 01:02:03.5",
            "26/11/2026 1:02:03,5 AM",
            "26-11-2026 01:02:03.5",
        ] {
            assert_eq!(date(text), same, "{text}");
            assert!(!is_ambiguous(text), "{text}");
        }
        assert_eq!(date("05/05/2026 00:00"), date("2026-05-05 00:00"));
        for text in ["03/04/2026 00:00", "3-4-2026 00:00"] {
            assert_eq!(date(text), None, "{text}");
            assert!(is_ambiguous(text), "{text}");
        }
        // The order that one date shows holds for later dates.
        let mut dates = Dates::default();
        assert_eq!(dates.seconds("11/30/2026 23:59:59"), Some(0.0));
        assert_eq!(dates.seconds("12/01/2026 00:00:01"), Some(2.0));
        assert_eq!(dates.seconds("13/01/2026 00:00:01"), None);
    }

    #[test]
    fn a_date_of_unclear_order_counts_while_it_stays_the_same_and_over_midnight() {
        for [day, next] in [
            ["21.11.26 ", "22.11.26 "],
            ["11/30/26 ", "12/1/26 "],
            ["26-11-21T", "26-11-22T"],
            ["Jul 03, 2026 ", "Jul 04, 2026 "],
            ["Fri Jul 3 2026 ", "Sat Jul 4 2026 "],
            ["3. Juli 2026 ", "4. Juli 2026 "],
        ] {
            let mut dates = Dates::default();
            let mut seconds = |day: &str, clock: &str| dates.seconds(&format!("{day}{clock}"));
            assert_eq!(seconds(day, "23:59:58.50"), Some(0.0), "{day}");
            assert_eq!(seconds(day, "23:59:59,75"), Some(1.25), "{day}");
            assert_eq!(seconds(next, "00:00:00.50"), Some(2.0), "{next}");
            assert_eq!(seconds(next, "12:00:00"), Some(43_201.5), "{next}");
            assert_eq!(seconds(day, "23:00:00"), None, "{day}");
        }
        assert_eq!(Dates::default().seconds("Pump 2 on 16:00:00"), None);
    }

    #[test]
    fn local_time_goes_on_where_summer_time_ends() {
        let mut dates = Dates::default();
        for (text, seconds) in [
            ("2026-10-25 02:59:59.5", 0.0),
            ("2026-10-25 02:00:00.0", 0.5),
            ("2026-10-25 02:00:01.0", 1.5),
            // A row that is given twice.
            ("2026-10-25 02:00:00.0", 0.5),
        ] {
            assert_eq!(dates.seconds(text), Some(seconds), "{text}");
        }
        let mut dates = Dates::default();
        assert_eq!(dates.seconds("2026-10-25T02:59:59+02:00"), Some(0.0));
        assert_eq!(dates.seconds("2026-10-25T02:00:00+01:00"), Some(1.0));
        assert_eq!(dates.seconds("2026-10-25T01:00:01Z"), Some(2.0));
        let mut dates = Dates::default();
        assert_eq!(dates.seconds("2026-10-25 16:59:59.5"), Some(0.0));
        assert_eq!(dates.seconds("2026-10-25 16:00:00"), Some(-3599.5));
    }

    #[test]
    fn a_leap_second_is_a_second() {
        let mut dates = Dates::default();
        for (text, seconds) in [
            ("2016-12-31T23:59:59.5Z", 0.0),
            ("2016-12-31T23:59:60.0Z", 0.5),
            ("2016-12-31T23:59:60.999Z", 1.499),
            ("2017-01-01T00:00:00Z", 1.5),
            ("2017-01-01T00:01:00Z", 61.5),
        ] {
            assert_eq!(dates.seconds(text), Some(seconds), "{text}");
        }
        assert_eq!(Dates::default().seconds("10:00:00:600"), Some(0.0));
    }

    #[test]
    fn fourteen_digits_are_a_date_where_they_can_be_one() {
        let mut dates = Dates::default();
        for (text, seconds) in [("20260713135959.99", 0.0), ("20260713140000", 0.01)] {
            assert!(is_compact(text.as_bytes()), "{text}");
            assert_eq!(dates.seconds(text), Some(seconds), "{text}");
        }
        for text in [
            "20261313135959",
            "1783951180123",
            "17839511801234",
            "2026071313595",
        ] {
            assert!(!is_compact(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn in_a_table_the_time_of_day_is_a_time() {
        let mut dates = Dates::default();
        for (text, seconds) in [
            ("23:59:58,5", 0.0),
            ("11:59:59.5 PM", 1.0),
            ("00:00:00.5", 2.0),
            ("23:59:59", 86_400.5),
            ("23:59:58", 86_399.5),
            ("23:59:58:250", 86_399.75),
        ] {
            assert_eq!(dates.seconds(text), Some(seconds), "{text}");
        }
        for text in [
            "12:30",
            "1:2:3:4",
            "01:02:03:04",
            "10:60:00",
            "9000:00:00",
            "2026-11-28 25:00:00",
            "25:00:00 PM",
            "1,5",
            "5 kg",
            "x sec",
            "1 days 2",
        ] {
            assert_eq!(dates.seconds(text), None, "{text}");
        }
    }

    #[test]
    fn the_end_of_a_day_and_hours_beyond_it_are_times() {
        for times in [
            // The end of a day by ISO 8601: alone, with its date, and with a date of unclear order.
            ["23:59:59.5", "24:00:00.0", "00:00:00.5"],
            [
                "2026-11-28 23:59:59.5",
                "2026-11-28 24:00:00",
                "2026-11-29 00:00:00.5",
            ],
            [
                "28.11.26 23:59:59,5",
                "28.11.26 24:00:00,0",
                "29.11.26 00:00:00,5",
            ],
            // [h]:mm:ss of a spreadsheet, and a counter of operating hours.
            ["23:59:59.5", "24:00:00.0", "24:00:00.5"],
            ["1207:59:59.5", "1208:00:00.0", "1208:00:00.5"],
        ] {
            let mut dates = Dates::default();
            let seconds = times.map(|text| dates.seconds(text));
            assert_eq!(seconds, [Some(0.0), Some(0.5), Some(1.0)], "{times:?}");
        }
    }

    #[test]
    fn minutes_and_durations_are_times() {
        for times in [
            ["59:59.5", "00:00.0", "00:01,25"],
            ["0 sec", "0.5 sec", "1.75 sec"],
            ["0 s", "0,5 s", "1,75 s"],
            ["0 days 23:59:59.5", "1 days 00:00:00", "1 days 00:00:01.25"],
            [
                "-1 days +23:59:59.5",
                "0 days 00:00:00",
                "0 days 00:00:01.25",
            ],
        ] {
            let mut dates = Dates::default();
            let found = times.map(|text| dates.seconds(text));
            assert_eq!(found, [Some(0.0), Some(0.5), Some(1.75)], "{times:?}");
        }
        assert_eq!(Dates::default().seconds("1e300 days"), Some(0.0));
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in [
            "",
            "x",
            "1.x",
            "+1",
            "1e3",
            "99999999999.0",
            "2014-04-10 21:30:09+019223372036854775807",
            "2014-13-01 00:00",
            "2014-01-01 24:01",
            "2014-01-01 13:00 PM",
            "2014-01-01 00:00 AM",
            "04/10/2014 9:30:09 PM",
            "12:30:00",
            "2014-01-01 00:61",
            "2014-01-01",
            "é-01-01 00:00",
            "2014-01-01 00:00:00+é0",
        ] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }
}
