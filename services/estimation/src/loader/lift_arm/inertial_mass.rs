//! Consistency of a load's inertial mass, from wheel force and acceleration, with its weight by the pressures: detects a changed sensor.
//!
//! ```text
//! a = kappa u - c sgn(v) + z,   u = F/M_0              each row in which the wheels drive; kappa restarts with each load
//! y = ln(kappa (M_0 + m_p)/M_0) = A + B x + e,   x = m_p/(M_0 + m_p)               each load, and each emptied bucket
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | a, F, v | `row` | specific force, force of the wheels, speed, with equal smoothing | m/s^2, N, m/s |
//! | M_0 | `rolling` | mass of the empty machine, with the equivalent mass of its wheels | kg |
//! | kappa | `motion` | M_0 over the loaded mass, times true over stated torque | 1 |
//! | c, z | `motion` | resistance, zero of the accelerometer: of ground and sensor, retained from load to load | m/s^2 |
//! | m_p | `weighed` | payload by the pressures | kg |
//! | A, B | `Line` | log gain of torques, tyres and mass; error proportional to the load: drawing, pressures, tyre deflection | 1 |
//!
//! After some loads A and B are known better than any machine file states them. A changed pressure sensor or angle moves loads off the
//! line, and emptied buckets less. A changed torque, tyre or accelerometer moves both equally. Three hypotheses have a line each: no change,
//! arm sensor changed, drive changed. Bayes' rule weights them (an interacting multiple model; Blom, Bar-Shalom 1988):
//! ```text
//! since the last load:   o += T/T_c,   and the line mixes with the unchanged one, widened by a change, by that share of o
//! load:                  o *= [(1 - p) t(y; changed) + p/R]/[(1 - p) t(y; same) + p/R]
//! ```
//! with o the odds of a change, T_c the mean time between two changes, and p the share of outlier loads, uniform over a range R. t is
//! Student's density: the scatter between loads is estimated from few of them, with as many degrees of freedom.
//! Where a changed drive is more probable than the other two together, its line becomes the unchanged one.

use crate::Quantity;
use crate::linear::{Measurement, diagonal, dot};
use crate::math::{exp, ln, sqrt};
use crate::mixture::mix;
use crate::repeats::{BETWEEN_CHANGES, Repeats};

/// Period of the rows used [s]: closer rows share the smoothing.
const EVERY: f64 = 0.15;
/// Standard deviation of such a row [m/s^2]: roads, tyres, a heaving load.
const NOISE: f64 = 0.05;
/// Least speed of a row [m/s]: below it stiction and the ground act.
const LEAST_SPEED: f64 = 0.5;
/// Gate of the innovation [m/s^2]: a larger one is a bad row or an external force.
const LARGEST: f64 = 0.4;
/// Prior of kappa, c and z, with standard deviations [1, m/s^2, m/s^2]: kappa of any load, a usual rolling resistance, no zero.
const START: [f64; 3] = [0.9, 0.2, 0.0];
const START_STD: [f64; 3] = [0.15, 0.1, 0.06];
/// Random walk of c and z [m/s^2/s^.5].
const WALK: f64 = 0.01;
/// Relative standard deviation of kappa at which a load is evaluated. A load put down before that is evaluated up to twice this value.
const SHARP: f64 = 0.01;
/// Largest standard deviation of a weight that is used, as a share of the capacity.
const WEIGHED: f64 = 0.05;
/// Prior standard deviations of A and B: torques within a tenth; B is -.49 to .24 on eight independently simulated machines.
const LINE_STD: [f64; 2] = [0.1, 0.3];
/// Random walk of A and B per load: tyres and oil warm up, the ground changes.
const LINE_WALK: [f64; 2] = [0.002, 0.005];
/// Standard deviations of a change of A and B. Sensors of the arm: a third of the weight, with a zero of a hundredth of the machine. Drive:
/// an eighth of the force.
const CHANGES: [[f64; 2]; 2] = [[0.01, 0.3], [0.12, 0.0]];
const ARM: usize = 0;
const DRIVE: usize = 1;
/// Prior scatter of y between loads, beyond that of weight and kappa: .005 to .04 on those machines. Loads rescale it (`scatter`).
const SCATTER: f64 = 0.012;
/// Share of outlier loads, and their range in y: a slipping wheel, a dragging brake, a pushing bucket.
const ODD: f64 = 0.03;
const RANGE: f64 = 0.3;
/// Standard deviations at which a residual is clipped for the scatter, and beyond which it does not update the unchanged line.
const FAR: f64 = 2.0;
const OTHER: f64 = 3.0;
/// Probability below which a change is neglected: a tenth of what a 95 % interval leaves out.
const EXCLUDED: f64 = 0.005;
/// Largest sum of the odds: sensors are repaired, so a hypothesis must be able to return.
const MOST: f64 = 100.0;

/// Estimate of A and B, with covariance.
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

    /// Returns a measurement of the line, and its likelihood times the share of loads that are no outliers. `noise`: its variance, and the
    /// degrees of freedom by which that is known.
    fn predict(&self, by: &[f64; 2], y: f64, noise: [f64; 2]) -> (Measurement<2>, f64) {
        let [noise, degrees] = noise;
        let found = Measurement::of(&self.covariance, by, y - dot(&self.state, by), noise);
        let square = found.innovation * found.innovation / found.variance;
        let tail = -0.5 * (degrees + 1.0) * ln(1.0 + square / degrees);
        let density = exp(tail) / (2.5 * sqrt(found.variance));
        (found, (1.0 - ODD) * density)
    }

    /// Updates with a measurement that belongs to this line with this probability.
    fn take(&mut self, found: &Measurement<2>, probability: f64) {
        let mut taken = *self;
        found.take(&mut taken.state, &mut taken.covariance);
        self.mix(&taken, probability);
    }

    /// Becomes the mixture with another line of this probability.
    fn mix(&mut self, other: &Self, probability: f64) {
        let other = (&other.state, &other.covariance);
        mix(&mut self.state, &mut self.covariance, other, probability);
    }

    /// Adds these standard deviations, as squares.
    fn open(&mut self, stds: [f64; 2]) {
        for (i, std) in stds.into_iter().enumerate() {
            self.covariance[i][i] += std * std;
        }
    }
}

/// State of the consistency test.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct InertialMass {
    /// kappa of this load, c and z.
    motion: [f64; 3],
    covariance: [[f64; 3]; 3],
    /// Time until the next row is used, and since the last load that was evaluated [s].
    wait: f64,
    since: f64,
    /// Weight of this load, with the least standard deviation so far [kg].
    weighed: Option<Quantity>,
    /// This load has been evaluated.
    told: bool,
    /// Line of an unchanged machine.
    same: Line,
    /// Lines and odds of a changed sensor of the arm, and of a changed drive.
    changed: [Hypothesis; 2],
    /// Ratio of the scatter observed to that claimed.
    scatter: Repeats,
    /// Probability of a changed sensor of the arm: read in each row, updated with each load.
    probability: f64,
}

/// Line after a change, and the odds of that change against none.
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

    /// Predicts: a change of `same` may have happened since the last load, with this probability.
    fn may_come(&mut self, same: &Line, change: [f64; 2], probability: f64) {
        let mut widened = *same;
        widened.open(change);
        self.line.open(LINE_WALK);
        self.odds += probability;
        self.line.mix(&widened, (probability / self.odds).min(1.0));
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
    /// Advances the time; true where the next row is due.
    pub fn is_due(&mut self, dt: f64) -> bool {
        self.wait -= dt;
        self.wait <= 0.0
    }

    /// Updates with a row: specific force, force over `rolling` [m/s^2], speed [m/s], and the weighed payload [kg]. `open`: the content
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
            self.evaluate(SHARP, rolling);
        }
    }

    /// Updates kappa, c and z with a row in which the wheels drive.
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
            let found = Measurement::of(&self.covariance, &by, innovation, NOISE * NOISE);
            found.take(&mut self.motion, &mut self.covariance);
        }
    }

    /// Ends a load: the content may change from now on, so kappa restarts from its prior.
    fn put_down(&mut self, rolling: f64) {
        if !self.told {
            self.evaluate(2.0 * SHARP, rolling);
        }
        (self.weighed, self.told) = (None, false);
        self.motion[0] = START[0];
        for i in 1..3 {
            (self.covariance[0][i], self.covariance[i][0]) = (0.0, 0.0);
        }
        self.covariance[0][0] = START_STD[0] * START_STD[0];
    }

    /// Evaluates this load once kappa is known to the relative deviation `sharp`.
    fn evaluate(&mut self, sharp: f64, rolling: f64) {
        let (kappa, std) = (self.motion[0], sqrt(self.covariance[0][0]));
        let Some(weighed) = self.weighed.filter(|_| std < sharp * kappa) else {
            return;
        };
        self.told = true;
        let mass = rolling + weighed.value;
        let (own, rows) = (std / kappa, weighed.std / mass);
        let noise = self.scatter.ratio() * (SCATTER * SCATTER + own * own + rows * rows);
        let noise = [noise, self.scatter.degrees()];
        self.load(weighed.value / mass, ln(kappa * mass / rolling), noise);
    }

    /// Updates lines and odds with the measurement (x, y) of a load.
    fn load(&mut self, x: f64, y: f64, noise: [f64; 2]) {
        let by = [1.0, x];
        let odd = ODD / RANGE;
        let may_change = core::mem::take(&mut self.since) / BETWEEN_CHANGES;
        self.same.open(LINE_WALK);
        let (same, own) = self.same.predict(&by, y, noise);
        for (changed, change) in self.changed.iter_mut().zip(CHANGES) {
            changed.may_come(&self.same, change, may_change);
            let (found, likely) = changed.line.predict(&by, y, noise);
            changed.line.take(&found, likely / (likely + odd));
            changed.odds *= (likely + odd) / (own + odd);
        }
        if !self.sum().is_finite() {
            *self = Self::default();
            return;
        }
        let certain = (self.sum() / MOST).max(1.0);
        self.changed.iter_mut().for_each(|c| c.odds /= certain);
        // A large residual may be due to a change: it is clipped for the scatter, or not used for the line.
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

    /// Sum of the odds, that of an unchanged machine being 1.
    fn sum(&self) -> f64 {
        1.0 + self.changed[ARM].odds + self.changed[DRIVE].odds
    }

    /// Probability that a sensor of the arm has changed; 0 where it is negligible.
    pub fn probability(&self) -> f64 {
        self.probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROLLING: f64 = 5000.0;
    const CAPACITY: f64 = 1500.0;
    /// Weight of arm and bucket at the cylinders, as a payload [kg].
    const ARM_WEIGHS: f64 = 300.0;

    /// A machine: gains of pressures and torques, and its rolling resistance [m/s^2].
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
        /// Drives forward and back with this payload, and puts it down.
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

        /// The same for a number of loads, each followed by an emptied bucket. Returns the first load after which a changed sensor of the
        /// arm is probable, and the number of such loads.
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
        // The machine file is wrong, and stays so.
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
            // A sixth is found, and fades again: loads scatter by as much.
            let stays = inertial.probability() > 0.05;
            assert!(stays || pressure == 1.15, "{pressure}: it stays");
        }
    }

    #[test]
    fn of_few_loads_that_agree_the_scatter_is_not_known() {
        let odd = |loads: u32| {
            let mut inertial = InertialMass::default();
            let mut load = |x: f64, y: f64| {
                let scatter = inertial.scatter;
                inertial.since = 60.0;
                inertial.load(x, y, [scatter.ratio() * 1.5e-4, scatter.degrees()]);
                inertial.probability()
            };
            for k in 0..loads {
                let y = if k % 4 < 2 { 0.004 } else { -0.004 };
                load(if k % 2 == 0 { 0.0 } else { 0.17 }, y);
            }
            load(0.17, 0.03)
        };
        assert!(odd(6) < 0.05 && odd(30) > 0.05, "{} {}", odd(6), odd(30));
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
    fn rows_without_a_drive_or_without_numbers_carry_no_information() {
        for torque in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut inertial = InertialMass::default();
            Machine { torque, ..SOUND }.works(&mut inertial, 3);
            assert_eq!(inertial.same, Line::NEW, "{torque}");
        }
    }
}
