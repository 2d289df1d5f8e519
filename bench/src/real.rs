//! The steps of the product on the simulators' rows: a minute of a working cycle of each machine at 100 Hz, repeated.

use crate::measure::{Contender, contender};
use crate::problem::Filter;
use estimation::{excavator, loader};
use sim::cylinder::Gauges;
use std::sync::LazyLock;

/// A problem with a time in its rows, repeated with continuing time.
struct Laps {
    offset: f64,
    last: f64,
    period: f64,
}

impl Laps {
    const NEW: Laps = Laps {
        offset: 0.0,
        last: f64::NEG_INFINITY,
        period: 0.01,
    };

    fn time(&mut self, time: f64) -> f64 {
        if time <= self.last {
            self.offset += self.last - time + self.period;
        }
        self.last = time;
        time + self.offset
    }
}

/// Rows of a minute at 100 Hz.
pub const ROWS: usize = 6000;

/// Sixty seconds of loading cycles of the excavator, simulated once.
pub fn excavator_rows() -> Vec<excavator::Sample> {
    static ROWS: LazyLock<Vec<excavator::Sample>> = LazyLock::new(|| excavator_rows_with(None));
    ROWS.clone()
}

/// The same, with or without pressure sensors.
fn excavator_rows_with(gauges: Option<Gauges>) -> Vec<excavator::Sample> {
    let run = sim::excavator::Run {
        duration: 60.0,
        gauges,
        ..sim::excavator::Run::new(sim::excavator::Scenario::Cycle)
    };
    let rows = sim::excavator::Simulation::new(&run)
        .unwrap_or_else(|error| panic!("the run is ours: {error}"));
    rows.take(ROWS)
        .map(|row| excavator::Sample {
            time: row.time,
            velocity: row.swing_velocity,
            angle: None,
            torque: row.swing_torque,
            posture: row.posture,
            inclination: row.inclination,
            boom_head_pressure: row.pressures[0],
            boom_rod_pressure: row.pressures[1],
            arm_head_pressure: row.pressures[2],
            arm_rod_pressure: row.pressures[3],
            ..excavator::Sample::default()
        })
        .collect()
}

/// Sixty seconds of work of the loader, simulated once.
pub fn loader_rows() -> Vec<loader::Sample> {
    static ROWS: LazyLock<Vec<loader::Sample>> = LazyLock::new(|| loader_rows_with(None));
    ROWS.clone()
}

/// The same, with or without the sensors of a lift arm.
fn loader_rows_with(gauges: Option<Gauges>) -> Vec<loader::Sample> {
    let run = sim::loader::Run {
        duration: Some(60.0),
        gauges,
        ..sim::loader::Run::new(sim::loader::Scenario::WorkCycle)
    };
    let rows = sim::loader::Simulation::new(&run)
        .unwrap_or_else(|error| panic!("the run is ours: {error}"));
    rows.take(ROWS)
        .map(|row| loader::Sample {
            time: row.time,
            speed: Some(row.speed),
            front_wheel_speed: Some(row.front_wheel_speed),
            rear_wheel_speed: Some(row.rear_wheel_speed),
            front_torque: Some(row.front_torque),
            rear_torque: Some(row.rear_torque),
            slope: Some(row.slope),
            acceleration: Some(row.acceleration),
            mass: row.mass,
            spade_force_x: row.spade_force_x,
            spade_force_z: row.spade_force_z,
            boom_moving: row.boom_moving.unwrap_or(false),
            lift_angle: row.arm.map(|arm| arm.lift_angle),
            tilt_angle: row.arm.map(|arm| arm.tilt_angle),
            lift_head_pressure: row.arm.map(|arm| arm.head_pressure),
            lift_rod_pressure: row.arm.map(|arm| arm.rod_pressure),
            ..loader::Sample::default()
        })
        .collect()
}

const EXCAVATOR_COLUMNS: excavator::Columns = excavator::Columns {
    velocity: true,
    angle: false,
    torque: true,
    posture: true,
};
const LOADER_COLUMNS: loader::Columns = loader::Columns { acceleration: true };

/// The Kalman filter stage of the excavator.
pub struct Motion {
    filter: excavator::MotionFilter,
    laps: Laps,
    last: excavator::Motion,
}

impl Default for Motion {
    fn default() -> Self {
        let filter =
            excavator::MotionFilter::new(&excavator::Settings::calibrated(), EXCAVATOR_COLUMNS);
        let filter = filter.unwrap_or_else(|error| panic!("defaults are valid: {error}"));
        Self {
            filter,
            laps: Laps::NEW,
            last: excavator::Motion::default(),
        }
    }
}

impl Filter<excavator::Sample, 2> for Motion {
    fn step(&mut self, sample: &excavator::Sample) {
        let time = self.laps.time(sample.time);
        self.last = self.filter.step(&excavator::Sample { time, ..*sample });
    }

    fn state(&self) -> [f64; 2] {
        [self.last.velocity, self.last.acceleration]
    }
}

/// The regression stage after it; `METHOD` is an index into [`excavator::Method::ALL`].
pub struct Regression<const METHOD: usize> {
    filter: excavator::Regression,
    laps: Laps,
    last: excavator::Estimate,
}

impl<const METHOD: usize> Default for Regression<METHOD> {
    fn default() -> Self {
        let filter = excavator::Regression::new(
            &excavator::Settings::calibrated(),
            excavator::Method::ALL[METHOD],
        );
        let filter = filter.unwrap_or_else(|error| panic!("defaults are valid: {error}"));
        Self {
            filter,
            laps: Laps::NEW,
            last: excavator::Estimate::default(),
        }
    }
}

impl<const METHOD: usize> Filter<excavator::Motion, 1> for Regression<METHOD> {
    fn step(&mut self, motion: &excavator::Motion) {
        let time = self.laps.time(motion.time);
        self.last = self.filter.step(&excavator::Motion { time, ..*motion });
    }

    fn state(&self) -> [f64; 1] {
        [self.last.inertia]
    }
}

/// A state-space estimator of the excavator; `METHOD` is an index into [`excavator::Method::ALL`], `CYLINDER` adds the boom's
/// cylinders.
pub struct Swing<const METHOD: usize, const CYLINDER: bool = false> {
    filter: excavator::SwingEstimator,
    laps: Laps,
    last: excavator::Estimate,
}

/// The simulated cylinders of the boom.
fn boom_cylinder() -> excavator::keys::BoomCylinder {
    let [boom, _] = sim::excavator::cylinders(&sim::excavator::Size::reference().geometry);
    excavator::keys::BoomCylinder {
        count: boom.count,
        head_area: boom.head_area,
        rod_area: boom.rod_area,
        base_distance: boom.base_distance,
        rod_distance: boom.rod_distance,
        angle: boom.angle,
        friction: boom.friction,
        friction_std: 0.5 * boom.friction,
        ..excavator::keys::BoomCylinder::default()
    }
}

impl<const METHOD: usize, const CYLINDER: bool> Default for Swing<METHOD, CYLINDER> {
    fn default() -> Self {
        let method = excavator::Method::ALL[METHOD];
        // As the product starts, for an uncalibrated machine.
        let mut description = excavator::keys::Description::default();
        if CYLINDER {
            description.boom_cylinder = boom_cylinder();
        }
        let settings = excavator::Settings::of(&description);
        let filter = excavator::SwingEstimator::new(&settings, method, EXCAVATOR_COLUMNS);
        let filter = filter.unwrap_or_else(|error| panic!("defaults are valid: {error}"));
        Self {
            filter,
            laps: Laps::NEW,
            last: excavator::Estimate::default(),
        }
    }
}

impl<const METHOD: usize, const CYLINDER: bool> Filter<excavator::Sample, 1>
    for Swing<METHOD, CYLINDER>
{
    fn step(&mut self, sample: &excavator::Sample) {
        let time = self.laps.time(sample.time);
        self.last = self.filter.step(&excavator::Sample { time, ..*sample });
    }

    fn state(&self) -> [f64; 1] {
        [self.last.inertia]
    }
}

/// The simulated lift arm and its cylinders.
fn lift_arm() -> (loader::keys::LiftArm, loader::keys::LiftCylinder) {
    let arm = sim::loader::LiftArm::of(&sim::loader::Size::Reference.machine());
    let cylinder = arm.cylinder;
    (
        loader::keys::LiftArm {
            length: arm.length,
            pivot_x: arm.pivot_x,
            pivot_z: arm.pivot_z,
            mass: arm.mass,
            mass_distance: arm.mass_distance,
            bucket_mass: arm.bucket_mass,
            payload_distance: arm.payload_distance,
            bucket_turn: Some(1.0),
            reference_angle: arm.reference.lift,
            reference_tilt: arm.reference.bucket - arm.reference.lift,
            ..loader::keys::LiftArm::default()
        },
        loader::keys::LiftCylinder {
            count: cylinder.count,
            head_area: cylinder.head_area,
            rod_area: cylinder.rod_area,
            base_distance: cylinder.base_distance,
            rod_distance: cylinder.rod_distance,
            angle: cylinder.angle,
            friction: cylinder.friction,
            ..loader::keys::LiftCylinder::default()
        },
    )
}

/// An estimator of the loader; `METHOD` is an index into [`loader::Method::ALL`], `ARM` adds the lift arm.
pub struct Loader<const METHOD: usize, const ARM: bool = false> {
    filter: loader::CgEstimator,
    laps: Laps,
}

impl<const METHOD: usize, const ARM: bool> Default for Loader<METHOD, ARM> {
    fn default() -> Self {
        let method = loader::Method::ALL[METHOD];
        let mut description = loader::keys::Description::default();
        if ARM {
            (description.lift_arm, description.lift_cylinder) = lift_arm();
        }
        let settings = loader::Settings::of(&description, method);
        let filter = loader::CgEstimator::new(&settings, method, LOADER_COLUMNS);
        Self {
            filter: filter.unwrap_or_else(|error| panic!("defaults are valid: {error}")),
            laps: Laps::NEW,
        }
    }
}

impl<const METHOD: usize, const ARM: bool> Filter<loader::Sample, 2> for Loader<METHOD, ARM> {
    fn step(&mut self, sample: &loader::Sample) {
        let time = self.laps.time(sample.time);
        self.filter.step(&loader::Sample { time, ..*sample });
    }

    fn state(&self) -> [f64; 2] {
        [
            self.filter.last().cg_height.value,
            self.filter.last().cg_ratio.value,
        ]
    }
}

/// A step with its key in the JSON, created on demand: under valgrind the simulation of a minute takes longer than the minute's
/// steps.
pub type Row = (&'static str, fn() -> Contender);

/// Every real step.
pub const STEPS: [Row; 15] = [
    ("excavator_kalman", || {
        contender::<Motion, _, 2>("excavator, kalman stage", excavator_rows())
    }),
    ("excavator_multi_forgetting_rls", || {
        contender::<Regression<1>, _, 1>("excavator, multi-forgetting-rls", motions())
    }),
    ("excavator_svf_rls", || {
        contender::<Regression<2>, _, 1>("excavator, svf-rls", motions())
    }),
    ("excavator_posture_torque", || {
        contender::<Swing<3>, _, 1>("excavator, posture-torque", excavator_rows())
    }),
    ("excavator_torque", || {
        contender::<Swing<4>, _, 1>("excavator, torque", excavator_rows())
    }),
    ("excavator_posture", || {
        contender::<Swing<5>, _, 1>("excavator, posture", excavator_rows())
    }),
    ("excavator_velocity", || {
        contender::<Swing<6>, _, 1>("excavator, velocity", excavator_rows())
    }),
    ("loader_full_12", || {
        contender::<Loader<0>, _, 2>("loader, full, 12 states", loader_rows())
    }),
    ("loader_isr_ukf_printed_6", || {
        contender::<Loader<1>, _, 2>("loader, isr-ukf-printed, 6 states", loader_rows())
    }),
    ("loader_isr_ukf_6", || {
        contender::<Loader<2>, _, 2>("loader, isr-ukf, 6 states", loader_rows())
    }),
    ("loader_ekf_6", || {
        contender::<Loader<3>, _, 2>("loader, ekf, 6 states", loader_rows())
    }),
    ("loader_full_ekf_12", || {
        contender::<Loader<4>, _, 2>("loader, full-ekf, 12 states", loader_rows())
    }),
    ("excavator_posture_torque_pressures", || {
        contender::<Swing<3, true>, _, 1>(
            "excavator, posture-torque, pressures",
            excavator_rows_with(Some(Gauges::default())),
        )
    }),
    ("loader_full_12_arm", || {
        contender::<Loader<0, true>, _, 2>(
            "loader, full, lift arm",
            loader_rows_with(Some(Gauges::default())),
        )
    }),
    ("loader_full_ekf_12_arm", || {
        contender::<Loader<4, true>, _, 2>(
            "loader, full-ekf, lift arm",
            loader_rows_with(Some(Gauges::default())),
        )
    }),
];

/// The answers of the excavator's motion filter to its rows.
fn motions() -> Vec<excavator::Motion> {
    let mut filter = Motion::default();
    let answer = |row: &excavator::Sample| {
        filter.step(row);
        filter.last
    };
    excavator_rows().iter().map(answer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_runs_on_over_the_laps() {
        let mut laps = Laps::NEW;
        let times = [0.0, 0.01, 0.02, 0.0, 0.01].map(|time| laps.time(time));
        for (time, expected) in times.into_iter().zip([0.0, 0.01, 0.02, 0.03, 0.04]) {
            assert!((time - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn the_real_steps_do_real_work() {
        let mut loader = Loader::<0>::default();
        loader_rows().iter().for_each(|row| loader.step(row));
        assert!(
            loader.filter.last().refused == 0 && (loader.state()[0] - 0.9).abs() < 0.3,
            "{:?}",
            loader.state()
        );
        let mut swing = Swing::<3>::default();
        excavator_rows().iter().for_each(|row| swing.step(row));
        assert!(
            (2500.0..20_000.0).contains(&swing.state()[0]) && swing.last.inertia_std < 1000.0,
            "{:?}",
            swing.last
        );
    }
}
