//! Proposes a map for a table.

use std::fmt::Write;
use std::path::Path;

use super::absolute::is_absolute;
use super::names::{fitting, heads_of_rods, is_pressure, may_be, quoted, wanted};
use super::ports::{pair, ports};
use super::sides::sides;
use super::suggestion::{LINKS, Suggestion, links, missing};
use super::{guessed_unit, lacking, opening, shown, sizes, unit_of};
use crate::Error;
use crate::csv::{self, Look};
use crate::signal::Sensors;
use crate::unit::{self, Unit};

/// Number of rows that are read.
const LOOK: usize = 20_000;

/// A map for a table.
pub(super) fn suggest<S: Sensors>(path: &Path) -> Result<Suggestion, Error> {
    let look = csv::look(path, LOOK)?;
    let own = Draft::of::<S>(&look, look.header.clone());
    let mut draft = match own.missing::<S>().is_empty() {
        true => own,
        false => {
            let grouped = Draft::of::<S>(&look, grouped(&look));
            if grouped.found.len() > own.found.len() {
                grouped
            } else {
                own
            }
        }
    };
    let misread = csv::misread(&look.header, &path.display().to_string());
    if let Some(error) = misread.filter(|_| draft.found.len() < 2) {
        return Err(error);
    }
    let missing = draft.missing::<S>();
    let mut text = opening::<S>(path);
    text.push_str("\n[columns]\n");
    text += &draft.out;
    text += &draft.ports::<S>();
    text += &draft.sides::<S>();
    draft.offer_ports::<S>();
    let mut offered = draft.taken.clone();
    text += &lacking::<S>(&draft.found, &missing, |signal| {
        draft.by_unit::<S>(signal, &mut offered)
    });
    text += &rest(&look.header, &draft.taken);
    Ok(Suggestion {
        text,
        missing,
        found: draft.found.len(),
        unknown: draft.unknown,
        of_second: draft.of_second,
        of_others: draft.of_others,
        links: links(&draft.found),
    })
}

/// The names of columns prefixed by those of their groups, which stand once above the first column of each: merged cells of a sheet.
fn grouped(look: &Look) -> Vec<String> {
    let mut group = "";
    let above = look
        .above
        .iter()
        .map(String::as_str)
        .chain(std::iter::repeat(""));
    let named = look.header.iter().zip(above).map(|(name, above)| {
        if !above.is_empty() {
            group = above;
        }
        match group {
            "" => name.clone(),
            group if name.starts_with(group) => name.clone(),
            group => format!("{group} {name}"),
        }
    });
    named.collect()
}

/// A map in the making.
struct Draft<'a> {
    look: &'a Look,
    /// Names of the columns.
    labels: Vec<String>,
    /// The same with the units from a row below the names.
    names: Vec<String>,
    /// The largest pressure of the columns without a unit: a logger writes all in the same unit.
    largest_pressure: f64,
    /// Whether an angle without a unit is beyond a turn in rad: a logger writes all in the same unit.
    in_degrees: bool,
    out: String,
    found: Vec<String>,
    taken: Vec<usize>,
    unknown: Vec<String>,
    of_second: Vec<String>,
    of_others: Vec<String>,
    links: [Option<Column>; LINKS.len()],
}

impl<'a> Draft<'a> {
    fn of<S: Sensors>(look: &'a Look, labels: Vec<String>) -> Self {
        // Sheets and web pages contain no-break spaces.
        let plain = |label: String| in_words(&label).replace(char::is_whitespace, " ");
        let labels: Vec<String> = labels.into_iter().map(plain).collect();
        let named = labels
            .iter()
            .zip(&look.units)
            .map(|(label, unit)| named(label, unit));
        let names: Vec<String> = named.collect();
        let mut draft = Self {
            look,
            largest_pressure: largest_pressure(look, &names),
            in_degrees: are_in_degrees::<S>(look, &names),
            labels,
            names,
            out: String::new(),
            found: Vec::new(),
            taken: Vec::new(),
            unknown: Vec::new(),
            of_second: Vec::new(),
            of_others: Vec::new(),
            links: [const { None }; LINKS.len()],
        };
        draft.stamp();
        draft.find::<S>(|name, si| unit::foreign(name, si).is_none_or(|unit| is_grade(unit, si)));
        draft.find::<S>(|_, _| true);
        draft
    }

    /// For each signal not found yet, takes the column that fits best, among those whose name and the signal's unit are `usable`.
    fn find<S: Sensors>(&mut self, usable: impl Fn(&str, &str) -> bool) {
        for signal in wanted::<S>() {
            let si = unit_of::<S>(&signal);
            let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
            let left_out = |at: &usize| self.taken.contains(at) || !usable(names[*at], si);
            let left_out: Vec<usize> = (0..names.len()).filter(left_out).collect();
            let fitting = fitting(&signal, &names, &left_out);
            if let Some(at) = fitting.filter(|_| !self.found.contains(&signal)) {
                self.take::<S>(signal, at);
            }
        }
    }

    /// Required signals that were not found.
    fn missing<S: Sensors>(&self) -> Vec<&'static [&'static str]> {
        let mut missing = missing::<S>(&self.found);
        if !self.found.iter().any(|signal| signal == "t") {
            missing.insert(0, &["t"]);
        }
        missing
    }

    /// Finds a time in two columns.
    fn stamp(&mut self) {
        let names: Vec<&str> = self.labels.iter().map(String::as_str).collect();
        if let Some([whole, below]) = seconds_and_below(&names) {
            let [s, ns] = [whole, below].map(|at| quoted(&self.look.header[at]));
            let _ = writeln!(
                self.out,
                "t = {{ terms = [{{ column = {s} }}, {{ column = {ns}, unit = \"ns\" }}] }}  # seconds, and nanoseconds beside them"
            );
            self.taken.extend([whole, below]);
            self.found.push("t".to_owned());
        }
    }

    /// Writes the line of the signal that this column is.
    fn take<S: Sensors>(&mut self, signal: String, at: usize) {
        self.taken.push(at);
        let named = self.names[at].clone();
        let si = unit_of::<S>(&signal);
        let name = quoted(&self.look.header[at]);
        if let Some(unit) = unit::foreign(&named, si) {
            let (line, is_usable) = of_another_unit(&signal, &name, unit, si);
            self.out += &line;
            if is_usable {
                self.found.push(signal);
            } else {
                self.of_others.push(format!("{signal} ({name}, in {unit})"));
            }
            return;
        }
        let large = self.largest_pressure;
        let (mut guess, other) =
            guessed_unit::of(&signal, si, &named, &self.look.columns[at], large);
        if guess.unit.is_none() && other.is_none() && self.in_degrees && !unit::is_of(&named, si) {
            let angle = unit::find("deg").filter(|_| si == "rad");
            if angle.is_some() {
                guess = (angle, "deg, as another angle without a unit?".to_owned()).into();
            }
        }
        let unknown = other.map(|text| format!("{text} (column {name})"));
        self.unknown.extend(unknown);
        let ambiguous = unit::of_name(&named, si).and_then(|unit| unit::ambiguous(&named, unit));
        if ambiguous.is_some_and(|a| a.is_asked) {
            self.of_second.push(format!("{signal} (column {name})"));
        }
        let below = milliseconds(at, &self.labels, self.look);
        if let Some(below) = below.filter(|_| signal == "t") {
            let ms = quoted(&self.look.header[below]);
            self.out += &format!(
                "t = {{ terms = [{{ column = {name} }}, {{ column = {ms}, unit = \"ms\" }}] }}  # whole seconds, and milliseconds beside them\n"
            );
            self.taken.push(below);
            self.found.push(signal);
            return;
        }
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        if heads_of_rods(&names)[at] {
            guess.reason += "; its head is that of the rod, as the other side is the bottom";
        }
        let column = Column {
            at,
            name: name.clone(),
            unit: guess.unit,
        };
        let line = self.difference(&signal, &column, &guess.reason);
        self.out += &line.unwrap_or_else(|| line_of(&signal, &name, guess.unit, si, &guess.reason));
        if let Some(link) = LINKS.iter().position(|link| *link == signal) {
            self.links[link] = Some(column);
        }
        if signal == "t" {
            let names: Vec<&str> = self.labels.iter().map(String::as_str).collect();
            let seconds = guess.unit.map_or(1.0, |unit| unit.factor);
            self.out += &other_times(at, seconds, &names, &self.look.columns);
        }
        self.found.push(signal);
    }

    /// Proposal for a signal that no name fits: the first column in a unit of it that was not `offered` yet.
    fn by_unit<S: Sensors>(&self, signal: &str, offered: &mut Vec<usize>) -> String {
        let si = unit_of::<S>(signal);
        let free: Vec<usize> = (0..self.names.len())
            .filter(|at| !offered.contains(at))
            .collect();
        let found = free.into_iter().find_map(|at| {
            let name = &self.names[at];
            // Degrees alone are no rate here: no name says that it is one.
            let is_candidate = may_be(signal, name) && unit::is_of(name, si);
            let unit = unit::of_name(name, si).filter(|_| is_candidate)?;
            offered.push(at);
            let column = quoted(&self.look.header[at]);
            Some(format!("{{ column = {column}, unit = \"{}\" }}", unit.name))
        });
        found.unwrap_or_else(|| "\"...\"".to_owned())
    }

    /// Two pressures of the swing motor, if no column is its torque.
    fn ports<S: Sensors>(&self) -> String {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let term = |at: usize, sign: &str| self.pressure(at, sign);
        ports::<S>((&names, &self.taken, &self.found), term)
    }

    /// Notes that two pressures of the swing motor are offered: they are not used without a number of the motor.
    fn offer_ports<S: Sensors>(&mut self) {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let Some(ports) = pair::<S>(&names, &self.taken, &self.found) else {
            return;
        };
        let [a, b] = ports.map(|at| quoted(&self.look.header[at]));
        self.of_others
            .push(format!("swing_torque ({a} less {b}, pressures)"));
        self.taken.extend(ports);
    }

    /// Pressures of cylinders whose side or link is to be decided.
    fn sides<S: Sensors>(&self) -> String {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let mean = |at: usize| {
            let known = self.look.columns[at].iter().filter(|x| x.is_finite());
            let (sum, count) = known.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
            sum / f64::max(count, 1.0)
        };
        let column = |at: usize| self.pressure(at, "");
        sides::<S>((&names, &self.taken, &self.found), mean, column)
    }

    /// The column of a pressure with its unit, and more in its braces.
    fn pressure(&self, at: usize, more: &str) -> String {
        let told = unit::of_name(&self.names[at], "Pa");
        let unit = told.or(sizes::pressure(self.largest_pressure).0);
        let unit = unit.map_or("Pa", |unit| unit.name);
        let column = quoted(&self.look.header[at]);
        format!("{{ column = {column}, unit = \"{unit}\"{more} }}")
    }

    /// The line of a link whose angle is from the horizontal: minus that of the link before.
    fn difference(&self, signal: &str, column: &Column, reason: &str) -> Option<String> {
        let link = LINKS.iter().position(|link| *link == signal)?;
        let before = self.links[link.checked_sub(1)?].as_ref()?;
        let radians = |column: &Column| {
            let factor = column.unit.map_or(1.0, |unit| unit.factor);
            let values = self.look.columns[column.at].iter();
            values.map(|x| x * factor).collect::<Vec<_>>()
        };
        let why = is_absolute(&self.labels[column.at], &radians(before), &radians(column))?;
        Some(format!(
            "{signal} = {{ terms = [{}, {}] }}  # from the horizontal, as {why}: less the link before; {reason}\n",
            column.term(""),
            before.term(", sign = -1")
        ))
    }
}

/// A name that pandas wrote as a tuple of words, `('swing', 'velocity')`, as these words.
fn in_words(label: &str) -> String {
    let tuple = label.strip_prefix('(').and_then(|l| l.strip_suffix(')'));
    let words = tuple.and_then(|tuple| {
        let words = tuple.trim_end_matches(',').split(", ").map(|word| {
            let word = word.strip_prefix(['\'', '"'])?;
            word.strip_suffix(['\'', '"'])
        });
        words.collect::<Option<Vec<&str>>>()
    });
    words.map_or_else(
        || label.to_owned(),
        |words| words.join(" ").trim().to_owned(),
    )
}

/// The name of a column with the unit from a row below the names.
fn named(label: &str, unit: &str) -> String {
    match unit {
        "" => label.to_owned(),
        unit => format!("{label} [{unit}]"),
    }
}

/// The largest pressure of the columns without a unit.
fn largest_pressure(look: &Look, names: &[String]) -> f64 {
    let of_none = |name: &str| is_pressure(name) && !unit::is_of(name, "Pa");
    let columns = names.iter().zip(&look.columns);
    let columns = columns.filter(|(name, _)| of_none(name));
    let sizes = columns.map(|(_, values)| sizes::largest(values.iter()));
    sizes.fold(0.0, f64::max)
}

/// Whether an angle of a link without a unit is beyond a turn in rad.
fn are_in_degrees<S: Sensors>(look: &Look, names: &[String]) -> bool {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let links = wanted::<S>().into_iter().filter(|signal| {
        let is_link = LINKS.contains(&signal.as_str());
        is_link || ["lift_angle", "tilt_angle", "pitch", "slope", "roll"].contains(&signal.as_str())
    });
    let mut columns = links.filter_map(|signal| fitting(&signal, &names, &[]));
    columns.any(|at| {
        let values = &look.columns[at];
        let has_none = !unit::is_of(names[at], "rad") && unit::foreign(names[at], "rad").is_none();
        has_none && guessed_unit::beyond(values, core::f64::consts::TAU) * 50 > values.len()
    })
}

/// The columns of seconds and of their nanoseconds, as in the headers of ROS, if they are the time.
fn seconds_and_below(names: &[&str]) -> Option<[usize; 2]> {
    const ENDS: [(&str, &str); 3] = [("sec", "nanosec"), ("secs", "nsecs"), ("sec", "nsec")];
    let time = fitting("t", names, &[]);
    let at = |name: &str| names.iter().position(|other| *other == name);
    let pair = ENDS.iter().find_map(|(whole, below)| {
        let before = names.iter().filter_map(|name| name.strip_suffix(below));
        let mut pairs = before.map(|before| {
            Some([
                at(&format!("{before}{whole}"))?,
                at(&format!("{before}{below}"))?,
            ])
        });
        pairs.find_map(|pair| pair)
    })?;
    let is_time = |at: usize| names[at].contains("stamp") || at == pair[0];
    time.is_none_or(is_time).then_some(pair)
}

/// Names of the milliseconds that loggers write beside whole seconds.
const MILLISECONDS: [&str; 9] = [
    "millitm",
    "ms",
    "msec",
    "msecs",
    "millis",
    "millisec",
    "millisecond",
    "milliseconds",
    "millisekunden",
];

/// The column of the milliseconds beside the whole seconds of column `at`: it stays below 1000, and restarts with each second.
fn milliseconds(at: usize, names: &[String], look: &Look) -> Option<usize> {
    if !look.is_whole_second[at] {
        return None;
    }
    let is_one = |other: &usize| {
        let name = names[*other].to_lowercase();
        let mut words = name.split(|c: char| !c.is_alphanumeric());
        let is_named = words.any(|word| MILLISECONDS.contains(&word));
        let values = &look.columns[*other];
        let begins_anew = values.windows(2).any(|w| w[1] < w[0]);
        // A date is no number here; a counter of milliseconds would not restart with each second.
        let steps = look.columns[at].windows(2).zip(values.windows(2));
        let mut seconds = steps.filter(|(s, _)| s[1] > s[0]);
        let goes_on = seconds.all(|(_, ms)| ms[1] < ms[0]);
        let in_second = values.iter().all(|ms| (0.0..1000.0).contains(ms));
        is_named && in_second && begins_anew && goes_on && values.iter().any(|ms| *ms > 1.0)
    };
    (0..names.len()).filter(|other| *other != at).find(is_one)
}

/// The line of a column in this unit, with the reason.
fn line_of(signal: &str, name: &str, unit: Option<&Unit>, si: &str, reason: &str) -> String {
    let Some(unit) = unit else {
        return format!("{signal} = {name}  # {reason}\n");
    };
    let scale = if unit.si == si { "" } else { ", scale = 1.0" };
    let unit = unit.name;
    format!("{signal} = {{ column = {name}, unit = \"{unit}\"{scale} }}  # {reason}\n")
}

/// Whether the unit of an angle is that of a grade.
fn is_grade(unit: &str, si: &str) -> bool {
    matches!(unit, "%" | "‰") && si == "rad"
}

/// The line of a column in a unit of another dimension than the signal's, and whether it is used all the same.
fn of_another_unit(signal: &str, name: &str, unit: &str, si: &str) -> (String, bool) {
    match is_grade(unit, si) {
        true => (
            format!(
                "{signal} = {{ column = {name}, unit = \"{unit}\", scale = 1.0 }}  # a grade: up to 20 % it is the angle, within a hundredth\n"
            ),
            true,
        ),
        false => (
            format!("# {signal} = {name}  # its unit is {unit}, which is none of {si}\n"),
            false,
        ),
    }
}

/// Columns of another time than that of column `at`, whose unit has this number of seconds, as comments. Some loggers write a time
/// for the signals of each rate, so those rows belong to other times.
fn other_times(at: usize, seconds: f64, names: &[&str], columns: &[Vec<f64>]) -> String {
    let mut out = String::new();
    let is_time = |other: &usize| *other != at && fitting("t", &[names[*other]], &[]).is_some();
    for other in (0..names.len()).filter(is_time) {
        let pairs = columns[at].iter().zip(&columns[other]);
        let pairs: Vec<_> = pairs.filter(|(t, o)| (*t + *o).is_finite()).collect();
        let (Some(first), Some(last)) = (pairs.first(), pairs.last()) else {
            continue;
        };
        let unit = guessed_unit::of("t", "s", names[other], &columns[other], 0.0)
            .0
            .unit;
        let spent = (last.1 - first.1) * unit.map_or(1.0, |unit| unit.factor);
        let ratio = spent / ((last.0 - first.0) * seconds);
        let increases = pairs.windows(2).all(|two| two[1].1 > two[0].1);
        if increases && ratio.is_finite() && (ratio - 1.0).abs() > 0.01 {
            let name = shown(names[other]);
            let _ = writeln!(
                out,
                "# {name} is {ratio:.2} times as fast as this: do its columns have rows of their own? Then write all signals at one rate"
            );
        }
    }
    out
}

/// The unused columns, as a comment.
fn rest(names: &[String], taken: &[usize]) -> String {
    let rest: Vec<&str> = (0..names.len())
        .filter(|at| !taken.contains(at) && !names[*at].is_empty())
        .map(|at| names[at].as_str())
        .collect();
    match rest.is_empty() {
        true => String::new(),
        false => format!(
            "\n# Columns that fit nothing: {}\n",
            shown(&rest.join(", "))
        ),
    }
}

/// A column that is a signal.
struct Column {
    at: usize,
    /// Name in quotes.
    name: String,
    unit: Option<&'static Unit>,
}

impl Column {
    /// The column as a term of a sum.
    fn term(&self, more: &str) -> String {
        let unit = self.unit.map(|unit| format!(", unit = \"{}\"", unit.name));
        format!(
            "{{ column = {}{}{more} }}",
            self.name,
            unit.unwrap_or_default()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_with_nanoseconds_beside_them_are_the_time() {
        let of = |names: &[&str]| seconds_and_below(names);
        assert_eq!(
            of(&["x", "header.stamp.sec", "header.stamp.nanosec"]),
            Some([1, 2])
        );
        assert_eq!(of(&["stamp_nsecs", "stamp_secs"]), Some([1, 0]));
        assert_eq!(of(&["x", "sec", "nanosec"]), Some([1, 2]));
        assert_eq!(of(&["time", "a.sec", "a.nanosec"]), None);
        assert_eq!(of(&["a.sec", "b.nanosec"]), None);
    }

    #[test]
    fn a_time_of_other_rows_is_named_and_another_clock_is_not() {
        let times = |step: f64| {
            (0..50)
                .map(|k| 7.0 + step * f64::from(k))
                .collect::<Vec<_>>()
        };
        let names = [
            "time",
            "time_50ms",
            "unix time [ms]",
            "cycle time",
            "timestamp",
        ];
        let still = vec![3.0; 50];
        let columns = [
            times(0.01),
            times(0.05),
            times(10.0),
            still,
            vec![f64::NAN; 50],
        ];
        let said = other_times(0, 1.0, &names, &columns);
        assert!(
            said.starts_with("# time_50ms is 5.00 times as fast"),
            "{said}"
        );
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}
