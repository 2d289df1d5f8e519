//! Steps that no arm and no content can do: what steps so is a sensor.
//!
//! An arm turns by its rate times the time between two rows. Content comes and goes in tenths of a second, and the oil under the piston takes a
//! tenth to be pressed together. So a moment that steps within a row, stays there, and had not swung before is another scale or another zero:
//! ```text
//! |d| > max(STEPS rms(d), LEAST) M,   mean after - mean before = d (1 +- ALIKE)       d: from row to row
//! ```
//! A blow steps too, but swings back. Nothing is told of a signal that comes seldom: time is counted from the last value that differed.

/// Slower rows see no step: a bucket is let down within that [s].
const SHARP: f64 = 0.03;
/// Standard deviations of what differs from row to row, and share of the moment, beyond which it steps.
const STEPS: f64 = 5.0;
const LEAST: f64 = 0.06;
/// Averaging time of what differs from row to row [s], and smoothing of the level before a step [s].
const MEMORY: f64 = 3.0;
const SMOOTH: f64 = 0.3;
/// The level after a step is the mean from here to there [s].
const AFTER: [f64; 2] = [0.2, 0.8];
/// How far the levels may differ by another amount than the step, as a share of it.
const ALIKE: f64 = 0.4;
/// An angle steps by more than this, and more than joints turn in the time [rad], [rad/s]: tilt cylinders dump in half a second.
const ANGLE: f64 = 0.05;
const FASTEST: f64 = 3.0;
/// Steps that sum to less are undone [rad].
const UNDONE: f64 = 0.03;

/// Steps of an angle, summed: a spike goes back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct AngleSteps {
    /// The last value [rad], and how old it is [s].
    last: Option<f64>,
    age: f64,
    /// Sum of the steps [rad].
    sum: f64,
}

impl AngleSteps {
    /// Takes an angle [rad], `dt` after the last.
    pub fn see(&mut self, angle: f64, dt: f64) {
        self.age += dt;
        let Some(last) = self.last else {
            (self.last, self.age) = (Some(angle), 0.0);
            return;
        };
        let moved = angle - last;
        if moved == 0.0 {
            return;
        }
        if moved.abs() > ANGLE + FASTEST * self.age {
            self.sum += moved;
        }
        (self.last, self.age) = (Some(angle), 0.0);
    }

    /// Nothing is known of what was done meanwhile; what has stepped has.
    pub fn gap(&mut self) {
        self.last = None;
    }

    /// The angle is not the one that it was.
    pub fn has_stepped(&self) -> bool {
        self.sum.abs() > UNDONE
    }
}

/// Steps of the moment, as what the cylinders carry [kg].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct MomentSteps {
    /// The last payload that was shown, and the smoothed one [kg].
    last: Option<f64>,
    level: f64,
    /// Mean square of what differs from row to row, as a share of the moment.
    square: f64,
    step: Option<Step>,
}

/// A step that may stay.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Step {
    /// Level before, and by how much it stepped [kg].
    before: f64,
    by: f64,
    /// What the cylinders carried before [kg].
    carried: f64,
    /// How old it is [s].
    age: f64,
    /// Sum and number of the rows after it.
    sum: f64,
    rows: f64,
}

/// A step that stayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stepped {
    /// By how much [kg], and over what was carried before.
    pub by: f64,
    pub share: f64,
}

impl MomentSteps {
    /// Takes what a row shows of the payload and what the cylinders carry [kg], `dt` after the last. `known`: the content is; `acts`: bucket,
    /// ground or stop may change it. A step that has stayed.
    pub fn see(
        &mut self,
        shown: f64,
        carried: f64,
        [known, acts]: [bool; 2],
        dt: f64,
    ) -> Option<Stepped> {
        let Some(last) = self.last.replace(shown) else {
            self.level = shown;
            return None;
        };
        let by = shown - last;
        let share = by / carried.abs().max(by.abs());
        let usual = (STEPS * STEPS * self.square).max(LEAST * LEAST);
        let is_step = share * share > usual && self.square > 0.0;
        if is_step && known && !acts && dt <= SHARP && self.step.is_none() {
            let before = self.level;
            self.step = Some(Step {
                before,
                by,
                carried: carried - by,
                age: 0.0,
                sum: 0.0,
                rows: 0.0,
            });
        }
        // In the ground and against a stop it steps as it likes.
        if !acts {
            self.square += (dt / MEMORY).min(1.0) * ((share * share).min(usual) - self.square);
        }
        self.level += (dt / SMOOTH).min(1.0) * (shown - self.level);
        let mut step = self.step.take().filter(|_| !acts)?;
        step.age += dt;
        if step.age > AFTER[1] {
            let stays = step.sum / step.rows.max(1.0) - step.before;
            let alike = (stays - step.by).abs() < ALIKE * step.by.abs();
            return alike.then_some(Stepped {
                by: stays,
                share: stays / step.carried,
            });
        }
        if step.age > AFTER[0] {
            step.sum += shown;
            step.rows += 1.0;
        }
        self.step = Some(step);
        None
    }

    /// Nothing is known of what was done meanwhile.
    pub fn gap(&mut self) {
        (self.last, self.step) = (None, None);
    }
}
