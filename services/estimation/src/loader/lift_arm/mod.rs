//! Payload, mass and centre of gravity from the lift-cylinder pressures and the arm's geometry: a moment balance about the arm's pivot.
//!
//! It weighs by gravity, moving or standing. The only assumption it shares with the slip-based filter is the empty machine.
//!
//! | file | idea |
//! |---|---|
//! | this file | the order of a row: which signals it has, what is stuck, when to begin anew |
//! | `weighing`, `answer` | a row with all its signals; its answer with all deviations |
//! | `drawing`, `numbers` | the described numbers, each with its standard deviation |
//! | `common` | which of their errors all loads share, as a zero and a scale |
//! | `geometry` | moment, payload and centre of gravity in a posture |
//! | `signals` | last value of each signal, since a row need not hold all of them |
//! | `silence` | missing signals: the load may have changed since the last weight |
//! | `seals` | friction of the seals, a play operator: it depends on the rod's last direction |
//! | `grading` | a low bucket that ground or heap carries: it shows another weight than in the air |
//! | `linkage` | how far the bucket turns with the arm: where the tilt cylinder sits |
//! | `drive` | the specific force where there is no accelerometer; wheels that push |
//! | `content` | when the bucket's content may change, and when the ground carries it |
//! | `turn` | sine and cosine of an angle, computed once a row |
//! | `stops` | the ends of the arm's travel: what a stop carries is no weight |
//! | `scale` | Kalman filter of payload and residual friction |
//! | `saturation` | a pressure sensor at the end of its range |
//! | `tare` | an emptied bucket is a known weight |
//! | `below` | a payload below zero, or beyond what the rear axle balances: the errors exceed their stated deviations |
//! | `steps`, `changed` | signal steps that neither arm nor content can make, and the probability that a sensor has changed |
//! | `inertial_mass` | inertial mass of a load against its weight: a second test for a changed sensor |
//! | [`Lifts`] | the moments of a whole recording, to calibrate |
//! | `doubt` | propagation of the drawing's standard deviations to the answer, one number a row |
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
//! | t | turn of the bucket per turn of the arm, tilt cylinder held (`linkage`); a tilt cylinder on the frame carries the rest | - |
//! | r | lever of the cylinder, dl/dth (l: its length) | m |
//! | F | friction of the seals | N |
//! | g', a | g cos(slope), specific force along the body | m/s^2 |
//! | x_f | load ahead of the front axle, pivot_x + x_b | m |
//! | lam_0, h_0 | empty machine with its arm at the reference; moved, raised: effect of arm and bucket away from it | -, m |

mod answer;
mod below;
mod changed;
mod common;
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
mod weighing;

use super::input::carriage::Carriage;
use super::layout::Each;
use super::sample::Sample;
use super::settings::Settings;
use crate::Quantity;
pub(super) use answer::{Carried, Said, Weighed};
use below::Below;
use changed::Changed;
use content::Content;
use doubt::Doubts;
use drawing::Drawing;
use drive::Drive;
use geometry::{Posture, USUAL_ROD_PRESSURE};
use grading::Grading;
use inertial_mass::InertialMass;
pub use lifts::{LiftKnown, LiftMoment, Lifts};
use linkage::Linkage;
use numbers::ROD_ZERO;
use saturation::Saturation;
use scale::Scale;
use seals::Seals;
use signals::{Now, Signals};
use steps::{AngleSteps, MomentSteps};
use stops::Stops;
use tare::Emptied;
use turn::Turn;

/// Longest gap between two weighed rows [s]: after a longer one the filter restarts.
const GAP: f64 = 0.5;
/// Time after which a pressure or angle that does not change, while the machine moves, counts as stuck [s].
const STUCK: f64 = 3.0;
/// Gap after which the bucket may have been exchanged [s].
const CHANGED: f64 = 60.0;
/// Travel of the arm after which a pressure that does not change counts as stuck [rad]: more than a slow bus hides.
const LIFTED: f64 = 0.15;
/// Smoothing of the angles [s].
const SMOOTH: f64 = 0.12;
/// Speed above which the machine drives, and shakes its sensors [m/s].
const DRIVING: f64 = 0.5;

/// State of the lift-arm estimator.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LiftWitness {
    drawing: Drawing,
    /// Smoothed angles of arm and bucket to the horizontal [rad], and their rates [rad/s].
    angles: Option<[f64; 2]>,
    rates: [f64; 2],
    last_time: f64,
    /// Time of the last row that held the arm's signals, used or not [s].
    seen: f64,
    /// Last head pressure [Pa] and lift angle [rad], and how long each has been unchanged while the machine moved [s].
    held: [f64; 2],
    still: [f64; 2],
    /// Lift angle when the head pressure last changed [rad].
    lifted_from: f64,
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
    /// Estimate of the bucket turn t from the angles; none where t is stated. It learns only where the bucket's angle is measured.
    linkage: Option<Linkage>,
    doubts: Doubts,
    emptied: Emptied,
    below: Below,
    /// Step detectors of the angles of arm and bucket, and of the moment.
    angle_steps: [AngleSteps; 2],
    moment_steps: MomentSteps,
    changed: Changed,
    inertial: InertialMass,
    answer: Option<Weighed>,
}

impl LiftWitness {
    /// Returns none where no arm is described.
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
            lifted_from: 0.0,
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

    /// Prior of the payload, where no pressure has been measured yet. With it the output has a payload from the first row on.
    pub fn unknown(&self) -> Quantity {
        Scale::new(&self.drawing).payload()
    }

    /// Updates with a plausible, accepted row; a value counts until it is older than `fresh` [s]. Returns the estimate after it, none
    /// before the first weight.
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
        if self.carriage.is_odd() {
            self.answer = None;
            return None;
        }
        if self.still.iter().any(|time| *time > STUCK) {
            // The payload has followed the stuck signal.
            self.scale.forget(&self.drawing);
            return self.silent(&now, sample).map(Said::Silent);
        }
        if rod.is_some() != self.measures_rod {
            self.measures_rod = rod.is_some();
            self.know(ROD_ZERO, self.drawing.rod_zero(self.measures_rod));
        }
        let dt = sample.time - self.last_time;
        let bucket = self.drawing.bucket_angle(lift, tilt);
        let old = self.angles.filter(|_| dt > 0.0 && dt < GAP);
        if old.is_none() {
            // First row, gap, or clock that was set: the work in between is unknown, so the filter restarts.
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

    /// Compares inertial mass and weight of the load.
    fn compare_masses(&mut self) {
        let open = self.answer.is_none_or(|answer| answer.carried.open);
        let masses = [self.drive.rolling, self.drawing.capacity];
        self.inertial
            .see(self.drive.pull(), self.scale.payload(), open, masses);
    }

    /// The last answer still counts.
    fn is_fresh(&self, time: f64, fresh: f64) -> bool {
        self.answer.is_some() && (0.0..=fresh).contains(&(time - self.last_time))
    }

    /// Counts the time in which a signal is unchanged while the machine moves; a head pressure also while the arm does.
    fn watch(&mut self, now: [f64; 2], sample: &Sample, dt: f64) {
        let driving = drives(sample);
        let [head, lift] = now;
        if head != self.held[0] {
            self.lifted_from = lift;
        } else if (lift - self.lifted_from).abs() > LIFTED {
            // The lever of an arm that moves changes the pressure.
            self.still[0] = f64::INFINITY;
        }
        for ((still, held), new) in self.still.iter_mut().zip(&mut self.held).zip(now) {
            // Compared to the bit: a working sensor has noise, or a machine that shakes it.
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
            // Smoothed a second time, so that angle noise does not look like a turning bucket.
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

    /// Sets a number of the drawing, and rescales its effects on the answer.
    fn know(&mut self, number: usize, known: Quantity) {
        let (value, std) = (self.drawing.values[number], self.drawing.std[number]);
        let moved = (known.value - value) / std;
        // An exact number has no effect to rescale: the next round computes it.
        let [by, moved] = if std > 0.0 {
            [known.std / std, moved]
        } else {
            [0.0; 2]
        };
        self.doubts.learnt(number, by, moved);
        self.drawing.set(number, known);
    }
}

/// The machine drives, and shakes its sensors.
fn drives(sample: &Sample) -> bool {
    sample.speed.is_some_and(|v| v.abs() > DRIVING)
}

#[cfg(test)]
mod tests;
