//! An excavator with a script of successive actions, for tests:
//!
//! ```
//! use sim::excavator::Story;
//! // Carries 300 kg through a swing without its torque sensor, dumps them and swings back.
//! let story = Story::at_rest().lose("swing_torque", 2.0).swing_to(1.5).dump(300.0).swing_to(0.0);
//! let last = story.rows().last().unwrap();
//! assert!(last.truth.payload == 0.0 && last.truth.velocity.abs() < 0.02);
//! ```

use super::path::{Joint, Move, Path};
use super::payload::Load;
use super::plant::Plant;
use super::plants::at_rest;
use super::plateaus::{Plateaus, Targets};
use super::scenario::Scenario;
use super::simulation::{Run, Simulation};
use crate::fault::{Fault, FaultKind};

/// Peak velocity of a long swing [rad/s], and the least time that a swing takes [s].
const PEAK: f64 = 0.9;
const SHORTEST: f64 = 2.0;
/// Share of a swing's time that accelerates.
const ACCELERATING: f64 = 0.53;
/// Time at rest after a swing, after a dump, and at the beginning [s].
const PAUSE: f64 = 1.0;
/// Time in which material leaves the bucket or enters it [s], and angle by which the bucket opens [deg].
const MOVING: f64 = 0.65;
const OPENING: f64 = 75.0;

/// The script so far.
#[derive(Clone, Debug)]
pub struct Story {
    path: Path,
    loads: Vec<Load>,
    /// Each swing: begin, end [s], angle [rad].
    swings: Vec<(f64, f64, f64)>,
    run: Run,
    /// Time [s] and swing angle [rad] at the end of the script.
    now: f64,
    angle: f64,
}

impl Story {
    /// At rest for a second, boom and arm in a usual posture, standard noise of the sensors.
    #[must_use]
    pub fn at_rest() -> Self {
        Self {
            path: Path::constant(),
            loads: Vec::new(),
            swings: Vec::new(),
            run: Run::new(Scenario::Base),
            now: PAUSE,
            angle: 0.0,
        }
    }

    /// Sets the seed of the noise.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.run.seed = seed;
        self
    }

    /// Rests for `seconds` \[s\].
    #[must_use]
    pub fn rest(mut self, seconds: f64) -> Self {
        self.now += seconds;
        self
    }

    /// Swings to an angle, anticlockwise positive \[rad\], and rests for a second.
    #[must_use]
    pub fn swing_to(mut self, angle: f64) -> Self {
        let turn = angle - self.angle;
        let end = self.now + (2.0 * turn.abs() / PEAK).max(SHORTEST);
        self.swings.push((self.now, end, turn));
        (self.now, self.angle) = (end + PAUSE, angle);
        self
    }

    /// Opens the bucket and dumps a load that it has carried from the beginning \[kg\].
    #[must_use]
    pub fn dump(mut self, mass: f64) -> Self {
        let end = self.now + MOVING;
        self.loads.push(Load {
            dump: (self.now, end),
            ..Load::kept(mass)
        });
        let (from, to) = (self.now, end);
        let Joint { moves, .. } = &mut self.path.joints[2];
        moves.push(Move {
            from,
            to,
            degrees: OPENING,
        });
        self.now = end + PAUSE;
        self
    }

    /// Picks up material and retains it \[kg\].
    #[must_use]
    pub fn take_up(mut self, mass: f64) -> Self {
        let end = self.now + MOVING;
        self.loads.push(Load {
            fill: (self.now, end),
            ..Load::kept(mass)
        });
        self.now = end + PAUSE;
        self
    }

    /// A sensor has no values for `seconds` \[s\] from now, in parallel with the following actions.
    #[must_use]
    pub fn lose(self, channel: &str, seconds: f64) -> Self {
        self.suffer(channel, FaultKind::Missing, seconds)
    }

    /// A sensor has a fault for `seconds` \[s\] from now, in parallel with the following actions.
    #[must_use]
    pub fn suffer(mut self, channel: &str, kind: FaultKind, seconds: f64) -> Self {
        let end = self.now + seconds;
        self.run
            .faults
            .push(Fault::between(channel, kind, self.now, end));
        self
    }

    /// The samples with the truth.
    ///
    /// # Panics
    /// A lost sensor does not exist.
    pub fn rows(self) -> impl Iterator<Item = super::Row> {
        let run = Run {
            duration: self.now,
            ..self.run
        };
        let mut plant = at_rest(self.path, self.loads);
        for (start, end, turn) in self.swings {
            plant = swing(plant, start, end, turn);
        }
        Simulation::of(plant, 0.0, &run).expect("a story of sensors that exist")
    }
}

/// Adds the swing by `turn` between `start` and `end`.
fn swing(mut plant: Plant, start: f64, end: f64, turn: f64) -> Plant {
    let mut targets = Targets {
        times: (start, start + ACCELERATING * (end - start), end),
        peak: 2.0 * turn / (end - start),
        last: 0.005 * turn.signum(),
    };
    // The angle is nearly proportional to the peak velocity.
    for _ in 0..4 {
        let solver = Plateaus::new(&plant, targets);
        targets.peak *= turn / solver.angle(solver.solve());
    }
    let swing = Plateaus::new(&plant, targets).solve();
    plant.swings.push(swing);
    plant
}
