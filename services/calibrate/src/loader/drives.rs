//! The drives of a loader as a model: parameters, what is known of them, blocks.

use std::ops::Range;

use config::Loader as Description;
use estimation::Quantity;
use estimation::loader::weigh::Reference;

use super::drive::Drive;
use super::guess::Guess;
use super::known::{MASS_STD, described, mark, parameters, way_scatter};
use super::residuals;
use super::way::Way;
use crate::model::{Innovation, Model};
use crate::parameter::Parameter;

/// What a parameter is in the guess; a load is numbered, 0 is the machine as described.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Relative error of the front rolling radius.
    FrontRadius,
    /// Relative error of the rear rolling radius.
    RearRadius,
    /// Load sensitivity of the radii.
    LoadSensitivity,
    /// Measured over true torque in front.
    FrontGain,
    /// Measured over true torque behind.
    RearGain,
    /// Slip stiffness.
    Stiffness,
    /// Slip stiffness in front over that behind.
    StiffnessRatio,
    /// How the stiffness falls with the load.
    LoadExponent,
    /// Limit of friction.
    Friction,
    /// Rolling resistance.
    Rolling,
    /// Zero of the slope.
    SlopeBias,
    /// Zero of the accelerometer.
    AccelerationOffset,
    /// Delay of the slope.
    SlopeDelay,
    /// Share of the acceleration that the slope sensor follows.
    SlopeFollows,
    /// Delay of the speed.
    SpeedDelay,
    /// Delay of the torques.
    TorqueDelay,
    /// Relaxation length of the tyres.
    Relaxation,
    /// Scatter between the wheels.
    WheelScatter,
    /// Scatter of the speed.
    SpeedScatter,
    /// Scatter of the balance of force.
    ForceScatter,
    /// Scatter of the motion.
    MotionScatter,
    /// Scatter of the slopes there and back.
    WayScatter,
    /// What is left of the shift between the marks of a way.
    Mark(usize),
    /// Mass with a load.
    Mass(usize),
    /// Share in front with a load.
    Ratio(usize),
    /// Height of the centre of gravity with a load.
    Height(usize),
    /// How far a load lies ahead of the front axle, where no scales tell the share.
    Reach(usize),
    /// Height of a load, where no scales tell that of the centre of gravity.
    Lift(usize),
}

impl Role {
    /// The load it belongs to, if it does.
    #[must_use]
    pub fn load(self) -> Option<usize> {
        match self {
            Self::Mass(load)
            | Self::Ratio(load)
            | Self::Height(load)
            | Self::Reach(load)
            | Self::Lift(load) => Some(load),
            _ => None,
        }
    }

    /// Whether it is only about noise.
    #[must_use]
    pub fn is_noise(self) -> bool {
        use Role::{ForceScatter, MotionScatter, SpeedScatter, WayScatter, WheelScatter};
        matches!(
            self,
            WheelScatter | SpeedScatter | ForceScatter | MotionScatter | WayScatter
        )
    }

    /// Whether it is about what the slope sensor shows.
    fn is_of_slope(self) -> bool {
        use Role::{AccelerationOffset, SlopeBias, SlopeDelay, SlopeFollows, WayScatter};
        matches!(
            self,
            AccelerationOffset | SlopeBias | SlopeDelay | SlopeFollows | WayScatter
        )
    }

    /// Whether it only takes part with what is known of it, so that its tolerance counts in the others: lags and limits that
    /// means over half a second hardly show, where the load lies, and the marks of a way.
    #[must_use]
    pub fn is_nuisance(self) -> bool {
        use Role::{Friction, Lift, Mark, Reach, Relaxation, TorqueDelay};
        matches!(
            self,
            Friction | Relaxation | TorqueDelay | Mark(_) | Reach(_) | Lift(_)
        ) || self.is_noise()
    }
}

/// What is known of a load before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Told {
    /// Mass of the whole machine [kg].
    pub mass: Option<Quantity>,
    /// Share of the weight in front, from axle scales.
    pub ratio: Option<Quantity>,
    /// Height of the centre of gravity, from axle scales on a slope [m].
    pub height: Option<Quantity>,
}

impl Told {
    /// What axle scales say; `scale_std` is the accuracy of one, relative, and it may be common to all readings.
    #[must_use]
    pub fn weighed(reference: &Reference, scale_std: f64) -> Self {
        let ratio = reference.cg_ratio;
        let common = core::f64::consts::SQRT_2 * scale_std * ratio.value * (1.0 - ratio.value);
        Self {
            mass: None,
            ratio: Some(Quantity {
                value: ratio.value,
                std: ratio.std.max(common),
            }),
            height: reference.cg_height,
        }
    }
}

/// A piece of the recordings with residuals of its own.
#[derive(Debug, Clone, Copy)]
enum Block {
    /// Recording and number of a stretch of driving.
    Stretch(usize, usize),
    /// Number of a way there and back and of its section.
    Section(usize, usize),
}

/// Drives of one machine.
#[derive(Debug, Clone)]
pub struct Drives {
    /// The recordings.
    pub drives: Vec<Drive>,
    /// The load of each.
    pub load_of: Vec<usize>,
    /// What is told of each load.
    pub loads: Vec<Told>,
    /// What each parameter is.
    pub roles: Vec<Role>,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// The ways that were driven there and back.
    pub ways: Vec<Way>,
    /// Stretches, and behind them sections of ways.
    blocks: Vec<Block>,
    /// What no parameter changes.
    fixed: Guess,
}

/// A mass on board that differs by this share is another load.
const OTHER_LOAD: f64 = 0.08;
impl Drives {
    /// The model of recordings under a description; `told` is what is known of the load of each, and `empty`
    /// what scales say of the machine as described.
    #[must_use]
    pub fn new(drives: Vec<Drive>, told: &[Told], empty: Told, d: &Description) -> Self {
        let (load_of, loads) = loads(&drives, told, empty, d.machine.mass);
        let (roles, parameters) = parameters(&drives, &loads, d).into_iter().unzip();
        let numbered = drives.iter().enumerate();
        let blocks = numbered
            .flat_map(|(r, drive)| (0..drive.blocks.len()).map(move |k| Block::Stretch(r, k)))
            .collect();
        Self {
            drives,
            load_of,
            loads,
            roles,
            parameters,
            ways: Vec::new(),
            blocks,
            fixed: described(d),
        }
    }

    /// The index of a parameter.
    #[must_use]
    pub fn index(&self, role: Role) -> Option<usize> {
        self.roles.iter().position(|r| *r == role)
    }

    /// The stretches of driving: the block, the recording, its rows.
    pub fn stretches(&self) -> impl Iterator<Item = (usize, &Drive, &Range<usize>)> {
        let blocks = self.blocks.iter().enumerate();
        blocks.filter_map(|(block, of)| match *of {
            Block::Stretch(recording, number) => {
                let drive = &self.drives[recording];
                Some((block, drive, &drive.blocks[number]))
            }
            Block::Section(..) => None,
        })
    }

    /// Matches two recordings of the same way at values of the parameters; their sections are blocks from then on, and their scatter and
    /// the shift of the marks are parameters.
    ///
    /// # Errors
    /// Says why they are not the same way there and back.
    pub fn join(&mut self, recordings: [usize; 2], values: &[f64]) -> Result<&Way, String> {
        let guess = self.guess(recordings[0], values);
        let way = Way::new(&self.drives, recordings, &guess)?;
        let number = self.ways.len();
        let sections = 0..way.sections.len();
        self.blocks
            .extend(sections.map(|k| Block::Section(number, k)));
        if self.index(Role::WayScatter).is_none() {
            self.roles.push(Role::WayScatter);
            self.parameters.push(way_scatter());
        }
        let [there, back] = recordings.map(|r| self.drives[r].name.as_str());
        self.parameters.push(mark(there, back));
        self.roles.push(Role::Mark(number));
        self.ways.push(way);
        Ok(&self.ways[number])
    }

    /// Time of driving with a load [s].
    #[must_use]
    pub fn driving_time(&self, load: usize) -> f64 {
        let drives = self.drives.iter().zip(&self.load_of);
        drives
            .filter(|(_, of)| **of == load)
            .map(|(drive, _)| drive.driving_time())
            .sum()
    }

    /// Sum of the axle torques that would lift the described machine straight up [N m].
    #[must_use]
    pub fn torque_of_weight(&self) -> f64 {
        self.fixed.mass * super::GRAVITY * self.fixed.radius
    }

    /// Share in front and height of a machine of this mass whose load lies this far ahead of the front axle, or this high.
    fn loaded(&self, mass: f64, values: &[f64], place: f64) -> (f64, f64) {
        let empty = |role: Role| self.index(role).map_or(0.0, |i| values[i]);
        let part = (empty(Role::Mass(0)) / mass).clamp(0.0, 1.0);
        let base = self.fixed.wheelbase;
        let mixed = |empty: f64, load: f64| part * empty + (1.0 - part) * load;
        (
            mixed(empty(Role::Ratio(0)), 1.0 + place / base),
            mixed(empty(Role::Height(0)), place),
        )
    }

    fn guess(&self, recording: usize, values: &[f64]) -> Guess {
        let mut g = self.fixed;
        let load = self.load_of[recording];
        for (role, &value) in self.roles.iter().zip(values) {
            match role {
                Role::FrontRadius => g.radius_errors[0] = value,
                Role::RearRadius => g.radius_errors[1] = value,
                Role::LoadSensitivity => g.load_sensitivity = value,
                Role::FrontGain => g.torque_gains[0] = value,
                Role::RearGain => g.torque_gains[1] = value,
                Role::Stiffness => g.stiffness = value,
                Role::StiffnessRatio => g.stiffness_ratio = value,
                Role::LoadExponent => g.load_exponent = value,
                Role::Friction => g.friction = value,
                Role::Rolling => g.rolling_resistance = value,
                Role::SlopeBias => g.slope_bias = value,
                Role::AccelerationOffset => g.acceleration_offset = value,
                Role::SlopeDelay => g.slope_delay = value,
                Role::SlopeFollows => g.slope_follows = value,
                Role::SpeedDelay => g.speed_delay = value,
                Role::TorqueDelay => g.torque_delay = value,
                Role::Relaxation => g.relaxation_length = value,
                Role::WheelScatter => g.scatter.wheels = value,
                Role::SpeedScatter => g.scatter.speed = value,
                Role::ForceScatter => g.scatter.force = value,
                Role::MotionScatter => g.scatter.motion = value,
                Role::WayScatter => g.scatter.way = value,
                Role::Mass(l) if *l == load => g.mass = value,
                Role::Ratio(l) if *l == load => g.ratio = value,
                Role::Height(l) if *l == load => g.height = value,
                Role::Reach(l) if *l == load => g.ratio = self.loaded(g.mass, values, value).0,
                Role::Lift(l) if *l == load => g.height = self.loaded(g.mass, values, value).1,
                _ => {}
            }
        }
        g
    }
}

impl Model for Drives {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn blocks(&self) -> usize {
        self.blocks.len()
    }

    fn recording(&self, block: usize) -> usize {
        match self.blocks[block] {
            Block::Stretch(recording, _) => recording,
            Block::Section(way, _) => self.ways[way].recordings[0],
        }
    }

    fn acts(&self, parameter: usize, block: usize) -> bool {
        let role = self.roles[parameter];
        match self.blocks[block] {
            Block::Section(way, _) => role.is_of_slope() || role == Role::Mark(way),
            Block::Stretch(recording, _) => {
                let load = self.load_of[recording];
                let of_way = matches!(role, Role::WayScatter | Role::Mark(_));
                !of_way && role.load().is_none_or(|l| l == load || l == 0)
            }
        }
    }

    fn innovations(&self, block: usize, values: &[f64], out: &mut Vec<Innovation>) {
        match self.blocks[block] {
            Block::Stretch(recording, number) => {
                let drive = &self.drives[recording];
                let guess = self.guess(recording, values);
                residuals::residuals(drive, &drive.blocks[number], &guess, out);
            }
            Block::Section(way, number) => {
                let ahead = self.index(Role::Mark(way)).map_or(0.0, |i| values[i]);
                let way = &self.ways[way];
                let guesses = way.recordings.map(|r| self.guess(r, values));
                out.push(way.residual(&self.drives, number, &guesses, ahead));
            }
        }
    }
}

/// The load of each recording and what is told of the loads: recordings of which nothing is told carry that of
/// the description, unless the mass on board says otherwise.
fn loads(drives: &[Drive], told: &[Told], empty: Told, mass: f64) -> (Vec<usize>, Vec<Told>) {
    let mut loads = vec![empty];
    let load_of = drives
        .iter()
        .zip(told)
        .map(|(drive, told)| {
            let on_board = drive.mass.filter(|m| (m / mass - 1.0).abs() > OTHER_LOAD);
            let measured = on_board.map(|value| Quantity {
                value,
                std: MASS_STD * value,
            });
            let own = Told {
                mass: told.mass.or(measured),
                ..*told
            };
            if own == Told::default() {
                return 0;
            }
            let known = loads[1..].iter().position(|l| *l == own);
            known.map_or_else(
                || {
                    loads.push(own);
                    loads.len() - 1
                },
                |at| at + 1,
            )
        })
        .collect();
    (load_of, loads)
}
