//! The course of a run: the plant, integrated and sampled without any sensor.

use super::front::Pose;
use super::plant::{Motion, Plant, Point};
use super::row::Truth;

/// Swing velocity below which the bucket may be in the ground [rad/s].
const STANDING: f64 = 0.03;
/// Time between the rates for the difference quotient of joint accelerations [s].
const NEAR: f64 = 1e-3;
/// The longest integration step [s].
const LONGEST_STEP: f64 = 1e-3;

/// An exact sample: error-free measurements, and the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact {
    /// Time of the sample \[s\].
    pub time: f64,
    /// The values of the channels, in the order of [`super::CHANNELS`].
    pub values: [f64; 6],
    /// True values.
    pub truth: Truth,
}

/// Exact samples of a plant. Computed once, they serve any number of seeds and faults.
#[derive(Clone, Debug)]
pub struct Course {
    plant: Plant,
    start: f64,
    rate: f64,
    /// Integration steps per sample.
    steps: u32,
    /// Index of the next sample.
    next: u64,
    /// Total number of samples.
    count: u64,
    motion: Motion,
    /// Inertia and torque at the time of the next sample.
    point: Point,
}

impl Course {
    /// The course of a plant that is at rest at `start` \[s\], sampled at `rate` \[Hz\] for `duration` \[s\], both
    /// ends included.
    pub fn new(plant: Plant, start: f64, rate: f64, duration: f64) -> Self {
        Self {
            start,
            rate,
            steps: (1.0 / (rate * LONGEST_STEP) - 1e-9).ceil().max(1.0) as u32,
            next: 0,
            // The cast saturates, so an infinite run is endless.
            count: ((duration * rate + 1e-6).floor() as u64).saturating_add(1),
            motion: Motion::default(),
            point: plant.point(start),
            plant,
        }
    }

    /// Time after `steps` integration steps from the next sample [s].
    fn time(&self, steps: f64) -> f64 {
        self.start + (self.next as f64 + steps / f64::from(self.steps)) / self.rate
    }

    fn sample(&self) -> Exact {
        let time = self.time(0.0);
        let [boom, arm, bucket] = self.plant.posture(time);
        let Motion { velocity, angle } = self.motion;
        let machine = &self.plant.machine;
        let truth = Truth {
            inertia: self.point.inertia,
            damping: machine.damping,
            friction: machine.friction,
            torque: self.point.torque,
            velocity,
            acceleration: machine.acceleration(&self.point, velocity),
            payload: self.plant.payload(time),
            digs: velocity.abs() < STANDING && self.plant.contact(time) > 0.0,
        };
        Exact {
            time,
            values: [velocity, angle, truth.torque, boom, arm, bucket],
            truth,
        }
    }

    /// Pose of the front at the time of a sample just taken.
    pub(super) fn pose(&self, exact: &Exact) -> Pose {
        let time = exact.time;
        let rates = self.plant.rate(time);
        let [before, after] = [-NEAR, NEAR].map(|step| self.plant.rate(time + step));
        let stands = exact.truth.velocity.abs() < STANDING;
        Pose {
            angles: [exact.values[3], exact.values[4], exact.values[5]],
            rates,
            accelerations: std::array::from_fn(|i| (after[i] - before[i]) / (2.0 * NEAR)),
            spin: exact.truth.velocity,
            inclination: [0.0; 2],
            payload: exact.truth.payload,
            contact: if stands {
                self.plant.contact(time)
            } else {
                0.0
            },
        }
    }

    /// Integrates to the next sample.
    fn advance(&mut self) {
        let h = 1.0 / (self.rate * f64::from(self.steps));
        for i in 0..self.steps {
            let middle = self.plant.point(self.time(f64::from(i) + 0.5));
            let end = self.plant.point(self.time(f64::from(i) + 1.0));
            self.motion = self
                .plant
                .machine
                .advance(self.motion, h, &[self.point, middle, end]);
            self.point = end;
        }
        self.next += 1;
    }
}

impl Iterator for Course {
    type Item = Exact;

    fn next(&mut self) -> Option<Exact> {
        (self.next < self.count).then(|| {
            let sample = self.sample();
            self.advance();
            sample
        })
    }
}
