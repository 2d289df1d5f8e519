//! Calibration over simulated machines (`heft calibrate`): errors of the result from two recordings of two minutes, and coverage
//! of its intervals.
//!
//! Each seed is a machine of its own: torque gain within 3 %, masses of the attachment within 5 %, damping
//! within 20 %, friction within 30 %, efficiency of the drive 0.9 to 1, a torque offset, and either the
//! torque or the velocity up to 50 ms late. It works 120 s empty and 120 s with 423 kg, weighed to 0.5 kg.
//!
//! JSON: `{"gain":{"median":..,"p95":..,"covered":..},..,"machines":n,"refused":n}`: errors in percent of
//! the value (offset in N m, delay in ms), share of the 95 % intervals that hold the truth in percent;
//! `"after":{"rms":..,"trusted":..,"wrong":..}` is the inertia from a third recording, in percent.

use calibrate::excavator::{self as calibration, Input, Role};
use estimation::Quantity;
use estimation::excavator::{Columns, Doubts, Geometry, Method, Sample, Settings, SwingEstimator};
use serde_json::{Map, Value, json};
use sim::excavator::{
    Course, Dynamics, Exact, Joint, Load, Machine, Path, Plant, Plateaus, Scenario, Targets,
};
use sim::noise::Noise;

use crate::text::{Table, plain, verdict};
use crate::{Error, Options, Report, seeds};
use statistics::judge::{JudgedRow, Tally};
use statistics::{median, p95, percentage};

/// Length of a recording [s], of a cycle [s], sampling rate [Hz].
const LENGTH: f64 = 120.0;
const CYCLE: f64 = 16.0;
const RATE: f64 = 100.0;
/// The weighed load and the accuracy of the scale [kg].
const LOAD: Quantity = Quantity {
    value: 423.0,
    std: 0.5,
};
/// The load afterwards, which is not stated [kg]; motion begins at this velocity [rad/s].
const AFTER: f64 = 288.0;
const MOVING: f64 = 0.10;
/// Noise of velocity [rad/s], torque [N m] and joint angles [rad].
const VELOCITY_STD: f64 = 0.005;
const TORQUE_STD: f64 = 100.0;
const ANGLE_STD: f64 = 0.001;
/// Median errors allowed: percent, percent, percent, percent, percent, N m, ms.
const TARGETS: [(&str, Role, f64); 4] = [
    ("gain", Role::Gain, 0.3),
    ("damping", Role::Damping, 1.0),
    ("friction", Role::Friction, 3.0),
    ("delay", Role::Delay, 2.0),
];
/// The others are reported.
const OTHERS: [(&str, Role); 4] = [
    ("efficiency", Role::Efficiency),
    ("upper_inertia", Role::Inertia),
    ("link_masses", Role::Links),
    ("offset", Role::Offset),
];

/// A machine that differs from its description.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// Measured over true torque.
    pub gain: f64,
    /// Measured torque at zero torque [N m].
    pub offset: f64,
    /// Masses and inertias of boom, arm and bucket over the described ones.
    pub links: f64,
    /// The same of the bucket, beyond those of boom and arm.
    pub bucket: f64,
    /// Damping [N m s/rad].
    pub damping: f64,
    /// Coulomb friction [N m].
    pub friction: f64,
    /// Efficiency of the drive.
    pub efficiency: f64,
    /// Delay of the velocity minus delay of the torque \[s\].
    pub delay: f64,
}

impl Truth {
    /// The machine of a seed.
    pub fn new(seed: u64) -> Self {
        let mut noise = Noise::channel(seed, 100);
        Self {
            gain: noise.uniform(0.97, 1.03),
            offset: noise.uniform(-60.0, 60.0),
            links: noise.uniform(0.95, 1.05),
            bucket: 1.0,
            damping: 1500.0 * noise.uniform(0.8, 1.2),
            friction: 250.0 * noise.uniform(0.7, 1.3),
            efficiency: noise.uniform(0.9, 1.0),
            delay: noise.uniform(-0.05, 0.05),
        }
    }

    fn of(&self, role: Role) -> f64 {
        match role {
            Role::Gain => self.gain,
            Role::Damping => self.damping,
            Role::Friction => self.friction,
            Role::Delay => self.delay,
            Role::Efficiency => self.efficiency,
            Role::Links => self.links,
            Role::Bucket => self.links * self.bucket,
            Role::Offset => self.offset,
            Role::Inertia => Scenario::Base.plant(None).machine.geometry.upper_inertia,
            Role::MotionNoise => VELOCITY_STD,
            Role::TorqueNoise => TORQUE_STD,
            Role::Payload(_) | Role::Swinging(_) | Role::AngleOffset(_) => 0.0,
            Role::Across(_) | Role::Along(_) | Role::Centre(_) => 0.0,
            Role::Lever => 1.0,
            Role::UpperMoment => Doubts::default().upper_moment(&Geometry::default()).0,
        }
    }

    fn machine(&self) -> Machine {
        let mut machine = Scenario::Base.plant(None).machine;
        let geometry = &mut machine.geometry;
        let links = [
            (&mut geometry.boom, self.links),
            (&mut geometry.arm, self.links),
            (&mut geometry.attachment.link, self.links * self.bucket),
        ];
        for (link, scale) in links {
            link.mass *= scale;
            link.flat_inertia *= scale;
            link.upright_inertia *= scale;
        }
        machine.damping = self.damping;
        machine.friction = self.friction;
        machine.dynamics = Dynamics::Momentum;
        machine
    }

    /// Endless swings to and fro on a path, with a constant load.
    fn plant(&self, path: Path, load: f64) -> Plant {
        let mut plant = Plant {
            machine: self.machine(),
            path,
            loads: vec![Load::kept(load)],
            swings: Vec::new(),
            period: CYCLE,
        };
        for targets in [
            Targets::working(5.5, 7.5, 9.3),
            Targets::back(11.2, 13.0, 14.8),
        ] {
            let swing = Plateaus::new(&plant, targets).solve();
            plant.swings.push(swing);
        }
        plant
    }

    /// A recording of this machine with a load \[kg\]: boom, arm and bucket move as in work.
    pub fn record(&self, load: f64, seed: u64) -> Vec<Sample> {
        self.record_on(working_path(), load, seed)
    }

    /// A recording on another path.
    pub fn record_on(&self, path: Path, load: f64, seed: u64) -> Vec<Sample> {
        self.measure(&self.exact(path, load), seed)
    }

    fn exact(&self, path: Path, load: f64) -> Vec<Exact> {
        Course::new(self.plant(path, load), 0.0, RATE, LENGTH).collect()
    }

    /// The measurements of its sensors.
    fn measure(&self, exact: &[Exact], seed: u64) -> Vec<Sample> {
        let mut noises = [0, 1, 2].map(|channel| Noise::channel(seed, channel));
        let velocity = |time: f64| at(exact, time, |e| e.truth.velocity);
        let torque = |time: f64| at(exact, time, |e| self.drive_torque(e));
        let (velocity_late, torque_late) = (self.delay.max(0.0), (-self.delay).max(0.0));
        exact
            .iter()
            .map(|e| Sample {
                time: e.time,
                velocity: Some(
                    velocity(e.time - velocity_late) + VELOCITY_STD * noises[0].normal(),
                ),
                torque: Some(
                    self.gain * torque(e.time - torque_late)
                        + self.offset
                        + TORQUE_STD * noises[1].normal(),
                ),
                posture: [3, 4, 5]
                    .map(|channel| Some(e.values[channel] + ANGLE_STD * noises[2].normal())),
                ..Sample::default()
            })
            .collect()
    }

    /// The torque of the drive; the gear loses a part of it before the upper body.
    fn drive_torque(&self, exact: &Exact) -> f64 {
        let torque = exact.truth.torque;
        if torque * exact.truth.velocity >= 0.0 {
            torque / self.efficiency
        } else {
            torque * self.efficiency
        }
    }
}

fn working_path() -> Path {
    let mut path = Path::base();
    let returns = [
        Joint::new(0.0, &[(11.3, 13.5, -21.0)]),
        Joint::new(0.0, &[(11.3, 14.0, -16.0)]),
    ];
    for (joint, back) in path.joints.iter_mut().zip(returns) {
        joint.moves.extend(back.moves);
    }
    path
}

fn at(exact: &[Exact], time: f64, of: impl Fn(&Exact) -> f64) -> f64 {
    let place = (time * RATE).max(0.0);
    let below = (place.floor() as usize).min(exact.len() - 1);
    let above = (below + 1).min(exact.len() - 1);
    let share = place - place.floor();
    (1.0 - share) * of(&exact[below]) + share * of(&exact[above])
}

/// Results of one machine.
struct MachineResult {
    /// Per parameter the error and whether the interval holds.
    parameters: Vec<(f64, bool)>,
    /// The inertia estimated afterwards.
    after: Tally,
}

/// Scores the inertia that the calibrated machine estimates in motion, with an unstated load.
fn afterwards(truth: &Truth, description: &config::Excavator, seed: u64) -> Result<Tally, Error> {
    let columns = Columns {
        velocity: true,
        torque: true,
        posture: true,
        ..Columns::default()
    };
    let settings = Settings::of(description);
    let mut estimator =
        SwingEstimator::new(&settings, Method::Auto, columns).map_err(Error::refused)?;
    let exact = truth.exact(working_path(), AFTER);
    let mut after = Tally::default();
    for (sample, exact) in truth.measure(&exact, seed).iter().zip(&exact) {
        let estimate = estimator.step(sample);
        if exact.truth.velocity.abs() >= MOVING {
            after.push(&JudgedRow {
                truth: exact.truth.inertia,
                estimate: estimate.inertia,
                std: estimate.inertia_std,
                trusted: estimate.flags.trusted(),
                moving: true,
                reason: "",
            });
        }
    }
    Ok(after)
}

/// Evaluates the table.
pub fn evaluate(options: &Options) -> Result<Report, Error> {
    let all = seeds(options, "calibration", one)?;
    let (machines, refused) = (all.len(), all.iter().filter(|f| f.is_none()).count());
    let found: Vec<MachineResult> = all.into_iter().flatten().collect();
    let mut table = Table::new(&["parameter", "median", "p95", "covered %", "target", ""]);
    let mut json = Map::new();
    let mut met = refused == 0;
    for (i, name) in names().enumerate() {
        let errors: Vec<f64> = found.iter().map(|f| f.parameters[i].0.abs()).collect();
        let covered = percentage(found.iter().map(|f| f.parameters[i].1));
        let target = TARGETS.get(i).map(|t| t.2);
        // Two standard deviations of a share of 95 % over this number of machines.
        let luck = 200.0 * (0.95 * 0.05 / found.len().max(1) as f64).sqrt();
        let good = target.is_none_or(|t| median(&errors) < t)
            && (90.0 - luck..=98.0 + luck).contains(&covered);
        met &= good || target.is_none();
        table.row([
            name.to_owned(),
            plain(median(&errors), 3),
            plain(p95(&errors), 3),
            plain(covered, 1),
            target.map_or(String::new(), |t| plain(t, 1)),
            target.map_or(String::new(), |_| verdict(good)),
        ]);
        json.insert(
            name.to_owned(),
            json!({"median": median(&errors), "p95": p95(&errors), "covered": covered}),
        );
    }
    let mut after = Tally::default();
    found.iter().for_each(|f| after.add(&f.after));
    let (rms, trusted, wrong) = (after.rms(), 100.0 * after.trusted(), 100.0 * after.wrong());
    let good = rms < 1.0 && trusted >= 70.0 && wrong <= 7.0;
    met &= good;
    json.insert(
        "after".into(),
        json!({"rms": rms, "trusted": trusted, "wrong": wrong}),
    );
    json.insert("machines".into(), json!(machines));
    json.insert("refused".into(), json!(refused));
    Ok(Report {
        text: format!(
            "Calibration of {machines} simulated machines from 120 s empty and 120 s with 423 kg \
             ({refused} refused); errors in percent, of the offset in N m, of the delay in ms\n{table}  \
             inertia afterwards, {AFTER} kg: rms {rms:.2} % (below 1), trusted {trusted:.0} % of the motion \
             (70 or more), of these {wrong:.1} % wrong (7 or less)  {}\n",
            verdict(good)
        ),
        json: Value::Object(json),
        met,
    })
}

fn names() -> impl Iterator<Item = &'static str> {
    TARGETS
        .iter()
        .map(|t| t.0)
        .chain(OTHERS.iter().map(|o| o.0))
}

fn one(seed: u64) -> Result<Option<MachineResult>, Error> {
    let truth = Truth::new(seed);
    let mut noise = Noise::channel(seed, 101);
    let stated = Quantity {
        value: LOAD.value + LOAD.std * noise.normal(),
        std: LOAD.std,
    };
    let inputs = [
        Input {
            name: "empty".into(),
            samples: truth.record(0.0, 2 * seed),
            payload: Some(Quantity::default()),
        },
        Input {
            name: "loaded".into(),
            samples: truth.record(LOAD.value, 2 * seed + 1),
            payload: Some(stated),
        },
    ];
    // The lengths of the simulated machine are exactly the described ones.
    let mut description = config::Excavator::default();
    description.machine.geometry_tolerance = 0.0;
    let options = calibration::Options::of(&description);
    let outcome = calibration::calibrate(&inputs, &options).map_err(Error::refused)?;
    if !outcome.faults.is_empty() {
        eprintln!("seed {seed}: {}", outcome.faults.join("; "));
        return Ok(None);
    }
    let Some((after, _)) = outcome.description(&description, &[]) else {
        return Ok(None);
    };
    let after = afterwards(&truth, &after, 3 * seed)?;
    let roles = TARGETS
        .iter()
        .map(|t| t.1)
        .chain(OTHERS.iter().map(|o| o.1));
    let parameters: Option<Vec<(f64, bool)>> = roles
        .map(|role| {
            let quantity = outcome.quantity(role)?;
            let error = quantity.value - truth.of(role);
            let scale = match role {
                Role::Delay => 1e3,
                Role::Offset => 1.0,
                _ => 100.0 / truth.of(role),
            };
            Some((
                scale * error,
                error.abs() < estimation::HALF_WIDTH_95 * quantity.std,
            ))
        })
        .collect();
    Ok(parameters.map(|parameters| MachineResult { parameters, after }))
}
