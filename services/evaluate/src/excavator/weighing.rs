//! Gain from the pressures of the boom's cylinders: share of all time with a narrow trusted interval, and errors of the weighed
//! loads.
//!
//! JSON: a list of lines, each with `machine`, `stated`, `seeds`, `loads`, `rows`, `met`, and a number by the key of each column;
//! null where there is nothing to count. `knowable` is the time in which the bucket neither digs nor empties. Targets: those of a
//! described machine with pressures.

use estimation::HALF_WIDTH_95;
use estimation::excavator::{Estimate, Method, Reason, Settings};
use estimation::loads::Row as Weighing;
use serde_json::json;
use sim::excavator::{Effects, Row, Size, Work};
use statistics::judge::is_wrong;

use super::calibrated;
use super::estimators::{Point, Setup};
use super::honesty_lines::{describe_boom_cylinder, described};
use crate::loads::{Book, Tally, share};
use crate::weighing::{Column, Line, at_least, at_most, text};
use crate::{Error, Options, Report, seeds};

/// Length of a record: 90 s at 100 Hz, five or six loads.
const ROWS: usize = 9000;
/// A 95 % half width below this share counts as narrow.
const NARROW: f64 = 0.05;
/// Rows around a change of the content in which it is not knowable.
const AROUND: usize = 20;

/// Inputs of the estimator.
#[derive(Clone, Copy, PartialEq)]
enum Knowledge {
    /// No pressures.
    Motion,
    /// Pressures and cylinders, data-sheet tolerances.
    Described,
    /// Described, and calibrated by two recordings ([`super::calibrated`]).
    Calibrated,
    /// Pressures without the torque.
    Scale,
}

impl Knowledge {
    const fn name(self) -> &'static str {
        match self {
            Self::Motion => "no pressures",
            Self::Described => "described",
            Self::Calibrated => "calibrated",
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
    /// The reason code that identifies the deviation.
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
    vec![
        case("good machine", Knowledge::Motion, good),
        case("good machine", Knowledge::Described, good),
        case("good machine", Knowledge::Calibrated, good),
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
struct Sums {
    rows: usize,
    knowable: usize,
    narrow: usize,
    trusted: usize,
    trusted_knowable: usize,
    wrong: usize,
    covered: usize,
    runs: usize,
    /// Runs in which that reason was reported.
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

/// The settings of a machine with this knowledge; `None` if its calibration is refused.
fn settings(work: &Work, case: &Case, seed: u64) -> Result<Option<Settings>, Error> {
    let mut d = described(work);
    d.geometry.bucket_mass *= case.bucket;
    d.geometry.bucket_inertia *= case.bucket;
    if case.knowledge == Knowledge::Motion {
        return Ok(Some(Settings::of(&d)));
    }
    describe_boom_cylinder(&mut d, work);
    if case.knowledge == Knowledge::Calibrated {
        return calibrated::settings((*work.size(), case.effects, seed), &d);
    }
    Ok(Some(Settings::of(&d)))
}

/// One seed of a case.
fn run(case: &Case, seed: u64) -> Result<Sums, Error> {
    let sizes = [Size::t13(), Size::t22(), Size::t36(), Size::reference()];
    let size = sizes[(seed as usize - 1) % sizes.len()];
    let mut work = Work::new(size, case.effects, seed);
    if case.knowledge != Knowledge::Motion {
        work = work.with_gauges(seed);
    }
    let Some(setup) = settings(&work, case, seed)? else {
        return Ok(Sums::default());
    };
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

const COLUMNS: [Column; 10] = [
    Column::share("narrow_of_knowable", "narrow", 2),
    Column::share("trusted_of_knowable", "trusted", 2),
    Column::share("wrong_of_trusted", "wrong", 3),
    Column::share("covered", "covered", 2),
    Column::share("named", "named", 2),
    Column::share("loads_found", "found", 2),
    Column::share("loads_invented", "invented", 2),
    Column::share("loads_trusted", "trusted", 2),
    Column::share("loads_covered", "covered", 2),
    Column::error("load_rms_of_rated", "rms, % rated"),
];

fn line(case: &Case, s: &Sums) -> Line<10> {
    let numbers = [
        share(s.narrow, s.knowable),
        share(s.trusted_knowable, s.knowable),
        share(s.wrong, s.trusted),
        share(s.covered, s.rows),
        case.names.and_then(|_| share(s.named, s.runs)),
        s.loads.found(),
        s.loads.invented(),
        s.loads.trusted(),
        s.loads.covered(),
        s.loads.rms(),
    ];
    Line {
        machine: case.name,
        stated: case.knowledge.name(),
        loads: s.loads.all,
        numbers,
        met: met(case, numbers),
    }
}

/// Whether a line meets section "acceptance" of the weighing specification.
fn met(case: &Case, numbers: [Option<f64>; 10]) -> bool {
    let [narrow, _, wrong, covered, named, _, _, trusted, inside, rms] = numbers;
    let honest = at_most(wrong, 0.03);
    if let Some(named) = named {
        return honest && named >= 0.8;
    }
    match (case.knowledge, case.name) {
        (Knowledge::Described, "good machine") => {
            honest && at_least(narrow, 0.8) && at_least(covered, 0.95)
        }
        (Knowledge::Calibrated, _) => {
            honest && at_most(rms, 0.015) && at_least(inside, 0.93) && at_least(trusted, 0.8)
        }
        _ => honest,
    }
}

/// Every case; the sizes alternate with the seeds.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let (mut lines, mut json) = (Vec::new(), Vec::new());
    for case in cases() {
        let label = format!("{}, {}", case.name, case.knowledge.name());
        let mut sums = Sums::default();
        for one in seeds(options, &label, |seed| run(&case, seed))? {
            sums.add(&one);
        }
        let line = line(&case, &sums);
        let mut of_line = line.json(&COLUMNS, options.seeds);
        of_line["rows"] = json!(sums.rows);
        json.push(of_line);
        lines.push(line);
    }
    Ok(Report {
        text: format!(
            "Excavators that weigh their loads by the boom's cylinder, {} seeds of 90 s: rows (narrow: half width below 5 %, of the time \
             in which the bucket neither digs nor empties), then loads\n{}",
            options.seeds,
            text(&COLUMNS, &lines)
        ),
        json: json.into(),
        met: lines.iter().all(|line| line.met),
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
        for seed in 1..=4 {
            sums.add(&run(case, seed).expect("a run"));
        }
        assert!(10 * sums.trusted > sums.rows, "{sums:?}");
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
