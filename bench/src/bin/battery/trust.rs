//! The trust matrix: one column of the sensors becomes faulty during the work, with every kind of fault and for every method, or
//! comes from another machine. The measure is the share of wrong values among those trusted afterwards, by `statistics::judge`:
//! the 95 % interval does not hold the truth, or it is more than 10 % away (a load: of the largest one). A machine without a
//! fault must be trusted, or its row would have no meaning.
//!
//! Some faults are indistinguishable from another machine in principle (a gain of the torque is an inertia). Those cells are in
//! `known.csv`, with the reason in `docs/trust-matrix.md`; all others have the bound.

use std::fmt;

use config::Description;
use messages::{Machine, Message, Value};
use recording::Sensors;
use runtime::Source;
use sheet::Quantity;
use statistics::judge::{FAR, is_covered, is_wrong};
use steps::chain::{chain, last_answer};
use steps::stages::Pipeline;
use view::estimate::{Estimate, Parameter};

use crate::attack::{Attack, Outcome, Rng};
use crate::ground::Ground;

/// Largest share of the trusted samples that may be wrong.
const BOUND: f64 = 0.05;
/// Cells above the bound: method, with or without pressures, begin of the fault, quantity, columns and kind of the fault, and the
/// largest share of the time that may be trusted and wrong: a quarter, and two hundredths, beyond the worst of seven tables.
const KNOWN: &str = include_str!("known.csv");
/// Least number of trusted samples for a share \[samples\].
const LEAST: u32 = 20;
/// Least share of the time in which a sound machine is trusted, with or without pressures: four fifths of the least of six seeds.
const SOUND: &[(Machine, bool, &str, f64)] = &[
    (Machine::Excavator, false, "inertia", 0.24),
    (Machine::Excavator, false, "payload", 0.24),
    (Machine::Excavator, true, "inertia", 0.45),
    (Machine::Excavator, true, "payload", 0.45),
    (Machine::Loader, true, "cg_height", 0.57),
    (Machine::Loader, true, "cg_ratio", 0.45),
    (Machine::Loader, true, "payload", 0.47),
];
/// Length of a run, begin of the fault, and duration of a drift \[s\]. With a loader the times are longer by the factor below.
const DURATION: f64 = 60.0;
pub const FROM: f64 = 25.0;
const LONGER: f64 = 2.0;
const DRIFT: f64 = 10.0;
/// Lead of the other machine in its work \[samples at 100 Hz\].
const MEANWHILE: usize = 1700;

/// A fault of one column.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// No fault.
    Sound,
    Missing,
    Frozen,
    Zero,
    /// Delay in samples at 100 Hz.
    Late(usize),
    Gain(f64),
    /// Offset in root mean squares of the column.
    Offset(f64),
    /// The same offset as a ramp.
    Drift(f64),
    GainDrift(f64),
    /// Another unit.
    Unit,
    /// Offset of an angle by its mounting or description \[rad\].
    Angle(f64),
    /// The signal of another machine at the same time, in another phase of its work.
    Foreign,
    /// Two columns exchanged.
    Swapped,
}

/// The kinds by name.
const KINDS: [(&str, Kind); 20] = [
    ("nothing", Kind::Sound),
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
    ("exchanged", Kind::Swapped),
];

/// Columns with faults, with the factor of a wrong unit.
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
    ("lift_angle", 57.3),
    ("boom_head_pressure", 1e-5),
    ("boom_rod_pressure", 1e-5),
    ("lift_head_pressure", 1e-5),
    ("lift_rod_pressure", 1e-5),
];

/// Joint angles, which a drawing may define differently.
const ANGLES: [&str; 4] = ["boom_angle", "arm_angle", "bucket_angle", "lift_angle"];

/// Columns with a common fault: one bus, one wrong drawing, one supply.
const TOGETHER: [(&str, &[&str]); 3] = [
    ("joint angles", &["boom_angle", "arm_angle", "bucket_angle"]),
    (
        "boom pressures",
        &["boom_head_pressure", "boom_rod_pressure"],
    ),
    (
        "lift pressures",
        &["lift_head_pressure", "lift_rod_pressure"],
    ),
];

/// A column of a machine: name, bit, factor of a wrong unit.
type Column = (&'static str, u32, f64);

/// Columns with a common fault, and their name.
type Group = (&'static str, Vec<Column>);

/// One cell of the matrix.
#[derive(Clone, Copy)]
pub struct Cell {
    machine: Machine,
    /// Whether pressures in its cylinders weigh.
    pressed: bool,
    method: &'static str,
    group: usize,
    kind: usize,
}

/// Counts of a cell.
#[derive(Clone, Copy, Default)]
pub struct Share {
    after: u32,
    trusted: u32,
    wrong: u32,
}

impl Share {
    /// Wrong values, as a share of the trusted ones.
    fn wrong(self) -> f64 {
        if self.trusted < LEAST {
            return 0.0;
        }
        f64::from(self.wrong) / f64::from(self.trusted)
    }

    fn trusted_of_time(self) -> f64 {
        f64::from(self.trusted) / f64::from(self.after.max(1))
    }

    /// Trusted and wrong values, as a share of the time.
    fn wrong_of_time(self) -> f64 {
        f64::from(self.wrong) / f64::from(self.after.max(1))
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let trusted = 100.0 * self.trusted_of_time();
        if trusted < 0.5 {
            return f.write_str("–");
        }
        write!(f, "{trusted:.0}/{:.0}", 100.0 * self.wrong())
    }
}

/// Runs cells on the samples of a machine without a fault, with the time of the fault; returns a share for each quantity.
type Clean = Box<dyn Fn(Cell, f64) -> Result<Vec<Share>, String>>;

macro_rules! machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        /// A machine at its usual work.
        fn clean(machine: Machine, pressed: bool, seed: u64) -> Result<Clean, String> {
            let duration = DURATION * longer(machine);
            Ok(match machine {
                $( Machine::$machine => {
                    use sensor::$module::Simulator;
                    let begin = |seed| {
                        let new = match pressed {
                            true => Simulator::weighing(duration, seed),
                            false => Simulator::at_usual_work(duration, seed).map(|s| (s, Vec::new())),
                        };
                        new.map_err(|e| e.to_string())
                    };
                    let ((mut source, stated), (mut other, _)) = (begin(seed)?, begin(seed + 1)?);
                    let series: Vec<_> = std::iter::from_fn(|| source.next()).collect();
                    let other: Vec<_> = std::iter::from_fn(|| other.next()).collect();
                    Box::new(move |cell, from| {
                        cell.judge::<_, messages::$estimate>(&stated, series.clone(), &other, from)
                    })
                } )*
            })
        }

        fn groups(machine: Machine, pressed: bool) -> Vec<Group> {
            match machine {
                $( Machine::$machine => groups_of::<messages::$sensors>(pressed), )*
            }
        }

        /// The judged quantities: those with a verdict, and loads.
        fn judged(machine: Machine) -> impl Iterator<Item = &'static Quantity> {
            let all = match machine {
                $( Machine::$machine => sheet::$module::QUANTITIES, )*
            };
            all.iter().filter(|q| q.is_headline || q.is_load)
        }
    };
}

messages::machines!(machines);

/// Factor of the times: a loader has another load every 26 s.
fn longer(machine: Machine) -> f64 {
    match machine {
        Machine::Excavator => 1.0,
        Machine::Loader => LONGER,
    }
}

/// With and without pressures; a loader only with pressures, because it is not trusted without them.
fn outfits(machine: Machine) -> &'static [bool] {
    match machine {
        Machine::Excavator => &[false, true],
        Machine::Loader => &[true],
    }
}

/// No column, each column alone, and the columns with a common fault.
fn groups_of<S: Sensors>(pressed: bool) -> Vec<Group> {
    let of = |(index, bit): (usize, u32)| {
        let (name, unit) = COLUMNS.iter().find(|c| c.0 == S::FIELDS[index].name)?;
        let is_there = pressed || !name.ends_with("_pressure");
        is_there.then_some((*name, bit, *unit))
    };
    let columns: Vec<Column> = recording::measured::<S>().filter_map(of).collect();
    let mut groups: Vec<Group> = vec![("sound", Vec::new())];
    groups.extend(columns.iter().map(|c| (c.0, vec![*c])));
    for (name, all) in TOGETHER {
        let mine = columns.iter().filter(|column| all.contains(&column.0));
        let mine: Vec<Column> = mine.copied().collect();
        groups.extend((!mine.is_empty()).then_some((name, mine)));
    }
    groups
}

/// Every cell.
pub fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for machine in Machine::ALL {
        for pressed in outfits(machine).iter().copied() {
            let stages = Pipeline::of(machine).stages.iter();
            for method in stages.flat_map(|s| s.methods()).copied() {
                for (group, (_, columns)) in groups(machine, pressed).iter().enumerate() {
                    let of = |kind| Cell {
                        machine,
                        pressed,
                        method,
                        group,
                        kind,
                    };
                    let kinds = (0..KINDS.len()).filter(|kind| can_be(KINDS[*kind].1, columns));
                    cells.extend(kinds.map(of));
                }
            }
        }
    }
    cells
}

/// Whether a kind applies: no fault has no columns, only angles have an offset of an angle, and only two pressures are exchanged.
fn can_be(kind: Kind, columns: &[Column]) -> bool {
    match kind {
        Kind::Sound => columns.is_empty(),
        _ if columns.is_empty() => false,
        Kind::Angle(_) => columns.iter().all(|c| ANGLES.contains(&c.0)),
        Kind::Swapped => columns.len() == 2,
        _ => true,
    }
}

impl Cell {
    fn name(self) -> String {
        let Self {
            machine, method, ..
        } = self;
        let pressures = if self.pressed { " with pressures" } else { "" };
        let kind = KINDS[self.kind].0;
        format!("{machine}{pressures} {method} {} {kind}", self.place())
    }

    /// The table that contains it.
    fn table(self) -> (Machine, bool, &'static str) {
        (self.machine, self.pressed, self.method)
    }

    /// The faulty columns.
    fn place(self) -> &'static str {
        groups(self.machine, self.pressed)[self.group].0
    }

    /// Violation by a quantity, if any: too many wrong values, or too few trusted ones without a fault.
    fn fault(self, quantity: &Quantity, share: Share, from: f64) -> Option<String> {
        let Share {
            after,
            trusted,
            wrong,
        } = share;
        let is_usual = ["auto", "posture-torque", "full-ekf", "full"].contains(&self.method);
        let is_sound = matches!(KINDS[self.kind].1, Kind::Sound);
        let is_mine = |limit: &&(Machine, bool, &str, f64)| {
            (limit.0, limit.1, limit.2) == (self.machine, self.pressed, quantity.name)
        };
        let least = SOUND.iter().filter(|_| is_usual && is_sound).find(is_mine);
        let least = least.map_or(0.0, |limit| limit.3);
        let known = self.known(quantity, from);
        let fault = if share.trusted_of_time() < least {
            format!("trusted for less than {least} of the time")
        } else if share.wrong() > BOUND && share.wrong_of_time() > known {
            format!("more than {BOUND} of it is wrong")
        } else {
            return None;
        };
        let name = quantity.name;
        Some(format!(
            "{}: {name}: {fault}: {wrong} of {trusted} trusted are wrong, of {after}",
            self.name()
        ))
    }

    /// The row of a known cell, without its share.
    fn row(self, quantity: &Quantity, from: f64) -> String {
        let weighs = if self.pressed { "pressures" } else { "motion" };
        let since = if from == 0.0 { "start" } else { "middle" };
        let (name, kind) = (quantity.name, KINDS[self.kind].0);
        // `auto` selects the first; the loader's two methods differ little.
        let method = match self.method {
            "auto" | "posture-torque" | "full" | "full-ekf" => "usual",
            other => other,
        };
        format!("{method},{weighs},{since},{name},{},{kind},", self.place())
    }

    /// Permitted share of the time that is trusted and wrong.
    fn known(self, quantity: &Quantity, from: f64) -> f64 {
        let row = self.row(quantity, from);
        let mut shares = KNOWN.lines().filter_map(|line| line.strip_prefix(&row));
        shares.find_map(|share| share.parse().ok()).unwrap_or(0.0)
    }

    /// Runs the cell.
    fn judge<S: Message, E: Estimate>(
        self,
        stated: &[String],
        mut series: Vec<(S, E::Truth)>,
        other: &[(S, E::Truth)],
        from: f64,
    ) -> Result<Vec<Share>, String> {
        let from = from * longer(self.machine);
        let (_, columns) = &groups(self.machine, self.pressed)[self.group];
        match (KINDS[self.kind].1, columns.as_slice()) {
            (Kind::Swapped, [one, two]) => exchange(&mut series, [one.0, two.0], from),
            (kind, columns) => columns
                .iter()
                .for_each(|column| damage(&mut series, other, *column, kind, from)),
        }
        let mut description = Description::default_of(self.machine);
        description.set_all(stated).map_err(|e| e.to_string())?;
        let chain = chain(&description, self.method);
        let mut chain = chain.map_err(|e| e.to_string())?;
        let parameter =
            |q: &'static Quantity| Some((q, E::PARAMETERS.iter().find(|p| p.key == q.name)?));
        let judged: Vec<_> = judged(self.machine).filter_map(parameter).collect();
        let loads = judged.iter().map(|(_, p)| p).filter(|p| p.is_load);
        let loads = loads.flat_map(|p| series.iter().map(|(_, truth)| p.truth(truth)));
        let full = loads.fold(0.0, f64::max);
        let mut shares = vec![Share::default(); judged.len()];
        for (sample, truth) in &series {
            let message = last_answer(&mut chain, sample.envelope());
            let message = message.ok_or("a step of another message")?;
            if sample.stamp().time >= from {
                let estimate = E::inside(&message).ok_or("no estimate of this machine")?;
                for (share, (quantity, parameter)) in shares.iter_mut().zip(&judged) {
                    let trusted = estimate.flags() & quantity.trusted != 0;
                    share.take(trusted, parameter, estimate, truth, full);
                }
            }
        }
        Ok(shares)
    }
}

impl Share {
    fn take<E: Estimate>(
        &mut self,
        trusted: bool,
        judged: &Parameter<E, E::Truth>,
        estimate: &E,
        truth: &E::Truth,
        full: f64,
    ) {
        self.after += 1;
        if !trusted {
            return;
        }
        self.trusted += 1;
        let (value, std, truth) = (
            judged.value(estimate),
            judged.std(estimate),
            judged.truth(truth),
        );
        let is_wrong = match judged.is_load {
            true => !is_covered(value, std, truth) || (value - truth).abs() > FAR * full,
            false => is_wrong(value, std, truth),
        };
        self.wrong += u32::from(is_wrong);
    }
}

/// Exchanges two columns from time `begin` on.
fn exchange<S: Message, T>(series: &mut [(S, T)], columns: [&str; 2], begin: f64) {
    let [Some(one), Some(two)] = columns.map(S::index) else {
        return;
    };
    for (sample, _) in series.iter_mut().filter(|(s, _)| s.stamp().time >= begin) {
        if let (Some(a), Some(b)) = (sample.get(one), sample.get(two)) {
            sample.set(one, b);
            sample.set(two, a);
        }
    }
}

/// Damages a column from time `begin` on.
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
            Kind::Sound | Kind::Swapped => continue,
        };
        sample.set(at, Value::F64(new));
    }
}

/// One cell per attempt.
pub struct Trust;

impl Attack for Trust {
    fn name(&self) -> String {
        "a cell of the trust matrix".into()
    }

    fn attempt(&mut self, rng: &mut Rng, _ground: &Ground) -> Result<Outcome, String> {
        let cell = rng.one(&cells());
        // From the start, or during the work.
        let later = 20.0 + rng.between(0, 15) as f64;
        let from = rng.one(&[0.0, later]);
        let shares = clean(cell.machine, cell.pressed, 1 + rng.between(0, 1000))?(cell, from)?;
        let mut judged = judged(cell.machine).zip(shares);
        if let Some(fault) = judged.find_map(|(quantity, share)| cell.fault(quantity, share, from))
        {
            return Err(fault);
        }
        Ok(Outcome::Survived { gap: 0 })
    }
}

/// Prints the matrix as Markdown, a table for each quantity of a method: the trusted share of the time, and the wrong share of
/// it. Cells above the bound are listed below. Returns whether all of them are known.
pub fn print(word: &str, seed: u64, from: f64) -> Result<bool, String> {
    let chosen = cells().into_iter().filter(|c| c.name().contains(word));
    let chosen: Vec<Cell> = chosen.collect();
    let mut all_known = true;
    for table in chosen.chunk_by(|a, b| a.table() == b.table()) {
        let (machine, pressed, _) = table[0].table();
        let run = clean(machine, pressed, seed)?;
        let shares = table.iter().map(|cell| Ok((*cell, run(*cell, from)?)));
        let shares: Vec<(Cell, Vec<Share>)> = shares.collect::<Result<_, String>>()?;
        for (i, quantity) in judged(machine).enumerate() {
            let mine: Vec<(Cell, Share)> = shares.iter().map(|(c, s)| (*c, s[i])).collect();
            print_table(&mine, quantity);
            for (cell, share) in &mine {
                let fault = cell.fault(quantity, *share, from);
                if let Some(fault) = &fault {
                    let row = cell.row(quantity, from);
                    println!("NEW {fault}: {row}{:.2}", share.wrong_of_time());
                } else if share.wrong() > BOUND {
                    println!(
                        "known {}: {}: {:.2}",
                        cell.name(),
                        quantity.name,
                        share.wrong()
                    );
                }
                all_known &= fault.is_none();
            }
        }
    }
    Ok(all_known)
}

/// A row for each kind, a column for each group of columns.
fn print_table(judged: &[(Cell, Share)], quantity: &Quantity) {
    let Some((first, _)) = judged.first() else {
        return;
    };
    let groups = groups(first.machine, first.pressed);
    let present = |group: &usize| judged.iter().any(|(cell, _)| cell.group == *group);
    let present: Vec<usize> = (0..groups.len()).filter(present).collect();
    let pressures = if first.pressed { " with pressures" } else { "" };
    println!(
        "\n{}{pressures}, `{}`, `{}`:\n",
        first.machine, first.method, quantity.name
    );
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
