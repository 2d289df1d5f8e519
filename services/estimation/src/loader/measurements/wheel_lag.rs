//! Lag tau of the rear axle's wheel speed behind that of the front axle.
//!
//! Two controllers send the wheel speeds, each in frames of its own. While the machine accelerates by a, a lag tau looks like slip:
//! at 2 m/s a millisecond is 4 % of the ratio. Slip grows with the speed, and a lag does not, so a regression distinguishes them:
//! ```text
//! y = r (w_f - w_r) = x' theta + e,   x = [v, |v| f_f/lam, -|v| f_r/(1 - lam), v a, a],   means over a block of 0.2 s
//! ```
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | f_i | - | force of an axle over the weight of the machine, T_i/(r m g) | 1 |
//! | lam | `share` | share of the weight in front, with the load: a load changes the slip per pull | 1 |
//! | theta | `state` | unequal radii; slip per pull over the axle's weight, 1/K of each axle; radii under load; tau | 1, 1, 1, s/m, s |
//! | P | `covariance` | of theta, a random walk | |
//! | chi | `scatter` | mean of the squared normalised residuals | 1 |
//!
//! A turn makes the slips unequal with some standard deviation, and adds v times that to e. Residuals are correlated
//! for 0.3 s, so the variance of tau is s^2 = P chi 0.3/0.2.
//!
//! Most machines send both speeds in one frame: tau = 0. On the others each frame is up to 10 ms old, so the lag has a triangular
//! density. The result is the mixture of both ([`crate::mixture`]), with the probability p of separate frames:
//! ```text
//! p/(1 - p) = P/(1 - P) d(tau)/N(tau; 0, s^2),   d = max(1 - |tau|/LONGEST, 0.1)/LONGEST,   P = 0.1
//! ```
//! On eight sound loaders of an independent simulator without lift pressures, this costs .005 of trust. With the rear speed shifted
//! by -3 to 10 ms, trusted rows are wrong for .03 of the time at most. Without it they are wrong for .27 to 1.0.

use core::f64::consts::{SQRT_2, TAU};

use crate::Quantity;
use crate::linear::{Measurement, dot};
use crate::loader::measurements::windup::LEAST_SHARE;
use crate::loader::physics::wheel_dynamics::WheelDynamics;
use crate::math::{exp, norm, sqrt};
use crate::mixture::spread;

/// Duration of a block [s]: shorter than a pull, longer than the noise of a wheel speed.
const BLOCK: f64 = 0.2;
/// Correlation time of the residuals [s]: slips fluctuate, and a machine pitches.
const CORRELATION_TIME: f64 = 0.3;
/// Standard deviation of the mean of a block [m/s]: 1.1 to 2.2 mm/s on thirteen machines of an independent simulator.
const NOISE: f64 = 0.002;
/// Least mean of the squared normalised residuals: blocks of a time shorter than [`MEMORY`] do not support less.
const LEAST_SCATTER: f64 = 0.3;
/// Limit of a squared normalised residual. Beyond it the variance of the block grows in proportion: wheels spin.
const OUTLIER: f64 = 4.0;
/// Averaging time of the residuals [s].
const MEMORY: f64 = 20.0;
/// Prior standard deviation of the difference of the radii by the load that an acceleration moves: at most .4 % for 1 m/s2 [s2/m].
const RADII_BY_LOAD: f64 = 0.004;
/// Random walk of theta in a minute: a load changes slips by a fifth, clocks differ by 20 parts in a million.
const WALK: [f64; 5] = [0.001, 0.01, 0.01, 0.001, 0.001];
/// Share of machines that send the speeds of their axles in frames of two controllers.
const APART: f64 = 0.1;
/// Largest lag between frames of two controllers [s]: each is up to 10 ms old.
const LONGEST: f64 = 0.01;
/// Density of a lag at that limit, as a share of the density at 0: the lag is measured to a millisecond.
const LEAST_DENSITY: f64 = 0.1;
/// Speed below which wheel speeds carry no information [m/s].
const SLOWEST: f64 = 0.5;

/// One row of the regression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Speed after and before the row [m/s].
    pub speeds: [f64; 2],
    /// Wheel speed of the front axle less that of the rear one [rad/s].
    pub difference: f64,
    /// Standard deviation of the slips from steering.
    pub turn: f64,
    /// Torques of the axles [N m].
    pub torques: [f64; 2],
    /// Share of the weight in front.
    pub share: f64,
}

/// Sums over the present block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Block {
    time: f64,
    rows: f64,
    /// Largest standard deviation of the slips from steering.
    turn: f64,
    /// Speed at its start [m/s].
    start: f64,
    /// Sums of w_f - w_r, of the speed, and of the torques over the shares of the weight.
    sums: [f64; 4],
}

/// Regression and mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelLag {
    block: Block,
    state: [f64; 5],
    covariance: [[f64; 5]; 5],
    scatter: f64,
    lag: Quantity,
}

impl WheelLag {
    /// Prior for a machine of this slip stiffness and ratio, with rolling radii known to `radius_std`.
    pub fn new(stiffness: Quantity, ratio: Quantity, radius_std: f64) -> Self {
        let shares = [ratio.value, 1.0 - ratio.value];
        let slip = 1.0 / stiffness.value;
        let relative = |share| norm(&[stiffness.std / stiffness.value, ratio.std / share]);
        let [front_std, rear_std] = shares.map(relative);
        let std = [
            SQRT_2 * radius_std,
            slip * front_std,
            slip * rear_std,
            RADII_BY_LOAD,
            LONGEST / sqrt(6.0),
        ];
        let mut lag = Self {
            block: Block::default(),
            state: [0.0, slip, slip, 0.0, 0.0],
            covariance: [[0.0; 5]; 5],
            scatter: 1.0,
            lag: Quantity {
                value: 0.0,
                std: 0.0,
            },
        };
        for (i, std) in std.into_iter().enumerate() {
            lag.covariance[i][i] = std * std;
        }
        lag.weigh();
        lag
    }

    /// Lag of the rear wheel speed behind the front one, with its deviation [s].
    pub fn lag(&self) -> Quantity {
        self.lag
    }

    /// Restarts the block at a row in which the wheels do not count.
    pub fn interrupt(&mut self) {
        self.block.time = 0.0;
    }

    /// Adds a row in which both wheels count, `dt` after the last.
    pub fn see(&mut self, machine: &WheelDynamics, row: &Row, dt: f64) {
        let [speed, before] = row.speeds;
        let block = &mut self.block;
        if block.time == 0.0 {
            *block = Block {
                start: before,
                ..Block::default()
            };
        }
        let [front, rear] = row.torques;
        let share = row.share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
        let [front, rear] = [front / share, -rear / (1.0 - share)];
        let adds = [row.difference, speed, front, rear];
        for (sum, adds) in block.sums.iter_mut().zip(adds) {
            *sum += adds;
        }
        block.rows += 1.0;
        block.turn = block.turn.max(row.turn);
        block.time += dt;
        // The nearest row ends the block, whatever the rounding.
        if block.time >= BLOCK - 0.5 * dt {
            self.absorb(machine, speed);
            self.block.time = 0.0;
        }
    }

    /// Updates the regression with the block that ends at speed `end`.
    fn absorb(&mut self, machine: &WheelDynamics, end: f64) {
        let block = &self.block;
        let [difference, speed, front, rear] = block.sums.map(|sum| sum / block.rows);
        let y = machine.wheel_radius * difference;
        let drawn = speed.abs() / (machine.wheel_radius * machine.mass * machine.gravity);
        if speed.abs() < SLOWEST {
            return;
        }
        let acceleration = (end - block.start) / block.time;
        let x = [
            speed,
            drawn * front,
            drawn * rear,
            speed * acceleration,
            acceleration,
        ];
        for (i, walk) in WALK.into_iter().enumerate() {
            self.covariance[i][i] += walk * walk / 60.0 * block.time;
        }
        let by_turn = block.turn * speed;
        let noise = NOISE * NOISE + by_turn * by_turn;
        let residual = y - dot(&self.state, &x);
        let mut measured = Measurement::of(&self.covariance, &x, residual, noise);
        let squared = residual * residual / measured.variance;
        if !squared.is_finite() {
            return;
        }
        let over = (squared / OUTLIER).max(1.0);
        measured.variance *= over;
        measured.take(&mut self.state, &mut self.covariance);
        self.scatter += BLOCK / MEMORY * (squared / over - self.scatter);
        self.weigh();
    }

    /// Computes the mixture of one frame and of two.
    fn weigh(&mut self) {
        let tau = self.state[4];
        let own =
            self.covariance[4][4] * self.scatter.max(LEAST_SCATTER) * (CORRELATION_TIME / BLOCK);
        let variance = own.min(LONGEST * LONGEST / 6.0);
        let together = exp(-0.5 * tau * tau / variance) / sqrt(TAU * variance);
        let density = (1.0 - tau.abs() / LONGEST).max(LEAST_DENSITY) / LONGEST;
        let apart = APART / (1.0 - APART) * density;
        let probability = apart / (apart + together);
        let value = probability * tau;
        let apart = spread(probability, tau - value, sqrt(variance));
        let together = spread(1.0 - probability, value, 0.0);
        self.lag = Quantity {
            value,
            std: apart.max(together),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::Settings;

    fn machine() -> WheelDynamics {
        WheelDynamics::of(&Settings::DEFAULT)
    }

    fn before() -> WheelLag {
        let quantity = |value, std| Quantity { value, std };
        WheelLag::new(quantity(18.0, 2.5), quantity(0.45, 0.1), 0.005)
    }

    /// A minute of shuttling at up to 2.5 m/s with this lag [s], slips of K 18, and radii .4 % apart. `share` of the weight in front at a
    /// time [s].
    fn shuttle_with(lag: f64, share: impl Fn(f64) -> f64) -> WheelLag {
        let mut learnt = before();
        let weight = machine().wheel_radius * machine().mass * machine().gravity;
        let at = |t: f64| 2.5 * (0.7 * t).sin() + 0.8 * (1.9 * t).sin();
        for k in 1..6000 {
            let t = 0.01 * f64::from(k);
            let (speed, before, share) = (at(t), at(t - 0.01), share(t));
            let acceleration = (speed - before) / 0.01;
            let pull = 0.5 * (acceleration / 9.81 + 0.03 * speed.signum());
            let slips = (1.0 / share - 1.0 / (1.0 - share)) / 18.0;
            let wavers = 1e-3 * (11.0 * t + 3.0 * (0.9 * t).sin()).sin();
            let difference =
                0.004 * speed + speed.abs() * slips * pull + lag * acceleration + wavers;
            let row = Row {
                speeds: [speed, before],
                difference: difference / machine().wheel_radius,
                turn: 0.0,
                torques: [pull * weight; 2],
                share,
            };
            learnt.see(&machine(), &row, 0.01);
        }
        learnt
    }

    fn shuttle(lag: f64) -> WheelLag {
        shuttle_with(lag, |_| 0.45)
    }

    #[test]
    fn a_load_that_changes_the_slips_is_no_lag() {
        let loaded = |t: f64| if (0.07 * t) % 1.0 < 0.5 { 0.42 } else { 0.66 };
        for lag in [0.0, 0.005] {
            let told = shuttle_with(lag, loaded).lag();
            assert!((told.value - lag).abs() < 5e-4, "{lag} {told:?}");
            assert!(told.std < 1e-3, "{lag} {told:?}");
        }
    }

    #[test]
    fn a_lag_is_distinguished_from_slip_and_none_is_none() {
        for lag in [-0.008, -0.004, 0.005] {
            let told = shuttle(lag).lag();
            assert!((told.value - lag).abs() < 1.96 * told.std, "{lag} {told:?}");
            assert!(told.std < 1.2e-3, "{lag} {told:?}");
        }
        let none = shuttle(0.0).lag();
        assert!(none.value.abs() < 5e-4 && none.std < 1e-3, "{none:?}");
    }

    #[test]
    fn a_block_has_as_many_rows_wherever_its_sum_rounds() {
        let mut lag = before();
        let row = Row {
            speeds: [2.0, 2.0],
            difference: 0.0,
            turn: 0.0,
            torques: [1e3; 2],
            share: 0.45,
        };
        for k in 0..2000 {
            let time = 0.01 * f64::from(k);
            lag.see(&machine(), &row, (time + 0.01) - time);
            assert_eq!(lag.block.time == 0.0, k % 20 == 19, "row {k}");
        }
    }

    #[test]
    fn each_axle_knows_its_slip_by_its_own_share() {
        let covariance = before().covariance;
        let relative = [1, 2].map(|i| sqrt(covariance[i][i]) / before().state[i].abs());
        let stiffness = 2.5 / 18.0;
        let expected = [0.45, 0.55].map(|share| norm(&[stiffness, 0.1 / share]));
        for i in 0..2 {
            assert!((relative[i] - expected[i]).abs() < 1e-12, "{relative:?}");
        }
    }

    #[test]
    fn before_any_row_frames_of_two_controllers_lie_anywhere() {
        let Quantity { value, std } = before().lag();
        assert!(value == 0.0 && (0.001..0.002).contains(&std), "{std}");
    }

    #[test]
    fn wheels_that_spin_hardly_count() {
        let mut lag = shuttle(0.0);
        let told = lag.lag();
        let row = Row {
            speeds: [2.0, 2.0],
            difference: 1.0,
            turn: 0.0,
            torques: [5e3; 2],
            share: 0.45,
        };
        (0..100).for_each(|_| lag.see(&machine(), &row, 0.01));
        let spun = lag.lag();
        assert!((spun.value - told.value).abs() < 5e-4, "{told:?} {spun:?}");
    }

    #[test]
    fn slow_and_non_finite_rows_carry_no_information() {
        let mut lag = before();
        let row = Row {
            speeds: [0.1, 0.1],
            difference: 0.0,
            turn: 0.0,
            torques: [1e3; 2],
            share: 0.45,
        };
        (0..100).for_each(|_| lag.see(&machine(), &row, 0.01));
        let far = Row {
            speeds: [2.0, 2.0],
            difference: f64::NAN,
            ..row
        };
        (0..100).for_each(|_| lag.see(&machine(), &far, 0.01));
        assert_eq!(lag.state, before().state);
        assert_eq!(lag.lag(), before().lag());
    }
}
