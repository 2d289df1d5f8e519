//! Gain from the lift arm's pressures and angles: centre of gravity while standing and driving, loads in kilograms.
//!
//! JSON: a list of lines, as that of the excavator. Ratio and height are judged over all time; their errors while the machine
//! carries a load.

mod machine;

use estimation::Quantity;
use estimation::loader::Reason;
use estimation::loads::{Row as Weighing, Witness};
use sim::loader::{CASES, Effects};
use statistics::judge::{is_covered, is_wrong};

use self::machine::{DURATION, Knowledge, Machine, RATED, sample};
use crate::loads::{Book, LOAD, Tally, rms, share};
use crate::weighing::{Column, Line, at_least, at_most, text};
use crate::{Error, Options, Report, seeds};

/// Sums over rows, of one quantity.
#[derive(Clone, Copy, Default)]
struct QuantitySums {
    rows: usize,
    trusted: usize,
    wrong: usize,
    covered: usize,
    carried: usize,
    squares: f64,
}

impl QuantitySums {
    fn row(&mut self, truth: f64, weighed: Quantity, trusted: bool, carries: bool) {
        self.rows += 1;
        self.trusted += usize::from(trusted);
        self.covered += usize::from(is_covered(weighed.value, weighed.std, truth));
        self.wrong += usize::from(trusted && is_wrong(weighed.value, weighed.std, truth));
        if trusted && carries {
            self.carried += 1;
            self.squares += ((weighed.value - truth) / truth).powi(2);
        }
    }

    fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.trusted += other.trusted;
        self.wrong += other.wrong;
        self.covered += other.covered;
        self.carried += other.carried;
        self.squares += other.squares;
    }

    /// Trusted, wrong of trusted, covered, rms while carrying.
    fn numbers(&self) -> [Option<f64>; 4] {
        [
            share(self.trusted, self.rows),
            share(self.wrong, self.trusted),
            share(self.covered, self.rows),
            rms(self.squares, self.carried),
        ]
    }
}

#[derive(Clone, Copy, Default)]
struct Sums {
    ratio: QuantitySums,
    height: QuantitySums,
    loads: Tally,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.ratio.add(&other.ratio);
        self.height.add(&other.height);
        self.loads.add(&other.loads);
    }
}

/// Scores one seed.
fn run(knowledge: Knowledge, effects: Effects, seed: u64) -> Result<Sums, Error> {
    let Machine {
        run,
        mut simulation,
        first,
        mut estimator,
    } = Machine::new(knowledge, effects, seed)?;
    let rated = RATED * run.size.machine().mass;
    let mut sums = Sums::default();
    let mut book = Book::new(rated);
    let mut next = Some(first);
    while let Some(row) = next {
        let estimate = estimator.step(&sample(knowledge, &simulation, &row));
        let carries = row.truth.payload > LOAD * rated;
        let (ratio, height) = (estimate.cg_ratio, estimate.cg_height);
        let truth = &row.truth;
        sums.ratio
            .row(truth.cg_ratio, ratio, estimate.trusted_ratio, carries);
        sums.height
            .row(truth.cg_height, height, estimate.trusted_height, carries);
        let weighed = Weighing {
            time: row.time,
            payload: estimate.payload,
            speed: estimate.speed,
            changing: estimate.reason == Reason::Load,
            trusted: estimate.trusted_payload,
            witness: Witness::Pressure,
            ..Weighing::default()
        };
        book.row(&weighed, truth.payload);
        next = simulation.next();
    }
    sums.loads = book.judge();
    Ok(sums)
}

const COLUMNS: [Column; 12] = [
    Column::share("ratio_trusted", "ratio", 2),
    Column::share("ratio_wrong_of_trusted", "wrong", 3),
    Column::share("ratio_covered", "covered", 2),
    Column::error("ratio_rms_carrying", "rms %"),
    Column::share("height_trusted", "height", 2),
    Column::share("height_wrong_of_trusted", "wrong", 3),
    Column::share("height_covered", "covered", 2),
    Column::error("height_rms_carrying", "rms %"),
    Column::share("loads_trusted", "loads", 2),
    Column::share("loads_invented", "invented", 2),
    Column::share("loads_covered", "covered", 2),
    Column::error("load_rms_of_rated", "rms, % rated"),
];

fn line(machine: &'static str, knowledge: Knowledge, sums: &Sums) -> Line<12> {
    let [a, b, c, d] = sums.ratio.numbers();
    let [e, f, g, h] = sums.height.numbers();
    let loads = &sums.loads;
    let (i, j) = (loads.trusted(), loads.invented());
    let (k, l) = (loads.covered(), loads.rms());
    let numbers = [a, b, c, d, e, f, g, h, i, j, k, l];
    Line {
        machine,
        stated: knowledge.name(),
        loads: loads.all,
        numbers,
        met: met(knowledge, sums),
    }
}

/// Whether the weighing specification is met: trusted .8 and .6 of all time, rms 1.5 and 5 %, wrong at most .03.
fn met(knowledge: Knowledge, sums: &Sums) -> bool {
    let [ratio, ratio_wrong, _, ratio_rms] = sums.ratio.numbers();
    let [height, height_wrong, _, height_rms] = sums.height.numbers();
    let honest = at_most(ratio_wrong, 0.03) && at_most(height_wrong, 0.03);
    if knowledge != Knowledge::Weighed {
        return honest;
    }
    let precise = at_most(ratio_rms, 0.015) && at_most(height_rms, 0.05);
    honest && precise && at_least(ratio, 0.8) && at_least(height, 0.6)
}

/// Every machine with each combination of statements.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let good = CASES.iter().find(|case| case.0 == "good machine");
    let sound = ("sound machine", Effects::default());
    let machines = [Some(sound), good.map(|case| (case.0, case.2))];
    let mut lines = Vec::new();
    for (name, effects) in machines.into_iter().flatten() {
        for knowledge in Knowledge::ALL {
            let label = format!("{name}, {}", knowledge.name());
            let mut sums = Sums::default();
            for one in seeds(options, &label, |seed| run(knowledge, effects, seed))? {
                sums.add(&one);
            }
            lines.push(line(name, knowledge, &sums));
        }
    }
    let json = |line: &Line<12>| line.json(&COLUMNS, options.seeds);
    Ok(Report {
        text: format!(
            "Loaders that weigh their loads by the lift cylinders, {} seeds of {DURATION} s: trusted of all time, wrong of trusted, \
             rms while carrying; loads\n{}",
            options.seeds,
            text(&COLUMNS, &lines)
        ),
        json: lines.iter().map(json).collect(),
        met: lines.iter().all(|line| line.met),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lift_arm_makes_ratio_and_height_trusted_and_weighs_the_loads() {
        let [without, with] = [Knowledge::Nothing, Knowledge::Weighed].map(|knowledge| {
            let mut sums = Sums::default();
            for seed in 1..=3 {
                sums.add(&run(knowledge, Effects::default(), seed).expect("a run"));
            }
            sums
        });
        assert!(with.height.trusted > without.height.trusted);
        let loads = with.loads;
        assert!(loads.all >= 12 && loads.found * 10 >= loads.all * 9);
        assert!(loads.rms() < Some(0.08));
        assert!(loads.covered() >= Some(0.85));
    }

    #[test]
    fn slow_lifts_with_a_weighed_load_make_loads_exact() {
        let [weighed, calibrated] = [Knowledge::Weighed, Knowledge::Calibrated].map(|knowledge| {
            let mut sums = Sums::default();
            for seed in 1..=4 {
                sums.add(&run(knowledge, Effects::default(), seed).expect("a run"));
            }
            sums.loads
        });
        let [before, after] = [&weighed, &calibrated].map(|loads| loads.rms().expect("loads"));
        assert!(after < 0.6 * before, "{before} {after}");
        assert!(calibrated.covered() >= Some(0.9));
    }
}
