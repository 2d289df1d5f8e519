//! Simulated loaders with a lift arm: their descriptions and their estimators.

use calibrate::loader::{Input, StatedLoad};
use estimation::Quantity;
use estimation::loader::keys::{LiftArm, LiftCylinder};
use estimation::loader::{CgEstimator, Columns, Method, Sample, Settings};
use sim::cylinder::Gauges;
use sim::loader::{Effects, Row, Run, Scenario, Simulation, Size, Tier};

use crate::Error;
use crate::loader::candidate::Candidate;
use crate::loader::honesty::scale;

/// Duration of five loading cycles [s].
pub(super) const DURATION: f64 = 130.0;
/// Content of a full bucket, in masses of the machine.
pub(super) const RATED: f64 = 0.32;
/// Standard deviations of the empty machine's ratio on axle scales, and of its stated height (5 %).
const SCALES: f64 = 0.01;
const STATED_HEIGHT: f64 = 0.05;
/// Load in a calibration, as a share of a full bucket, and accuracy of its weighing.
const CALIBRATED: f64 = 0.7;
const LOAD_STD: f64 = 0.005;
/// Distance of the seeds of a machine's recordings.
const LIFTS: u64 = 100_000;

/// Statements and measurements.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Knowledge {
    /// No lift arm.
    Nothing,
    /// The drawing of the arm; the empty machine of the data sheet.
    Drawing,
    /// The empty machine stood on axle scales once.
    Weighed,
    /// Weighed, and slow lifts, empty and with a weighed load.
    Calibrated,
    /// The empty machine on axle scales, without wheels: a scale.
    Scale,
}

impl Knowledge {
    pub(super) const ALL: [Self; 5] = [
        Self::Nothing,
        Self::Drawing,
        Self::Weighed,
        Self::Calibrated,
        Self::Scale,
    ];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "no lift arm",
            Self::Drawing => "drawing",
            Self::Weighed => "empty machine weighed",
            Self::Calibrated => "weighed, lifts calibrated",
            Self::Scale => "weighed, no wheels",
        }
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
        // The tilt cylinder is mounted on the arm, and the driver levels the bucket.
        bucket_turn: Some(1.0),
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

/// The settings of a machine's estimator.
fn settings(knowledge: Knowledge, run: &Run, simulation: &Simulation, first: &Row) -> Settings {
    let candidate = Candidate::DATA_SHEET;
    let mut settings = candidate.settings(simulation.nominal(), first);
    scale(&mut settings, run.size);
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

/// The settings after slow lifts with an empty bucket and with a weighed load.
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
    let options = calibrate::loader::Options::of(&description);
    let outcome = calibrate::loader::calibrate(&inputs, &options).map_err(Error::refused)?;
    let (found, _) = outcome
        .description(&description, &[])
        .ok_or_else(|| Error::refused(outcome.faults.join("; ")))?;
    Ok(Settings {
        lift_arm: found.lift_arm,
        lift_cylinder: found.lift_cylinder,
        ..settings
    })
}

/// The estimator's part of a row.
pub(super) fn sample(knowledge: Knowledge, simulation: &Simulation, row: &Row) -> Sample {
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
pub(super) struct Machine {
    pub run: Run,
    pub simulation: Simulation,
    pub first: Row,
    pub estimator: CgEstimator,
}

impl Machine {
    pub(super) fn new(knowledge: Knowledge, effects: Effects, seed: u64) -> Result<Self, Error> {
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
        let columns = Columns { acceleration: true };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::remembered::Learnt;
    use estimation::loader::Status;
    use sim::loader::CASES;
    use statistics::judge::{is_covered, is_wrong};

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
        let columns = Columns { acceleration: true };
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

    /// A working day: trusted and wrong rows of the ratio, the share of rows whose interval holds it, and what was restored.
    fn day(number: u64, ratio_std: f64, learnt: Option<&mut Learnt>) -> [f64; 4] {
        const MACHINE: u64 = 3;
        let run = Run {
            seed: MACHINE + number * LIFTS,
            machine_seed: Some(MACHINE),
            tier: Tier::B,
            size: Size::REAL[1],
            duration: Some(DURATION),
            gauges: Some(Gauges::default()),
            ..Run::new(Scenario::Loading)
        };
        let mut simulation = Simulation::new(&run).expect("a run");
        let first = simulation.next().expect("a row");
        let mut settings = settings(Knowledge::Drawing, &run, &simulation, &first);
        let (machine, prior) = (*simulation.machine(), &mut settings.prior);
        // The empty machine stood on scales once, and its result is the prior.
        prior.cg_ratio = machine.cg_ratio + 0.5 * ratio_std;
        prior.cg_ratio_std = ratio_std;
        let mut learnt = learnt;
        let restored = learnt.as_ref().map_or(0, |l| l.restore(prior, 0.0));
        let columns = Columns { acceleration: true };
        let mut estimator = CgEstimator::new(&settings, Method::Full, columns).expect("settings");
        let nominal = simulation.clone();
        let (mut rows, mut covered, mut trusted, mut wrong) = (0.0, 0.0, 0.0, 0.0);
        for row in simulation {
            let estimate = estimator.step(&sample(Knowledge::Drawing, &nominal, &row));
            let (truth, Quantity { value, std }) = (row.truth.cg_ratio, estimate.cg_ratio);
            rows += 1.0;
            covered += f64::from(u8::from(is_covered(value, std, truth)));
            if estimate.trusted_ratio {
                trusted += 1.0;
                wrong += f64::from(u8::from(is_wrong(value, std, truth)));
            }
            if let Some(learnt) = &mut learnt {
                learnt.see(&estimate);
            }
        }
        [trusted / rows, wrong, covered / rows, restored as f64]
    }

    /// An earlier heft stored the ratio with its load: after four days all trusted rows were wrong.
    #[test]
    fn over_days_of_loading_what_is_remembered_makes_no_ratio_wrong() {
        for ratio_std in [0.006, 0.06] {
            let mut learnt = Learnt::default();
            for number in 1..=5 {
                let cold = day(number, ratio_std, None);
                let warm = day(number, ratio_std, Some(&mut learnt));
                println!("{ratio_std} {number}: {cold:?} {warm:?} {learnt:?}");
                assert!(warm[1] <= cold[1], "{number}: {cold:?} {warm:?}");
                assert!(warm[2] > 0.95, "{number}: {cold:?} {warm:?}");
            }
        }
    }
}
