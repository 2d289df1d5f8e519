//! The figures of the excavator's paper, drawn from our runs.

use evaluate::excavator::{Point, table1};
use sim::excavator::{Attachment, Geometry, Scenario};
use view::excavator::figures as excavator;
use view::figures::Curve;

use crate::failure::Failure;
use crate::machines::{Figure, SEED};

/// Materials of the three cases of the excavator paper \[kg\].
const CASES: [(f64, &str); 3] = [(0.0, "empty"), (288.0, "288 kg"), (423.0, "423 kg")];
/// Postures 1 and 2 of Fig. 3: boom, arm, bucket \[deg\].
const POSTURES: [[f64; 3]; 2] = [[55.0, -146.0, -85.0], [45.0, -75.0, -60.0]];
/// Every figure of the paper.
pub fn all() -> Result<Vec<Figure>, Failure> {
    let mut figures = vec![
        ("fig03".to_owned(), attachments()),
        ("fig08".to_owned(), working_angles()),
        ("fig09".to_owned(), analytic_inertia()),
    ];
    for (i, (payload, name)) in CASES.into_iter().enumerate() {
        let points = table1::series(payload, SEED).map_err(Failure::internal)?;
        // The paper's regression runs from 5.5 to 9.3 s.
        let points: Vec<Point> = points
            .into_iter()
            .filter(|p| (5.5..=9.3).contains(&p.time))
            .collect();
        for (offset, svg) in case(11 + 3 * i, name, &points).into_iter().enumerate() {
            figures.push((format!("fig{}", 11 + 3 * i + offset), svg));
        }
    }
    Ok(figures)
}

fn attachments() -> String {
    let inertia = |tool: Attachment, posture: usize, mass: f64| {
        Geometry::with(tool)
            .inertia(POSTURES[posture].map(f64::to_radians), [0.0; 3])
            .total(mass)
    };
    let both = |tool: Attachment, mass: f64| (inertia(tool, 0, mass), inertia(tool, 1, mass));
    let mut conditions = Vec::new();
    for (name, tool, mass) in [
        ("bucket, empty", Attachment::bucket(), 0.0),
        ("bucket, 423 kg", Attachment::bucket(), 423.0),
        ("crusher, empty", Attachment::crusher(), 0.0),
        ("crusher, 423 kg", Attachment::crusher(), 423.0),
    ] {
        let (one, two) = both(tool, mass);
        conditions.push((name, one, two));
    }
    excavator::attachments(&conditions)
}

/// Times of Figs. 8 and 9: the working cycle of 13 s.
fn cycle_times() -> Vec<f64> {
    (0..=1300).map(|k| 0.01 * f64::from(k)).collect()
}

fn working_angles() -> String {
    let plant = Scenario::Base.plant(Some(288.0));
    let t = cycle_times();
    let joint = |i: usize| t.iter().map(|&t| plant.posture(t)[i]).collect::<Vec<f64>>();
    let joints = [joint(0), joint(1), joint(2)];
    let run = sim::excavator::Run {
        payload: Some(288.0),
        duration: 13.0,
        noise: sim::excavator::Sensors::EXACT,
        ..sim::excavator::Run::new(Scenario::Base)
    };
    // The machine stands until the swing begins; before the record it is at rest.
    let rows: Vec<(f64, f64)> = sim::excavator::Simulation::new(&run)
        .map(|rows| rows.map(|r| (r.time, r.truth.velocity)).collect())
        .unwrap_or_default();
    let velocity: Vec<f64> = t
        .iter()
        .map(|&t| {
            rows.iter()
                .rfind(|(time, _)| *time <= t + 1e-9)
                .map_or(0.0, |(_, w)| *w)
        })
        .collect();
    let mut angle = 0.0;
    let angles: Vec<f64> = velocity
        .iter()
        .map(|w| {
            angle += 0.01 * w;
            angle
        })
        .collect();
    excavator::working_angles(&t, [&joints[0], &joints[1], &joints[2]], &angles, &velocity)
}

fn analytic_inertia() -> String {
    let t = cycle_times();
    let series = CASES.map(|(payload, name)| {
        let plant = Scenario::Base.plant(Some(payload));
        let inertia = |&t: &f64| plant.inertia(t).total(plant.payload(t));
        (name, t.iter().map(inertia).collect::<Vec<f64>>())
    });
    let curves: [Curve<'_>; 3] = series.each_ref().map(|(name, of)| (*name, of.as_slice()));
    excavator::analytic_inertia(&t, &curves)
}

/// The three figures of one case: results, updating rules, error distribution.
fn case(first: usize, name: &str, points: &[Point]) -> [String; 3] {
    let column = |f: fn(&Point) -> f64| points.iter().map(f).collect::<Vec<f64>>();
    let t = column(|p| p.time);
    let inertia = column(|p| p.estimate.inertia);
    let true_inertia = column(|p| p.truth.inertia);
    let damping = column(|p| p.estimate.damping.map_or(0.0, |q| q.value));
    let true_damping = column(|p| p.truth.damping);
    let torque = column(|p| p.estimate.torque.map_or(0.0, |q| q.value));
    // The torque of the regression is the total one, friction included.
    let true_torque =
        column(|p| p.truth.torque - p.truth.friction * (p.truth.velocity / 0.005).tanh());
    let errors: Vec<f64> = inertia
        .iter()
        .zip(&true_inertia)
        .map(|(e, t)| 100.0 * (e / t - 1.0))
        .collect();
    let nominal: Vec<bool> = points.iter().map(|p| p.estimate.flags.nominal).collect();
    let window: Vec<bool> = points.iter().map(|p| p.estimate.flags.window).collect();
    let results = excavator::Results {
        t: &t,
        inertia: &inertia,
        true_inertia: &true_inertia,
        damping: &damping,
        true_damping: &true_damping,
        torque: &torque,
        true_torque: &true_torque,
    };
    [
        excavator::results(&first.to_string(), name, &results),
        excavator::updates(&(first + 1).to_string(), name, &t, &nominal, &window),
        excavator::error_distribution(&(first + 2).to_string(), name, &errors),
    ]
}
