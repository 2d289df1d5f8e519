//! Checks of all samples of an input: gaps, refused and repeated rows, units, ranges, marks of missing samples, another machine.
//! Every command that estimates from the input reports the findings: at the end, or meanwhile where the input has no end.

use std::marker::PhantomData;
use std::ops::RangeInclusive;

use checks::{Look, advised};
use config::{Description, Keyed};
use messages::{Envelope, Message, Value};
use recording::measurable::{self, Measured};
use recording::{Finding, Gaps, Lacks, Map, Sensors, Together};

use crate::failure::Failure;
use crate::marked::{Count, Ends, Shared};
use crate::parts;

/// Collects statistics of the rows of an input.
pub struct Doubts<L: Look> {
    /// Checks by the description of the machine, and the samples for them: signals of neighbouring rows combined.
    look: Option<L>,
    together: Together<L::Sensors>,
    map: Option<Map>,
    rate: f64,
    times: Vec<f64>,
    gaps: Gaps,
    /// What parts an input whose times are out of order into several.
    several: Option<Finding>,
    rows: usize,
    refused: usize,
    /// The previous row, and the number of refused rows that repeat the row before them.
    before: Option<L::Sensors>,
    repeated: usize,
    /// Whether any signal had a value.
    is_measured: bool,
    measured: Vec<Measured>,
    /// Number of rows in which each signal, by its bit, was larger than any measurement.
    beyond: [usize; 32],
    /// Least and largest values of each of `measured`, and the number of rows in which it was too large without being a mark.
    ends: Vec<Ends>,
    too_large: Vec<usize>,
    /// Marks of missing samples in any signal, and their number of rows in each of `measured`.
    shared: Shared,
    counts: Vec<Count>,
}

/// [`Doubts`] without the type of the machine, for a caller that receives all messages of its processes.
pub trait AnyDoubts {
    /// Takes samples, and the estimates of one channel.
    fn see(&mut self, message: &Envelope);
    /// Reports possible errors.
    fn tell(&self);
    /// Fails on a certain error of the data.
    fn judge(&self) -> Result<(), Failure>;
}

/// Rows of a machine at its first judgement before the end, a minute of 100 Hz. Each further judgement is at twice as many.
pub const FIRST_JUDGED: usize = 6000;

/// Checks of the messages of a run.
pub struct Seen<L: Look, E> {
    doubts: Doubts<L>,
    /// Number of rows at the next judgement.
    judge_at: usize,
    estimates: PhantomData<E>,
}

impl<L: Look, E> Seen<L, E> {
    /// For a description.
    pub fn of(description: &Description) -> Self {
        Self {
            doubts: Doubts::of(description),
            judge_at: FIRST_JUDGED,
            estimates: PhantomData,
        }
    }

    /// What is surely wrong, if a judgement is due: a run on a bus may never end.
    fn found(&mut self) -> Option<Failure> {
        if self.doubts.rows() < self.judge_at {
            return None;
        }
        self.judge_at *= 2;
        self.doubts.judge(&Lacks::default()).err()
    }
}

impl<L: Look, E: recording::csv::Estimate> AnyDoubts for Seen<L, E> {
    fn see(&mut self, message: &Envelope) {
        if let Some(sample) = L::Sensors::inside(message) {
            self.doubts.add(sample, false);
        }
        let is_refused = E::inside(message).is_some_and(E::is_refused);
        self.doubts.refused += usize::from(is_refused);
        if let Some(fault) = self.found() {
            tracing::warn!("{fault}");
        }
    }

    fn tell(&self) {
        self.doubts.tell();
    }

    fn judge(&self) -> Result<(), Failure> {
        // A run that is stopped before its first sample has not failed.
        if self.doubts.rows > 0 {
            self.doubts.has_rows()?;
        }
        self.doubts.judge(&Lacks::default())
    }
}

/// Unit of the signals whose range is checked: joint angles have mechanical stops and pressures a zero, torques have neither.
const ENDLESS: &str = "N m";

/// Number of rows from which the unit of the time is judged.
const LOOKED_AT: usize = 1000;

impl<L: Look> Doubts<L> {
    /// For a description.
    pub fn of(description: &Description) -> Self {
        let described = L::Described::inside(description);
        let measured = measurable::measured::<L::Sensors>(|signal| L::largest(described?, signal));
        Self {
            look: described.map(L::of),
            together: Together::default(),
            map: None,
            rate: description.rate(),
            times: Vec::new(),
            gaps: Gaps::default(),
            several: None,
            rows: 0,
            refused: 0,
            before: None,
            repeated: 0,
            is_measured: false,
            ends: vec![Ends::default(); measured.len()],
            too_large: vec![0; measured.len()],
            shared: Shared::default(),
            counts: vec![Count::default(); measured.len()],
            measured,
            beyond: [0; 32],
        }
    }

    /// For data that were read with this signal map.
    pub fn mapped(self, map: Option<Map>) -> Self {
        Self { map, ..self }
    }

    /// Takes a sample before it is known whether its row is refused. A row that repeats the one before it is only counted.
    pub fn see(&mut self, sample: &L::Sensors) {
        let repeats = self.repeats(sample);
        self.add(sample, repeats);
    }

    /// Takes a sample, and whether its row was refused.
    pub fn add(&mut self, sample: &L::Sensors, is_refused: bool) {
        if is_refused && self.repeats(sample) {
            self.repeated += 1;
            return;
        }
        self.before = Some(*sample);
        self.rows += 1;
        self.refused += usize::from(is_refused);
        self.gaps.see(sample.stamp().time);
        if self.times.len() < LOOKED_AT {
            self.times.push(sample.stamp().time);
        }
        let valid = sample.bits_of("valid");
        self.is_measured |= valid != 0;
        let seen = self
            .ends
            .iter_mut()
            .zip(&mut self.counts)
            .zip(&mut self.too_large);
        for ((index, bit, limit), ((ends, count), too_large)) in self.measured.iter().zip(seen) {
            let value = sample.get(*index).map(Value::as_f64);
            let Some(value) = value.filter(|_| valid & bit != 0) else {
                continue;
            };
            if value.abs() <= *limit {
                ends.see(value);
                count.see(value, &self.shared);
            } else {
                self.shared.learn(value);
                *too_large += usize::from(!self.shared.is_mark(value));
            }
        }
        let beyond = measurable::beyond(sample, &self.measured);
        if beyond != 0 {
            for (bit, count) in self.beyond.iter_mut().enumerate() {
                *count += (beyond >> bit & 1) as usize;
            }
        }
        if let Some(look) = &mut self.look {
            look.add(self.together.with(sample));
        }
    }

    /// Whether a row repeats the one before it, with the same time.
    fn repeats(&self, sample: &L::Sensors) -> bool {
        let same = |before: &L::Sensors| {
            let mut values = self.measured.iter();
            let at = |row: &L::Sensors, index: usize| row.get(index).map(|v| v.as_f64().to_bits());
            before.stamp().time == sample.stamp().time
                && before.bits_of("valid") == sample.bits_of("valid")
                && values.all(|(index, ..)| at(before, *index) == at(sample, *index))
        };
        self.before.as_ref().is_some_and(same)
    }

    /// Reports possible errors.
    pub fn tell(&self) {
        self.words().iter().for_each(|words| eprintln!("{words}"));
    }

    /// Texts of possible errors.
    pub fn words(&self) -> Vec<String> {
        let repeated = (self.repeated > 0).then(|| {
            let rows = self.repeated;
            format!("{rows} rows repeat the row before them; they are left out")
        });
        let slow = recording::too_slow(&self.times, self.rate);
        let fast = recording::too_fast(&self.times, self.rate);
        let mut all: Vec<_> = [repeated, self.gaps.words(), slow, fast]
            .into_iter()
            .flatten()
            .collect();
        for signal in <L::Sensors as Sensors>::SIGNALS {
            let count = self.beyond[signal.bit.trailing_zeros() as usize % 32];
            if count > 0 {
                all.push(measurable::words(signal.name, count));
            }
        }
        all.extend(self.marks());
        all.extend(self.range_ends());
        all
    }

    /// Number of rows without those that repeat another.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Sets the number of refused rows from their sum, which includes rows that repeat another.
    pub fn refused(&mut self, refused: usize) {
        self.refused = refused.saturating_sub(self.repeated);
    }

    /// A signal that is often larger than any measurement: it has another unit, or is of another machine.
    fn often_too_large(&self) -> Option<Finding> {
        let counts = self.too_large.iter().zip(&self.ends);
        let mut counts = self.measured.iter().zip(counts);
        counts.find_map(|((index, ..), (large, ends))| {
            let name = <L::Sensors as Message>::FIELDS[*index].name;
            too_large_often(name, *large, large + ends.rows())
        })
    }

    /// Texts on torques that are exactly at one end of their range in many rows. Angles have mechanical stops and pressures a zero.
    fn range_ends(&self) -> impl Iterator<Item = String> {
        let seen = self.measured.iter().zip(&self.ends);
        seen.filter_map(|((index, ..), ends)| {
            let field = &<L::Sensors as Message>::FIELDS[*index];
            let (value, rows) = ends.cut().filter(|_| field.unit == ENDLESS)?;
            Some(format!(
                "{} is exactly {value} {} in {rows} rows, and never beyond: its range seems to end there, and what is beyond is not seen",
                field.name, field.unit
            ))
        })
    }

    /// Texts on signals in which one number seems to mark missing samples.
    fn marks(&self) -> impl Iterator<Item = String> {
        let seen = self.ends.iter().zip(&self.counts);
        self.measured.iter().zip(seen).filter_map(|((index, ..), (ends, count))| {
            let field = &<L::Sensors as Message>::FIELDS[*index];
            let far = ends.mark().zip(Some("far from all its other values"));
            let shared = count
                .mark()
                .zip(Some("as other signals have it where it is no measurement"));
            // Numbers without a unit are states, which repeat exactly.
            let ((value, rows), why) = far.or(shared).filter(|_| !field.unit.is_empty())?;
            if self.look.as_ref().is_some_and(|look| look.is_measurement(field.name, value)) {
                return None;
            }
            let or_empty = match field.name {
                "mass" => "; if the empty machine weighs this, state machine.mass",
                _ => "",
            };
            Some(format!(
                "{} is {value} {} in {rows} rows, exactly and {why}: leave the cell empty if the sample is missing there{or_empty}",
                field.name, field.unit
            ))
        })
    }

    /// Whether the times are out of order: they go back, or many rows were refused.
    pub fn is_out_of_order(&self) -> bool {
        self.gaps.goes_back() || refused_often(self.refused, self.rows).is_some()
    }

    /// What parts an input whose times are out of order.
    pub fn parted(&mut self, several: Option<Finding>) {
        self.several = several;
    }

    /// Checks whether the rows can give a result: at least half were accepted, and a signal has a value.
    pub fn has_rows(&self) -> Result<(), Failure> {
        if self.rows == 0 {
            return Err(Failure::input(
                "the input gives no row",
                "the times of the input",
                "give a longer recording, or check the rate and the master of the signal map",
            ));
        }
        most_rows_were_taken(self.refused, self.rows).map_err(|failure| match &self.several {
            Some(found) => Failure::input(&found.what, TIME, &found.remedy),
            None if falls(&self.times) => Failure::input(
                format!(
                    "{} of {} rows were refused: they stand in the reverse order, each time before that of the row above it",
                    self.refused, self.rows
                ),
                TIME,
                "sort the rows by time",
            ),
            None => failure,
        })?;
        if !self.is_measured {
            return Err(Failure::input(
                "nothing was measured: no row has a value beside the time",
                "the columns that are used",
                "check that the sensors were on, and the columns of the signal map",
            ));
        }
        Ok(())
    }

    /// Fails on a certain error: damaged data, times in another unit, gaps, many refused rows, too large values, another machine;
    /// without any, on an input whose end is missing.
    pub fn judge(&self, lacks: &Lacks) -> Result<(), Failure> {
        lacks.remarks().for_each(|remark| eprintln!("{remark}"));
        parts::check_undamaged(lacks)?;
        let fault = time_fault(&self.times, self.rate)
            .or_else(|| self.several.clone())
            .or_else(|| self.gaps.fault())
            .or_else(|| refused_often(self.refused, self.rows))
            .or_else(|| self.look.as_ref().and_then(L::fault))
            .or_else(|| self.often_too_large());
        let Some(fault) = fault else {
            let time = |sample: &L::Sensors| Some(sample.stamp().time).filter(|t| t.is_finite());
            return parts::check_end(lacks, || self.before.as_ref().and_then(time));
        };
        lacks.cut_off.iter().for_each(|cut| eprintln!("{cut}"));
        let fault = advised(fault, self.map.as_ref());
        Err(Failure::answer_is_no(fault.to_string()))
    }
}

/// Where a fault of the times is.
const TIME: &str = "the time `t`";

/// Whether each time is before the previous one.
fn falls(times: &[f64]) -> bool {
    times.len() > 2 && times.is_sorted_by(|before, time| time < before)
}

/// Sampling periods of any sensor \[s\].
const STEPS: RangeInclusive<f64> = 1e-6..=10.0;

/// The fault of times that cannot be in seconds, or do not fit the described rate \[Hz\].
fn time_fault(times: &[f64], rate: f64) -> Option<Finding> {
    let (step, remedy) = match recording::time_unit(times, rate) {
        Some((step, unit)) => (
            step,
            format!(
                "is the time in {unit}? write t = {{ column = \"t\", unit = \"{unit}\" }} in a signal map; else state sensors.rate{}",
                match 1.0 / step {
                    rate @ 1.0.. => format!(" = {rate:.0} in the machine file"),
                    _ => String::new(),
                }
            ),
        ),
        None => (
            recording::usual_step(times).filter(|step| !STEPS.contains(step))?,
            "check the unit of the time".into(),
        ),
    };
    Some(Finding::new(
        format!("the rows are {step} s apart, and sensors.rate is {rate} Hz"),
        remedy,
    ))
}

/// Rows per refused row, or per too large value, below which a result is in doubt.
const REFUSED_ONE_IN: usize = 10;

/// The fault of an input in which more than one row in ten was refused.
fn refused_often(refused: usize, rows: usize) -> Option<Finding> {
    (REFUSED_ONE_IN * refused > rows).then(|| {
        Finding::new(
            format!("{refused} of {rows} rows were refused, more than one in {REFUSED_ONE_IN}: their time is missing or does not increase"),
            "give the times with more digits, and sort the rows by time; rows at even steps need no time: t = { column = \"row\", scale = 0.01 } in a signal map",
        )
    })
}

/// The fault of a signal that is larger than any measurement in more than one row in ten.
fn too_large_often(name: &str, large: usize, rows: usize) -> Option<Finding> {
    (REFUSED_ONE_IN * large > rows).then(|| {
        Finding::new(
            format!("{name} is larger than any measurement in {large} of {rows} rows, where it counts as missing"),
            "check its unit and scale in the signal map, and the size of the machine (--class, --config)",
        )
    })
}

/// Fails if most rows were refused: the times run backwards, or the time is in another column.
pub fn most_rows_were_taken(refused: usize, rows: usize) -> Result<(), Failure> {
    if 2 * refused <= rows {
        return Ok(());
    }
    Err(Failure::input(
        format!(
            "{refused} of {rows} rows were refused: their time is missing or does not increase"
        ),
        TIME,
        "give the times with more digits if several rows have one (rows at even steps need none: t = { column = \"row\", scale = 0.01 } in a signal map), sort the rows by time, or map `t` to the column that increases",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_in_ten_may_be_refused() {
        assert_eq!(refused_often(10, 100), None);
        assert!(refused_often(11, 100).is_some_and(|words| words.what.contains("11 of 100 rows")));
    }

    /// Checks nothing.
    struct Nothing;

    impl Look for Nothing {
        type Described = config::Loader;
        type Sensors = messages::LoaderSensors;

        fn of(_: &config::Loader) -> Self {
            Self
        }

        fn largest(_: &config::Loader, _: &str) -> Option<f64> {
            Some(1e8)
        }

        fn add(&mut self, _: &messages::LoaderSensors) {}

        fn fault(&self) -> Option<Finding> {
            None
        }
    }

    #[test]
    fn one_value_in_ten_may_be_too_large_and_a_mark_is_none() {
        assert_eq!(too_large_often("speed", 10, 100), None);
        assert!(
            too_large_often("speed", 11, 100).is_some_and(|text| text.what.contains("speed is"))
        );
        let fault = |value: fn(u32) -> f64| {
            let loader = Description::default_of(messages::Machine::Loader);
            let mut doubts = Doubts::<Nothing>::of(&loader);
            for k in 0..1000 {
                let sample = messages::LoaderSensors {
                    lift_head_pressure: value(k),
                    valid: u32::MAX,
                    ..Default::default()
                };
                doubts.add(&sample, false);
            }
            doubts.often_too_large()
        };
        assert!(fault(|k| 1e9 + f64::from(k)).is_some());
        assert_eq!(fault(|k| if k % 2 == 0 { 4e9 } else { 1e7 }), None);
    }

    #[test]
    fn a_run_without_an_end_is_judged_after_a_minute_and_at_twice_as_many_rows_again() {
        let loader = Description::default_of(messages::Machine::Loader);
        let mut seen = Seen::<Nothing, ()>::of(&loader);
        let mut judged = Vec::new();
        for k in 1..=12_000 {
            let sample = messages::LoaderSensors {
                lift_head_pressure: 1e9 + f64::from(k),
                valid: u32::MAX,
                ..Default::default()
            };
            seen.doubts.add(&sample, false);
            judged.extend(seen.found().map(|fault| (k, fault.to_string())));
        }
        let at: Vec<i32> = judged.iter().map(|(k, _)| *k).collect();
        assert_eq!(at, [6000, 12_000]);
        assert!(judged[0].1.contains("larger than any measurement"));
    }

    #[test]
    fn a_row_that_is_written_twice_is_no_doubt_and_another_of_its_time_is() {
        let judged = |second: f64| {
            let loader = Description::default_of(messages::Machine::Loader);
            let mut doubts = Doubts::<Nothing>::of(&loader);
            for k in 0..100 {
                let mut sample = messages::LoaderSensors {
                    speed: f64::from(k),
                    valid: u32::MAX,
                    ..Default::default()
                };
                sample.stamp.time = 0.01 * f64::from(k);
                doubts.add(&sample, false);
                sample.speed += second;
                doubts.add(&sample, true);
            }
            refused_often(doubts.refused, doubts.rows)
        };
        assert_eq!(judged(0.0), None);
        assert!(judged(0.1).is_some());
    }

    #[test]
    fn times_in_milliseconds_are_named_and_slow_sensors_are_not() {
        let every = |step: f64| (0..50).map(|i| f64::from(i) * step).collect::<Vec<_>>();
        assert!(time_fault(&every(10.0), 100.0).is_some_and(|h| h.remedy.contains("\"ms\"")));
        assert!(time_fault(&every(1e4), 100.0).is_some_and(|h| h.remedy.contains("\"us\"")));
        for step in [0.001, 0.01, 0.1, 1.0] {
            assert_eq!(time_fault(&every(step), 100.0), None, "{step} s");
        }
        assert_eq!(time_fault(&[], 100.0), None);
        for step in [1e-11, 864.0] {
            let hint = time_fault(&every(step), 100.0).expect("a hint");
            assert_eq!(hint.remedy, "check the unit of the time");
        }
    }
}
