//! The residuals of one stretch of driving, in bins of half a second.
//!
//! What a wheel turns tells the speed once its slip is known, and the slip follows from the torque:
//! ```text
//! s_i = mu/K_i atanh(F_i/(mu F_zi)),  F_i = (T_i/g_i - I v'/r)/r
//! F_zf = m g lam - m h a/l,  F_zr = m g (1 - lam) + m h a/l
//! r_i = r (1 + d_i) (1 - rho (F_zi/F_0 - 1)),  K_i = K q_i (F_zi/F_0)^-p,  F_0 = m g/2
//! u_i = (r_i w_i - L s_i') (1 - |s_i|) where the wheel drives, over (1 - |s_i|) where it brakes
//! s + tau_s s' = b + th + kappa (a/g - th)
//! ```
//! with the specific force a of the accelerometer, or of the torques without one, and what the slope sensor shows, s. A bin has
//! the first three residuals, two seconds have the last:
//!
//! | residual | tells |
//! |---|---|
//! | u_f - u_r, mean | radii, their load sensitivity, stiffness of the axles, loads |
//! | speed - u(t - tau), mean | radii, stiffness, delay of the speed |
//! | accelerometer - balance of force, mean | torque gains against the mass, rolling resistance |
//! | change of u from second to second - integral of a - g sin th | zero of the slope sensor, its delay, what it follows of the acceleration |
//!
//! The body pitches and heaves, axle loads and tyres follow with a lag, and bumps make all of it noise of a few hertz: a filter
//! that takes every row for white noise around this model is sure of what is wrong. Means over half a second of everything alike
//! hold nearly without these lags, no regressor is noisy, and what scatter is left shows between the stretches.

use std::ops::Range;

use super::drive::Drive;
use crate::model::Innovation;

const GRAVITY: f64 = 9.81;
/// An axle carries at least this share of the weight.
const LEAST_LOAD: f64 = 0.02;
/// A tyre uses at most this share of its friction.
const MOST_FRICTION: f64 = 0.98;
/// Length of a bin [s].
pub const BIN: f64 = 0.5;
/// So many bins make a window over which motion and slope are averaged: the change of the slope must stand out of its noise, which
/// otherwise hides a part of its delay.
const WINDOW: usize = 2;
/// Longest delay of the speed: so much of the beginning of a stretch has none to compare with [s].
pub const LONGEST_DELAY: f64 = 0.45;

/// The machine, its sensors and the load, as one guess.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Mass with load [kg].
    pub mass: f64,
    /// Share of the static weight in front.
    pub ratio: f64,
    /// Height of the centre of gravity [m].
    pub height: f64,
    /// Nominal rolling radius [m].
    pub radius: f64,
    /// Relative errors of the radii.
    pub radius_errors: [f64; 2],
    /// Load sensitivity of the radii.
    pub load_sensitivity: f64,
    /// Slip stiffness.
    pub stiffness: f64,
    /// Stiffness in front over that behind.
    pub stiffness_ratio: f64,
    /// How the stiffness falls with the load.
    pub load_exponent: f64,
    /// Limit of friction.
    pub friction: f64,
    /// Measured over true torque, per axle.
    pub torque_gains: [f64; 2],
    /// Rolling resistance.
    pub rolling_resistance: f64,
    /// Slope measured where there is none [rad].
    pub slope_bias: f64,
    /// How late the slope comes [s].
    pub slope_delay: f64,
    /// Share of the acceleration that the slope sensor follows.
    pub slope_follows: f64,
    /// How late the speed comes [s].
    pub speed_delay: f64,
    /// How late the torques come [s].
    pub torque_delay: f64,
    /// Relaxation length of the tyres [m].
    pub relaxation_length: f64,
    /// Moment of inertia of an axle [kg m^2].
    pub axle_inertia: f64,
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Scatter of a bin: between the wheels and of the speed [m/s], of the balance of force [m/s^2], of the motion [m/s].
    pub scatter: Scatter,
}

impl Guess {
    /// Slope of the road by what an inclinometer without delay shows, and the specific force.
    fn prompt_slope(&self, shown: f64, force: f64) -> f64 {
        let level = shown - self.slope_bias;
        if force.is_finite() {
            (level - self.slope_follows * force / GRAVITY) / (1.0 - self.slope_follows)
        } else {
            level
        }
    }

    /// What the delay of the slope adds to the integral of gravity along the road, per radian of change [m/s].
    fn delayed(&self) -> f64 {
        GRAVITY * self.slope_delay / (1.0 - self.slope_follows)
    }
}

/// Standard deviations of the residuals of a bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Between the speeds that the wheels show [m/s].
    pub wheels: f64,
    /// Between them and the measured speed [m/s].
    pub speed: f64,
    /// Between accelerometer and torques [m/s^2].
    pub force: f64,
    /// Between the change of the wheels' speed from window to window and the specific force along the slope [m/s].
    pub motion: f64,
}

/// What acts at one time.
#[derive(Clone, Copy)]
struct Acting {
    /// True torques [N m] and their rates [N m/s].
    torque: [f64; 2],
    torque_rate: [f64; 2],
    /// Gravity along the road [m/s^2].
    along: f64,
}

impl Acting {
    fn at(drive: &Drive, g: &Guess, k: usize) -> Self {
        let (row, share) = drive.place(k, g.torque_delay);
        let mixed = |column: &[f64]| column[row] + share * (column[row + 1] - column[row]);
        Self {
            torque: [0, 1].map(|i| mixed(&drive.torques[i]) / g.torque_gains[i]),
            torque_rate: [0, 1].map(|i| mixed(&drive.torque_rates[i]) / g.torque_gains[i]),
            along: GRAVITY * g.prompt_slope(drive.slope[k], drive.acceleration[k]).sin(),
        }
    }
}

/// What a row shows under a guess; NaN where a signal is missing.
struct Shown {
    /// Speeds that the wheels show [m/s].
    speeds: [f64; 2],
    /// Specific force that the torques make [m/s^2].
    balance: f64,
    /// Rate of the speed by specific force and slope [m/s^2].
    rate: f64,
}

impl Shown {
    fn of(drive: &Drive, g: &Guess, k: usize) -> Self {
        let acting = Acting::at(drive, g, k);
        let wheels = [drive.wheels[0][k], drive.wheels[1][k]];
        let forward = (wheels[0] + wheels[1]).signum();
        let measured = drive.acceleration[k];
        let a = if measured.is_finite() {
            measured
        } else {
            balance(g, &acting, forward, balance(g, &acting, forward, 0.0))
        };
        Self {
            speeds: [0, 1].map(|i| {
                let Slipping {
                    radius,
                    faster,
                    wound,
                } = slipping(g, i, &acting, forward, a);
                (radius * wheels[i] - wound) / faster
            }),
            balance: balance(g, &acting, forward, a),
            rate: a - acting.along,
        }
    }

    fn speed(&self) -> f64 {
        0.5 * (self.speeds[0] + self.speeds[1])
    }
}

/// Appends the residuals of a stretch, equally many at any guess.
pub fn residuals(drive: &Drive, block: &Range<usize>, g: &Guess, out: &mut Vec<Innovation>) {
    let first = block.start;
    let shown: Vec<Shown> = block.clone().map(|k| Shown::of(drive, g, k)).collect();
    for bin in drive.bins(block) {
        let mean = |of: &dyn Fn(usize) -> f64| mean(bin.clone().map(of));
        let wheels = mean(&|k| shown[k - first].speeds[0] - shown[k - first].speeds[1]);
        out.push(residual(wheels, g.scatter.wheels));
        let is_late = drive.time[bin.start] - drive.time[first] > LONGEST_DELAY;
        let speed = mean(&|k| {
            let (row, share) = drive.place(k, -g.speed_delay);
            let at = |row: usize| {
                shown
                    .get(row.wrapping_sub(first))
                    .map_or(f64::NAN, Shown::speed)
            };
            let before = at(row);
            let then = if share > 0.0 { at(row + 1) } else { before };
            drive.speed[k] - before - share * (then - before)
        });
        out.push(residual(
            if is_late { speed } else { f64::NAN },
            g.scatter.speed,
        ));
        if drive.has_acceleration {
            let force = mean(&|k| drive.acceleration[k] - shown[k - first].balance);
            out.push(residual(force, g.scatter.force));
        }
    }
    for pair in pairs(drive, block) {
        let at = |k: usize| &shown[k - first];
        let difference = |of: &dyn Fn(usize) -> f64| {
            let [before, after] = [&pair.before, &pair.after].map(|window| {
                let sum: f64 = window.clone().map(of).sum();
                sum / window.len() as f64
            });
            after - before
        };
        let gained = pair.steps().map(|(k, weight)| {
            let step = drive.time[k + 1] - drive.time[k];
            weight * 0.5 * step * (at(k).rate + at(k + 1).rate)
        });
        let change = difference(&|k| at(k).speed()) - gained.sum::<f64>();
        // The integral of the slope's rate is its change.
        let late = g.delayed() * difference(&|k| drive.slope[k]);
        out.push(residual(change + late, g.scatter.motion));
    }
}

/// Two windows that follow one another: the difference of the means of a signal is its rate, weighted by a triangle over both.
pub struct Pair {
    before: Range<usize>,
    after: Range<usize>,
}

impl Pair {
    /// Each step from a row to the next, by its first row, with its weight.
    pub fn steps(&self) -> impl Iterator<Item = (usize, f64)> {
        let (middle, end) = (self.after.start, self.after.end);
        let (up, down) = (self.before.len() as f64, self.after.len() as f64);
        (self.before.start..end - 1).map(move |k| {
            let weight = if k < middle {
                (k + 1 - self.before.start) as f64 / up
            } else {
                (end - 1 - k) as f64 / down
            };
            (k, weight)
        })
    }
}

/// The pairs of windows of a stretch, each of [`WINDOW`] bins.
pub fn pairs(drive: &Drive, block: &Range<usize>) -> Vec<Pair> {
    let bins = drive.bins(block);
    let windows: Vec<Range<usize>> = bins
        .chunks_exact(WINDOW)
        .map(|bins| bins[0].start..bins[WINDOW - 1].end)
        .collect();
    windows
        .windows(2)
        .map(|two| Pair {
            before: two[0].clone(),
            after: two[1].clone(),
        })
        .collect()
}

/// Mean of the finite ones of some values; NaN where they are not even half.
fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let all = values.len();
    let (sum, count) = values
        .filter(|v| v.is_finite())
        .fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    if 2 * count >= all {
        sum / count.max(1) as f64
    } else {
        f64::NAN
    }
}

/// One that is missing says nothing, whatever the guess.
fn residual(value: f64, std: f64) -> Innovation {
    if value.is_finite() {
        Innovation {
            value,
            variance: std * std,
        }
    } else {
        Innovation {
            value: 0.0,
            variance: 1.0,
        }
    }
}

/// Load of an axle [N] under a specific force.
fn load(g: &Guess, i: usize, a: f64) -> f64 {
    let weight = g.mass * GRAVITY;
    let transfer = g.mass * g.height * a / g.wheelbase;
    let load = if i == 0 {
        weight * g.ratio - transfer
    } else {
        weight * (1.0 - g.ratio) + transfer
    };
    load.max(LEAST_LOAD * weight)
}

/// Rolling radius of an axle under its load [m].
fn radius(g: &Guess, i: usize, load: f64) -> f64 {
    let excess = load / (0.5 * g.mass * GRAVITY) - 1.0;
    g.radius * (1.0 + g.radius_errors[i]) * (1.0 - g.load_sensitivity * excess)
}

/// The specific force that the torques make [m/s^2].
fn balance(g: &Guess, acting: &Acting, forward: f64, a: f64) -> f64 {
    let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
    let pull: f64 = (0..2)
        .map(|i| acting.torque[i] / radius(g, i, load(g, i, a)))
        .sum();
    let rolling = g.rolling_resistance * g.mass * GRAVITY * forward;
    (pull - rolling + spin * acting.along) / (g.mass + spin)
}

/// An axle under its torque.
struct Slipping {
    /// Rolling radius [m].
    radius: f64,
    /// Rim speed over road speed.
    faster: f64,
    /// Rim speed that winds the tyre up [m/s].
    wound: f64,
}

fn slipping(g: &Guess, i: usize, acting: &Acting, forward: f64, a: f64) -> Slipping {
    let load = load(g, i, a);
    let relative = load / (0.5 * g.mass * GRAVITY);
    let radius = radius(g, i, load);
    let gain = g.stiffness_ratio.sqrt();
    let stiffness = g.stiffness
        * if i == 0 { gain } else { 1.0 / gain }
        * (-g.load_exponent * relative.ln()).exp();
    let pull = (acting.torque[i] - g.axle_inertia * (a - acting.along) / radius) / radius;
    let used = pull / (g.friction * load);
    let slip = if g.friction.is_finite() {
        let used = used.clamp(-MOST_FRICTION, MOST_FRICTION);
        0.5 * g.friction / stiffness * ((1.0 + used) / (1.0 - used)).ln()
    } else {
        pull / (stiffness * load)
    };
    let slip = slip.clamp(-0.5, 0.5);
    Slipping {
        radius,
        // Relative to the faster of wheel and road: the wheel where it drives, the road where it brakes.
        faster: if slip * forward >= 0.0 {
            1.0 / (1.0 - slip.abs())
        } else {
            1.0 - slip.abs()
        },
        wound: g.relaxation_length * acting.torque_rate[i] / (radius * stiffness * load),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use estimation::loader::Sample;

    use super::*;

    pub fn guess() -> Guess {
        Guess {
            mass: 4700.0,
            ratio: 0.45,
            height: 0.9,
            radius: 0.55,
            radius_errors: [0.002, -0.001],
            load_sensitivity: 0.01,
            stiffness: 19.0,
            stiffness_ratio: 1.05,
            load_exponent: 0.1,
            friction: 0.8,
            torque_gains: [1.01, 0.99],
            rolling_resistance: 0.02,
            slope_bias: 0.005,
            slope_delay: 0.2,
            slope_follows: 0.3,
            speed_delay: 0.03,
            torque_delay: 0.01,
            relaxation_length: 0.1,
            axle_inertia: 3.3,
            wheelbase: 2.3,
            scatter: Scatter {
                wheels: 5e-4,
                speed: 4e-3,
                force: 0.01,
                motion: 5e-3,
            },
        }
    }

    /// Uniform noise of variance 1 from a linear congruence.
    pub fn noise(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }

    /// A machine that goes faster and slower over waves of the ground for 60 s, as the model has it; `split` shifts the torque to and fro.
    pub fn samples(g: &Guess, split: f64, seed: u64) -> Vec<Sample> {
        let (mut state, mut shown) = (seed, 0.0);
        let ground = |t: f64| 0.02 * (1.3 * t).sin();
        let speed = |t: f64| 3.0 + 1.2 * (0.9 * t).sin() + 0.4 * (2.1 * t).sin();
        let rate = |t: f64| 1.08 * (0.9 * t).cos() + 0.84 * (2.1 * t).cos();
        let force = |t: f64| rate(t) + GRAVITY * ground(t).sin();
        let torque = |t: f64| {
            let share = [0.5 + split * (0.7 * t).sin(), 0.5 - split * (0.7 * t).sin()];
            let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
            let pull = (force(t) + g.rolling_resistance * GRAVITY) * g.mass + spin * rate(t);
            let radii = [0, 1].map(|i| radius(g, i, load(g, i, force(t))));
            [0, 1].map(|i| share[i] * pull * radii[i])
        };
        (0..3000)
            .map(|k| {
                let t = f64::from(k) * 0.02;
                let acting = Acting {
                    torque: torque(t),
                    torque_rate: [0, 1].map(|i| (torque(t + 0.01)[i] - torque(t - 0.01)[i]) / 0.02),
                    along: force(t) - rate(t),
                };
                let wheels = [0, 1].map(|i| {
                    let axle = slipping(g, i, &acting, 1.0, force(t));
                    (speed(t) * axle.faster + axle.wound) / axle.radius
                });
                let late = torque(t - g.torque_delay);
                let seen = ground(t) + g.slope_follows * rate(t) / GRAVITY;
                let weight = 0.02 / (0.02 + g.slope_delay);
                shown += weight * (seen + g.slope_bias - shown);
                Sample {
                    time: t,
                    speed: Some(speed(t - g.speed_delay) + 0.02 * noise(&mut state)),
                    front_wheel_speed: Some(wheels[0] + 0.002 * noise(&mut state)),
                    rear_wheel_speed: Some(wheels[1] + 0.002 * noise(&mut state)),
                    front_torque: Some(g.torque_gains[0] * late[0]),
                    rear_torque: Some(g.torque_gains[1] * late[1]),
                    slope: Some(shown + 5e-4 * noise(&mut state)),
                    acceleration: Some(force(t) + 0.05 * noise(&mut state)),
                    ..Sample::default()
                }
            })
            .collect()
    }

    /// Mean of the squares over their expectation.
    fn agreement(drive: &Drive, g: &Guess) -> f64 {
        let mut all = Vec::new();
        for block in &drive.blocks {
            residuals(drive, block, g, &mut all);
        }
        let squares = all.iter().map(|i| i.value * i.value / i.variance);
        squares.sum::<f64>() / all.len() as f64
    }

    #[test]
    fn the_residuals_of_the_machine_that_it_is_are_as_large_as_the_noise() {
        let g = guess();
        let drive = Drive::new("a", &samples(&g, 0.2, 1), 4.6e4, 2.3);
        assert!(drive.driving_time() > 50.0);
        let right = agreement(&drive, &g);
        assert!((0.3..1.2).contains(&right), "{right}");
        for wrong in [
            Guess {
                radius_errors: [0.003, -0.001],
                ..g
            },
            Guess {
                stiffness: 17.0,
                ..g
            },
            Guess {
                speed_delay: 0.08,
                ..g
            },
            Guess {
                torque_gains: [1.06, 1.04],
                ..g
            },
            Guess {
                slope_bias: 0.008,
                ..g
            },
            Guess {
                slope_delay: 0.1,
                ..g
            },
            Guess {
                slope_follows: 0.25,
                ..g
            },
        ] {
            assert!(agreement(&drive, &wrong) > 1.1 * right, "{wrong:?}");
        }
    }

    #[test]
    fn as_many_residuals_come_at_any_guess_and_from_bad_rows() {
        let g = guess();
        let mut rows = samples(&g, 0.0, 2);
        rows[500].speed = None;
        rows[501].front_wheel_speed = Some(f64::NAN);
        rows[502].acceleration = Some(f64::INFINITY);
        let drive = Drive::new("a", &rows, 4.6e4, 2.3);
        let count = |g: &Guess| {
            let mut all = Vec::new();
            residuals(&drive, &drive.blocks[1], g, &mut all);
            assert!(all.iter().all(|i| i.value.is_finite() && i.variance > 0.0));
            all.len()
        };
        let late = Guess {
            speed_delay: 0.19,
            ..g
        };
        assert_eq!(count(&g), count(&late));
    }
}
