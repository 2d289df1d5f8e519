//! Whether a load moves as it weighs: its inertial mass, by the force of the wheels over the acceleration, against its weight by the pressures.
//!
//! ```text
//! a = kappa u - c sgn(v) + z,   u = F/M_0              each row in which the wheels drive; kappa is another one with each load
//! y = ln(kappa (M_0 + m_p)/M_0) = A + B x + e,   x = m_p/(M_0 + m_p)               each load, and each emptied bucket
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | a, F, v | `row` | specific force, force of the wheels, speed, smoothed alike | m/s^2, N, m/s |
//! | M_0 | `rolling` | mass of the empty machine, and what its wheels turn | kg |
//! | kappa | `motion` | M_0 over the mass that rolls, times true over stated torque | 1 |
//! | c, z | `motion` | what resists, and zero of the accelerometer: of ground and sensor, the next load finds them as they were | m/s^2 |
//! | m_p | `weighed` | payload by the pressures | kg |
//! | A, B | `Line` | gain of torques, tyres and mass; what goes with a load: drawing, pressures, tyres that give way | 1 |
//!
//! No description is as good as A and B are known after some loads. A pressure sensor or an angle that shows otherwise than it did moves the
//! next loads off the line, and an emptied bucket less; a torque, a tyre or the accelerometer moves all alike. Three lines go on from load to
//! load, one where all is as it was and one for each of these; Bayes' rule weighs them (an interacting multiple model; Blom, Bar-Shalom 1988):
//! ```text
//! since the last load:   o += T/T_c,   and the line takes over as much of the first one, opened by a change
//! load:                  o *= [(1 - p) N(y; changed) + p/R]/[(1 - p) N(y; same) + p/R]
//! ```
//! with o the odds of a change, T_c the time between two of them, and p the share of loads that move as nobody foretells, anywhere in R.
//! A drive that has changed more probably than not is the one that the next loads are compared with.

use crate::Quantity;
use crate::linear::{Measurement, diagonal, dot};
use crate::math::{exp, ln, sqrt};
use crate::mixture::mix;
use crate::repeats::{BETWEEN_CHANGES, Repeats};

/// One row in so long is taken: closer ones are smoothed over the same time [s].
const EVERY: f64 = 0.15;
/// Noise of such a row: roads, tyres and a load that heaves [m/s^2].
const NOISE: f64 = 0.05;
/// Slower than this, stiction and the ground act [m/s].
const LEAST_SPEED: f64 = 0.5;
/// An innovation beyond this is a bad row or a force, no load [m/s^2].
const LARGEST: f64 = 0.4;
/// kappa of any load, a usual rolling resistance, no zero, and their standard deviations [1, m/s^2, m/s^2].
const START: [f64; 3] = [0.9, 0.2, 0.0];
const START_STD: [f64; 3] = [0.15, 0.1, 0.06];
/// Random walk of c and z [m/s^2/s^.5].
const WALK: f64 = 0.01;
/// A load tells once kappa is known so well; one that is put down before, where it is known half as well.
const SHARP: f64 = 0.01;
/// What rows may leave open of the weight, as a share of the capacity.
const WEIGHED: f64 = 0.05;
/// Standard deviations of A and B before the first load: torques within a tenth; B is -.49 to .24 on eight machines of others.
const LINE_STD: [f64; 2] = [0.1, 0.3];
/// Random walk of A and B from load to load: tyres and oil warm up, the ground is another one.
const LINE_WALK: [f64; 2] = [0.002, 0.005];
/// What a change does to A and B, standard deviations: a third of the weight, with a zero of a hundredth of the machine, by the arm's sensors; an
/// eighth of the force by the drive's.
const CHANGES: [[f64; 2]; 2] = [[0.01, 0.3], [0.12, 0.0]];
const ARM: usize = 0;
const DRIVE: usize = 1;
/// What a load leaves unexplained beside rows and kappa, until loads have shown it themselves: .005 to .04 on those machines.
const SCATTER: f64 = 0.012;
/// Loads that move as nobody foretells, as a share, and how far: a wheel that slips, a brake that drags, a bucket that pushes.
const ODD: f64 = 0.03;
const RANGE: f64 = 0.3;
/// Beyond so many deviations a load says no more of the scatter, and beyond so many nothing of the line.
const FAR: f64 = 2.0;
const OTHER: f64 = 3.0;
/// What is less probable an interval may leave out: a tenth of what one of 95 % does.
const EXCLUDED: f64 = 0.005;
/// Odds beyond which nothing is more certain: sensors are mended.
const MOST: f64 = 100.0;

/// A and B.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Line {
    state: [f64; 2],
    covariance: [[f64; 2]; 2],
}

impl Line {
    const NEW: Self = Self {
        state: [0.0; 2],
        covariance: diagonal(LINE_STD),
    };

    /// A measurement of it, and how likely that was, odd ones left out.
    fn foretells(&self, by: &[f64; 2], y: f64, noise: f64) -> (Measurement<2>, f64) {
        let told = Measurement::of(&self.covariance, by, y - dot(&self.state, by), noise);
        let square = told.innovation * told.innovation / told.variance;
        let density = exp(-0.5 * square) / (2.5 * sqrt(told.variance));
        (told, (1.0 - ODD) * density)
    }

    /// Takes a measurement that is its own with this probability.
    fn take(&mut self, told: &Measurement<2>, probability: f64) {
        let mut taken = *self;
        told.take(&mut taken.state, &mut taken.covariance);
        self.mix(&taken, probability);
    }

    /// Becomes the other one with this probability.
    fn mix(&mut self, other: &Self, probability: f64) {
        let other = (&other.state, &other.covariance);
        mix(&mut self.state, &mut self.covariance, other, probability);
    }

    fn open(&mut self, stds: [f64; 2]) {
        for (i, std) in stds.into_iter().enumerate() {
            self.covariance[i][i] += std * std;
        }
    }
}

/// Memory of loads, of the ground and of the sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct InertialMass {
    /// kappa of this load, c and z.
    motion: [f64; 3],
    covariance: [[f64; 3]; 3],
    /// Time until a row is taken, and since the last load that told [s].
    wait: f64,
    since: f64,
    /// Weight of this load, as sharp as rows have shown it [kg].
    weighed: Option<Quantity>,
    /// This load has told.
    told: bool,
    same: Line,
    /// With the arm's sensors changed, and with those of the drive.
    changed: [Hypothesis; 2],
    scatter: Repeats,
    /// Probability that the arm's have: asked in each row, another one with each load.
    probability: f64,
}

/// A line after a change, and the odds of that.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Hypothesis {
    line: Line,
    odds: f64,
}

impl Hypothesis {
    const NEW: Self = Self {
        line: Line::NEW,
        odds: 0.0,
    };

    /// It may have come since the last load, as a change of `same`, with this probability.
    fn may_come(&mut self, same: &Line, change: [f64; 2], probability: f64) {
        let mut anew = *same;
        anew.open(change);
        self.line.open(LINE_WALK);
        self.odds += probability;
        self.line.mix(&anew, (probability / self.odds).min(1.0));
    }
}

impl Default for InertialMass {
    fn default() -> Self {
        Self {
            motion: START,
            covariance: diagonal(START_STD),
            wait: 0.0,
            since: 0.0,
            weighed: None,
            told: false,
            same: Line::NEW,
            changed: [Hypothesis::NEW; 2],
            scatter: Repeats::default(),
            probability: 0.0,
        }
    }
}

impl InertialMass {
    /// Time passes; whether a row is taken.
    pub fn is_due(&mut self, dt: f64) -> bool {
        self.wait -= dt;
        self.wait <= 0.0
    }

    /// Takes a row: specific force, force over `rolling` [m/s^2] and speed [m/s], and what rows show of the payload. `open`: the content
    /// may be changing.
    #[cold]
    #[inline(never)]
    pub fn see(
        &mut self,
        row: [f64; 3],
        shown: Quantity,
        open: bool,
        [rolling, capacity]: [f64; 2],
    ) {
        let passed = EVERY - self.wait;
        self.since += passed;
        self.wait = EVERY;
        if open {
            self.put_down(rolling);
        } else if !self.told {
            let sharper = self.weighed.is_none_or(|last| shown.std < last.std);
            if sharper && shown.std < WEIGHED * capacity {
                self.weighed = Some(shown);
            }
            self.pull(row, passed);
            self.tell(SHARP, rolling);
        }
    }

    /// A row in which the wheels drive.
    fn pull(&mut self, [a, u, v]: [f64; 3], passed: f64) {
        if v.abs() < LEAST_SPEED || u * v <= 0.0 {
            return;
        }
        for i in 1..3 {
            self.covariance[i][i] += WALK * WALK * passed;
        }
        let by = [u, -1.0_f64.copysign(v), 1.0];
        let innovation = a - dot(&self.motion, &by);
        if innovation.abs() < LARGEST {
            let told = Measurement::of(&self.covariance, &by, innovation, NOISE * NOISE);
            told.take(&mut self.motion, &mut self.covariance);
        }
    }

    /// The content may be another one from now on.
    fn put_down(&mut self, rolling: f64) {
        if !self.told {
            self.tell(2.0 * SHARP, rolling);
        }
        (self.weighed, self.told) = (None, false);
        self.motion[0] = START[0];
        for i in 1..3 {
            (self.covariance[0][i], self.covariance[i][0]) = (0.0, 0.0);
        }
        self.covariance[0][0] = START_STD[0] * START_STD[0];
    }

    /// What this load tells, once kappa is known so well.
    fn tell(&mut self, sharp: f64, rolling: f64) {
        let (kappa, std) = (self.motion[0], sqrt(self.covariance[0][0]));
        let Some(weighed) = self.weighed.filter(|_| std < sharp * kappa) else {
            return;
        };
        self.told = true;
        let mass = rolling + weighed.value;
        let (own, rows) = (std / kappa, weighed.std / mass);
        let noise = self.scatter.ratio() * (SCATTER * SCATTER + own * own + rows * rows);
        self.load(weighed.value / mass, ln(kappa * mass / rolling), noise);
    }

    /// A load at x has shown this y.
    fn load(&mut self, x: f64, y: f64, noise: f64) {
        let by = [1.0, x];
        let odd = ODD / RANGE;
        let may_change = core::mem::take(&mut self.since) / BETWEEN_CHANGES;
        self.same.open(LINE_WALK);
        let (same, own) = self.same.foretells(&by, y, noise);
        for (changed, change) in self.changed.iter_mut().zip(CHANGES) {
            changed.may_come(&self.same, change, may_change);
            let (told, likely) = changed.line.foretells(&by, y, noise);
            changed.line.take(&told, likely / (likely + odd));
            changed.odds *= (likely + odd) / (own + odd);
        }
        if !self.sum().is_finite() {
            *self = Self::default();
            return;
        }
        let certain = (self.sum() / MOST).max(1.0);
        self.changed.iter_mut().for_each(|c| c.odds /= certain);
        // One far away may be of a change.
        let z = same.innovation / sqrt(same.variance);
        let near = z.clamp(-FAR, FAR);
        self.scatter.see(near * sqrt(self.scatter.ratio()), true);
        if z.abs() < OTHER {
            self.same.take(&same, own / (self.sum() * (own + odd)));
        }
        let drive = self.changed[DRIVE];
        if drive.odds > 1.0 + self.changed[ARM].odds {
            self.same = drive.line;
            self.changed[DRIVE] = Hypothesis::NEW;
            let arm = &mut self.changed[ARM];
            arm.odds /= drive.odds;
            arm.line = self.same;
            arm.line.open(CHANGES[ARM]);
        }
        let probability = self.changed[ARM].odds / self.sum();
        self.probability = if probability < EXCLUDED {
            0.0
        } else {
            probability
        };
    }

    /// Of the odds of all.
    fn sum(&self) -> f64 {
        1.0 + self.changed[ARM].odds + self.changed[DRIVE].odds
    }

    /// Probability that a sensor of the arm shows otherwise than it did; 0 where an interval may leave it out.
    pub fn probability(&self) -> f64 {
        self.probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROLLING: f64 = 5000.0;
    const CAPACITY: f64 = 1500.0;
    /// Payload that the cylinders carry as arm and bucket [kg].
    const ARM_WEIGHS: f64 = 300.0;

    /// A machine: gains of pressures and torques, and what it stands on.
    #[derive(Clone, Copy)]
    struct Machine {
        pressure: f64,
        torque: f64,
        rolling: f64,
    }

    const SOUND: Machine = Machine {
        pressure: 1.0,
        torque: 1.03,
        rolling: 0.25,
    };

    impl Machine {
        /// Drives to and fro with this payload, and puts it down.
        fn carries(self, inertial: &mut InertialMass, payload: f64) {
            let shown = Quantity {
                value: self.pressure * (payload + ARM_WEIGHS) - ARM_WEIGHS,
                std: 30.0,
            };
            for k in 0..1300 {
                let (t, direction) = (0.01 * f64::from(k % 600), if k < 600 { 1.0 } else { -1.0 });
                let (a, v) = if t < 1.0 { (2.2, 2.2 * t) } else { (0.0, 2.2) };
                let by_road = 0.03 * (0.37 * f64::from(k)).sin();
                let [a, v, resists] = [a, v, self.rolling].map(|x| direction * x);
                let u = self.torque * (a + resists) * (ROLLING + payload) / ROLLING;
                let open = k >= 1200;
                if inertial.is_due(0.01) {
                    inertial.see([a + by_road, u, v], shown, open, [ROLLING, CAPACITY]);
                }
            }
        }

        /// The same for so many loads, an emptied bucket after each; after how many a sensor of the arm is doubted, and how many are.
        fn works(self, inertial: &mut InertialMass, loads: u32) -> (Option<u32>, u32) {
            let mut doubted = (None, 0);
            for load in 0..loads {
                for payload in [900.0 + 100.0 * f64::from(load % 4), 20.0] {
                    self.carries(inertial, payload);
                }
                if inertial.probability() > 0.05 {
                    doubted = (doubted.0.or(Some(load + 1)), doubted.1 + 1);
                }
            }
            doubted
        }
    }

    #[test]
    fn a_sound_machine_moves_as_it_weighs_on_any_ground() {
        let mut inertial = InertialMass::default();
        assert_eq!(SOUND.works(&mut inertial, 20), (None, 0));
        assert_eq!(inertial.probability(), 0.0);
        let soft = Machine {
            rolling: 0.6,
            ..SOUND
        };
        assert_eq!(soft.works(&mut inertial, 20), (None, 0));
        // What is stated is off, and stays so.
        let mut inertial = InertialMass::default();
        let misdescribed = Machine {
            pressure: 1.1,
            torque: 0.93,
            ..SOUND
        };
        assert_eq!(misdescribed.works(&mut inertial, 20), (None, 0));
    }

    #[test]
    fn pressures_that_change_their_gain_are_found_the_sooner_the_more() {
        for (pressure, most) in [(0.75, 2), (0.8, 3), (0.87, 6), (1.15, 6), (1.25, 2)] {
            let mut inertial = InertialMass::default();
            SOUND.works(&mut inertial, 20);
            let changed = Machine { pressure, ..SOUND };
            let (found, _) = changed.works(&mut inertial, 10);
            assert!(
                found.is_some_and(|load| load <= most),
                "{pressure}: {found:?}"
            );
            assert!(inertial.probability() > 0.05, "{pressure}: it stays");
        }
    }

    #[test]
    fn torques_that_change_are_no_sensor_of_the_arm() {
        for torque in [0.85, 0.97, 1.1, 1.2] {
            let mut inertial = InertialMass::default();
            SOUND.works(&mut inertial, 6);
            let changed = Machine { torque, ..SOUND };
            let (_, doubted) = changed.works(&mut inertial, 10);
            assert!(doubted <= 3, "{torque}: {doubted}");
            assert_eq!(inertial.probability(), 0.0, "{torque}");
        }
    }

    #[test]
    fn rows_without_a_drive_or_without_numbers_tell_nothing() {
        for torque in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut inertial = InertialMass::default();
            Machine { torque, ..SOUND }.works(&mut inertial, 3);
            assert_eq!(inertial.same, Line::NEW, "{torque}");
        }
    }
}
