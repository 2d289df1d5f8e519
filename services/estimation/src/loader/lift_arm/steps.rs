//! Detects steps of angles and moment that neither arm nor content can make: a sensor has changed.
//!
//! An angle is limited by the rate of the joint. Content comes and goes in tenths of a second, and the oil under the piston takes a tenth to
//! be compressed. So a moment that steps within a row and stays at the new level has another scale or another zero:
//! ```text
//! |d| > max(STEPS rms(d/M), LEAST) M,   mean after - known before = d (1 +- ALIKE),   scatter after < ALIKE |d|
//! d: change from row to row,   M: moment
//! ```
//! M and d are those of the pressures alone, and the payload must step with them. A friction or an acceleration that is not as modelled
//! moves the payload within a row and no pressure; one that is as modelled, the reverse. A blow steps too, but swings back. Moments in slow rows are not tested. For a slow angle the time counts from the last change of value.

use crate::math::sqrt;

/// Longest time between rows in which a step is detected [s]: in a longer one a bucket can be put down.
const SHARP: f64 = 0.03;
/// Threshold of a step, in standard deviations of the change from row to row, and as a share of the moment. On six independently simulated
/// loaders .06 finds a blow, .12 none; a scale of .8 is .2.
const STEPS: f64 = 5.0;
const LEAST: f64 = 0.12;
/// Averaging time of the mean-square change from row to row [s], and its initial root, as a share of the moment.
const MEMORY: f64 = 3.0;
const FIRST: f64 = 0.05;
/// Interval after a step over which its level is averaged [s]: one period of rocking, and too short to fill a bucket.
const AFTER: [f64; 2] = [0.2, 0.8];
/// Tolerance of the change of level against the step, and limit of the scatter about that level, as shares of the step.
const ALIKE: f64 = 0.4;
/// Threshold of an angle's step [rad], and rate that a joint may add [rad/s]: a tilt cylinder dumps in half a second.
const ANGLE: f64 = 0.05;
const FASTEST: f64 = 3.0;
/// Sum of steps below which the angle is back [rad].
const UNDONE: f64 = 0.03;
/// Width of the hysteresis about the middle of the range, by which strokes are counted [rad].
const STROKE: f64 = 0.2;
/// Number of strokes that end where the old range did, after which the angle may be back: work uses the same range as before.
const STROKES: u32 = 4;

/// Sum of the steps of an angle, so that a spike cancels.
///
/// A step back in a gap is detected by the ends of the strokes. An angle that shows too much does not reach its former least value, and one
/// that shows too little does not reach its former greatest value. An angle that drifts and then steps back has widened the former range
/// before: then the strokes must stay within it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct AngleSteps {
    /// The last value [rad], and how old it is [s].
    last: Option<f64>,
    age: f64,
    /// Sum of the steps [rad].
    sum: f64,
    /// Least and greatest angle before the step, and since [rad].
    ends: [f64; 2],
    since: [f64; 2],
    /// Number of upward strokes through the middle of the range since, and whether the angle is above it.
    strokes: u32,
    rises: bool,
}

impl Default for AngleSteps {
    /// Before the first angle.
    fn default() -> Self {
        Self {
            last: None,
            age: 0.0,
            sum: 0.0,
            ends: NOWHERE,
            since: NOWHERE,
            strokes: 0,
            rises: false,
        }
    }
}

/// Empty range.
const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Widens a range to include an angle.
#[inline]
fn widen([least, greatest]: &mut [f64; 2], angle: f64) {
    if angle < *least {
        *least = angle;
    }
    if angle > *greatest {
        *greatest = angle;
    }
}

impl AngleSteps {
    /// Updates with an angle [rad], `dt` after the last.
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
            (self.since, self.strokes) = (NOWHERE, 0);
        }
        (self.last, self.age) = (Some(angle), 0.0);
        if self.has_stepped() {
            self.watch(angle);
        } else {
            widen(&mut self.ends, angle);
        }
    }

    /// Updates with an angle after a step.
    #[cold]
    fn watch(&mut self, angle: f64) {
        widen(&mut self.since, angle);
        let [least, greatest] = self.since;
        let beyond = if self.rises { -0.5 } else { 0.5 } * STROKE;
        let rises = angle - 0.5 * (least + greatest) > beyond;
        let begins = rises && !self.rises;
        self.strokes += u32::from(begins && (self.ends_as_before(0) || self.ends_as_before(1)));
        self.rises = rises;
        if self.is_back() {
            self.sum = 0.0;
        }
    }

    /// The ranges before and since the step agree at their least angle (0) or greatest angle (1).
    fn ends_as_before(&self, end: usize) -> bool {
        (self.since[end] - self.ends[end]).abs() < UNDONE
    }

    /// The angle is back: its strokes end where a wrong angle could not, or stay within the former range.
    fn is_back(&self) -> bool {
        let decisive = usize::from(self.sum < 0.0);
        let within = self.since[0] > self.ends[0] - UNDONE && self.since[1] < self.ends[1] + UNDONE;
        self.strokes >= STROKES && (within || self.ends_as_before(decisive))
    }

    /// A gap: the change over it is unknown, and earlier steps remain.
    pub fn gap(&mut self) {
        self.last = None;
    }

    /// The angle has stepped, and is not back.
    pub fn has_stepped(&self) -> bool {
        self.sum.abs() > UNDONE
    }
}

/// Detector of steps of the moment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct MomentSteps {
    /// Payload [kg], and moment by the pressures [N m], of the last row.
    last: Option<[f64; 2]>,
    /// Mean-square change from row to row, as a share of the moment.
    square: f64,
    /// A step that has not been decided.
    step: Option<Step>,
}

/// A step whose level is being averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Step {
    /// Payload known before, and size of the step [kg].
    before: f64,
    by: f64,
    /// Whole moment before, as a weight [kg].
    carried: f64,
    /// Age [s].
    age: f64,
    /// Sum of the rows averaged, of their squares, and their number.
    sum: f64,
    squares: f64,
    rows: f64,
}

/// A step that stayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stepped {
    /// Change of the payload [kg], and as a share of the whole moment before.
    pub by: f64,
    pub share: f64,
    /// Payload shown since [kg].
    pub level: f64,
}

impl MomentSteps {
    /// Before the first row.
    pub const NEW: Self = Self {
        last: None,
        square: FIRST * FIRST,
        step: None,
    };

    /// Updates with the payload by a row [kg], the whole moment by its pressures [N m] and that of a kilogram of load [N m/kg], `dt` after
    /// the last. `known`: payload before it, if known [kg]; `acts`: bucket, ground or stop may change the moment. Returns a step that has
    /// stayed.
    pub fn see(
        &mut self,
        [shown, pressed, per_load]: [f64; 3],
        known: Option<f64>,
        acts: bool,
        dt: f64,
    ) -> Option<Stepped> {
        let [payload, last] = self.last.replace([shown, pressed])?;
        let by = pressed - last;
        if acts {
            // The moment may step in the ground and against a stop.
            self.step = None;
            return None;
        }
        let share = by / pressed.abs().max(last.abs());
        let usual = (STEPS * STEPS * self.square).max(LEAST * LEAST);
        let square = share * share;
        self.square += (dt / MEMORY).min(1.0) * (square.min(usual) - self.square);
        let steps = square > usual;
        if steps && dt <= SHARP && self.step.is_none() {
            let by = by / per_load;
            let agrees = (shown - payload - by).abs() < ALIKE * by.abs();
            self.step = known.filter(|_| agrees).map(|before| Step {
                before,
                by,
                carried: last / per_load,
                age: 0.0,
                sum: 0.0,
                squares: 0.0,
                rows: 0.0,
            });
        }
        let step = self.step.as_mut()?;
        step.age += dt;
        if steps && by * step.by < 0.0 {
            self.step = None;
            return None;
        }
        if step.age > AFTER[0] {
            step.sum += shown;
            step.squares += shown * shown;
            step.rows += 1.0;
        }
        if step.age > AFTER[1] {
            return self.step.take().and_then(Step::stayed);
        }
        None
    }

    /// A step is undecided: a stop detected now is an effect of the step.
    pub fn is_stepping(&self) -> bool {
        self.step.is_some()
    }

    /// A gap: the change over it is unknown.
    pub fn gap(&mut self) {
        (self.last, self.step) = (None, None);
    }
}

impl Step {
    /// Returns the step where its level agrees with it, and is one: a moment that swings has none.
    fn stayed(self) -> Option<Stepped> {
        let rows = self.rows.max(1.0);
        let mean = self.sum / rows;
        let by = mean - self.before;
        let scatter = sqrt((self.squares / rows - mean * mean).max(0.0));
        let agrees = (by - self.by).abs().max(scatter) < ALIKE * self.by.abs();
        agrees.then_some(Stepped {
            by,
            share: by / self.carried,
            level: self.before + by,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moment of a kilogram of load [N m/kg].
    const PER_LOAD: f64 = 30.0;

    #[test]
    fn a_step_of_the_payload_or_of_the_pressures_alone_is_no_sensors() {
        let found = |payload: f64, pressed: f64| {
            let mut steps = MomentSteps::NEW;
            let see = |k: u32| {
                let [payload, pressed] =
                    [payload, pressed].map(|by| if k < 500 { 0.0 } else { by });
                let rows = [1600.0 + payload, PER_LOAD * (2600.0 + pressed), PER_LOAD];
                // The filter follows the rows slowly.
                steps.see(rows, Some(1600.0 + 0.1 * payload), false, 0.01)
            };
            (0..800).filter_map(see).count()
        };
        assert_eq!(found(800.0, 0.0), 0, "friction");
        assert_eq!(found(0.0, 800.0), 0, "friction that is modelled");
        assert_eq!(found(800.0, 800.0), 1);
    }

    /// Last step found in eight seconds with 2000 kg on 1000 kg of arm; `sensor`: value by time and true moment; noise of 1 %.
    fn stepped(dt: f64, acts: bool, sensor: impl Fn(f64, f64) -> f64) -> Option<Stepped> {
        let mut steps = MomentSteps::NEW;
        let rows = 0..(8.0 / dt) as u32;
        let see = |k: u32| {
            let noise = if k.is_multiple_of(2) { 30.0 } else { -30.0 };
            let carried = sensor(dt * f64::from(k), 3000.0) + noise;
            let pressed = PER_LOAD * carried;
            let rows = [carried - 1000.0, pressed, PER_LOAD];
            steps.see(rows, Some(2000.0), acts, dt)
        };
        rows.filter_map(see).last()
    }

    #[test]
    fn a_moment_that_steps_within_a_row_and_stays_is_a_sensors() {
        let from =
            |gain: f64| move |t: f64, moment: f64| if t < 5.0 { moment } else { gain * moment };
        for gain in [0.5, 0.8, 1.25, 2.0] {
            let step = stepped(0.01, false, from(gain)).expect("it stepped");
            assert!((step.share - (gain - 1.0)).abs() < 0.03, "{step:?}");
            assert!((step.by - 3000.0 * (gain - 1.0)).abs() < 90.0);
            assert_eq!(stepped(0.01, true, from(gain)), None, "the ground pushes");
            assert_eq!(stepped(0.05, false, from(gain)), None, "rows are seldom");
        }
        let blow = |t: f64, moment: f64| {
            if (5.0..5.1).contains(&t) {
                2.0 * moment
            } else {
                moment
            }
        };
        assert_eq!(stepped(0.01, false, blow), None);
        let silence = |t: f64, moment: f64| if (5.0..5.6).contains(&t) { 0.0 } else { moment };
        assert_eq!(stepped(0.01, false, silence), None);
        let filled = |t: f64, moment: f64| moment * (1.0 + (t - 5.0).clamp(0.0, 0.3));
        assert_eq!(stepped(0.01, false, filled), None);
        // Its mean is another one, which it never has.
        let shaken = |t: f64, moment: f64| {
            let swing = if (5.0..5.3).contains(&t) { 0.4 } else { -0.4 };
            moment
                * if t < 5.0 {
                    1.0
                } else {
                    1.2 + swing * (40.0 * t).sin().signum()
                }
        };
        assert_eq!(stepped(0.01, false, shaken), None);
    }

    #[test]
    fn an_angle_faster_than_any_joint_has_stepped_until_it_steps_back() {
        let mut steps = AngleSteps::default();
        (0..100).for_each(|k| steps.see(0.01 * f64::from(k), 0.01));
        assert!(!steps.has_stepped(), "an arm at full speed");
        // A slow bus repeats a value for a fifth of a second.
        (0..20).for_each(|_| steps.see(0.99, 0.01));
        steps.see(1.3, 0.01);
        assert!(!steps.has_stepped());
        steps.see(1.6, 0.01);
        assert!(steps.has_stepped());
        (0..300).for_each(|_| steps.see(1.6, 0.01));
        assert!(steps.has_stepped());
        steps.see(1.31, 0.01);
        assert!(steps.has_stepped(), "it was still for long");
        let mut spike = AngleSteps::default();
        for angle in [0.2, 0.9, 0.2] {
            spike.see(angle, 0.01);
        }
        assert!(!spike.has_stepped());
    }

    #[test]
    fn an_angle_that_went_back_in_a_gap_is_trusted_after_strokes_to_its_old_end() {
        let stroke = |steps: &mut AngleSteps, off: f64| {
            (0..=200)
                .for_each(|k: i32| steps.see(off - 0.8 + 0.006 * f64::from(k.abs_diff(100)), 0.01));
        };
        for off in [0.3, -0.3] {
            let mut steps = AngleSteps::default();
            (0..3).for_each(|_| stroke(&mut steps, 0.0));
            stroke(&mut steps, off);
            assert!(steps.has_stepped());
            (0..9).for_each(|_| stroke(&mut steps, off));
            assert!(steps.has_stepped(), "it is still off");
            steps.gap();
            (0..5).for_each(|_| stroke(&mut steps, 0.0));
            assert!(!steps.has_stepped(), "{off}");
            // Drifts, and steps back.
            (0..200).for_each(|k| steps.see(-0.2 + 0.005 * off * f64::from(k), 0.01));
            (0..9).for_each(|_| stroke(&mut steps, off));
            stroke(&mut steps, 0.0);
            assert!(steps.has_stepped());
            (0..5).for_each(|_| stroke(&mut steps, 0.0));
            assert!(!steps.has_stepped(), "{off}");
        }
    }
}
