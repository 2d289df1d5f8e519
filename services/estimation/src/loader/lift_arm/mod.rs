//! The second witness: pressure of the lift cylinders and the arm's geometry tell the load by gravity alone, moving or standing,
//! and with it the machine's mass and its centre of gravity. It shares no assumption with the slips but the empty machine.
//!
//! | file | idea |
//! |---|---|
//! | `drawing`, `numbers` | the described numbers, each with its doubt |
//! | `geometry` | moment, payload and centre of gravity in a posture |
//! | `signals` | a row need not hold all of them |
//! | `silence` | signals that do not come: a load may have come or gone |
//! | `seals` | friction of the seals remembers which way the rod moved last |
//! | `grading` | a low bucket that the ground may carry, where nobody tells a torque |
//! | `linkage` | how far the bucket turns with the arm: where the tilt cylinder sits |
//! | `drive` | the specific force where no accelerometer tells it; wheels that push
//! | `content` | when the bucket's content may change, and when the ground carries it |
//! | `turn` | sine and cosine of an angle, taken once a row |
//! | `stops` | the ends of the arm's travel: what a stop carries is no weight |
//! | `scale` | payload and rest of friction from row to row |
//! | `saturation` | a pressure sensor at its end |
//! | `tare` | an emptied bucket is a weight that is known |
//! | `below` | a payload below zero, or more than the rear axle balances: the description is off by more than it claims |
//! | `steps`, `changed` | a step that neither arm nor content can do is a sensor's, and how probable that is |
//! | `inertial_mass` | a load that does not move as it weighs tells of a sensor too |
//! | [`Lifts`] | the moments of a whole recording, to calibrate |
//! | `doubt` | what the drawing's doubts do to the answer, one of them a row |
//!
//! ```text
//! tau = r(th) [n (A_h p_h - A_r p_r) - F]  =  m_a (x_a g' - z_a a) + (m_b + m_p)(x_t g' - z_t a)        about the pivot
//! (x_t, z_t) = pin + t (x_b - x_pin, z_b - z_pin)
//! m = m_0 + m_p,   lam = [m_0 lam_0 + moved + m_p (l + x_f)/l]/m,   h = [m_0 h_0 + raised + m_p (pivot_z + z_b)]/m
//! ```
//! | symbol | meaning | unit |
//! |---|---|---|
//! | th, beta | angle of the arm, of the bucket (pin to load) from the horizontal | rad |
//! | x, z | centre of mass from the pivot, forward and up, of arm a, bucket and load b | m |
//! | t | how far the bucket turns with the arm while nobody tilts (`linkage`): the tilt cylinder on a frame carries the rest | - |
//! | r | lever of the cylinder, dl/dth | m |
//! | F | friction of the seals | N |
//! | g', a | g cos(slope), specific force along the body | m/s^2 |
//! | x_f | load ahead of the front axle, pivot_x + x_b | m |
//! | lam_0, h_0 | empty machine with its arm at the reference; moved, raised: arm and bucket away from there | -, m |

mod below;
mod changed;
mod content;
mod doubt;
mod drawing;
mod drive;
mod geometry;
mod grading;
mod inertial_mass;
mod lifts;
mod linkage;
mod numbers;
mod saturation;
mod scale;
mod seals;
mod signals;
mod silence;
mod steps;
mod stops;
mod tare;
mod turn;

use core::ops::Deref;

use super::input::carriage::Carriage;
use super::layout::Each;
use super::physics::cg_model::Loading;
use super::sample::Sample;
use super::settings::Settings;
use crate::Quantity;
use crate::math::{norm, sqrt};
use below::Below;
use changed::{Bucket, Changed, DOUBTED};
use content::{Content, Motion};
use doubt::Doubts;
use drawing::Drawing;
use drive::Drive;
use geometry::{Empty, Posture, Shown, USUAL_ROD_PRESSURE};
use grading::Grading;
use inertial_mass::InertialMass;
pub use lifts::{LiftKnown, LiftMoment, Lifts};
use linkage::Linkage;
use numbers::{EMPTY_MASS, FRICTION, ROD_ZERO, TURN};
use saturation::Saturation;
use scale::Scale;
use seals::Seals;
use signals::{Now, Signals};
use steps::{AngleSteps, MomentSteps};
use stops::{End, Stops};
use tare::Emptied;
use turn::Turn;

/// Nothing is known of what was done in a longer gap between two weighed rows [s].
const GAP: f64 = 0.5;
/// A pressure or angle that never changes for so long while the machine moves is none [s].
const STUCK: f64 = 3.0;
/// In a gap of this length the bucket may have become another one [s].
const CHANGED: f64 = 60.0;
/// Smoothing of the angles [s].
const SMOOTH: f64 = 0.12;
/// Deviations below nothing beyond which a bucket at the lower end of the arm's travel rests on something.
const CARRIED: f64 = 1.9;
/// Faster than this the machine shakes its sensors [m/s].
const DRIVING: f64 = 0.5;

/// The lift arm as far as it has been described and measured.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LiftWitness {
    drawing: Drawing,
    /// Smoothed angles of arm and bucket, and their rates [rad], [rad/s].
    angles: Option<[f64; 2]>,
    rates: [f64; 2],
    last_time: f64,
    /// Time of the last row with the signals of the arm, used or not [s].
    seen: f64,
    /// The last head pressure and lift angle, and how long they have stood still while the machine moved [s].
    held: [f64; 2],
    still: [f64; 2],
    saturation: Saturation,
    signals: Signals,
    /// The rod's pressure is measured.
    measures_rod: bool,
    carriage: Carriage,
    seals: Seals,
    drive: Drive,
    content: Content,
    grading: Grading,
    stops: Stops,
    scale: Scale,
    /// What the angles tell of the linkage; none where it is stated, or no angle of the bucket is measured.
    linkage: Option<Linkage>,
    doubts: Doubts,
    emptied: Emptied,
    below: Below,
    /// Steps of the angles of arm and bucket, and of the moment.
    angle_steps: [AngleSteps; 2],
    moment_steps: MomentSteps,
    changed: Changed,
    inertial: InertialMass,
    answer: Option<Weighed>,
}

/// What the machine carries in a row, for who measures the empty one otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Carried {
    /// Mass of the machine with it [kg].
    pub mass: f64,
    /// What load and arm add to the empty machine.
    pub loading: Loading,
    /// Standard deviations of ratio and height of that, the empty machine being known [-, m].
    pub loading_std: [f64; 2],
    /// The content may be changing, or the ground carries a part of it.
    pub open: bool,
}

/// What the pressures say of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Weighed {
    /// What the bucket holds, as the pressures show it: an empty one may show less than nothing [kg].
    pub payload: Quantity,
    /// Share of the weight in front.
    pub ratio: Quantity,
    /// Height of the centre of gravity [m].
    pub height: Quantity,
    /// What the slips take of it.
    pub carried: Carried,
    /// How far it lies from either place of the tilt cylinder, while both are possible [kg].
    pub undecided: f64,
    /// Standard deviation by the pressure's gain at a load, which a weighed load alone tells: in that of the payload [kg].
    pub gain_left: f64,
    /// No doubt that was stated explains what the pressures show.
    pub wrong: bool,
    /// Signals of the arm are missing or too old: this is what may be since the last weight.
    pub silent: bool,
}

/// What a row says of it, or what may be where it says nothing.
pub(super) enum Said<'a> {
    Weighed(&'a Weighed),
    Silent(Weighed),
}

impl Deref for Said<'_> {
    type Target = Weighed;

    fn deref(&self) -> &Weighed {
        match self {
            Self::Weighed(weighed) => weighed,
            Self::Silent(weighed) => weighed,
        }
    }
}

impl LiftWitness {
    /// The witness that a description allows; none where no arm is described.
    pub fn new(settings: &Settings) -> Option<Self> {
        let mut drawing = Drawing::of(settings)?;
        drawing.set(ROD_ZERO, drawing.rod_zero(false));
        Some(Self {
            scale: Scale::new(&drawing),
            linkage: drawing.learns_turn.then_some(Linkage::NEW),
            drawing,
            angles: None,
            rates: [0.0; 2],
            last_time: 0.0,
            seen: 0.0,
            held: [f64::NAN; 2],
            still: [0.0; 2],
            saturation: Saturation::NEW,
            signals: Signals::NONE,
            measures_rod: false,
            carriage: Carriage::default(),
            seals: Seals::default(),
            drive: Drive::new(settings, drawing.capacity),
            content: Content::default(),
            grading: Grading::default(),
            stops: Stops::default(),
            doubts: Doubts::default(),
            emptied: Emptied::default(),
            below: Below::default(),
            angle_steps: [AngleSteps::default(); 2],
            moment_steps: MomentSteps::NEW,
            changed: Changed::default(),
            inertial: InertialMass::default(),
            answer: None,
        })
    }

    /// Centre of gravity of the empty machine, its arm at the reference, with standard deviations.
    pub fn empty(&self) -> Each<(f64, f64)> {
        self.drawing.empty()
    }

    /// The payload where no pressure tells it: whatever the bucket holds, so that who writes columns has it from the first row on.
    pub fn unknown(&self) -> Quantity {
        Scale::new(&self.drawing).payload()
    }

    /// Takes a plausible row that was accepted, whose values count for as long as they are `fresh` [s]; what is known after it, once
    /// something was weighed.
    pub fn step(&mut self, sample: &Sample, fresh: f64) -> Option<Said<'_>> {
        let now = self.signals.take(sample, fresh);
        let Now {
            lift,
            tilt,
            rod,
            acceleration,
        } = now;
        self.drive.take(sample, acceleration);
        let lift = lift.filter(|_| tilt.is_some() || !self.signals.measure_tilt());
        let (Some(lift), Some(head)) = (lift, sample.lift_head_pressure) else {
            if lift.is_some() && self.is_fresh(sample.time, fresh) {
                return self.answer.as_ref().map(Said::Weighed);
            }
            return self.silent(&now, sample).map(Said::Silent);
        };
        let since = sample.time - core::mem::replace(&mut self.seen, sample.time);
        self.watch([head, lift], sample, since);
        self.angle_steps[0].see(lift, since);
        if let Some(tilt) = tilt {
            self.angle_steps[1].see(tilt, since);
        }
        if let (Some(speed), Some(tilt)) = (sample.speed, tilt) {
            self.carriage.see(speed, [lift, tilt], since);
        }
        if self.carriage.is_odd() || self.still.iter().any(|time| *time > STUCK) {
            self.answer = None;
            return None;
        }
        if rod.is_some() != self.measures_rod {
            self.measures_rod = rod.is_some();
            self.know(ROD_ZERO, self.drawing.rod_zero(self.measures_rod));
        }
        let dt = sample.time - self.last_time;
        let bucket = self.drawing.bucket_angle(lift, tilt);
        let old = self.angles.filter(|_| dt > 0.0 && dt < GAP);
        if old.is_none() {
            // The first row, after a gap, or after a clock that was set: nothing is known of what was done meanwhile.
            let silent = self.silent(&now, sample);
            self.scale.forget(&self.drawing);
            self.content = Content::default();
            self.grading = Grading::default();
            self.emptied = Emptied::default();
            if !(0.0..CHANGED).contains(&dt) {
                self.doubts.forget();
                self.inertial = InertialMass::default();
            }
            self.seals.forget();
            self.moment_steps.gap();
            self.angle_steps.iter_mut().for_each(AngleSteps::gap);
            self.angles = Some([lift, bucket]);
            self.rates = [0.0; 2];
            self.last_time = sample.time;
            return silent.map(Said::Silent);
        }
        self.last_time = sample.time;
        self.follow([lift, bucket], dt);
        let angles = self.angles.unwrap_or_default();
        let posture = self.posture(angles, [head, rod.unwrap_or(USUAL_ROD_PRESSURE)], sample);
        self.weigh(angles, posture, sample, dt);
        if self.inertial.is_due(dt) {
            self.compare_masses();
        }
        self.answer.as_ref().map(Said::Weighed)
    }

    /// Inertial mass and weight of the load.
    fn compare_masses(&mut self) {
        let open = self.answer.is_none_or(|answer| answer.carried.open);
        let masses = [self.drive.rolling, self.drawing.capacity];
        self.inertial
            .see(self.drive.pull(), self.scale.payload(), open, masses);
    }

    /// The last answer counts still.
    fn is_fresh(&self, time: f64, fresh: f64) -> bool {
        self.answer.is_some() && (0.0..=fresh).contains(&(time - self.last_time))
    }

    /// Counts how long signals stand still while the machine moves.
    fn watch(&mut self, now: [f64; 2], sample: &Sample, dt: f64) {
        let driving = drives(sample);
        for ((still, held), new) in self.still.iter_mut().zip(&mut self.held).zip(now) {
            // The same bits: a sensor that lives has noise, or a machine that shakes it.
            if *held != new {
                *still = 0.0;
            } else if driving && dt > 0.0 {
                *still += dt;
            }
            *held = new;
        }
    }

    fn follow(&mut self, angles: [f64; 2], dt: f64) {
        let weight = (dt / SMOOTH).min(1.0);
        let Some(smooth) = &mut self.angles else {
            return;
        };
        for ((smooth, rate), new) in smooth.iter_mut().zip(&mut self.rates).zip(angles) {
            let away = new - *smooth;
            *smooth += weight * away;
            // Smoothed once more: the noise of an angle is no turning bucket.
            *rate += weight * (away / SMOOTH.max(dt) - *rate);
        }
    }

    fn posture(&self, [lift, bucket]: [f64; 2], [head, rod]: [f64; 2], sample: &Sample) -> Posture {
        Posture {
            arm: Turn::of(lift),
            bucket: Turn::of(bucket),
            head,
            rod,
            gravity: self.drawing.gravity(sample.slope.unwrap_or(0.0)),
            acceleration: self.drive.felt,
            seals: 0.0,
            rest: 0.0,
        }
    }

    fn weigh(&mut self, [lift, bucket]: [f64; 2], mut posture: Posture, sample: &Sample, dt: f64) {
        let stance = self.drawing.stance(&self.drawing.values, &posture);
        self.seals.take(stance.rod_length, dt);
        let low = self.drawing.is_low(posture.arm);
        let (pushes, driving) = (self.drive.pushes(), drives(sample));
        let mut motion = self
            .content
            .motion(self.rates, [low, pushes], sample.speed, dt);
        self.learn(&posture, &motion);
        let (drawing, values) = (&self.drawing, &self.drawing.values);
        posture.seals = self.seals.share();
        let shown = drawing.shown(values, &stance, &posture);
        // One that drives with its bucket low carries it: who levels carries next to nothing, and that is no weight.
        let rests = low && !driving;
        self.watch_steps(&shown, &motion, [rests, pushes], dt);
        if !self.drawing.carries_itself(&shown) {
            motion = self.content.put_down(&motion);
        }
        self.take(&shown, [posture.head, lift], driving, &motion, dt);
        // What swings is not known, whatever comes of it.
        motion.open |= self.scale.swings();
        posture.rest = self.scale.rest();
        let (drawing, values) = (&self.drawing, &self.drawing.values);
        let shown = Shown {
            lifting: drawing.lifted(values, shown.lever, &posture),
            ..shown
        };
        let payload = self.scale.payload();
        let empty = drawing.empty_at(values, &stance);
        let known = (!motion.open).then_some(payload);
        let moment = shown.lifting / shown.per_load;
        if !self.drive.tells_torque() && self.grading.see(known, low.then_some(bucket), moment) {
            motion = self.content.put_down(&motion);
        }
        self.doubts.see(
            &mut self.drawing,
            (&stance, &posture),
            [shown.payload(), payload.value],
            &empty,
        );
        let drawn = self.doubts.shown();
        let std = norm(&[payload.std, drawn]);
        let shown = Quantity { std, ..payload };
        // The ground may carry a low bucket.
        let hangs = !low && self.below.explains(shown);
        let capacity = self.drawing.capacity;
        let tare = self.emptied.see(payload, &motion, hangs, capacity);
        self.doubts.empty(tare);
        let row = Bucket {
            shown: payload,
            doubts: &self.doubts,
            motion: &motion,
            in_the_air: (!low).then_some(bucket),
            is_empty: tare.is_some_and(|tare| tare.at_dump),
            rests,
            capacity,
        };
        self.changed.see(&row, dt);
        if !motion.open {
            self.below.see(shown, empty.most(), rests, dt);
        }
        self.answer = Some(self.answer(&empty, &empty, payload, motion.open));
    }

    /// Steps of the moment that no content makes. `rests`: the ground may carry a part of it; `pushes`: the wheels do.
    fn watch_steps(&mut self, shown: &Shown, motion: &Motion, [rests, pushes]: [bool; 2], dt: f64) {
        let acts =
            motion.turning || pushes || self.stops.carry() && !self.moment_steps.is_stepping();
        let rows = [shown.payload(), shown.lifting / shown.per_load];
        let Quantity { value, std } = self.scale.payload();
        // What the ground carries a part of is not known.
        let is_known = !(motion.open || rests && value < -std);
        let known = is_known.then_some(value);
        if let Some(step) = self.moment_steps.see(rows, known, acts, dt) {
            self.changed.step(step, shown.empty / shown.per_load, rests);
        }
    }

    /// The payload by this row, as far as no stop and no ground carries.
    fn take(
        &mut self,
        shown: &Shown,
        [head, lift]: [f64; 2],
        driving: bool,
        motion: &Motion,
        dt: f64,
    ) {
        self.stops.see(lift);
        let drawing = &self.drawing;
        self.scale.walk(drawing, &self.seals, motion, dt);
        if self.stops.carry() {
            self.scale.stop();
            return;
        }
        let moves = motion.lifting || driving;
        if self.saturation.see(head, moves, dt) {
            return;
        }
        self.scale
            .step(drawing, shown, &self.seals, motion, self.drive.measured, dt);
        let is_low = self.stops.is_at(End::Lower, lift);
        if self.stops.is_at(End::Upper, lift) && self.scale.presses(shown, motion) {
            self.scale.stop();
            self.stops.meet(End::Upper, lift);
        } else if is_low && self.scale.swings() && self.is_less_than_nothing(shown.payload(), shown)
        {
            self.scale.stop();
            self.stops.meet(End::Lower, lift);
        } else if is_low
            && !motion.open
            && self.is_less_than_nothing(self.scale.payload().value, shown)
        {
            // Nobody saw it come to rest.
            self.scale.forget(drawing);
            self.stops.meet(End::Lower, lift);
        } else if self.scale.jumped() {
            self.scale.open(drawing);
            self.scale.dig(drawing, dt);
            self.content.touch();
        } else if motion.held {
            self.scale.dig(drawing, dt);
        }
    }

    /// The cylinders carry less than the empty arm and bucket, whatever the drawing and the seals leave open.
    fn is_less_than_nothing(&self, payload: f64, shown: &Shown) -> bool {
        let (drawing, v) = (&self.drawing, &self.drawing.values);
        let friction = self.seals.unknown() * v[FRICTION] * drawing.full_force(v);
        let seals = friction * shown.lever / shown.per_load;
        let off = self.doubts.off();
        payload - off.value < -CARRIED * norm(&[seals, off.std])
    }

    /// How probable it is that a sensor shows otherwise than it did.
    fn changed(&self) -> f64 {
        if self.angle_steps.iter().any(AngleSteps::has_stepped) {
            1.0
        } else {
            let (emptied, moved) = (self.changed.probability(), self.inertial.probability());
            if emptied > moved { emptied } else { moved }
        }
    }

    /// What the angles tell of the linkage. The payload stays the one that the pressures showed: with another lever it is another one.
    fn learn(&mut self, posture: &Posture, motion: &Motion) {
        let (Some(linkage), Some(angles)) = (&mut self.linkage, self.angles) else {
            return;
        };
        if !self.signals.measure_tilt() {
            return;
        }
        let Some(turn) = linkage.see(angles, motion.lifting && !motion.held) else {
            return;
        };
        let old = self.drawing;
        self.know(TURN, turn);
        let moments = [&old, &self.drawing].map(|d| d.moments(&d.values, posture));
        self.scale.redraw(moments);
    }

    /// A number of the drawing is known better, or otherwise.
    fn know(&mut self, number: usize, known: Quantity) {
        let (value, std) = (self.drawing.values[number], self.drawing.std[number]);
        let moved = (known.value - value) / std;
        // The effect of one that was exact is taken at its turn.
        let [by, moved] = if std > 0.0 {
            [known.std / std, moved]
        } else {
            [0.0; 2]
        };
        self.doubts.learnt(number, by, moved);
        self.drawing.set(number, known);
    }

    /// The centre of gravity with this payload, with all doubts; `moved`: the machine with its arm where it may be while more is in it.
    fn answer(&self, machine: &Empty, moved: &Empty, payload: Quantity, open: bool) -> Weighed {
        let drawing = &self.drawing;
        let centre = machine.with(payload.value);
        // No emptied bucket tells the gain of a pressure that it has not.
        let gain_left = drawing.gain_left_std * payload.value.max(0.0);
        // With a sensor that has changed it may hold anything.
        let changed = self.changed();
        let anything = sqrt(changed) * drawing.capacity;
        let std = norm(&[payload.std, gain_left, anything]);
        let more = moved.with(payload.value + std);
        let rows = [std, more.ratio - centre.ratio, more.height - centre.height];
        let shown = self
            .doubts
            .doubted(payload.value, centre, rows, self.below.factor());
        // What may have come into the bucket meanwhile is no error about what it holds.
        let widened = if open {
            shown
        } else {
            shown.not_less_than_nothing()
        };
        let mass = drawing.values[EMPTY_MASS] + widened.payload.value;
        let share = drawing.values[EMPTY_MASS] / mass;
        let (empty, Each { ratio, height }) = (self.empty(), widened.centre);
        Weighed {
            payload: shown.payload,
            ratio,
            height,
            carried: Carried {
                mass,
                loading: Loading {
                    share,
                    height: height.value - share * empty.height.0,
                    ratio: ratio.value - share * empty.ratio.0,
                },
                loading_std: [widened.moved.ratio, widened.moved.height],
                open,
            },
            undecided: self.linkage.map_or(0.0, |_| self.doubts.of_payload(TURN)),
            gain_left,
            wrong: self.below.is_wrong() || changed > DOUBTED,
            silent: false,
        }
    }
}

/// The machine drives.
fn drives(sample: &Sample) -> bool {
    sample.speed.is_some_and(|v| v.abs() > DRIVING)
}

#[cfg(test)]
mod tests;
