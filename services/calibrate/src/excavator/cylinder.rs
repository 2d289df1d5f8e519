//! Identifies zero, span and friction of the boom's cylinders from recordings with known loads.
//!
//! ```text
//! r F = (1 + s) tau + r (z + F_c d + f)        tau: the moment of the described machine with the known load
//! ```
//! (`estimation::excavator::Moment`) is linear in the span s, the zero z and the seals' friction F_c. Masses of the links and of the
//! bucket, the loads and the slope are known to their tolerances, and the rest f is correlated over some seconds: one least-squares
//! fit with priors ([`crate::lasting`]).

use config::Excavator as Description;
use estimation::Quantity;
use estimation::excavator::keys::Attachment;
use estimation::excavator::{
    Cylinder, FADING, FULL_PRESSURE, GRAVITY, Geometry, Lifts, Moment, Sample, Settings,
    true_posture,
};

use super::Input;
use crate::cylinders::{
    self, CURVE, FRICTION, IDENTIFIED, LEAST_MOTION, LEAST_STD, LEVEL, SPAN, ZERO,
};
use crate::lasting::{Equation, GAP, Solution};
use crate::output::Pen;

/// Standard deviation of a link's centre of mass, along its line of pins and beside it, as a share of the moment that it carries.
const CENTRE: f64 = 0.02;
/// Share of the stated load below which the bucket holds another content: it was dumped.
const DUMPED: f64 = 0.5;
/// Indices of the unknowns behind those of every cylinder and the six missed moments: friction at rest, slopes, then the load of each
/// recording.
const HELD: usize = CURVE + CURVES.len();
const SLOPES: usize = HELD + 1;
const LOADS: usize = SLOPES + 2;

/// Keys of the missed moment.
const CURVES: [&str; 6] = [
    "machine.boom_cylinder.boom_cos",
    "machine.boom_cylinder.boom_sin",
    "machine.boom_cylinder.arm_cos",
    "machine.boom_cylinder.arm_sin",
    "machine.boom_cylinder.bucket_cos",
    "machine.boom_cylinder.bucket_sin",
];

/// Fit of the boom's cylinders: the missed moments are those of boom, arm and bucket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderFit {
    /// Unknowns common to the cylinders of every machine.
    pub common: cylinders::CylinderFit<{ CURVES.len() }>,
    /// Share of the friction that the seals retain at rest.
    pub kept: Quantity,
}

/// Fit of the described cylinders, or why there is none; `None` where no cylinder is described or no pressure
/// measured.
pub fn learn(d: &Description, inputs: &[Input]) -> Option<Result<CylinderFit, String>> {
    let lifts = Recorded::of(d, inputs)?;
    if !lifts.move_both_ways() {
        return Some(Err(
            "the boom's cylinders keep the values of the machine file: lift and lower the boom slowly and fully, twice, while the upper body stands"
                .into(),
        ));
    }
    Some(fit(d, &lifts))
}

/// The load of a recording by the pressures, without its stated mass.
pub fn weigh(d: &Description, inputs: &[Input], recording: usize) -> Option<Quantity> {
    let stated = inputs[recording].payload?;
    let mut inputs = inputs.to_vec();
    let open = Quantity {
        std: stated.value,
        ..stated
    };
    inputs[recording].payload = Some(open);
    let lifts = Recorded::of(d, &inputs)?;
    let run = inputs[..recording].iter().filter(|i| i.payload.is_some());
    let at = LOADS + run.count();
    if !lifts.move_both_ways() || lifts.runs[at - LOADS].is_empty() {
        return None;
    }
    let (before, after) = lifts.solve(d)?;
    let error = after.quantity(at, &before);
    Some(Quantity {
        value: stated.value + error.value,
        std: error.std,
    })
}

/// The moments of recordings with known loads.
struct Recorded {
    cylinder: Cylinder,
    runs: Vec<Vec<Moment>>,
    loads: Vec<Quantity>,
}

impl Recorded {
    /// `None` where no cylinder is described or no pressure measured.
    fn of(d: &Description, inputs: &[Input]) -> Option<Self> {
        let cylinder = Cylinder::of_boom(d)?;
        let geometry = Geometry::of(d);
        let offsets = Settings::of(d).sensors.angle_offsets;
        let keeping = Cylinder {
            kept: 1.0,
            ..cylinder
        };
        let known = inputs
            .iter()
            .filter_map(|input| Some((input, input.payload?)));
        let (runs, loads): (Vec<Vec<Moment>>, Vec<Quantity>) = known
            .map(|(input, load)| (moments(&geometry, (keeping, offsets), input, load), load))
            .unzip();
        let is_measured = runs.iter().any(|run| !run.is_empty());
        is_measured.then_some(Self {
            cylinder,
            runs,
            loads,
        })
    }

    fn move_both_ways(&self) -> bool {
        let moved = |sign: f64| -> f64 {
            let moving = self.runs.iter().flatten().filter(|m| m.moves);
            let these = moving.filter(|m| m.direction * sign > 0.0);
            these.map(|m| m.period.min(GAP)).sum()
        };
        [1.0, -1.0]
            .into_iter()
            .all(|sign| moved(sign) >= LEAST_MOTION)
    }

    /// Described frictions in motion and at rest \[N\].
    fn frictions(&self) -> [f64; 2] {
        let friction = self.cylinder.friction[0];
        [friction, self.cylinder.kept * friction]
    }

    /// The unknowns before and after the recordings.
    fn solve(&self, d: &Description) -> Option<(Solution, Solution)> {
        let before = before(d, &self.cylinder, &self.loads);
        let frictions = self.frictions();
        let unknowns = LOADS + self.runs.len();
        let runs = self.runs.iter().zip(&self.loads).enumerate();
        let equations: Vec<Equation> = runs
            .flat_map(|(run, (moments, load))| {
                let of = move |m| equation(frictions, m, (run, load.value), unknowns);
                moments.iter().map(of)
            })
            .collect();
        // Equations far from the first solution belong to a bucket on the ground.
        let after = before.after(&equations, FADING)?;
        Some((before, after))
    }
}

/// The moments of a recording while the bucket is in the air with its load. The seals are assumed to retain all of their friction at rest.
/// With the offsets of the joint angles \[rad\].
fn moments(
    geometry: &Geometry,
    (cylinder, offsets): (Cylinder, [f64; 3]),
    input: &Input,
    load: Quantity,
) -> Vec<Moment> {
    let mut lifts = Lifts::new(*geometry, cylinder);
    let moments = input.samples.iter().filter_map(|sample| {
        lifts.step(&Sample {
            posture: true_posture(sample.posture, offsets),
            ..*sample
        })
    });
    moments
        .filter(|m| {
            let friction = m.lever * m.direction * cylinder.friction[0];
            let weighed = (m.measured - friction - m.empty) / m.per_payload;
            load.value <= 0.0 || weighed > DUMPED * load.value
        })
        .collect()
}

fn fit(d: &Description, lifts: &Recorded) -> Result<CylinderFit, String> {
    let [friction, friction_std] = lifts.cylinder.friction;
    let frictions = lifts.frictions();
    let solved = lifts.solve(d);
    let (before, solution) = solved.ok_or("the boom's cylinders are not determined")?;
    let c = &d.boom_cylinder;
    let full_force = c.count * c.head_area * FULL_PRESSURE;
    let common = cylinders::CylinderFit::of(&solution, &before, friction, full_force);
    if common.friction.std > IDENTIFIED * friction_std {
        return Err("the boom's cylinders keep the values of the machine file: their friction cannot be distinguished from the zeros of the sensors; lift and lower the boom more often"
            .into());
    }
    let held = solution.quantity(HELD, &before);
    let moving = common.friction.value.max(f64::MIN_POSITIVE);
    let kept = Quantity {
        value: ((frictions[1] + held.value) / moving).clamp(0.0, 1.0),
        std: held.std / moving,
    };
    Ok(CylinderFit { common, kept })
}

/// Moments about the boom foot that depend on the angles of boom, arm and bucket, on level ground [N m].
fn first_moments(g: &Attachment) -> [f64; 3] {
    let behind = [g.arm_mass + g.bucket_mass, g.bucket_mass, 0.0];
    [
        g.boom_mass * g.boom_centre + behind[0] * g.boom_length,
        g.arm_mass * g.arm_centre + behind[1] * g.arm_length,
        g.bucket_mass * g.bucket_centre,
    ]
    .map(|first| GRAVITY * first)
}

/// A moment as an equation of the unknowns, in newtons of the cylinders. `frictions` are the described ones in motion and at rest \[N\];
/// with the recording and its load \[kg\].
fn equation(
    frictions: [f64; 2],
    m: &Moment,
    (run, load): (usize, f64),
    unknowns: usize,
) -> Equation {
    let tau = m.empty + load * m.per_payload;
    let tilt = m.tilt + load * m.tilt_payload;
    let mut row = vec![0.0; unknowns];
    row[SPAN] = tau / m.lever;
    row[ZERO] = 1.0;
    let (friction, unknown) = if m.moves {
        (frictions[0], FRICTION)
    } else {
        (frictions[1], HELD)
    };
    row[unknown] = m.direction;
    for (i, part) in m.directions.iter().flatten().enumerate() {
        row[CURVE + i] = part / m.lever;
    }
    row[SLOPES] = tilt * m.turn[0] / m.lever;
    row[SLOPES + 1] = tilt * m.turn[1] / m.lever;
    row[LOADS + run] = m.per_payload / m.lever;
    Equation {
        row,
        value: (m.measured - tau) / m.lever - friction * m.direction,
        rest: m.rest(frictions[0]),
        noise: m.variance / (m.lever * m.lever),
        period: m.period,
    }
}

/// Prior of the unknowns.
fn before(d: &Description, cylinder: &Cylinder, loads: &[Quantity]) -> Solution {
    let links = Settings::of(d)
        .doubts
        .map_or(0.0, |doubts| doubts.links_share);
    let mut stds = vec![cylinder.span_std, cylinder.zero_std, cylinder.friction[1]];
    let first = first_moments(&d.geometry);
    stds.extend(
        first
            .iter()
            .flat_map(|m| [links.max(CENTRE) * m, CENTRE * m]),
    );
    stds.push(cylinder.kept_std * cylinder.friction[0]);
    stds.extend([LEVEL; 2]);
    stds.extend(loads.iter().map(|load| load.std.max(LEAST_STD)));
    let together = cylinder.correlation * cylinder.span_std * cylinder.zero_std;
    Solution::before(&stds, &[(SPAN, ZERO, together)])
}

/// Writes the keys of the description.
pub fn write(learnt: &CylinderFit, pen: &mut Pen<Description>) {
    learnt
        .common
        .write(pen, "machine.boom_cylinder", &CURVES, 0.0);
    pen.value("machine.boom_cylinder.friction_kept", learnt.kept);
    pen.std("machine.boom_cylinder.friction_kept_std", learnt.kept.std);
}

/// The fit as text.
pub fn words(learnt: &CylinderFit) -> String {
    let cylinders = learnt.common.words("the boom's cylinders");
    let [kept, std] = [learnt.kept.value, learnt.kept.std].map(|share| 100.0 * share);
    format!("{cylinders}, of which {kept:.0} ± {std:.0} % stay at rest")
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimation::excavator::Sample;

    /// Friction \[N\], zero \[N\] and span of the true cylinder.
    const FRICTION: f64 = 5200.0;
    const OFFSET: f64 = 2500.0;
    const SCALE: f64 = 1.015;

    fn described() -> Description {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.0104, 0.0071);
        (c.base_distance, c.rod_distance, c.angle) = (0.62, 1.35, 1.3);
        (c.friction, c.friction_std) = (0.02, 0.01);
        d
    }

    /// A machine that stands and moves its boom to the angle `boom` of each time, by statics and Coulomb friction.
    fn record(payload: f64, boom: impl Fn(f64) -> f64) -> Input {
        let rises = |time: f64| (boom(time + 0.01) - boom(time)).signum();
        record_with(payload, &boom, rises)
    }

    /// The same with a direction of the seals' friction.
    fn record_with(
        payload: f64,
        boom: impl Fn(f64) -> f64,
        direction: impl Fn(f64) -> f64,
    ) -> Input {
        let d = described();
        let (g, c) = (&d.geometry, &d.boom_cylinder);
        let cylinder = Cylinder::of_boom(&d).expect("described");
        let samples = (0..6000).map(|row| {
            let time = 0.01 * f64::from(row);
            let arm = if time < 30.0 { -1.5 } else { -2.1 };
            let posture = [boom(time), arm, -0.6];
            let alpha = [posture[0], posture[0] + arm, posture[0] + arm - 0.6];
            let [first, second, third] = alpha.map(f64::cos);
            let pins = [
                g.boom_length * first,
                g.boom_length * first + g.arm_length * second,
            ];
            let moment = GRAVITY
                * (g.boom_mass * g.boom_centre * first
                    + g.arm_mass * (pins[0] + g.arm_centre * second)
                    + g.bucket_mass * (pins[1] + g.bucket_centre * third)
                    + payload * (pins[1] + g.payload_centre * third));
            let friction = FRICTION * direction(time);
            let force = SCALE * moment / cylinder.lever(posture[0]).1 + friction + OFFSET;
            let rod = 1e6;
            Sample {
                time,
                velocity: Some(0.0),
                posture: posture.map(Some),
                boom_head_pressure: Some((force + c.rod_area * rod) / c.head_area),
                boom_rod_pressure: Some(rod),
                ..Sample::default()
            }
        });
        Input {
            name: "a recording".into(),
            samples: samples.collect(),
            payload: Some(Quantity {
                value: payload,
                std: 0.01 * payload,
            }),
        }
    }

    /// Mean load of a recording under the cylinders of a description \[kg\].
    fn weighed(d: &Description, input: &Input) -> f64 {
        let cylinder = Cylinder::of_boom(d).expect("described");
        let mut lifts = Lifts::new(Geometry::of(d), cylinder);
        let moments = input.samples.iter().filter_map(|s| lifts.step(s));
        let friction = |m: &Moment| m.lever * m.direction * cylinder.friction[0];
        let of = |m: Moment| (m.measured - friction(&m) - m.empty) / m.per_payload;
        let each: Vec<f64> = moments.filter(|m| m.moves).map(of).collect();
        each.iter().sum::<f64>() / each.len() as f64
    }

    fn up_and_down(time: f64) -> f64 {
        0.55 + 0.45 * (0.5 * time).sin()
    }

    #[test]
    fn lifts_with_two_loads_identify_friction_and_zero_within_their_intervals() {
        let inputs = [0.0, 400.0].map(|payload| record(payload, up_and_down));
        let learnt = learn(&described(), &inputs)
            .expect("pressures")
            .expect("a value");
        for (stated, truth) in [
            (learnt.common.friction, FRICTION),
            (learnt.common.zero, OFFSET),
            (learnt.common.span, SCALE - 1.0),
        ] {
            assert!(
                (stated.value - truth).abs() < 2.0 * stated.std,
                "{stated:?} {truth}"
            );
        }
        let cylinder = Cylinder::of_boom(&described()).expect("described");
        assert!(
            learnt.common.friction.std < 0.3 * cylinder.friction[1],
            "{learnt:?}"
        );
        let mut pen = Pen::new(described());
        write(&learnt, &mut pen);
        let written = Cylinder::of_boom(&pen.description).expect("described");
        assert!((written.friction[0] - FRICTION).abs() < 3.0 * learnt.common.friction.std);
        assert!(written.friction[1] < cylinder.friction[1]);
        // A third load, which was not stated.
        let off = |d: &Description| weighed(d, &record(250.0, up_and_down)) - 250.0;
        assert!(off(&described()).abs() > 30.0, "{}", off(&described()));
        assert!(
            off(&pen.description).abs() < 6.0,
            "{}",
            off(&pen.description)
        );
    }

    /// Identified share where the seals retain this share of their friction; the boom stands 2 s before each motion of 4 s.
    fn kept(share: f64) -> Quantity {
        let way = |time: f64| {
            if ((time / 6.0) as u32).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            }
        };
        let boom = |time: f64| {
            let done = ((time % 6.0) - 2.0).max(0.0) / 4.0;
            0.55 + way(time) * 0.45 * (2.0 * done - 1.0)
        };
        let direction = |time: f64| {
            if time % 6.0 < 2.0 {
                -share * way(time)
            } else {
                way(time)
            }
        };
        let inputs = [0.0, 400.0].map(|payload| record_with(payload, boom, direction));
        let learnt = learn(&described(), &inputs).expect("pressures");
        learnt.expect("a value").kept
    }

    #[test]
    fn a_boom_that_stops_identifies_what_its_seals_retain() {
        let [none, all] = [0.0, 1.0].map(kept);
        assert!(none.value < 0.3 && all.value > 0.8, "{none:?} {all:?}");
        assert!(none.std < 0.3, "{none:?}");
    }

    #[test]
    fn a_boom_that_only_rises_does_not_distinguish_friction_and_zero_and_no_pressure_gives_no_fit()
    {
        let rising = record(0.0, |time| 0.1 + 0.015 * time);
        let refused = learn(&described(), &[rising]).expect("pressures");
        assert!(refused.is_err_and(|why| why.contains("lift and lower")));
        let mut without = record(0.0, up_and_down);
        for sample in &mut without.samples {
            sample.boom_head_pressure = None;
        }
        assert_eq!(learn(&described(), &[without]), None);
    }
}
