//! Model of a loader's drives: parameters, priors, blocks.

use std::ops::Range;

use config::Loader as Description;
use estimation::Quantity;

use super::drive::Drive;
use super::guess::Guess;
use super::known::{MASS_STD, described, mark, parameters, path_scatter};
use super::out_and_back::OutAndBack;
use super::residuals;
use super::role::{Role, StatedLoad};
use crate::model::{Innovation, Model};
use crate::parameter::Parameter;

/// A piece of the recordings with residuals of its own.
#[derive(Debug, Clone, Copy)]
enum Block {
    /// Recording and number of a stretch of driving.
    Stretch(usize, usize),
    /// Number of an out-and-back path, and of its section.
    Section(usize, usize),
}

/// Drives of one machine.
#[derive(Debug, Clone)]
pub struct Drives {
    /// The recordings.
    pub drives: Vec<Drive>,
    /// Load of each recording.
    pub load_of: Vec<usize>,
    /// Stated values of each load.
    pub loads: Vec<StatedLoad>,
    /// Role of each parameter.
    pub roles: Vec<Role>,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// The paths that were driven out and back.
    pub paths: Vec<OutAndBack>,
    /// Stretches, followed by sections of paths.
    blocks: Vec<Block>,
    /// Values that no parameter changes.
    fixed: Guess,
}

/// Relative difference of the measured mass above which a recording has another load.
const OTHER_LOAD: f64 = 0.08;
impl Drives {
    /// The model of recordings under a description; `stated` is the stated load of each, and `empty`
    /// the axle weights of the described machine.
    pub fn new(
        drives: Vec<Drive>,
        stated: &[StatedLoad],
        empty: StatedLoad,
        d: &Description,
    ) -> Self {
        let (load_of, loads) = loads(&drives, stated, empty, d.machine.mass);
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
            paths: Vec::new(),
            blocks,
            fixed: described(d),
        }
    }

    /// The index of a parameter.
    pub fn index(&self, role: Role) -> Option<usize> {
        self.roles.iter().position(|r| *r == role)
    }

    /// The stretches of driving: block, recording, rows.
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

    /// Matches two recordings of the same path at values of the parameters. Their sections become blocks; their scatter and
    /// the offset of their marks become parameters.
    ///
    /// # Errors
    /// Explains why they are not the same path out and back.
    pub fn join(&mut self, recordings: [usize; 2], values: &[f64]) -> Result<&OutAndBack, String> {
        let guess = self.guess(recordings[0], values);
        let path = OutAndBack::new(&self.drives, recordings, &guess)?;
        let number = self.paths.len();
        let sections = 0..path.sections.len();
        self.blocks
            .extend(sections.map(|k| Block::Section(number, k)));
        if self.index(Role::PathScatter).is_none() {
            self.roles.push(Role::PathScatter);
            self.parameters.push(path_scatter());
        }
        let [there, back] = recordings.map(|r| self.drives[r].name.as_str());
        self.parameters.push(mark(there, back));
        self.roles.push(Role::Mark(number));
        self.paths.push(path);
        Ok(&self.paths[number])
    }

    /// Sum of the axle torques that would lift the described machine vertically [N m].
    pub fn torque_of_weight(&self) -> f64 {
        self.fixed.mass * super::GRAVITY * self.fixed.radius
    }

    /// Front share and height of a machine of this mass whose load is `place` ahead of the front axle, or at that height.
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
            if *role == Role::Mass(0) {
                g.empty_mass = value;
            }
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
                Role::Brush => g.brush = value,
                Role::LoadVariance => g.load_variance = value,
                Role::Rolling => g.rolling_resistance = value,
                Role::SlopeBias => g.slope_bias = value,
                Role::AccelerationOffset => g.acceleration_offset = value,
                Role::SlopeDelay => g.slope_delay = value,
                Role::SlopeFollows => g.slope_sensitivity = value,
                Role::SpeedDelay => g.speed_delay = value,
                Role::TorqueDelay => g.torque_delay = value,
                Role::Relaxation => g.relaxation_length = value,
                Role::Squat => g.squat = value,
                // See `pitched`.
                Role::Settling => {}
                Role::WheelScatter => g.scatter.wheels = value,
                Role::SpeedScatter => g.scatter.speed = value,
                Role::ForceScatter => g.scatter.force = value,
                Role::MotionScatter => g.scatter.motion = value,
                Role::PathScatter => g.scatter.path = value,
                Role::Mass(l) if *l == load => g.mass = value,
                Role::Ratio(l) if *l == load => g.ratio = value,
                Role::Height(l) if *l == load => g.height = value,
                Role::Reach(l) if *l == load => g.ratio = self.loaded(g.mass, values, value).0,
                Role::Lift(l) if *l == load => g.height = self.loaded(g.mass, values, value).1,
                // Belongs to another load, or to the slopes only.
                Role::Mass(_)
                | Role::Ratio(_)
                | Role::Height(_)
                | Role::Reach(_)
                | Role::Lift(_)
                | Role::Mark(_) => {}
            }
        }
        self.pitched(&mut g, values);
        g
    }

    /// The chassis pitches on the springs of its tyres, k an axle, and slope sensor and accelerometer with it:
    /// ```text
    /// pitch = (F_zr - F_zf)/(k l) = q [m h/(m_0 h_0) a/g - s (m (2 lam - 1) - m_0 (2 lam_0 - 1)) l/(2 m_0 h_0)],  q = 2 m_0 g h_0/(k l^2)
    /// ```
    /// against that of the empty machine, which the zeros of the sensors contain; q is the squat. The tyres of the two axles differ, and
    /// stiffen under a load: s is about 1 ([`Role::Settling`]). With s = 1, the pitch would determine the position of the load.
    fn pitched(&self, g: &mut Guess, values: &[f64]) {
        let empty = |role: Role, own: f64| self.index(role).map_or(own, |i| values[i]);
        let (height, ratio) = (
            empty(Role::Height(0), g.height),
            empty(Role::Ratio(0), g.ratio),
        );
        let moment = g.empty_mass * height;
        let ahead = g.mass * (2.0 * g.ratio - 1.0) - g.empty_mass * (2.0 * ratio - 1.0);
        let settling = self.index(Role::Settling).map_or(1.0, |i| values[i]);
        let pitch = -settling * g.squat * ahead * g.wheelbase / (2.0 * moment);
        g.squat *= g.mass * g.height / moment;
        g.slope_bias += pitch;
        g.acceleration_offset += super::GRAVITY * pitch;
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
            Block::Section(path, _) => self.paths[path].recordings[0],
        }
    }

    fn acts(&self, parameter: usize, block: usize) -> bool {
        let role = self.roles[parameter];
        match self.blocks[block] {
            Block::Section(path, _) => role.is_of_slope() || role == Role::Mark(path),
            Block::Stretch(recording, _) => {
                let load = self.load_of[recording];
                let of_path = matches!(role, Role::PathScatter | Role::Mark(_));
                !of_path && role.load().is_none_or(|l| l == load || l == 0)
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
            Block::Section(path, number) => {
                let ahead = self.index(Role::Mark(path)).map_or(0.0, |i| values[i]);
                let path = &self.paths[path];
                let guesses = path.recordings.map(|r| self.guess(r, values));
                out.push(path.residual(&self.drives, number, &guesses, ahead));
            }
        }
    }
}

/// The load of each recording, and the stated values of the loads. A recording without stated values carries the load of
/// the description, unless its measured mass differs.
fn loads(
    drives: &[Drive],
    stated: &[StatedLoad],
    empty: StatedLoad,
    mass: f64,
) -> (Vec<usize>, Vec<StatedLoad>) {
    let mut loads = vec![empty];
    let load_of = drives
        .iter()
        .zip(stated)
        .map(|(drive, stated)| {
            let on_board = drive.mass.filter(|m| (m / mass - 1.0).abs() > OTHER_LOAD);
            let measured = on_board.map(|value| Quantity {
                value,
                std: MASS_STD * value,
            });
            let own = StatedLoad {
                mass: stated.mass.or(measured),
                ..*stated
            };
            if own == StatedLoad::default() {
                return 0;
            }
            // The angles of the arm scatter from recording to recording.
            let bare = |of: &StatedLoad| StatedLoad {
                reach: None,
                lift: None,
                ..*of
            };
            let known = loads[1..].iter().position(|l| bare(l) == bare(&own));
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
