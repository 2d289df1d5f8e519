//! Steps that no arm and no content can do: what steps so is a sensor.
//!
//! An arm turns by its rate times the time between two rows. Content comes and goes in tenths of a second, and the oil under the piston takes a
//! tenth to be pressed together. So a moment that steps within a row, stays there, and had not swung before is another scale or another zero:
//! ```text
//! |d| > max(STEPS rms(d), LEAST) M,   mean after - known before = d (1 +- ALIKE)       d: from row to row
//! ```
//! A blow steps too, but swings back. Of a signal that comes seldom nothing is told: time counts from the last value that differed.

/// Slower rows see no step: a bucket is let down within that [s].
const SHARP: f64 = 0.03;
/// Standard deviations of what differs from row to row, and share of the moment, beyond which it steps. On six loaders of others .06 finds a
/// blow, .12 none; a scale of .8 is .2.
const STEPS: f64 = 5.0;
const LEAST: f64 = 0.12;
/// Averaging time of what differs from row to row [s], and what differs at the start, as a share of the moment.
const MEMORY: f64 = 3.0;
const FIRST: f64 = 0.05;
/// The level after a step is the mean from here to there [s]: rocking has gone round once, and no bucket is filled by then.
const AFTER: [f64; 2] = [0.2, 0.8];
/// How far the levels may differ by another amount than the step, as a share of it.
const ALIKE: f64 = 0.4;
/// An angle steps by more than this, and more than joints turn in the time [rad], [rad/s]: a tilt cylinder dumps in half a second.
const ANGLE: f64 = 0.05;
const FASTEST: f64 = 3.0;
/// Steps that sum to less are undone [rad].
const UNDONE: f64 = 0.03;
/// A stroke goes by so much through the middle of the range [rad].
const STROKE: f64 = 0.2;
/// After so many strokes that end where the old range did it may be the old angle: who works goes as far as before.
const STROKES: u32 = 4;

/// Steps of an angle, summed: a spike goes back.
///
/// One that goes back unseen, in a gap, shows at the ends of its strokes: an angle that shows too much reaches the least one of before no more,
/// one that shows too little the greatest. One that was off little by little and steps back has widened the range before: there its
/// strokes never leave it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct AngleSteps {
    /// The last value [rad], and how old it is [s].
    last: Option<f64>,
    age: f64,
    /// Sum of the steps [rad].
    sum: f64,
    /// Least and greatest angle before it stepped, and since [rad].
    ends: [f64; 2],
    since: [f64; 2],
    /// Strokes up through the middle of the range since, and whether it is above.
    strokes: u32,
    rises: bool,
}

impl Default for AngleSteps {
    /// Nothing has been seen.
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

/// Least and greatest of nothing.
const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// A range with this angle.
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
            (self.since, self.strokes) = (NOWHERE, 0);
        }
        (self.last, self.age) = (Some(angle), 0.0);
        if self.has_stepped() {
            self.watch(angle);
        } else {
            widen(&mut self.ends, angle);
        }
    }

    /// Takes an angle after a step.
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

    /// The range of before ends where that since does, at its least angle (0) or at its greatest (1).
    fn ends_as_before(&self, end: usize) -> bool {
        (self.since[end] - self.ends[end]).abs() < UNDONE
    }

    /// Its strokes end where they could not if it were still off, or go as far as before.
    fn is_back(&self) -> bool {
        let telling = usize::from(self.sum < 0.0);
        let within = self.since[0] > self.ends[0] - UNDONE && self.since[1] < self.ends[1] + UNDONE;
        self.strokes >= STROKES && (within || self.ends_as_before(telling))
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
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct MomentSteps {
    /// The last payload that was shown [kg].
    last: Option<f64>,
    /// Mean square of what differs from row to row, as a share of the moment.
    square: f64,
    step: Option<Step>,
}

/// A step that may stay.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Step {
    /// What was known of the payload before, and by how much it stepped [kg].
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
    /// What is shown of the payload since [kg].
    pub level: f64,
}

impl MomentSteps {
    /// Nothing has been seen.
    pub const NEW: Self = Self {
        last: None,
        square: FIRST * FIRST,
        step: None,
    };

    /// Takes what a row shows of the payload, and what the cylinders carry [kg], `dt` after the last. `known`: the payload before it, where it
    /// is [kg]; `acts`: bucket, ground or stop may change it. A step that has stayed.
    pub fn see(
        &mut self,
        [shown, carried]: [f64; 2],
        known: Option<f64>,
        acts: bool,
        dt: f64,
    ) -> Option<Stepped> {
        let by = shown - self.last.replace(shown)?;
        if acts {
            // In the ground and against a stop it does as it likes.
            self.step = None;
            return None;
        }
        let share = by / carried.abs().max((carried - by).abs());
        let usual = (STEPS * STEPS * self.square).max(LEAST * LEAST);
        let square = share * share;
        self.square += (dt / MEMORY).min(1.0) * (square.min(usual) - self.square);
        let steps = square > usual;
        if steps && dt <= SHARP && self.step.is_none() {
            self.step = known.map(|before| Step {
                before,
                by,
                carried: carried - by,
                age: 0.0,
                sum: 0.0,
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
            step.rows += 1.0;
        }
        if step.age > AFTER[1] {
            return self.step.take().and_then(Step::stayed);
        }
        None
    }

    /// A step may stay: a stop that is met meanwhile is met by the step.
    pub fn is_stepping(&self) -> bool {
        self.step.is_some()
    }

    /// Nothing is known of what was done meanwhile.
    pub fn gap(&mut self) {
        (self.last, self.step) = (None, None);
    }
}

impl Step {
    fn stayed(self) -> Option<Stepped> {
        let by = self.sum / self.rows.max(1.0) - self.before;
        let alike = (by - self.by).abs() < ALIKE * self.by.abs();
        alike.then_some(Stepped {
            by,
            share: by / self.carried,
            level: self.before + by,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What steps in three seconds of 2000 kg on 1000 kg of arm, shown as `sensor` does by time and true moment; noise of 1 %.
    fn stepped(dt: f64, acts: bool, sensor: impl Fn(f64, f64) -> f64) -> Option<Stepped> {
        let mut steps = MomentSteps::NEW;
        let rows = 0..(8.0 / dt) as u32;
        let see = |k: u32| {
            let noise = if k.is_multiple_of(2) { 30.0 } else { -30.0 };
            let carried = sensor(dt * f64::from(k), 3000.0) + noise;
            steps.see([carried - 1000.0, carried], Some(2000.0), acts, dt)
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
    }

    #[test]
    fn an_angle_that_no_joint_can_do_is_a_sensors_until_it_is_undone() {
        let mut steps = AngleSteps::default();
        (0..100).for_each(|k| steps.see(0.01 * f64::from(k), 0.01));
        assert!(!steps.has_stepped(), "an arm at full speed");
        // A slow bus holds a value for a fifth of a second.
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
    fn an_angle_that_went_back_unseen_is_believed_after_a_stroke_to_its_old_end() {
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
            // Off little by little, and back at once.
            (0..200).for_each(|k| steps.see(-0.2 + 0.005 * off * f64::from(k), 0.01));
            (0..9).for_each(|_| stroke(&mut steps, off));
            stroke(&mut steps, 0.0);
            assert!(steps.has_stepped());
            (0..5).for_each(|_| stroke(&mut steps, 0.0));
            assert!(!steps.has_stepped(), "{off}");
        }
    }
}
