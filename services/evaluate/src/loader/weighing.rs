//! What the lift arm's pressures and angles add: centre of gravity while standing and driving, loads in kilograms.
//!
//! JSON: a list of lines, each with `machine`, `stated`, `seeds`, and the numbers named by [`COLUMNS`]; null where there is nothing to
//! count. Ratio and height are judged over all time; their errors while the machine carries a load.

use std::sync::atomic::AtomicBool;

use calibrate::loader::{Input, StatedLoad};
use estimation::Quantity;
use estimation::loader::keys::{LiftArm, LiftCylinder};
use estimation::loader::{CgEstimator, Columns, Method, Reason, Sample, Settings};
use estimation::loads::Row as Weighing;
use serde_json::{Value, json};
use sim::cylinder::Gauges;
use sim::loader::{CASES, Effects, Row, Run, Scenario, Simulation, Size, Tier};
use statistics::judge::{is_covered, is_wrong};

use super::candidate::Candidate;
use super::honesty::scaled;
use crate::loads::{Book, LOAD, Tally, rms, share};
use crate::text::{Table, plain};
use crate::{Error, Options, Report, seeds};

/// Five cycles of loading [s].
const DURATION: f64 = 130.0;
/// A full bucket, in masses of the machine.
const RATED: f64 = 0.32;
/// Standard deviations of the empty machine's ratio on axle scales, and of a height stated to 5 %.
const SCALES: f64 = 0.01;
const STATED_HEIGHT: f64 = 0.05;
/// Load that a calibration lifts, as a share of a full bucket, and how well it was weighed.
const CALIBRATED: f64 = 0.7;
const LOAD_STD: f64 = 0.005;
/// Between the seeds of a machine's recordings.
const LIFTS: u64 = 100_000;

/// What is stated and measured.
#[derive(Clone, Copy, PartialEq)]
enum Knowledge {
    /// No lift arm.
    Nothing,
    /// The drawing of the arm; the empty machine of the data sheet.
    Drawing,
    /// The empty machine stood on axle scales once.
    Weighed,
    /// And slow lifts, empty and with a weighed load.
    Calibrated,
    /// The empty machine on axle scales, without wheels: a scale.
    Scale,
}

impl Knowledge {
    const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "no lift arm",
            Self::Drawing => "drawing",
            Self::Weighed => "empty machine weighed",
            Self::Calibrated => "weighed, lifts calibrated",
            Self::Scale => "weighed, no wheels",
        }
    }
}

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

/// The drawing of a simulated machine's arm.
fn drawing(size: Size) -> (LiftArm, LiftCylinder) {
    let real = sim::loader::LiftArm::of(&size.machine());
    let c = real.cylinder;
    let arm = LiftArm {
        length: real.length,
        pivot_x: real.pivot_x,
        pivot_z: real.pivot_z,
        mass: real.mass,
        mass_distance: real.mass_distance,
        bucket_mass: real.bucket_mass,
        payload_distance: real.payload_distance,
        reference_angle: real.reference.lift,
        reference_tilt: real.reference.bucket - real.reference.lift,
        ..LiftArm::default()
    };
    let cylinder = LiftCylinder {
        count: c.count,
        head_area: c.head_area,
        rod_area: c.rod_area,
        base_distance: c.base_distance,
        rod_distance: c.rod_distance,
        angle: c.angle,
        friction: c.friction,
        ..LiftCylinder::default()
    };
    (arm, cylinder)
}

/// What the estimator of a machine is given.
fn settings(knowledge: Knowledge, run: &Run, simulation: &Simulation, first: &Row) -> Settings {
    let candidate = Candidate::DATA_SHEET;
    let mut settings = scaled(candidate.settings(simulation.nominal(), first), run.size);
    if knowledge == Knowledge::Nothing {
        return settings;
    }
    settings.sensors.angle_offset_std = 0.009;
    (settings.lift_arm, settings.lift_cylinder) = drawing(run.size);
    if knowledge != Knowledge::Drawing {
        let machine = simulation.machine();
        let mut noise = sim::noise::Noise::channel(run.seed, 900);
        let arm = &mut settings.lift_arm;
        arm.empty_mass = machine.mass * (1.0 + 0.005 * noise.normal());
        arm.empty_mass_std = 0.005 * machine.mass;
        arm.empty_ratio = machine.cg_ratio + SCALES * noise.normal();
        arm.empty_ratio_std = SCALES;
        arm.empty_height = machine.cg_height * (1.0 + STATED_HEIGHT * noise.normal());
        arm.empty_height_std = STATED_HEIGHT * machine.cg_height;
    }
    settings
}

/// The settings after slow lifts with nothing in the bucket and with a load that was weighed.
fn calibrated(settings: Settings, run: &Run) -> Result<Settings, Error> {
    let load = CALIBRATED * RATED * run.size.machine().mass;
    let mut noise = sim::noise::Noise::channel(run.seed, 901);
    let mut lifts = |payload: f64, std: f64, number: u64| -> Result<Input, Error> {
        let lifts = Run {
            scenario: Scenario::Lifts,
            payload: Some(payload),
            machine_seed: Some(run.seed),
            seed: LIFTS * number + run.seed,
            duration: None,
            ..run.clone()
        };
        let simulation = Simulation::new(&lifts).map_err(Error::refused)?;
        let nominal = simulation.clone();
        Ok(Input {
            name: format!("{payload:.0} kg"),
            samples: simulation
                .map(|row| sample(Knowledge::Calibrated, &nominal, &row))
                .collect(),
            stated: StatedLoad::default(),
            payload: Some(Quantity {
                value: payload + std * noise.normal(),
                std,
            }),
        })
    };
    let inputs = [lifts(0.0, 0.0, 1)?, lifts(load, LOAD_STD * load, 2)?];
    let description = config::Loader {
        machine: settings.machine,
        lift_arm: settings.lift_arm,
        lift_cylinder: settings.lift_cylinder,
        sensors: settings.sensors,
        prior: settings.prior,
        ..config::Loader::default()
    };
    let outcome = calibrate::loader::calibrate(
        &inputs,
        &calibrate::loader::Options {
            description: &description,
            weighed: StatedLoad::default(),
            ways: &[],
            slices: false,
            free: None,
            stop: &AtomicBool::new(false),
            progress: &|_| {},
        },
    )
    .map_err(Error::refused)?;
    let (found, _) = outcome
        .description(&description, &[])
        .ok_or_else(|| Error::refused(outcome.faults.join("; ")))?;
    Ok(Settings {
        lift_arm: found.lift_arm,
        lift_cylinder: found.lift_cylinder,
        ..settings
    })
}

fn sample(knowledge: Knowledge, simulation: &Simulation, row: &Row) -> Sample {
    let mut sample = Candidate::DATA_SHEET.sample(simulation.nominal(), row);
    if knowledge == Knowledge::Scale {
        sample = Sample {
            time: row.time,
            ..Sample::default()
        };
    }
    if let (false, Some(arm)) = (knowledge == Knowledge::Nothing, row.arm) {
        sample.lift_angle = Some(arm.lift_angle);
        sample.tilt_angle = Some(arm.tilt_angle);
        sample.lift_head_pressure = Some(arm.head_pressure);
        sample.lift_rod_pressure = Some(arm.rod_pressure);
    }
    sample
}

/// A simulated machine with its estimator.
struct Machine {
    run: Run,
    simulation: Simulation,
    first: Row,
    estimator: CgEstimator,
}

impl Machine {
    fn new(knowledge: Knowledge, effects: Effects, seed: u64) -> Result<Self, Error> {
        let run = Run {
            seed,
            tier: Tier::B,
            size: Size::REAL[(seed as usize - 1) % Size::REAL.len()],
            duration: Some(DURATION),
            gauges: (knowledge != Knowledge::Nothing).then(Gauges::default),
            effects,
            ..Run::new(Scenario::Loading)
        };
        let mut simulation = Simulation::new(&run).map_err(Error::refused)?;
        let first = simulation
            .next()
            .ok_or_else(|| Error::refused("a run without rows"))?;
        let columns = Columns {
            acceleration: true,
            mass: first.mass.is_some(),
            ..Columns::default()
        };
        let mut settings = settings(knowledge, &run, &simulation, &first);
        if knowledge == Knowledge::Calibrated {
            settings = calibrated(settings, &run)?;
        }
        let estimator = CgEstimator::new(&settings, Method::Full, columns);
        Ok(Self {
            run,
            simulation,
            first,
            estimator: estimator.map_err(Error::refused)?,
        })
    }
}

/// One seed.
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
            ..Weighing::default()
        };
        book.row(&weighed, truth.payload);
        next = simulation.next();
    }
    sums.loads = book.judge();
    Ok(sums)
}

/// A line of the table.
struct Line {
    name: &'static str,
    knowledge: Knowledge,
    sums: Sums,
}

/// Keys of the numbers of a line.
pub const COLUMNS: [&str; 11] = [
    "ratio_trusted",
    "ratio_wrong_of_trusted",
    "ratio_covered",
    "ratio_rms_carrying",
    "height_trusted",
    "height_wrong_of_trusted",
    "height_covered",
    "height_rms_carrying",
    "loads_trusted",
    "loads_covered",
    "load_rms_of_rated",
];

impl Line {
    fn numbers(&self) -> [Option<f64>; 11] {
        let [a, b, c, d] = self.sums.ratio.numbers();
        let [e, f, g, h] = self.sums.height.numbers();
        let loads = &self.sums.loads;
        [
            a,
            b,
            c,
            d,
            e,
            f,
            g,
            h,
            loads.trusted(),
            loads.covered(),
            loads.rms(),
        ]
    }

    /// What the weighing specification asks: trusted .8 and .6 of all time, rms 1.5 and 5 %, wrong at most .03.
    fn met(&self) -> bool {
        let [
            ratio,
            ratio_wrong,
            _,
            ratio_rms,
            height,
            height_wrong,
            _,
            height_rms,
            ..,
        ] = self.numbers();
        let most = |value: Option<f64>, limit: f64| value.is_none_or(|v| v <= limit);
        let least = |value: Option<f64>, limit: f64| value.is_some_and(|v| v >= limit);
        let honest = most(ratio_wrong, 0.03) && most(height_wrong, 0.03);
        if self.knowledge != Knowledge::Weighed {
            return honest;
        }
        let precise = most(ratio_rms, 0.015) && most(height_rms, 0.05);
        honest && precise && least(ratio, 0.8) && least(height, 0.6)
    }
}

fn text(lines: &[Line]) -> String {
    let mut table = Table::new(&[
        "machine",
        "stated",
        "ratio",
        "wrong",
        "covered",
        "rms %",
        "height",
        "wrong",
        "covered",
        "rms %",
        "loads",
        "covered",
        "rms, % rated",
        "",
    ]);
    for line in lines {
        let mut cells = vec![line.name.to_owned(), line.knowledge.name().to_owned()];
        for (i, value) in line.numbers().into_iter().enumerate() {
            let (factor, decimals) = match i {
                3 | 7 | 10 => (100.0, 1),
                1 | 5 => (1.0, 3),
                _ => (1.0, 2),
            };
            cells.push(value.map_or("-".into(), |v| plain(factor * v, decimals)));
        }
        cells.push(if line.met() { "met" } else { "missed" }.into());
        table.row(cells);
    }
    table.to_string()
}

/// Every machine with everything that may be stated of it.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let good = CASES.iter().find(|case| case.0 == "good machine");
    let sound = ("sound machine", Effects::default());
    let machines = [Some(sound), good.map(|case| (case.0, case.2))];
    let mut lines = Vec::new();
    for (name, effects) in machines.into_iter().flatten() {
        for knowledge in [
            Knowledge::Nothing,
            Knowledge::Drawing,
            Knowledge::Weighed,
            Knowledge::Calibrated,
            Knowledge::Scale,
        ] {
            let label = format!("{name}, {}", knowledge.name());
            let mut sums = Sums::default();
            for one in seeds(options, &label, |seed| run(knowledge, effects, seed))? {
                sums.add(&one);
            }
            lines.push(Line {
                name,
                knowledge,
                sums,
            });
        }
    }
    let json_of = |line: &Line| -> Value {
        let mut out = json!({
            "machine": line.name, "stated": line.knowledge.name(), "seeds": options.seeds, "loads": line.sums.loads.all, "met": line.met(),
        });
        for (key, value) in COLUMNS.iter().zip(line.numbers()) {
            out[*key] = json!(value);
        }
        out
    };
    Ok(Report {
        text: format!(
            "Loaders that weigh their loads by the lift cylinders, {} seeds of {DURATION} s: trusted of all time, wrong of trusted, \
             rms while carrying; loads\n{}",
            options.seeds,
            text(&lines)
        ),
        json: lines.iter().map(json_of).collect(),
        met: lines.iter().all(Line::met),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimation::loader::Status;

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

    /// With 12 t and a full bucket the rear axle carries a tenth of the weight while the machine sets off in reverse.
    #[test]
    fn a_wheel_that_spins_leads_nothing_astray() {
        let good = CASES.iter().find(|case| case.0 == "good machine");
        let effects = Effects {
            spins: true,
            ..good.expect("a case").2
        };
        let mut machine = Machine::new(Knowledge::Drawing, effects, 8).expect("a machine");
        let radius = machine.run.size.machine().wheel_radius;
        let mut spun = 0;
        let mut next = Some(machine.first);
        while let Some(row) = next {
            let estimate =
                machine
                    .estimator
                    .step(&sample(Knowledge::Drawing, &machine.simulation, &row));
            spun += u32::from((radius * row.rear_wheel_speed - row.speed).abs() > 5.0);
            assert!(
                (estimate.speed - row.speed).abs() < 1.0,
                "{row:?} {estimate:?}"
            );
            assert!(estimate.slope_bias.is_none_or(|bias| bias.abs() < 0.1));
            next = machine.simulation.next();
        }
        assert!(spun > 20, "{spun}");
    }
    #[test]
    fn a_wheel_of_another_radius_does_not_spin_for_ever() {
        let machine = Machine::new(Knowledge::Nothing, Effects::default(), 1).expect("a machine");
        let Machine {
            run,
            simulation,
            first,
            ..
        } = machine;
        let mut settings = settings(Knowledge::Nothing, &run, &simulation, &first);
        settings.machine.wheel_radius *= 1.25;
        let columns = Columns {
            acceleration: true,
            ..Columns::default()
        };
        let mut estimator = CgEstimator::new(&settings, Method::Full, columns).expect("settings");
        let (mut moving, mut trusted, mut set_aside) = (0, 0, 0);
        let nominal = *simulation.nominal();
        for row in simulation {
            let sample = Candidate::DATA_SHEET.sample(&nominal, &row);
            let estimate = estimator.step(&sample);
            moving += u32::from(row.speed.abs() > 1.0);
            trusted += u32::from(estimate.trusted_ratio);
            set_aside += u32::from(row.speed.abs() > 1.0 && estimate.status == Status::Gap);
        }
        assert!(
            moving > 3000 && set_aside * 2 < moving && trusted == 0,
            "{set_aside} of {moving}, {trusted}"
        );
    }
}
