//! An excavator that is given a script, one thing after the other, so that a test reads as what happens:
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
/// How long the machine stands after a swing, while it dumps, and at the beginning [s].
const PAUSE: f64 = 1.0;
/// How long material takes to leave the bucket or to get into it [s], and by how much the bucket opens [deg].
const MOVING: f64 = 0.65;
const OPENING: f64 = 75.0;

/// What happens, so far.
#[derive(Clone, Debug)]
pub struct Story {
    path: Path,
    loads: Vec<Load>,
    /// Each swing: begin, end [s], by how much it turns [rad].
    swings: Vec<(f64, f64, f64)>,
    run: Run,
    /// Time [s] and swing angle [rad] after all of it.
    now: f64,
    angle: f64,
}

impl Story {
    /// Stands for a second, boom and arm in a usual posture, the usual noise on its sensors.
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

    /// The noise is that of another seed.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.run.seed = seed;
        self
    }

    /// Stands for so long \[s\].
    #[must_use]
    pub fn rest(mut self, seconds: f64) -> Self {
        self.now += seconds;
        self
    }

    /// Swings to an angle, anticlockwise positive \[rad\], and stands for a second.
    #[must_use]
    pub fn swing_to(mut self, angle: f64) -> Self {
        let turn = angle - self.angle;
        let end = self.now + (2.0 * turn.abs() / PEAK).max(SHORTEST);
        self.swings.push((self.now, end, turn));
        (self.now, self.angle) = (end + PAUSE, angle);
        self
    }

    /// Opens the bucket, out of which falls what it carried from the beginning \[kg\].
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

    /// Takes material into the bucket and keeps it \[kg\].
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

    /// From now on a sensor is silent for so long \[s\], whatever happens then.
    #[must_use]
    pub fn lose(self, channel: &str, seconds: f64) -> Self {
        self.suffer(channel, FaultKind::Missing, seconds)
    }

    /// From now on a sensor does this for so long \[s\], whatever happens then.
    #[must_use]
    pub fn suffer(mut self, channel: &str, kind: FaultKind, seconds: f64) -> Self {
        let end = self.now + seconds;
        self.run
            .faults
            .push(Fault::between(channel, kind, self.now, end));
        self
    }

    /// What the sensors tell of it, with the truth.
    ///
    /// # Panics
    /// A sensor that is lost does not exist.
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

/// Adds the swing that turns by so much in this time.
fn swing(mut plant: Plant, start: f64, end: f64, turn: f64) -> Plant {
    let mut targets = Targets {
        times: (start, start + ACCELERATING * (end - start), end),
        peak: 2.0 * turn / (end - start),
        last: 0.005 * turn.signum(),
    };
    // The angle is nearly in proportion to the peak.
    for _ in 0..4 {
        let solver = Plateaus::new(&plant, targets);
        targets.peak *= turn / solver.angle(solver.solve());
    }
    let swing = Plateaus::new(&plant, targets).solve();
    plant.swings.push(swing);
    plant
}
