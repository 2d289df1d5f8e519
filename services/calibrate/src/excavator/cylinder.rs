//! Zero, span and friction of the boom's cylinders, from recordings with known loads.
//!
//! ```text
//! r F = (1 + s) tau + r (z + F_c d + f)        tau: the moment of the described machine with the known load
//! ```
//! (`estimation::excavator::Moment`) is linear in the span s, the zero z and the seals' friction F_c. Masses of the links and of the
//! bucket, the loads and the slope are known to their tolerances, and f, the rest, is correlated over some seconds: one least-squares
//! fit with priors. Differences of neighbouring moments would be white, but the noise of the angles is in the unknowns' factors too, and
//! weakens what differences say: what lasts counts as what it is, one measurement in twice its time.

use config::Excavator as Description;
use estimation::Quantity;
use estimation::excavator::keys::Attachment;
use estimation::excavator::{Cylinder, FULL_PRESSURE, Geometry, Lifts, Moment, Settings};
use faer::Mat;

use super::Input;
use crate::algebra;
use crate::description::number;
use crate::output::Pen;

/// Least time in which the boom rises, and in which it sinks \[s\].
const LEAST_MOTION: f64 = 3.0;
/// What is known to more than this share of its description's tolerance has not been told.
const TOLD: f64 = 0.7;
/// Rest of the seals' friction as a share of it, while the cylinder moves and while it stands; of the moment, what the drawing misses.
const REST: [f64; 2] = [0.15, 0.5];
const DRAWN: f64 = 0.01;
/// Standard deviation of a link's centre of mass, along its line of pins and beside it, as a share of the moment that it carries.
const CENTRE: f64 = 0.02;
/// Standard gravity [m/s^2].
const GRAVITY: f64 = 9.806_65;
/// The rest is another one after this time \[s\].
const FADING: f64 = 3.0;
/// A longer time between two moments ends what belongs together \[s\].
const GAP: f64 = 0.3;
/// Slope of ground that is called level \[rad\].
const LEVEL: f64 = 0.01;
/// A moment so many standard deviations away from the others is one with the bucket on the ground; the fit is done so often.
const GATE: f64 = 4.0;
const ROUNDS: usize = 4;
/// A bucket that weighs less than this share of the told load is another one's content: it was dumped.
const DUMPED: f64 = 0.5;

/// Unknowns: span, zero, friction, the moment that the drawing misses (with cosine and sine of each link's angle), slopes, then the
/// load of each recording.
const SPAN: usize = 0;
const ZERO: usize = 1;
const FRICTION: usize = 2;
const CURVE: usize = 3;
const SLOPES: usize = 9;
const LOADS: usize = 11;

/// Keys of the moment that the drawing misses.
const CURVES: [&str; 6] = [
    "machine.boom_cylinder.boom_cos",
    "machine.boom_cylinder.boom_sin",
    "machine.boom_cylinder.arm_cos",
    "machine.boom_cylinder.arm_sin",
    "machine.boom_cylinder.bucket_cos",
    "machine.boom_cylinder.bucket_sin",
];

/// What was learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learnt {
    /// Relative error of the moment as described.
    pub span: Quantity,
    /// Force that the pressures show too much \[N\].
    pub zero: Quantity,
    /// Correlation of the errors of the two.
    pub correlation: f64,
    /// Friction of the seals \[N\].
    pub friction: Quantity,
    /// Moments that the drawing misses, with cosine and sine of the angles of boom, arm and bucket to the horizontal [N m].
    pub missed: [Quantity; 6],
}

/// What the recordings tell of the described cylinders, or why they do not; `None` where no cylinder is described or no pressure
/// measured.
pub fn learn(d: &Description, inputs: &[Input]) -> Option<Result<Learnt, String>> {
    let cylinder = Cylinder::of_boom(d)?;
    let geometry = Geometry::of(d);
    let known: Vec<(&Input, Quantity)> = inputs
        .iter()
        .filter_map(|input| Some((input, input.payload?)))
        .collect();
    let runs: Vec<Vec<Moment>> = known
        .iter()
        .map(|(input, payload)| moments(&geometry, cylinder, input, *payload))
        .collect();
    if runs.iter().all(Vec::is_empty) {
        return None;
    }
    let moved = |sign: f64| -> f64 {
        let moving = runs.iter().flatten().filter(|m| m.moves);
        let these = moving.filter(|m| m.friction * sign > 0.0);
        these.map(|m| m.period.min(GAP)).sum()
    };
    if [1.0, -1.0]
        .into_iter()
        .any(|sign| moved(sign) < LEAST_MOTION)
    {
        return Some(Err(
            "the boom's cylinders stay as described: lift and lower the boom slowly and fully, twice, while the upper body stands"
                .into(),
        ));
    }
    let loads: Vec<Quantity> = known.iter().map(|(_, payload)| *payload).collect();
    Some(fit(d, &cylinder, &runs, &loads))
}

/// The moments of a recording while the bucket is in the air with its load in it.
fn moments(geometry: &Geometry, cylinder: Cylinder, input: &Input, load: Quantity) -> Vec<Moment> {
    let mut lifts = Lifts::new(*geometry, cylinder);
    let moments = input.samples.iter().filter_map(|sample| lifts.step(sample));
    moments
        .filter(|m| {
            let weighed = (m.measured - m.lever * m.friction - m.empty) / m.per_payload;
            load.value <= 0.0 || weighed > DUMPED * load.value
        })
        .collect()
}

fn fit(
    d: &Description,
    cylinder: &Cylinder,
    runs: &[Vec<Moment>],
    loads: &[Quantity],
) -> Result<Learnt, String> {
    let doubts = Settings::of(d).doubts;
    let [friction, friction_std] = cylinder.friction;
    let mut prior = vec![cylinder.span_std, cylinder.zero_std, friction_std];
    let links = doubts.map_or(DRAWN, |doubts| doubts.links_share.max(CENTRE));
    let first = first_moments(&d.geometry);
    prior.extend(first.into_iter().flat_map(|m| [links * m, CENTRE * m]));
    prior.extend([LEVEL; 2]);
    prior.extend(loads.iter().map(|load| load.std.max(1e-3)));
    let equations: Vec<Vec<Equation>> = runs
        .iter()
        .enumerate()
        .map(|(run, moments)| {
            let of = |m| Equation::new(cylinder, m, (run, loads[run].value), prior.len());
            moments.iter().map(of).collect()
        })
        .collect();
    let mut solution = Solution::new(&prior);
    // What lies far from the first solution was on the ground.
    for _ in 0..ROUNDS {
        solution = Solution::of(&equations, &prior, &solution)
            .ok_or("the boom's cylinders are not determined")?;
    }
    let learnt = solution.learnt(friction);
    if learnt.friction.std > TOLD * friction_std {
        return Err("the boom's cylinders stay as described: their friction cannot be told from the zeros of the sensors; lift and lower the boom more often"
            .into());
    }
    Ok(learnt)
}

/// Moments about the boom foot of what the angles of boom, arm and bucket carry, level [N m].
fn first_moments(g: &Attachment) -> [f64; 3] {
    let behind = [g.arm_mass + g.bucket_mass, g.bucket_mass, 0.0];
    [
        g.boom_mass * g.boom_centre + behind[0] * g.boom_length,
        g.arm_mass * g.arm_centre + behind[1] * g.arm_length,
        g.bucket_mass * g.bucket_centre,
    ]
    .map(|first| GRAVITY * first)
}

/// A moment as an equation of the unknowns, in newtons of the cylinders.
struct Equation {
    row: Vec<f64>,
    value: f64,
    /// Variance of what lasts for some seconds, and of noise [N^2].
    rest: f64,
    noise: f64,
    /// Time since the one before \[s\].
    period: f64,
}

impl Equation {
    fn new(cylinder: &Cylinder, m: &Moment, (run, load): (usize, f64), unknowns: usize) -> Self {
        let friction = cylinder.friction[0].max(f64::MIN_POSITIVE);
        let tau = m.empty + load * m.per_payload;
        let tilt = m.tilt + load * m.tilt_payload;
        let mut row = vec![0.0; unknowns];
        row[SPAN] = tau / m.lever;
        row[ZERO] = 1.0;
        row[FRICTION] = m.friction / friction;
        for (i, part) in m.directions.iter().flatten().enumerate() {
            row[CURVE + i] = part / m.lever;
        }
        row[SLOPES] = tilt * m.turn[0] / m.lever;
        row[SLOPES + 1] = tilt * m.turn[1] / m.lever;
        row[LOADS + run] = m.per_payload / m.lever;
        let rest = REST[usize::from(!m.moves)] * friction;
        let drawn = DRAWN * m.measured / m.lever;
        Self {
            row,
            value: (m.measured - tau) / m.lever - m.friction,
            rest: rest * rest + drawn * drawn,
            noise: m.variance / (m.lever * m.lever),
            period: m.period,
        }
    }

    /// What the unknowns leave of it.
    fn residual(&self, unknowns: &Mat<f64>) -> f64 {
        let told: f64 = self
            .row
            .iter()
            .enumerate()
            .map(|(i, a)| a * unknowns[(i, 0)])
            .sum();
        self.value - told
    }
}

/// The unknowns with their covariance.
struct Solution {
    unknowns: Mat<f64>,
    covariance: Mat<f64>,
    /// Standard deviations before the data, and the scatter of the data over what is stated.
    prior: Vec<f64>,
    widened: f64,
}

impl Solution {
    /// Before the data.
    fn new(prior: &[f64]) -> Self {
        let n = prior.len();
        Self {
            unknowns: Mat::zeros(n, 1),
            covariance: Mat::from_fn(n, n, |i, j| if i == j { prior[i].powi(2) } else { 0.0 }),
            prior: prior.to_vec(),
            widened: 1.0,
        }
    }

    /// From the equations that an earlier solution does not contradict; `None` where they determine nothing.
    fn of(runs: &[Vec<Equation>], prior: &[f64], earlier: &Self) -> Option<Self> {
        let n = prior.len();
        let inverse = |std: f64| std.max(1e-12).powi(-2);
        let mut information =
            Mat::from_fn(n, n, |i, j| if i == j { inverse(prior[i]) } else { 0.0 });
        let mut right = Mat::<f64>::zeros(n, 1);
        let (mut white, mut sum) = (0.0, 0.0);
        for e in runs.iter().flatten() {
            let stated = e.rest + e.noise;
            let left = e.residual(&earlier.unknowns).powi(2);
            let fits = left <= GATE * GATE * (stated + earlier.variance(&e.row));
            if !fits {
                continue;
            }
            // What lasts says the same again and again.
            let variance = e.rest * (1.0 + 2.0 * FADING / e.period.min(GAP)) + e.noise;
            for i in 0..n {
                right[(i, 0)] += e.row[i] * e.value / variance;
                for j in 0..n {
                    information[(i, j)] += e.row[i] * e.row[j] / variance;
                }
            }
            white += left / stated;
            sum += 1.0;
        }
        let covariance = algebra::inverse(&information)?;
        Some(Self {
            unknowns: &covariance * &right,
            covariance,
            prior: prior.to_vec(),
            widened: (white / f64::max(sum, 1.0)).max(1.0).sqrt(),
        })
    }

    /// Variance of a row of the unknowns.
    fn variance(&self, row: &[f64]) -> f64 {
        let n = row.len();
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        pairs
            .map(|(i, j)| row[i] * self.covariance[(i, j)] * row[j])
            .sum()
    }

    fn learnt(&self, friction: f64) -> Learnt {
        let c = &self.covariance;
        let of = |i: usize| Quantity {
            value: self.unknowns[(i, 0)],
            std: (self.widened * c[(i, i)].sqrt()).min(self.prior[i]),
        };
        Learnt {
            span: of(SPAN),
            zero: of(ZERO),
            correlation: c[(SPAN, ZERO)] / (c[(SPAN, SPAN)] * c[(ZERO, ZERO)]).sqrt(),
            friction: Quantity {
                value: (friction + self.unknowns[(FRICTION, 0)]).max(0.0),
                ..of(FRICTION)
            },
            missed: std::array::from_fn(|i| of(CURVE + i)),
        }
    }
}

impl Learnt {
    /// The keys of the description.
    pub fn write(&self, pen: &mut Pen<Description>) {
        let c = pen.description.boom_cylinder;
        let span = 1.0 + self.span.value;
        for (key, area) in [("head_area", c.head_area), ("rod_area", c.rod_area)] {
            let area = Quantity {
                value: area / span,
                std: area * self.span.std,
            };
            pen.value(&format!("machine.boom_cylinder.{key}"), area);
        }
        let zero = Quantity {
            value: (c.force_offset + self.zero.value) / span,
            std: self.zero.std,
        };
        pen.value("machine.boom_cylinder.force_offset", zero);
        pen.std("machine.boom_cylinder.force_offset_std", self.zero.std);
        pen.std("machine.boom_cylinder.span_std", self.span.std);
        pen.std(
            "machine.boom_cylinder.span_offset_correlation",
            self.correlation,
        );
        for (key, missed) in CURVES.iter().zip(self.missed) {
            let was = number(&pen.description, key).unwrap_or(0.0);
            let missed = Quantity {
                value: was + missed.value,
                ..missed
            };
            pen.value(key, missed);
        }
        let full = c.count * c.head_area * FULL_PRESSURE;
        let friction = Quantity {
            value: self.friction.value / full,
            std: self.friction.std / full,
        };
        pen.value("machine.boom_cylinder.friction", friction);
        pen.std("machine.boom_cylinder.friction_std", friction.std);
    }

    /// In words.
    pub fn words(&self) -> String {
        format!(
            "the boom's cylinders: the moment is {:+.1} ± {:.1} % of what the drawing says, zero {:.0} ± {:.0} N, friction {:.0} ± {:.0} N",
            100.0 * self.span.value,
            100.0 * self.span.std,
            self.zero.value,
            self.zero.std,
            self.friction.value,
            self.friction.std
        )
    }
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

    /// A machine that stands and moves its boom between the angles that `boom` gives at each time, by statics and Coulomb's friction.
    fn record(payload: f64, boom: impl Fn(f64) -> f64) -> Input {
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
            let rises = (boom(time + 0.01) - boom(time)).signum();
            let force = SCALE * moment / cylinder.lever(posture[0]).1 + FRICTION * rises + OFFSET;
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

    /// Mean of what the cylinders of a description weigh in a recording \[kg\].
    fn weighed(d: &Description, input: &Input) -> f64 {
        let cylinder = Cylinder::of_boom(d).expect("described");
        let mut lifts = Lifts::new(Geometry::of(d), cylinder);
        let moments = input.samples.iter().filter_map(|s| lifts.step(s));
        let of = |m: Moment| (m.measured - m.lever * m.friction - m.empty) / m.per_payload;
        let each: Vec<f64> = moments.filter(|m| m.moves).map(of).collect();
        each.iter().sum::<f64>() / each.len() as f64
    }

    fn up_and_down(time: f64) -> f64 {
        0.55 + 0.45 * (0.5 * time).sin()
    }

    #[test]
    fn lifts_with_two_loads_tell_friction_and_zero_within_their_intervals() {
        let inputs = [0.0, 400.0].map(|payload| record(payload, up_and_down));
        let learnt = learn(&described(), &inputs)
            .expect("pressures")
            .expect("told");
        for (told, truth) in [
            (learnt.friction, FRICTION),
            (learnt.zero, OFFSET),
            (learnt.span, SCALE - 1.0),
        ] {
            assert!(
                (told.value - truth).abs() < 2.0 * told.std,
                "{told:?} {truth}"
            );
        }
        let cylinder = Cylinder::of_boom(&described()).expect("described");
        assert!(
            learnt.friction.std < 0.3 * cylinder.friction[1],
            "{learnt:?}"
        );
        let mut pen = Pen::new(described());
        learnt.write(&mut pen);
        let written = Cylinder::of_boom(&pen.description).expect("described");
        assert!((written.friction[0] - FRICTION).abs() < 3.0 * learnt.friction.std);
        assert!(written.friction[1] < cylinder.friction[1]);
        // A third load, of which nothing was told.
        let off = |d: &Description| weighed(d, &record(250.0, up_and_down)) - 250.0;
        assert!(off(&described()).abs() > 30.0, "{}", off(&described()));
        assert!(
            off(&pen.description).abs() < 6.0,
            "{}",
            off(&pen.description)
        );
    }

    #[test]
    fn a_boom_that_only_rises_tells_friction_and_zero_not_apart_and_no_pressure_tells_nothing() {
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
