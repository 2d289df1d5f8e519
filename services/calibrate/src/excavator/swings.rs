//! Model of an excavator's swings: parameters, priors, blocks.

use std::ops::Range;

use config::{Excavator as Description, Tables as _};
use estimation::Quantity;
use estimation::excavator::{Doubts, Geometry, Settings};

use super::filter::{self, Guess};
use super::series::{Load, Measured, Series, Swing};
use super::swinging::RATES;
use crate::column::percentile;
use crate::model::{Innovation, Model};
use crate::parameter::{Law, Parameter, Source, rows};

/// Role of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Viscous damping.
    Damping,
    /// Coulomb friction.
    Friction,
    /// Efficiency of the drive.
    Efficiency,
    /// Zero of the torque.
    Offset,
    /// Gain of the torque.
    Gain,
    /// Inertia of the upper body, or of the whole machine where no posture is measured.
    Inertia,
    /// Masses and inertias of boom and arm.
    Links,
    /// Mass and inertia of the bucket, which is changed more often than boom and arm.
    Bucket,
    /// Delay of the velocity minus that of the torque.
    Delay,
    /// Noise of velocity or angle.
    MotionNoise,
    /// Noise of the torque.
    TorqueNoise,
    /// Load of a recording.
    Payload(usize),
    /// Inertia of a load of known mass over the described one: errors of lengths, held within their tolerance.
    Lever,
    /// Place of the load's centre, along and beside the line from the bucket's pin to its tip.
    Centre(usize),
    /// Share of the load that swings at one of the rates.
    Swinging(usize),
    /// Offset of a joint angle: of boom, arm, bucket.
    AngleOffset(usize),
    /// First moment of the upper body.
    UpperMoment,
    /// Slope of the ground in a recording, across the machine at its beginning.
    Across(usize),
    /// The same along the machine.
    Along(usize),
}

impl Role {
    /// Whether it belongs to a recording and not to the machine.
    #[must_use]
    pub fn is_load(&self) -> bool {
        matches!(self, Self::Payload(_) | Self::Across(_) | Self::Along(_))
    }

    /// Whether it is a noise, or held with the tolerance of the lengths.
    #[must_use]
    pub fn is_noise(&self) -> bool {
        matches!(self, Self::MotionNoise | Self::TorqueNoise | Self::Lever)
    }

    /// Whether it is a nuisance parameter: of no use beyond the fit, and never held.
    #[must_use]
    pub fn is_nuisance(&self) -> bool {
        matches!(
            self,
            Self::Swinging(_)
                | Self::AngleOffset(_)
                | Self::UpperMoment
                | Self::Across(_)
                | Self::Along(_)
        )
    }

    /// Whether it is a parameter of the machine or its sensors, which the description holds.
    #[must_use]
    pub fn is_described(&self) -> bool {
        let is_offset = matches!(self, Self::AngleOffset(_));
        !self.is_load() && *self != Self::Lever && (is_offset || !self.is_nuisance())
    }
}

/// Swings of several recordings of one machine.
#[derive(Debug, Clone)]
pub struct Swings {
    /// The recordings.
    pub series: Vec<Series>,
    /// Their stated loads \[kg\].
    pub stated: Vec<Option<Quantity>>,
    /// Role of each parameter.
    pub roles: Vec<Role>,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// A load that is plausible for the described machine \[kg\].
    pub full_bucket: f64,
    /// Recording of each block, and number of its swing.
    blocks: Vec<(usize, usize)>,
}

impl Swings {
    /// The model of recordings with their stated loads, under a description.
    #[must_use]
    pub fn new(
        series: Vec<Series>,
        stated: Vec<Option<Quantity>>,
        description: &Description,
    ) -> Self {
        let (roles, parameters) = parameters(&series, &stated, description)
            .into_iter()
            .unzip();
        let mut swings = Self {
            series,
            stated,
            roles,
            parameters,
            full_bucket: description.prior.payload + description.prior.payload_std,
            blocks: Vec::new(),
        };
        swings.count_blocks();
        swings
    }

    /// Numbers the blocks again; to be called after swings have been removed.
    pub fn count_blocks(&mut self) {
        let numbered = self.series.iter().enumerate();
        self.blocks = numbered
            .flat_map(|(r, s)| (0..s.swings.len()).map(move |k| (r, k)))
            .collect();
    }

    /// Makes the load of a recording a parameter with this prior. Returns the index of the parameter, which is a
    /// new last one where the load was exact.
    pub fn release(&mut self, recording: usize, load: Quantity) -> usize {
        let role = Role::Payload(recording);
        let at = self.index(role).unwrap_or(self.roles.len());
        let parameter = opened(&self.series[recording].name, load, Source::Measured);
        if at == self.roles.len() {
            self.roles.push(role);
            self.parameters.push(parameter);
        } else {
            self.parameters[at] = parameter;
        }
        at
    }

    /// Whether all recordings have the joint angles.
    #[must_use]
    pub fn has_posture(&self) -> bool {
        self.series.iter().all(|s| s.has_posture)
    }

    /// The index of a parameter.
    #[must_use]
    pub fn index(&self, role: Role) -> Option<usize> {
        self.roles.iter().position(|r| *r == role)
    }

    /// The blocks of a recording.
    #[must_use]
    pub fn blocks_of(&self, recording: usize) -> Vec<usize> {
        (0..self.blocks.len())
            .filter(|&b| self.blocks[b].0 == recording)
            .collect()
    }

    /// The recording and the swing of a block.
    #[must_use]
    pub fn swing(&self, block: usize) -> (&Series, &Swing) {
        let (recording, number) = self.blocks[block];
        let series = &self.series[recording];
        (series, &series.swings[number])
    }

    /// The guess from these values, for one recording.
    #[must_use]
    pub fn guess(&self, recording: usize, values: &[f64]) -> Guess {
        let mut guess = Guess {
            damping: 0.0,
            friction: 0.0,
            efficiency: 1.0,
            offset: 0.0,
            gain: 1.0,
            upper_inertia: 0.0,
            link_scale: 1.0,
            bucket_scale: 1.0,
            delay: 0.0,
            motion_std: 1.0,
            torque_std: 1.0,
            payload: self.stated[recording].map_or(0.0, |q| q.value),
            lever: 1.0,
            centre: [0.0; 2],
            swinging: [0.0; RATES.len()],
            angle_offsets: [0.0; 3],
            upper_moment: 0.0,
            slope: [0.0; 2],
        };
        let roles = self.roles.iter().zip(&self.parameters);
        for ((role, parameter), &value) in roles.zip(values) {
            match role {
                Role::Damping => guess.damping = value,
                Role::Friction => guess.friction = value,
                Role::Efficiency => guess.efficiency = value,
                Role::Offset => guess.offset = value,
                Role::Gain => guess.gain = value,
                Role::Inertia => guess.upper_inertia = value,
                Role::Links => guess.link_scale = value,
                Role::Bucket => guess.bucket_scale = value,
                Role::Delay => guess.delay = value,
                Role::MotionNoise => guess.motion_std = value,
                Role::TorqueNoise => guess.torque_std = value,
                Role::Lever => guess.lever = value,
                Role::Centre(i) => guess.centre[*i] = value - parameter.mean,
                Role::Swinging(i) => guess.swinging[*i] = value,
                Role::AngleOffset(i) => guess.angle_offsets[*i] = value - parameter.mean,
                Role::UpperMoment => guess.upper_moment = value,
                Role::Payload(r) if *r == recording => guess.payload = value,
                Role::Across(r) if *r == recording => guess.slope[0] = value,
                Role::Along(r) if *r == recording => guess.slope[1] = value,
                Role::Payload(_) | Role::Across(_) | Role::Along(_) => {}
            }
        }
        guess
    }
}

impl Model for Swings {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn sum(&self) -> Option<(Range<usize>, &'static str)> {
        let first = self.index(Role::Swinging(0))?;
        let shares = first..first + RATES.len();
        Some((shares, "the share of the load that swings, at any rate"))
    }

    fn blocks(&self) -> usize {
        self.blocks.len()
    }

    fn recording(&self, block: usize) -> usize {
        self.blocks[block].0
    }

    fn acts(&self, parameter: usize, block: usize) -> bool {
        let (recording, number) = self.blocks[block];
        let is_stated = self.series[recording].swings[number].load == Load::Stated;
        match self.roles[parameter] {
            Role::Payload(r) => r == recording && is_stated,
            Role::Across(r) | Role::Along(r) => r == recording,
            Role::Lever | Role::Centre(_) | Role::Swinging(_) => is_stated,
            _ => true,
        }
    }

    fn innovations(&self, block: usize, values: &[f64], out: &mut Vec<Innovation>) {
        let (series, swing) = self.swing(block);
        let guess = self.guess(self.recording(block), values);
        filter::innovations(series, swing, &guess, out);
    }
}

/// Tolerances where the description states none, or ones too narrow before a calibration: gain of a torque
/// sensor, efficiency of a swing gear, drawings against a machine, delays of a bus [s].
const GAIN_STD: f64 = 0.05;
const EFFICIENCY_STD: f64 = 0.05;
const UPPER_INERTIA_STD: f64 = 0.15;
const LINKS_STD: f64 = 0.05;
/// The same of a bucket on a weighbridge.
const BUCKET_WEIGHED: f64 = 0.005;
const DELAY_STD: f64 = 0.03;
const DELAY_MAX: f64 = 0.2;
const DAMPING_STD: f64 = 0.3;
const FRICTION_STD: f64 = 0.5;
/// Standard deviation of the torque offset, as a share of the large torques.
const OFFSET_STD: f64 = 0.03;
/// Standard deviation of the share of a load that swings, over all rates. A load that lies in a bucket does not swing; one that slips or
/// hangs does in part.
pub const SWINGING_STD: f64 = 0.15;
/// Standard deviation of the logarithm of a noise.
const NOISE_STD: f64 = 1.0;

/// Relative standard deviation of the lengths that fix the radius of a load. An error of a guessed boom pin is common to gain and
/// masses. An estimator that treats their errors as independent halves the variance: hence the 2.
fn lengths(d: &Description) -> f64 {
    let tolerance = d.machine.geometry_tolerance;
    let by_pin = d.guessed_radius_std();
    (tolerance * tolerance + 2.0 * by_pin * by_pin).sqrt()
}

fn parameters(
    series: &[Series],
    stated: &[Option<Quantity>],
    d: &Description,
) -> Vec<(Role, Parameter)> {
    let posture = series.iter().all(|s| s.has_posture);
    let torque = percentile(series.iter().map(|s| s.torque.size()).collect(), 1.0);
    let mut all = of_motion(torque, d);
    all.extend(if posture { of_posture(d) } else { constant(d) });
    all.extend(noises(series, d));
    if posture {
        all.extend(ground(series, d));
        let lever = 2.0 * lengths(d);
        if lever > 0.0 {
            let words = "the place of a load in the bucket (inertia over that of the machine file)";
            let lever = Parameter::described("load inertia", words, "", 1.0, lever, (0.1, 10.0));
            all.push((Role::Lever, lever));
        }
        all.extend(centre(d));
        all.extend(swinging());
        all.extend(angle_offsets(d));
        let loads = series.iter().zip(stated).enumerate();
        all.extend(loads.filter_map(|(r, (series, stated))| {
            let payload = payload(&series.name, *stated, d)?;
            Some((Role::Payload(r), payload))
        }));
    }
    all
}

/// Parameters of the forces on the swing; `torque` is a large one.
fn of_motion(torque: f64, d: &Description) -> Vec<(Role, Parameter)> {
    let (m, p) = (&d.machine, &d.prior);
    let stated = |key| d.number(key).unwrap_or(0.0);
    let damping_std = p.damping_std.max(DAMPING_STD * m.nominal_damping);
    let friction_std = p.friction_std.max(FRICTION_STD * m.coulomb_friction);
    let offset_std = p.torque_offset_std.max(OFFSET_STD * torque);
    let delay = stated("sensors.swing_velocity_delay") - stated("sensors.swing_torque_delay");
    let rows = rows! {
        Role::Damping, "machine.nominal_damping", "the viscous damping", "N m s/rad",
            m.nominal_damping, damping_std, (0.0, 1e7);
        Role::Friction, "machine.coulomb_friction", "the Coulomb friction", "N m",
            m.coulomb_friction, friction_std, (0.0, 1e6);
        Role::Offset, "sensors.swing_torque_offset", "the offset of the torque", "N m",
            stated("sensors.swing_torque_offset"), offset_std, (-1e6, 1e6);
        Role::Delay, "sensors.*_delay", "the delay between torque and velocity", "s",
            delay, DELAY_STD, (-DELAY_MAX, DELAY_MAX);
    };
    rows.into()
}

/// Parameters of the machine, its drive and its torque sensor, where the posture is measured.
fn of_posture(d: &Description) -> Vec<(Role, Parameter)> {
    let upper = d.machine.upper_inertia;
    let stated = |key, otherwise| d.number(key).unwrap_or(otherwise);
    let efficiency_std = stated("machine.drive_efficiency_std", 0.0).max(EFFICIENCY_STD);
    let gain_std = stated("sensors.swing_torque_gain_std", 0.0).max(GAIN_STD);
    let rows = rows! {
        Role::Efficiency, "machine.drive_efficiency", "the efficiency of the drive", "",
            stated("machine.drive_efficiency", 1.0), efficiency_std, (0.5, 1.1);
        Role::Gain, "sensors.swing_torque_gain", "the gain of the torque (measured over true)", "",
            stated("sensors.swing_torque_gain", 1.0), gain_std, (0.2, 5.0);
        Role::Inertia, "machine.upper_inertia", "the inertia of the upper body", "kg m^2",
            upper, UPPER_INERTIA_STD * upper, (0.0, 1e9);
        Role::Links, "machine.geometry.*_mass", "the masses of boom and arm over those of the machine file", "",
            1.0, LINKS_STD, (0.2, 5.0);
        Role::Bucket, "machine.geometry.bucket_mass", "the mass of the bucket over that of the machine file", "",
            1.0, bucket_std(d), (0.2, 5.0);
    };
    rows.into()
}

/// Relative standard deviation of the bucket's mass: as stated, for a bucket is easily weighed.
fn bucket_std(d: &Description) -> f64 {
    let stated = d.machine.bucket_tolerance.is_some();
    let least = if stated { BUCKET_WEIGHED } else { LINKS_STD };
    Doubts::of(d).bucket_share.max(least)
}

/// One constant inertia: no known mass is moved, so the torque is taken as measured.
fn constant(d: &Description) -> Vec<(Role, Parameter)> {
    let (m, p) = (&d.machine, &d.prior);
    let inertia_std = p.inertia_std.max(UPPER_INERTIA_STD * p.inertia);
    let rows = rows! {
        Role::Inertia, "prior.inertia", "the inertia", "kg m^2",
            p.inertia, inertia_std, (m.inertia_min, m.inertia_max);
    };
    rows.into()
}

/// The noises of motion and torque.
fn noises(series: &[Series], d: &Description) -> [(Role, Parameter); 2] {
    let s = &d.sensors;
    let (key, words, unit, std) = if series.iter().any(|s| s.measured == Measured::Velocity) {
        let words = "the noise of the velocity";
        (
            "sensors.swing_velocity_std",
            words,
            "rad/s",
            s.swing_velocity_std,
        )
    } else {
        (
            "sensors.swing_angle_std",
            "the noise of the angle",
            "rad",
            s.swing_angle_std,
        )
    };
    let motion = Parameter::noise(key, words, unit, std, NOISE_STD);
    let (key, words) = ("sensors.swing_torque_std", "the noise of the torque");
    let torque = Parameter::noise(key, words, "N m", s.swing_torque_std, NOISE_STD);
    [(Role::MotionNoise, motion), (Role::TorqueNoise, torque)]
}

/// Slopes of the ground, and the first moment that they act on.
fn ground(series: &[Series], d: &Description) -> Vec<(Role, Parameter)> {
    let std = d.machine.slope_std;
    if std <= 0.0 {
        return Vec::new();
    }
    let (moment, moment_std) = Doubts::of(d).upper_moment(&Geometry::of(d));
    let linear = Parameter::described;
    let mut all = Vec::new();
    for (r, series) in series.iter().enumerate() {
        for (role, way) in [(Role::Across(r), "across"), (Role::Along(r), "along")] {
            let words = format!(
                "the slope of the ground {way} the machine in {}",
                series.name
            );
            let key = format!("slope {way} in {}", series.name);
            all.push((role, linear(&key, &words, "rad", 0.0, std, (-0.5, 0.5))));
        }
    }
    let words = "the first moment of the upper body";
    let (key, range) = ("machine.upper_first_moment", (-1e7, 1e7));
    let moment = linear(key, words, "kg m", moment, moment_std.max(1.0), range);
    all.push((Role::UpperMoment, moment));
    all
}

/// Standard deviation of the centre of a load in the bucket where none is stated, as a share of its distance from the bucket's pin: loads
/// lie differently from recording to recording.
const LIES: f64 = 0.05;

/// Centre of the load in the bucket.
fn centre(d: &Description) -> impl Iterator<Item = (Role, Parameter)> {
    let g = &d.geometry;
    // Without a tolerance the lengths are exact.
    let lies = match d.machine.geometry_tolerance > 0.0 {
        true => LIES * g.payload_centre.abs(),
        false => 0.0,
    };
    let std = g
        .payload_centre_std
        .unwrap_or_else(|| lies.max(d.load_centre_std()));
    let rows = rows! {
        Role::Centre(0), "machine.geometry.payload_centre", "the distance of the load from the bucket's pin", "m",
            g.payload_centre, std, (0.0, 10.0);
        Role::Centre(1), "machine.geometry.payload_rise", "the distance of the load from the line of the bucket", "m",
            g.payload_rise, std, (-10.0, 10.0);
    };
    rows.into_iter().filter(move |_| std > 0.0)
}

/// Swinging shares of the load.
fn swinging() -> impl Iterator<Item = (Role, Parameter)> {
    RATES.into_iter().enumerate().map(|(i, rate)| {
        let key = format!("load that swings at {rate} rad/s");
        let words = format!("the share of the load that swings at {rate} rad/s");
        let std = SWINGING_STD / (RATES.len() as f64).sqrt();
        let share = Parameter::described(&key, &words, "", 0.0, std, (-1.0, 1.0));
        (Role::Swinging(i), share)
    })
}

/// Offsets of the joint angles: their effect on the radii differs between arm in and arm out.
fn angle_offsets(d: &Description) -> impl Iterator<Item = (Role, Parameter)> {
    let std = d.sensors.angle_offset_std;
    let described = Settings::of(d).sensors.angle_offsets;
    let joints = ["boom", "arm", "bucket"].into_iter().zip(described);
    let joints = joints.filter(move |_| std > 0.0).enumerate();
    joints.map(move |(i, (joint, offset))| {
        let key = format!("sensors.{joint}_angle_offset");
        let words = format!("the offset of the {joint} angle");
        let offset = Parameter::described(&key, &words, "rad", offset, std, (-0.5, 0.5));
        (Role::AngleOffset(i), offset)
    })
}

/// Parameter of a load that is not known exactly; `None` where it is.
fn payload(name: &str, stated: Option<Quantity>, d: &Description) -> Option<Parameter> {
    let (load, source) = match stated {
        Some(load) if load.std <= 0.0 => return None,
        Some(load) => (load, Source::Measured),
        None => {
            let prior = Quantity {
                value: d.prior.payload,
                std: d.prior.payload_std,
            };
            (prior, Source::Description)
        }
    };
    Some(opened(name, load, source))
}

fn opened(name: &str, load: Quantity, source: Source) -> Parameter {
    Parameter {
        key: format!("payload of {name}"),
        words: format!("the load of {name}"),
        unit: "kg",
        mean: load.value,
        std: load.std,
        range: (-1e6, 1e6),
        law: Law::Linear,
        source,
    }
}
