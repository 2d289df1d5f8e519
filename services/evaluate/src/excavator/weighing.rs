//! The second witness: how much of all time the pressures of the boom's cylinders make trustworthy, and how well each load is weighed.
//!
//! JSON: a list of lines, each with `machine`, `stated`, `seeds`, and the numbers of [`Sums`]; a share or error that no row or load has is
//! null. `knowable` is the time in which the bucket neither digs nor empties. Targets: those of a described machine with pressures.

use estimation::HALF_WIDTH_95;
use estimation::excavator::keys::Description;
use estimation::excavator::{Cylinder, Estimate, Method, Reason, Settings};
use estimation::loads::Row as Weighing;
use serde_json::{Value, json};
use sim::excavator::{Effects, Row, Size, Work, cylinders};
use statistics::judge::is_wrong;

use super::estimators::{Point, Setup};
use super::honesty_lines::described;
use crate::loads::{Book, Tally, share};
use crate::text::{Table, plain};
use crate::{Error, Options, Report, seeds};

/// Length of a record: 90 s at 100 Hz, five or six loads.
const ROWS: usize = 9000;
/// A 95 % half width below this share is narrow.
const NARROW: f64 = 0.05;
/// Content that changes within this many rows is not knowable.
const AROUND: usize = 20;

/// What the estimator is given.
#[derive(Clone, Copy, PartialEq)]
enum Knowledge {
    /// No pressures.
    Motion,
    /// Pressures and cylinders, data-sheet tolerances.
    Described,
    /// The same, calibrated: masses and lengths to 0.5 %, friction of the seals to a fifth.
    Narrow,
    /// Pressures without the torque.
    Scale,
}

impl Knowledge {
    const fn name(self) -> &'static str {
        match self {
            Self::Motion => "no pressures",
            Self::Described => "described",
            Self::Narrow => "calibrated",
            Self::Scale => "no torque",
        }
    }
}

/// A machine of the table.
struct Case {
    name: &'static str,
    knowledge: Knowledge,
    effects: Effects,
    /// The described bucket over the true one.
    bucket: f64,
    /// The reason that names what is wrong.
    names: Option<Reason>,
}

fn cases() -> Vec<Case> {
    let case = |name, knowledge, effects| Case {
        name,
        knowledge,
        effects,
        bucket: 1.0,
        names: None,
    };
    let good = Effects::good();
    let precise = Effects {
        mass_error: 0.004,
        length_error: 0.003,
        ..good
    };
    vec![
        case("good machine", Knowledge::Motion, good),
        case("good machine", Knowledge::Described, good),
        case("good machine", Knowledge::Narrow, precise),
        case("good machine", Knowledge::Scale, good),
        case(
            "emptied while it swings",
            Knowledge::Scale,
            Effects {
                dumps_swinging: true,
                ..good
            },
        ),
        case("usual machine", Knowledge::Described, Effects::usual()),
        Case {
            bucket: 1.0 / 1.25,
            names: Some(Reason::Attachment),
            ..case("another bucket, +25 %", Knowledge::Described, good)
        },
        case(
            "soil that sticks, 8 %",
            Knowledge::Described,
            Effects {
                sticks: Some(0.08),
                ..good
            },
        ),
        Case {
            names: Some(Reason::Gain),
            ..case(
                "torque gain, +5 %",
                Knowledge::Described,
                Effects {
                    torque_gain: 1.05,
                    ..good
                },
            )
        },
        Case {
            names: Some(Reason::Hanging),
            ..case(
                "hanging load",
                Knowledge::Described,
                Effects {
                    pendulum: 1.0,
                    pendulum_length: 1.5,
                    ..good
                },
            )
        },
    ]
}

/// Sums over rows and loads.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    rows: usize,
    knowable: usize,
    narrow: usize,
    trusted: usize,
    trusted_knowable: usize,
    wrong: usize,
    covered: usize,
    runs: usize,
    /// Runs in which the reason that names what is wrong was given.
    named: usize,
    loads: Tally,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        for (sum, one) in [
            (&mut self.rows, other.rows),
            (&mut self.knowable, other.knowable),
            (&mut self.narrow, other.narrow),
            (&mut self.trusted, other.trusted),
            (&mut self.trusted_knowable, other.trusted_knowable),
            (&mut self.wrong, other.wrong),
            (&mut self.covered, other.covered),
            (&mut self.runs, other.runs),
            (&mut self.named, other.named),
        ] {
            *sum += one;
        }
        self.loads.add(&other.loads);
    }

    fn row(&mut self, truth: f64, estimate: &Estimate, knowable: bool) {
        let half = HALF_WIDTH_95 * estimate.inertia_std;
        let error = (estimate.inertia - truth).abs();
        let trusted = estimate.flags.trusted();
        self.rows += 1;
        self.knowable += usize::from(knowable);
        self.narrow += usize::from(knowable && half < NARROW * estimate.inertia);
        self.covered += usize::from(error <= half);
        self.trusted += usize::from(trusted);
        self.trusted_knowable += usize::from(trusted && knowable);
        let wrong = is_wrong(estimate.inertia, estimate.inertia_std, truth);
        self.wrong += usize::from(trusted && wrong);
    }
}

/// The settings of a machine with this knowledge.
fn settings(work: &Work, case: &Case) -> Settings {
    let mut settings = described(work);
    settings.geometry.masses[2] *= case.bucket;
    settings.geometry.inertias[2] *= case.bucket;
    let mut d = Description::default();
    if case.knowledge == Knowledge::Narrow {
        d.machine.mass_tolerance = 0.005;
        d.machine.upper_tolerance = Some(0.01);
        d.machine.bucket_tolerance = Some(0.01);
        d.machine.geometry_tolerance = 0.004;
        let narrow = Settings::of(&d).doubts;
        if let (Some(doubts), Some(narrow)) = (&mut settings.doubts, narrow) {
            let friction = doubts.friction_std;
            *doubts = narrow;
            doubts.friction_std = friction;
        }
    }
    if case.knowledge != Knowledge::Motion {
        let [boom, _] = cylinders(&work.size().geometry);
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (boom.count, boom.head_area, boom.rod_area);
        (c.base_distance, c.rod_distance) = (boom.base_distance, boom.rod_distance);
        (c.angle, c.friction) = (boom.angle, boom.friction);
        c.friction_std = if case.knowledge == Knowledge::Narrow {
            0.2
        } else {
            0.5
        } * boom.friction;
        settings.boom = Cylinder::of_boom(&d);
    }
    settings
}

/// One seed of a case.
fn run(case: &Case, seed: u64) -> Result<Sums, Error> {
    let sizes = [Size::t13(), Size::t22(), Size::t36(), Size::reference()];
    let size = sizes[(seed as usize - 1) % sizes.len()];
    let mut work = Work::new(size, case.effects, seed);
    if case.knowledge != Knowledge::Motion {
        work = work.with_gauges(seed);
    }
    let setup = settings(&work, case);
    let rows: Vec<Row> = work.take(ROWS).collect();
    let method = match case.knowledge {
        Knowledge::Scale => Method::Posture,
        _ => Method::PostureTorque,
    };
    let points = Setup::working(case.name, method, setup).run(&rows)?;
    let mut sums = Sums {
        runs: 1,
        ..Sums::default()
    };
    let knowable = knowable(&rows, size.rated);
    for (point, knowable) in points.iter().zip(knowable) {
        sums.row(point.truth.inertia, &point.estimate, knowable);
    }
    let named = |p: &&Point| case.names.is_some_and(|name| p.estimate.reason == name);
    let known = points.iter().filter(named).count();
    sums.named = usize::from(20 * known > points.len());
    sums.loads = weigh(&points, size.rated);
    Ok(sums)
}

/// Rows in which the bucket neither digs nor empties.
fn knowable(rows: &[Row], rated: f64) -> Vec<bool> {
    let payload = |i: usize| rows[i.min(rows.len() - 1)].truth.payload;
    (0..rows.len())
        .map(|i| {
            let changed = (payload(i + AROUND) - payload(i.saturating_sub(AROUND))).abs();
            changed < 0.01 * rated && !rows[i].truth.digs
        })
        .collect()
}

/// Compares the ledger's loads with the true ones.
fn weigh(points: &[Point], rated: f64) -> Tally {
    let mut book = Book::new(rated);
    for p in points {
        let row = Weighing {
            time: p.time,
            payload: p.estimate.payload,
            speed: p.estimate.velocity,
            changing: p.estimate.flags.changing,
            trusted: p.estimate.flags.trusted(),
            ..Weighing::default()
        };
        book.row(&row, p.truth.payload);
    }
    book.judge()
}

/// A line with what is asked of it.
struct Line {
    case: Case,
    sums: Sums,
}

impl Line {
    fn numbers(&self) -> [Option<f64>; 9] {
        let s = &self.sums;
        [
            share(s.narrow, s.knowable),
            share(s.trusted_knowable, s.knowable),
            share(s.wrong, s.trusted),
            share(s.covered, s.rows),
            self.case.names.and_then(|_| share(s.named, s.runs)),
            s.loads.found(),
            s.loads.trusted(),
            s.loads.covered(),
            s.loads.rms(),
        ]
    }

    /// Whether the line meets what section "acceptance" of the weighing specification asks.
    fn met(&self) -> bool {
        let [narrow, _, wrong, covered, named, _, trusted, inside, rms] = self.numbers();
        let most = |value: Option<f64>, limit: f64| value.is_none_or(|v| v <= limit);
        let least = |value: Option<f64>, limit: f64| value.is_some_and(|v| v >= limit);
        let honest = most(wrong, 0.03);
        if let Some(named) = named {
            return honest && named >= 0.8;
        }
        match (self.case.knowledge, self.case.name) {
            (Knowledge::Described, "good machine") => {
                honest && least(narrow, 0.8) && least(covered, 0.95)
            }
            (Knowledge::Narrow, _) => {
                honest && most(rms, 0.015) && least(inside, 0.93) && least(trusted, 0.8)
            }
            _ => honest,
        }
    }

    fn json(&self, seeds: usize) -> Value {
        let mut line = json!({
            "machine": self.case.name, "stated": self.case.knowledge.name(), "seeds": seeds,
            "loads": self.sums.loads.all, "rows": self.sums.rows, "met": self.met(),
        });
        for (key, value) in COLUMNS.iter().zip(self.numbers()) {
            line[*key] = json!(value);
        }
        line
    }
}

const COLUMNS: [&str; 9] = [
    "narrow_of_knowable",
    "trusted_of_knowable",
    "wrong_of_trusted",
    "covered",
    "named",
    "loads_found",
    "loads_trusted",
    "loads_covered",
    "load_rms_of_rated",
];

fn text(lines: &[Line]) -> String {
    let mut table = Table::new(&[
        "machine",
        "stated",
        "narrow",
        "trusted",
        "wrong",
        "covered",
        "named",
        "found",
        "trusted",
        "covered",
        "rms, % rated",
        "",
    ]);
    for line in lines {
        let mut cells = vec![
            line.case.name.to_owned(),
            line.case.knowledge.name().to_owned(),
        ];
        for (i, value) in line.numbers().into_iter().enumerate() {
            let (factor, decimals) = if i == 8 {
                (100.0, 1)
            } else {
                (1.0, if i == 2 { 3 } else { 2 })
            };
            cells.push(value.map_or("-".into(), |v| plain(factor * v, decimals)));
        }
        cells.push(if line.met() { "met" } else { "missed" }.into());
        table.row(cells);
    }
    table.to_string()
}

/// Every case; the sizes take turns with the seeds.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let mut lines = Vec::new();
    for case in cases() {
        let label = format!("{}, {}", case.name, case.knowledge.name());
        let mut sums = Sums::default();
        for one in seeds(options, &label, |seed| run(&case, seed))? {
            sums.add(&one);
        }
        lines.push(Line { case, sums });
    }
    Ok(Report {
        text: format!(
            "Excavators that weigh their loads by the boom's cylinder, {} seeds of 90 s: rows (narrow: half width below 5 %, of the time \
             in which the bucket neither digs nor empties), then loads\n{}",
            options.seeds,
            text(&lines)
        ),
        json: lines.iter().map(|line| line.json(options.seeds)).collect(),
        met: lines.iter().all(Line::met),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_sees_a_load_that_leaves_while_the_machine_swings() {
        let case = &cases()[4];
        assert!(case.effects.dumps_swinging && case.knowledge == Knowledge::Scale);
        let mut sums = Sums::default();
        for seed in 1..=2 {
            sums.add(&run(case, seed).expect("a run"));
        }
        assert!(sums.trusted > sums.rows / 10, "{sums:?}");
        assert!(20 * sums.wrong <= sums.trusted, "{sums:?}");
        assert!(sums.covered * 100 >= sums.rows * 95, "{sums:?}");
    }

    #[test]
    fn pressures_make_more_of_the_time_narrow_and_the_loads_no_worse() {
        let [without, with] = [0, 1].map(|i| {
            let case = &cases()[i];
            let mut sums = Sums::default();
            for seed in 1..=2 {
                sums.add(&run(case, seed).expect("a run"));
            }
            sums
        });
        assert!(with.narrow > without.narrow, "{without:?} {with:?}");
        let loads = with.loads;
        assert!(loads.all >= 6 && loads.found * 10 >= loads.all * 8);
        assert!(loads.rms() <= without.loads.rms().map(|rms| 1.09 * rms));
    }
}
