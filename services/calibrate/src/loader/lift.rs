//! Identifies zero, span and friction of the lift cylinders, and the moment missing in the arm's drawing, from slow lifts with known loads.
//!
//! ```text
//! r F = (1 + s) tau + missed + r (z + F_c d + f)        tau: the moment of the described arm with the known load
//! ```
//! ([`LiftMoment`]) is linear in the span s, the zero z, the friction F_c and the missed moment, with cosine and sine of the angles of arm
//! and bucket. Loads and slope are known to their tolerances, and the rest f is correlated over some seconds: one least-squares fit with
//! priors ([`crate::lasting`]). The position of the load in the bucket is the described one: an error of it counts as a span.

use config::Loader as Description;
use estimation::Quantity;
use estimation::loader::{LiftKnown, LiftMoment, Lifts, Method, Sample, Settings};
use estimation::math::norm;

use super::known::MASS_STD;
use super::role::StatedLoad;
use super::{GRAVITY, Input};
use crate::column::percentile;
use crate::cylinders::{
    self, CURVE, FRICTION, IDENTIFIED, LEAST_MOTION, LEAST_STD, LEVEL, SPAN, ZERO,
};
use crate::lasting::{Equation, GAP, Solution};
use crate::output::Pen;

/// Standard deviations, as shares of the full force and of the span, below which friction and span count as identified in any case.
const KNOWN_FRICTION: f64 = 0.003;
const KNOWN_SPAN: f64 = 0.005;
/// Least standard deviation of a written span: loads lie elsewhere, and oil warms.
const SPAN_FLOOR: f64 = 0.01;
/// Distance of a recording from the description above which its load is contradicted, in standard deviations.
const FAR: f64 = 4.0;
/// Offset of a centre of mass from its line of pins, as a share of its distance: Z linkages, cylinders on the arm. The same of the
/// empty bucket from the line to the load.
const CENTRE_BESIDE: f64 = 0.1;
const BUCKET_BESIDE: f64 = 0.3;
/// Correlation time of the errors of friction and drawing \[s\].
const FADING: f64 = 3.0;
/// Tolerances of a drawing: masses of arm and bucket, and their distances, as in `machine.lift_arm`.
const DRAWN: [f64; 4] = [0.05, 0.2, 0.05, 0.1];

/// Index of the first unknown behind those of every cylinder and the four missed moments: for each recording its load and its slope.
const LOADS: usize = CURVE + CURVES.len();

/// Keys of the missed moment.
const CURVES: [&str; 4] = [
    "machine.lift_arm.arm_cos",
    "machine.lift_arm.arm_sin",
    "machine.lift_arm.bucket_cos",
    "machine.lift_arm.bucket_sin",
];

/// Fit of the lift cylinders: the missed moments are those of arm and bucket.
pub type CylinderFit = cylinders::CylinderFit<{ CURVES.len() }>;

/// Moments of a recording with a known load.
struct Run<'a> {
    name: &'a str,
    load: Quantity,
    moments: Vec<LiftMoment>,
}

/// The moments of a recording: none without a described arm or pressures, or if the arm never moves while the machine stands.
pub fn moments(settings: &Settings, samples: &[Sample]) -> Vec<LiftMoment> {
    let Some(mut lifts) = Lifts::new(settings) else {
        return Vec::new();
    };
    samples.iter().filter_map(|s| lifts.step(s)).collect()
}

/// Turn of the bucket per turn of the arm, from the angles of all recordings; `None` where it is stated.
pub fn bucket_turn(d: &Description, inputs: &[Input]) -> Option<Quantity> {
    let mut lifts = Lifts::new(&Settings::of(d, Method::Full))?;
    for sample in inputs.iter().flat_map(|input| &input.samples) {
        lifts.step(sample);
    }
    lifts.bucket_turn()
}

/// Duration in which the arm rises (1) or sinks (-1) \[s\].
fn moved<'a>(moments: impl Iterator<Item = &'a LiftMoment>, sign: f64) -> f64 {
    let these = moments.filter(|m| m.direction * sign > 0.0);
    these.map(|m| m.period.min(GAP)).sum()
}

/// Whether a recording lifts and lowers the arm for long enough.
pub fn lifts(moments: &[LiftMoment]) -> bool {
    moved(moments.iter(), 1.0) >= LEAST_MOTION && moved(moments.iter(), -1.0) >= LEAST_MOTION
}

/// Fit of the described cylinders, or why there is none; `None` where no pressure is measured.
pub fn learn(d: &Description, inputs: &[Input]) -> Option<Result<CylinderFit, String>> {
    let settings = Settings::of(d, Method::Full);
    let measured = |of: fn(&Sample) -> Option<f64>| {
        let mut samples = inputs.iter().flat_map(|input| &input.samples);
        samples.any(|s| of(s).is_some())
    };
    if !measured(|s| s.lift_head_pressure) || !measured(|s| s.lift_angle) {
        return None;
    }
    let Some(lifts) = Lifts::new(&settings) else {
        return Some(Err(NO_ARM.into()));
    };
    let known = lifts.known();
    let all = inputs
        .iter()
        .map(|input| (input, moments(&settings, &input.samples)));
    let moving: Vec<_> = all.filter(|(_, moments)| !moments.is_empty()).collect();
    if moving.is_empty() {
        return Some(Err(NO_LIFTS.into()));
    }
    let runs: Vec<Run<'_>> = moving
        .into_iter()
        .filter_map(|(input, moments)| {
            let load = load(d, input)?;
            Some(Run {
                name: &input.name,
                load,
                moments,
            })
        })
        .collect();
    if runs.is_empty() {
        return Some(Err(NO_LOAD.into()));
    }
    let every = || runs.iter().flat_map(|run| &run.moments);
    if [1.0, -1.0]
        .into_iter()
        .any(|sign| moved(every(), sign) < LEAST_MOTION)
    {
        return Some(Err(NO_LIFTS.into()));
    }
    Some(fit(d, &known, &runs))
}

/// Fault: there are pressures and no drawing.
const NO_ARM: &str = "lift pressures are recorded, but the machine file has no lift arm: its cylinders cannot be calibrated; measure the lengths of machine.lift_arm and machine.lift_arm.cylinder (docs/lift-arm.md)";
/// Fault: the arm hardly moves.
const NO_LIFTS: &str = "the lift cylinders keep the values of the machine file: lift and lower the arm slowly and fully, twice, while the machine stands and the bucket is off the ground";
/// Fault: no load is known.
const NO_LOAD: &str = "the lift cylinders keep the values of the machine file: the loads of the recordings with lifts are not known; state them: --payload empty.mcap=0 --payload loaded.mcap=KG±KG";
/// Difference of two loads above which they differ clearly, in standard deviations.
const CLEARLY: f64 = 5.0;
/// Fault: the loads do not determine the span.
fn one_load(runs: &[Run<'_>]) -> String {
    let loads: Vec<String> = runs
        .iter()
        .map(|run| {
            format!(
                "{}: {:.0} ± {:.0} kg",
                run.name, run.load.value, run.load.std
            )
        })
        .collect();
    let loads_differ = |a: &Run<'_>, b: &Run<'_>| {
        let std = norm(&[a.load.std, b.load.std]);
        (a.load.value - b.load.value).abs() > CLEARLY * std.max(1.0)
    };
    let differ = |a| runs.iter().any(|b| loads_differ(a, b));
    if runs.iter().any(differ) {
        return format!(
            "the lift cylinders keep the values of the machine file: the loads ({}) differ, and still the areas cannot be distinguished from the weight of the arm; check that all recordings are of one machine and that its arm was lifted slowly and fully, twice",
            loads.join(", ")
        );
    }
    format!(
        "the lift cylinders keep the values of the machine file: the loads ({}) are too much alike, or not known well enough, to distinguish the areas from the weight of the arm; record slow lifts with the bucket empty and with a weighed load, and state both: --payload FILE=KG±KG",
        loads.join(", ")
    )
}

/// Mass of the empty machine.
fn empty(d: &Description) -> Quantity {
    let arm = &d.lift_arm;
    let or = |stated: f64, usual: f64| if stated > 0.0 { stated } else { usual };
    let value = or(arm.empty_mass, d.machine.mass);
    Quantity {
        value,
        std: or(arm.empty_mass_std, MASS_STD * value),
    }
}

/// The load of a recording: as stated, or from the mass of the machine.
fn load(d: &Description, input: &Input) -> Option<Quantity> {
    let by_mass = |mass: Quantity| Quantity {
        value: mass.value - empty(d).value,
        std: norm(&[mass.std, empty(d).std]),
    };
    input.payload.or_else(|| input.stated.mass.map(by_mass))
}

/// Stated values of a recording that drives: a load in the bucket adds to the mass of the machine.
pub fn stated(d: &Description, input: &Input) -> StatedLoad {
    let with = |load: Quantity| Quantity {
        value: empty(d).value + load.value,
        std: norm(&[load.std, empty(d).std]),
    };
    let loaded = input.payload.filter(|load| load.value > 0.0);
    let mass = input.stated.mass.or_else(|| loaded.map(with));
    let [reach, lift] = mass
        .and_then(|_| place(d, input))
        .map_or([None; 2], |at| at.map(Some));
    StatedLoad {
        mass,
        reach,
        lift,
        ..input.stated
    }
}

/// Distance of a load ahead of the front axle, and its height above the ground, by the drawing of the arm and its median angles; `None`
/// without a drawing or an angle.
fn place(d: &Description, input: &Input) -> Option<[Quantity; 2]> {
    let median = |of: fn(&Sample) -> Option<f64>| {
        let all = input.samples.iter().filter_map(of);
        let all: Vec<f64> = all.filter(|angle| angle.is_finite()).collect();
        (!all.is_empty()).then(|| percentile(all, 0.5))
    };
    let lifts = Lifts::new(&Settings::of(d, Method::Full))?;
    Some(lifts.load_place(median(|s| s.lift_angle)?, median(|s| s.tilt_angle)?))
}

fn fit(d: &Description, known: &LiftKnown, runs: &[Run<'_>]) -> Result<CylinderFit, String> {
    let before = before(d, known, runs);
    let equations: Vec<Equation> = runs
        .iter()
        .enumerate()
        .flat_map(|(run, r)| {
            let of = move |m| equation(m, (run, r.load.value), LOADS + 2 * runs.len());
            r.moments.iter().map(of)
        })
        .collect();
    if let Some(run) = runs
        .iter()
        .find(|run| doubt(run, &before, runs.len()) > FAR)
    {
        return Err(contradicted(run));
    }
    // Equations far from the first solution belong to a bucket on the ground.
    let solution = before
        .after(&equations, FADING)
        .ok_or("the lift cylinders are not determined")?;
    let friction = known.friction;
    let learnt = CylinderFit::of(&solution, &before, friction.value, known.full_force);
    let unknown =
        |found: Quantity, std: f64, enough: f64| found.std > IDENTIFIED * std && found.std > enough;
    if unknown(learnt.span, known.span_std, KNOWN_SPAN) {
        return Err(one_load(runs));
    }
    if unknown(
        learnt.friction,
        friction.std,
        KNOWN_FRICTION * known.full_force,
    ) {
        return Err("the lift cylinders keep the values of the machine file: their friction cannot be distinguished from the zeros of the sensors; lift and lower the arm more often".into());
    }
    Ok(learnt)
}

/// Load that a moment gives under the description \[kg\].
fn weighed(m: &LiftMoment) -> f64 {
    (m.measured - m.empty) / m.per_load
}

/// The moment of a recording with the median load.
fn middle<'a>(run: &'a Run<'_>) -> &'a LiftMoment {
    let mut order: Vec<&LiftMoment> = run.moments.iter().collect();
    order.sort_by(|a, b| weighed(a).total_cmp(&weighed(b)));
    order[order.len() / 2]
}

/// Distance of a recording from its stated load, in standard deviations of the prior.
fn doubt(run: &Run<'_>, before: &Solution, runs: usize) -> f64 {
    let load = run.load.value;
    let e = equation(middle(run), (0, load), LOADS + 2 * runs);
    e.value.abs() / (before.variance(&e.row) + e.rest + e.noise).sqrt()
}

fn contradicted(run: &Run<'_>) -> String {
    let Run { name, load, .. } = run;
    format!(
        "the lift cylinders keep the values of the machine file: the load of {name} was stated as {:.0} kg, but by the machine file they carry {:.0} kg; weigh it again, check which recording is which, and the areas and distances of machine.lift_arm",
        load.value,
        weighed(middle(run))
    )
}

/// A moment as an equation of the unknowns, in newtons of the cylinders; with the recording and its load \[kg\].
fn equation(m: &LiftMoment, (run, load): (usize, f64), unknowns: usize) -> Equation {
    let tau = m.empty + load * m.per_load;
    let mut row = vec![0.0; unknowns];
    row[SPAN] = tau / m.lever;
    row[ZERO] = 1.0;
    row[FRICTION] = m.direction;
    for (i, turn) in m.turns.iter().enumerate() {
        row[CURVE + i] = turn / m.lever;
    }
    row[LOADS + 2 * run] = m.per_load / m.lever;
    row[LOADS + 2 * run + 1] = (m.tilt[0] + load * m.tilt[1]) / m.lever;
    Equation {
        row,
        value: (m.measured - tau) / m.lever,
        rest: m.rest,
        noise: m.noise,
        period: m.period,
    }
}

/// Prior of the unknowns.
fn before(d: &Description, known: &LiftKnown, runs: &[Run<'_>]) -> Solution {
    let arm = &d.lift_arm;
    let or = |stated: f64, usual: f64| if stated > 0.0 { stated } else { usual };
    let mass = or(arm.mass_std, DRAWN[0] * arm.mass);
    let bucket = or(arm.bucket_mass_std, DRAWN[1] * arm.bucket_mass);
    let far = or(arm.mass_distance_std, DRAWN[2] * arm.mass_distance);
    let load = or(arm.payload_distance_std, DRAWN[3] * arm.payload_distance);
    let own = arm.mass * arm.mass_distance + arm.bucket_mass * arm.length;
    let turned = d.sensors.angle_offset_std;
    let curve = [
        norm(&[
            mass * arm.mass_distance,
            arm.mass * far,
            bucket * arm.length,
        ]),
        own * norm(&[CENTRE_BESIDE, turned]),
        norm(&[bucket * arm.payload_distance, arm.bucket_mass * load]),
        arm.bucket_mass * arm.payload_distance * norm(&[BUCKET_BESIDE, turned]),
    ];
    let mut stds = vec![known.span_std, known.offset_std, known.friction.std];
    stds.extend(curve.map(|first| GRAVITY * first));
    stds.extend(
        runs.iter()
            .flat_map(|run| [run.load.std.max(LEAST_STD), LEVEL]),
    );
    let together = known.correlation * known.span_std * known.offset_std;
    Solution::before(&stds, &[(SPAN, ZERO, together)])
}

/// Writes the turn of the bucket into a description.
pub fn write_turn(turn: Quantity, pen: &mut Pen<Description>) {
    pen.value("machine.lift_arm.bucket_turn", turn);
    pen.std("machine.lift_arm.bucket_turn_std", turn.std);
}

/// Writes the keys of the description.
pub fn write(learnt: &CylinderFit, pen: &mut Pen<Description>) {
    learnt.write(pen, "machine.lift_arm.cylinder", &CURVES, SPAN_FLOOR);
}

/// The fit as text.
pub fn words(learnt: &CylinderFit) -> String {
    learnt.words("the lift cylinders")
}
