//! The trust matrix: one column of the sensors goes wrong in the middle of the work, in every way and for
//! every method, or is another machine's. What counts is the share of what is trusted afterwards that is wrong, by
//! the judge of `statistics`: the 95 % interval does not hold the truth, or it is more than 10 % away.
//!
//! Some faults cannot be distinguished from another machine by anybody (a gain of the torque is an inertia). Those
//! cells are in [`KNOWN`] and [`KNOWN_FROM_THE_START`], with the reason in `docs/trust-matrix.md`; every other has the bound.

use std::fmt;

use config::Description;
use messages::{Envelope, Machine, Message, Value};
use recording::Sensors;
use runtime::Source;
use statistics::judge::is_wrong;
use steps::stages::Pipeline;
use view::estimate::{Estimate, Parameter};

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

/// Largest share of the trusted samples that may be wrong.
const BOUND: f64 = 0.05;
/// The same of a known cell: largest share of the time that may be trusted and wrong. The worst of eight tables was 0.20.
const KNOWN_BOUND: f64 = 0.35;
/// Fewer trusted samples than these have no share \[samples\].
const LEAST: u32 = 20;
/// Length of a run, when the fault begins, and how long a drift takes \[s\].
const DURATION: f64 = 60.0;
pub const FROM: f64 = 25.0;
const DRIFT: f64 = 10.0;
/// Another machine is so far ahead in its work \[samples at 100 Hz\].
const MEANWHILE: usize = 1700;

/// A fault of one column.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Missing,
    Frozen,
    Zero,
    /// Late by so many samples at 100 Hz.
    Late(usize),
    Gain(f64),
    /// In root mean squares of the column.
    Offset(f64),
    /// The same, little by little.
    Drift(f64),
    GainDrift(f64),
    /// Written in another unit.
    Unit,
    /// Off by so many rad: an angle that was mounted or described otherwise.
    Angle(f64),
    /// What another machine measures meanwhile, at another moment of its work.
    Foreign,
}

/// The kinds, by their names.
const KINDS: [(&str, Kind); 18] = [
    ("missing", Kind::Missing),
    ("frozen", Kind::Frozen),
    ("zero", Kind::Zero),
    ("late 50 ms", Kind::Late(5)),
    ("late 200 ms", Kind::Late(20)),
    ("late 500 ms", Kind::Late(50)),
    ("gain 0.5", Kind::Gain(0.5)),
    ("gain 0.8", Kind::Gain(0.8)),
    ("gain 1.1", Kind::Gain(1.1)),
    ("gain 1.25", Kind::Gain(1.25)),
    ("gain 2", Kind::Gain(2.0)),
    ("sign", Kind::Gain(-1.0)),
    ("offset", Kind::Offset(0.3)),
    ("unit", Kind::Unit),
    ("0.3 rad off", Kind::Angle(0.3)),
    ("another machine's", Kind::Foreign),
    ("drift", Kind::Drift(0.3)),
    ("drift of the gain", Kind::GainDrift(0.8)),
];

/// Columns that go wrong, with the factor of a wrong unit.
const COLUMNS: &[(&str, f64)] = &[
    ("swing_velocity", 57.3),
    ("swing_torque", 1e-3),
    ("boom_angle", 57.3),
    ("arm_angle", 57.3),
    ("bucket_angle", 57.3),
    ("speed", 3.6),
    ("front_wheel_speed", 9.55),
    ("rear_wheel_speed", 9.55),
    ("front_torque", 1e-3),
    ("rear_torque", 1e-3),
    ("slope", 57.3),
    ("acceleration", 0.102),
];

/// The joint angles together: one bus, one wrong drawing.
const JOINTS: (&str, [&str; 3]) = ("joint angles", ["boom_angle", "arm_angle", "bucket_angle"]);

/// A column of a machine: name, bit, factor of a wrong unit.
type Column = (&'static str, u32, f64);

/// What goes wrong together, and its name.
type Group = (&'static str, Vec<Column>);

/// One cell of the matrix.
#[derive(Clone, Copy)]
pub struct Cell {
    machine: Machine,
    method: &'static str,
    group: usize,
    kind: usize,
}

/// What became of a cell.
#[derive(Clone, Copy, Default)]
pub struct Share {
    after: u32,
    trusted: u32,
    wrong: u32,
}

impl Share {
    /// Wrong of the trusted.
    fn wrong(self) -> f64 {
        if self.trusted < LEAST {
            return 0.0;
        }
        f64::from(self.wrong) / f64::from(self.trusted)
    }

    /// Trusted and wrong, of the time.
    fn wrong_of_time(self) -> f64 {
        f64::from(self.wrong) / f64::from(self.after.max(1))
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let trusted = 100.0 * f64::from(self.trusted) / f64::from(self.after.max(1));
        if trusted < 0.5 {
            return f.write_str("–");
        }
        write!(f, "{trusted:.0}/{:.0}", 100.0 * self.wrong())
    }
}

/// Runs cells on the samples of a machine, before anything went wrong, with the time of the fault.
type Clean = Box<dyn Fn(Cell, f64) -> Result<Share, String>>;

macro_rules! machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// A machine at its usual work.
        fn clean(machine: Machine, seed: u64) -> Result<Clean, String> {
            Ok(match machine {
                $( Machine::$machine => {
                    let mut source = sensor::$module::Simulator::at_usual_work(DURATION, seed)
                        .map_err(|e| e.to_string())?;
                    let mut other = sensor::$module::Simulator::at_usual_work(DURATION, seed + 1)
                        .map_err(|e| e.to_string())?;
                    let series: Vec<_> = std::iter::from_fn(|| source.next()).collect();
                    let other: Vec<_> = std::iter::from_fn(|| other.next()).collect();
                    Box::new(move |cell, from| {
                        cell.judge::<_, messages::$estimate>(series.clone(), &other, from)
                    })
                } )*
            })
        }

        fn groups(machine: Machine) -> Vec<Group> {
            match machine {
                $( Machine::$machine => groups_of::<messages::$sensors>(), )*
            }
        }
    };
}

messages::machines!(machines);

/// Each column that goes wrong alone, and the joint angles together.
fn groups_of<S: Sensors>() -> Vec<Group> {
    let of = |(index, bit): (usize, u32)| {
        let (name, unit) = COLUMNS.iter().find(|c| c.0 == S::FIELDS[index].name)?;
        Some((*name, bit, *unit))
    };
    let columns: Vec<Column> = recording::measured::<S>().filter_map(of).collect();
    let is_joint = |column: &&Column| JOINTS.1.contains(&column.0);
    let joints: Vec<Column> = columns.iter().filter(is_joint).copied().collect();
    let mut groups: Vec<Group> = columns.iter().map(|c| (c.0, vec![*c])).collect();
    groups.extend((!joints.is_empty()).then_some((JOINTS.0, joints)));
    groups
}

/// Every cell.
pub fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for machine in Machine::ALL {
        let stages = Pipeline::of(machine).stages.iter();
        for method in stages.flat_map(|s| s.methods()).copied() {
            for (group, (_, columns)) in groups(machine).iter().enumerate() {
                let of = |kind| Cell {
                    machine,
                    method,
                    group,
                    kind,
                };
                let kinds = (0..KINDS.len()).filter(|kind| can_be(KINDS[*kind].1, columns));
                cells.extend(kinds.map(of));
            }
        }
    }
    cells
}

/// Only angles are off by an angle.
fn can_be(kind: Kind, columns: &[Column]) -> bool {
    !matches!(kind, Kind::Angle(_)) || columns.iter().all(|c| JOINTS.1.contains(&c.0))
}

impl Cell {
    fn name(self) -> String {
        let Self {
            machine, method, ..
        } = self;
        format!("{machine} {method} {} {}", self.place(), KINDS[self.kind].0)
    }

    /// What goes wrong.
    fn place(self) -> &'static str {
        groups(self.machine)[self.group].0
    }

    /// Whether so much may be wrong.
    fn allows(self, share: Share, from: f64) -> bool {
        share.wrong() <= BOUND || self.is_known(from) && share.wrong_of_time() <= KNOWN_BOUND
    }

    fn is_known(self, from: f64) -> bool {
        let cell = (self.place(), KINDS[self.kind].0);
        let methods = ["auto", "posture-torque"];
        let known = if from > 0.0 {
            KNOWN
        } else {
            KNOWN_FROM_THE_START
        };
        methods.contains(&self.method) && known.contains(&cell)
    }

    /// Runs the cell.
    fn judge<S: Message, E: Estimate>(
        self,
        mut series: Vec<(S, E::Truth)>,
        other: &[(S, E::Truth)],
        from: f64,
    ) -> Result<Share, String> {
        for column in &groups(self.machine)[self.group].1 {
            damage(&mut series, other, *column, KINDS[self.kind].1, from);
        }
        let description = Description::default_of(self.machine);
        let pipeline = Pipeline::of(self.machine);
        let stage = pipeline.with_method(self.method).ok_or("no such method")?;
        let mut way = Vec::new();
        for row in pipeline.way_to(stage) {
            let method = if row.methods().contains(&self.method) {
                self.method
            } else {
                ""
            };
            way.push(row.start(&description, method).map_err(|e| e.to_string())?);
        }
        let mut share = Share::default();
        for (sample, truth) in &series {
            let mut message: Envelope = sample.envelope();
            for step in &mut way {
                message = step.answer(&message).ok_or("a step of another message")?;
            }
            if sample.stamp().time >= from {
                let estimate = E::inside(&message).ok_or("no estimate of this machine")?;
                E::headlines().for_each(|p| share.take(p, estimate, truth));
            }
        }
        Ok(share)
    }
}

impl Share {
    fn take<E: Estimate>(
        &mut self,
        judged: &Parameter<E, E::Truth>,
        estimate: &E,
        truth: &E::Truth,
    ) {
        self.after += 1;
        if estimate.flags() & judged.trusted == 0 {
            return;
        }
        self.trusted += 1;
        let (value, std) = (judged.value(estimate), judged.std(estimate));
        self.wrong += u32::from(is_wrong(value, std, judged.truth(truth)));
    }
}

/// Damages a column from this time on.
fn damage<S: Message, T>(
    series: &mut [(S, T)],
    other: &[(S, T)],
    (name, bit, unit): Column,
    kind: Kind,
    begin: f64,
) {
    let (Some(at), Some(valid)) = (S::index(name), S::index("valid")) else {
        return;
    };
    let value = |sample: &S| sample.get(at).map_or(0.0, Value::as_f64);
    let clean: Vec<f64> = series.iter().map(|(sample, _)| value(sample)).collect();
    let square = clean.iter().map(|v| v * v).sum::<f64>() / clean.len().max(1) as f64;
    let from = series.iter().position(|(s, _)| s.stamp().time >= begin);
    let from = from.unwrap_or(series.len());
    for (n, (sample, _)) in series.iter_mut().enumerate().skip(from) {
        let part = ((sample.stamp().time - begin) / DRIFT).min(1.0);
        let new = match kind {
            Kind::Missing => {
                if let Some(Value::U32(bits)) = sample.get(valid) {
                    sample.set(valid, Value::U32(bits & !bit));
                }
                continue;
            }
            Kind::Frozen => clean[from],
            Kind::Zero => 0.0,
            Kind::Late(samples) => clean[n.saturating_sub(samples)],
            Kind::Gain(gain) => gain * clean[n],
            Kind::Offset(share) => clean[n] + share * square.sqrt(),
            Kind::Drift(share) => clean[n] + part * share * square.sqrt(),
            Kind::GainDrift(gain) => clean[n] * (1.0 + part * (gain - 1.0)),
            Kind::Unit => unit * clean[n],
            Kind::Angle(angle) => clean[n] + angle,
            Kind::Foreign => value(&other[(n + MEANWHILE) % other.len()].0),
        };
        sample.set(at, Value::F64(new));
    }
}

/// One cell a turn.
pub struct Trust;

impl Attack for Trust {
    fn name(&self) -> String {
        "a cell of the trust matrix".into()
    }

    fn attempt(&mut self, rng: &mut Rng, _ground: &Ground) -> Result<Outcome, String> {
        let cell = rng.one(&cells());
        // From the start, or in the middle of the work.
        let later = 20.0 + rng.between(0, 15) as f64;
        let from = rng.one(&[0.0, later]);
        let share = clean(cell.machine, 1 + rng.between(0, 1000))?(cell, from)?;
        if !cell.allows(share, from) {
            let Share {
                after,
                trusted,
                wrong,
            } = share;
            return Err(format!(
                "{}: {wrong} of {trusted} trusted are wrong, of {after}",
                cell.name()
            ));
        }
        Ok(Outcome::Survived { gap: 0 })
    }
}

/// The matrix as Markdown, a table a method: the time that is trusted, and how much of that is wrong; what is above the
/// bound is named below it. Whether all of that is known.
pub fn print(word: &str, seed: u64, from: f64) -> Result<bool, String> {
    let chosen = cells().into_iter().filter(|c| c.name().contains(word));
    let chosen: Vec<Cell> = chosen.collect();
    let runs = Machine::ALL.map(|machine| clean(machine, seed));
    let mut all_known = true;
    for table in chosen.chunk_by(|a, b| (a.machine, a.method) == (b.machine, b.method)) {
        let run = runs[table[0].machine as usize]
            .as_ref()
            .map_err(String::clone)?;
        let judged = table.iter().map(|cell| Ok((*cell, run(*cell, from)?)));
        let judged: Vec<(Cell, Share)> = judged.collect::<Result<_, String>>()?;
        print_table(&judged);
        for (cell, share) in judged.iter().filter(|(_, share)| share.wrong() > BOUND) {
            let allowed = cell.allows(*share, from);
            let known = if allowed { "known" } else { "NEW" };
            println!("{}: {:.2} {known}", cell.name(), share.wrong());
            all_known &= allowed;
        }
    }
    Ok(all_known)
}

/// A row a kind, a column for what goes wrong.
fn print_table(judged: &[(Cell, Share)]) {
    let Some((first, _)) = judged.first() else {
        return;
    };
    let groups = groups(first.machine);
    let present = |group: &usize| judged.iter().any(|(cell, _)| cell.group == *group);
    let present: Vec<usize> = (0..groups.len()).filter(present).collect();
    println!("\n{}, `{}`:\n", first.machine, first.method);
    let names: Vec<String> = present
        .iter()
        .map(|g| format!("`{}`", groups[*g].0))
        .collect();
    println!(
        "| fault | {} |\n|{}",
        names.join(" | "),
        "---|".repeat(1 + names.len())
    );
    for (kind, (name, _)) in KINDS.iter().enumerate() {
        let text = |group: &usize| {
            let mut found = judged
                .iter()
                .filter(|(c, _)| (c.group, c.kind) == (*group, kind));
            found
                .next()
                .map_or(String::new(), |(_, share)| share.to_string())
        };
        let texts: Vec<String> = present.iter().map(text).collect();
        if texts.iter().any(|text| !text.is_empty()) {
            println!("| {name} | {} |", texts.join(" | "));
        }
    }
    println!();
}

/// Cells of the excavator's `posture-torque`, which `auto` chooses, that may lie above the bound when the fault begins in
/// the middle of the work: what goes wrong, and how.
const KNOWN: &[(&str, &str)] = &[
    ("swing_velocity", "drift"),
    ("swing_velocity", "drift of the gain"),
    ("swing_velocity", "gain 1.1"),
    ("swing_torque", "drift"),
    ("swing_torque", "gain 1.1"),
    ("swing_torque", "offset"),
    ("arm_angle", "frozen"),
    ("arm_angle", "late 200 ms"),
    (JOINTS.0, "drift"),
];

/// The same for a fault that is there from the first row on: a machine that is not the one of its machine file.
const KNOWN_FROM_THE_START: &[(&str, &str)] = &[
    ("swing_velocity", "drift"),
    ("swing_velocity", "gain 1.1"),
    ("swing_velocity", "offset"),
    ("swing_torque", "drift of the gain"),
    ("arm_angle", "late 200 ms"),
    (JOINTS.0, "late 200 ms"),
    (JOINTS.0, "late 500 ms"),
];
