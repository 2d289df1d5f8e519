//! The innovations of one stretch of driving.
//!
//! State: speed v and specific force a along the body, a random walk. Per row, one after the other:
//! ```text
//! v' = a - g sin(slope - b)
//! accelerometer    a
//! balance of force (T_f/(g_f r_f) + T_r/(g_r r_r) - f m g sign v + 2 I/r^2 g sin slope)/(m + 2 I/r^2) = a
//! speed            v at the time of the row less tau
//! wheels           w_i = (v + |v| s_i + L s_i')/r_i
//! s_i = mu/K_i atanh(F_i/(mu F_zi)),  F_i = (T_i/g_i - I v'/r)/r
//! F_zf = m g lam - m h a/l,  F_zr = m g (1 - lam) + m h a/l
//! r_i = r (1 + d_i) (1 - rho (F_zi/F_0 - 1)),  K_i = K q_i (F_zi/F_0)^-p,  F_0 = m g/2
//! ```
//! The slip is relative to the faster of wheel and road (Yang, Wang, Han 2021, which the estimator follows too). Slips are
//! a few thousandths: the difference of the two wheels tells the radii where nothing pulls, and stiffness, load shares and
//! load sensitivity where something does.
//!
//! A delay of the speed is counted in whole rows and only the rest of it by a straight line: interpolated noise would be
//! smaller, and the likelihood would find every delay half a row off.

use super::drive::Drive;
use crate::fit::GATE;
use crate::model::Innovation;

const GRAVITY: f64 = 9.81;
/// An axle carries at least this share of the weight.
const LEAST_LOAD: f64 = 0.02;
/// A tyre uses at most this share of its friction.
const MOST_FRICTION: f64 = 0.98;
/// What is not known of the specific force where a stretch begins [m/s^2].
const FIRST_STD: f64 = 1.0;

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
    /// Noise of the speed [m/s].
    pub speed_std: f64,
    /// Noise of the wheel speeds [rad/s].
    pub wheel_std: f64,
    /// Ripple of the axle loads, as a share, that acts through slip and radius.
    pub ripple: f64,
    /// Noise of the accelerometer [m/s^2].
    pub acceleration_std: f64,
    /// Noise of the balance of force [m/s^2].
    pub balance_std: f64,
    /// Walk of the specific force [m/s^2/sqrt(s)].
    pub jerk_std: f64,
    /// Noise of the slope [rad].
    pub slope_std: f64,
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
        let mixed = |column: &[f64], (row, share): (usize, f64)| {
            column[row] + share * (column[row + 1] - column[row])
        };
        let place = drive.place(k, g.torque_delay);
        let slope = mixed(&drive.slope, drive.place(k, g.slope_delay)) - g.slope_bias;
        Self {
            torque: [0, 1].map(|i| mixed(&drive.torques[i], place) / g.torque_gains[i]),
            torque_rate: [0, 1].map(|i| mixed(&drive.torque_rates[i], place) / g.torque_gains[i]),
            along: GRAVITY * slope.sin(),
        }
    }
}

/// Speed and specific force with their covariance.
#[derive(Clone, Copy)]
struct State {
    v: f64,
    a: f64,
    vv: f64,
    va: f64,
    aa: f64,
}

/// A measurement: what came, what was expected, how it depends on speed and specific force, its noise.
struct Measured {
    value: f64,
    expected: f64,
    slopes: [f64; 2],
    std: f64,
}

/// Appends the innovations of a stretch, equally many at any guess.
pub fn innovations(
    drive: &Drive,
    block: &std::ops::Range<usize>,
    g: &Guess,
    out: &mut Vec<Innovation>,
) {
    let speed = |k: usize| drive.speed[drive.later(k, g.speed_delay)];
    let begin = Acting::at(drive, g, block.start);
    let rim = 0.5 * g.radius * (drive.wheels[0][block.start] + drive.wheels[1][block.start]);
    let [first, std] = match (speed(block.start), rim) {
        (_, rim) if rim.is_finite() => [rim, 0.05 * rim.abs()],
        (speed, _) if speed.is_finite() => [speed, g.speed_std],
        _ => [0.0, 10.0],
    };
    let mut state = State {
        v: first,
        a: balance(g, &begin, first, 0.0),
        vv: std * std,
        va: 0.0,
        aa: FIRST_STD * FIRST_STD,
    };
    let mut last = begin;
    for k in block.start + 1..block.end {
        let dt = drive.time[k] - drive.time[k - 1];
        let now = Acting::at(drive, g, k);
        state.predict(dt, 0.5 * (last.along + now.along), g);
        last = now;
        if drive.has_acceleration {
            out.push(state.measure(&Measured {
                value: drive.acceleration[k],
                expected: state.a,
                slopes: [0.0, 1.0],
                std: g.acceleration_std,
            }));
        }
        out.push(state.measure(&Measured {
            value: balance(g, &now, state.v, state.a),
            expected: state.a,
            slopes: [0.0, 1.0],
            std: g.balance_std,
        }));
        let row = drive.later(k, g.speed_delay);
        let after = drive.time[row] - g.speed_delay - drive.time[k];
        out.push(state.measure(&Measured {
            value: drive.speed[row],
            expected: state.v + after * (state.a - now.along),
            slopes: [1.0, after],
            std: g.speed_std,
        }));
        for i in 0..2 {
            let wheel = wheel(g, i, &now, state.v, state.a);
            out.push(state.measure(&Measured {
                value: drive.wheels[i][k],
                ..wheel
            }));
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
fn balance(g: &Guess, acting: &Acting, v: f64, a: f64) -> f64 {
    let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
    let pull: f64 = (0..2)
        .map(|i| acting.torque[i] / radius(g, i, load(g, i, a)))
        .sum();
    let rolling = g.rolling_resistance * g.mass * GRAVITY * v.signum();
    (pull - rolling + spin * acting.along) / (g.mass + spin)
}

/// What is expected of a wheel.
fn wheel(g: &Guess, i: usize, acting: &Acting, v: f64, a: f64) -> Measured {
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
    let slip_rate = acting.torque_rate[i] / (radius * stiffness * load);
    // Relative to the faster of wheel and road: the wheel where it drives, the road where it brakes.
    let faster = if slip * v >= 0.0 {
        1.0 / (1.0 - slip.abs())
    } else {
        1.0 - slip.abs()
    };
    let ripple = g.ripple * (slip.abs() + g.load_sensitivity) * v.abs() / radius;
    Measured {
        value: f64::NAN,
        expected: (v * faster + g.relaxation_length * slip_rate) / radius,
        slopes: [faster / radius, 0.0],
        std: (g.wheel_std * g.wheel_std + ripple * ripple).sqrt(),
    }
}

impl State {
    fn predict(&mut self, dt: f64, along: f64, g: &Guess) {
        self.v += dt * (self.a - along);
        let slope = GRAVITY * g.slope_std * dt;
        let walk = g.jerk_std * g.jerk_std * dt;
        self.vv += dt * (2.0 * self.va + dt * self.aa) + slope * slope + walk * dt * dt / 3.0;
        self.va += dt * self.aa + 0.5 * walk * dt;
        self.aa += walk;
    }

    /// Takes a measurement; one that is missing changes nothing, whatever the guess.
    fn measure(&mut self, m: &Measured) -> Innovation {
        let innovation = m.value - m.expected;
        if !innovation.is_finite() {
            return Innovation {
                value: 0.0,
                variance: 1.0,
            };
        }
        let across = [
            self.vv * m.slopes[0] + self.va * m.slopes[1],
            self.va * m.slopes[0] + self.aa * m.slopes[1],
        ];
        let variance = m.slopes[0] * across[0] + m.slopes[1] * across[1] + m.std * m.std;
        let used = variance.max(innovation * innovation / (GATE * GATE));
        self.v += across[0] * innovation / used;
        self.a += across[1] * innovation / used;
        self.vv -= across[0] * across[0] / used;
        self.va -= across[0] * across[1] / used;
        self.aa -= across[1] * across[1] / used;
        Innovation {
            value: innovation,
            variance,
        }
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
            slope_delay: 0.0,
            speed_delay: 0.03,
            torque_delay: 0.01,
            relaxation_length: 0.1,
            axle_inertia: 3.3,
            wheelbase: 2.3,
            speed_std: 0.02,
            wheel_std: 0.002,
            ripple: 0.0,
            acceleration_std: 0.05,
            balance_std: 0.01,
            jerk_std: 1.0,
            slope_std: 1e-4,
        }
    }

    /// Uniform noise of variance 1 from a linear congruence.
    fn noise(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }

    /// A machine that goes faster and slower for 40 s, as the model has it; `split` shifts the torque to and fro.
    pub fn samples(g: &Guess, split: f64, seed: u64) -> Vec<Sample> {
        let mut state = seed;
        let speed = |t: f64| 3.0 + 1.2 * (0.9 * t).sin() + 0.4 * (2.1 * t).sin();
        let rate = |t: f64| 1.08 * (0.9 * t).cos() + 0.84 * (2.1 * t).cos();
        // Torques that make this acceleration on level ground, by a few passes.
        let torque = |t: f64| {
            let share = [0.5 + split * (0.7 * t).sin(), 0.5 - split * (0.7 * t).sin()];
            let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
            let force = rate(t) * (g.mass + spin) + g.rolling_resistance * g.mass * GRAVITY;
            let radii = [0, 1].map(|i| radius(g, i, load(g, i, rate(t))));
            [0, 1].map(|i| share[i] * force * radii[i])
        };
        (0..2000)
            .map(|k| {
                let t = f64::from(k) * 0.02;
                let acting = Acting {
                    torque: torque(t),
                    torque_rate: [0, 1].map(|i| (torque(t + 0.01)[i] - torque(t - 0.01)[i]) / 0.02),
                    along: 0.0,
                };
                let wheels = [0, 1].map(|i| wheel(g, i, &acting, speed(t), rate(t)).expected);
                let late = torque(t - g.torque_delay);
                Sample {
                    time: t,
                    speed: Some(speed(t - g.speed_delay) + g.speed_std * noise(&mut state)),
                    front_wheel_speed: Some(wheels[0] + g.wheel_std * noise(&mut state)),
                    rear_wheel_speed: Some(wheels[1] + g.wheel_std * noise(&mut state)),
                    front_torque: Some(g.torque_gains[0] * late[0]),
                    rear_torque: Some(g.torque_gains[1] * late[1]),
                    slope: Some(g.slope_bias),
                    acceleration: Some(rate(t) + g.acceleration_std * noise(&mut state)),
                    ..Sample::default()
                }
            })
            .collect()
    }

    /// Mean of the squares over their expectation, and correlation of the wheels' with the next.
    fn agreement(drive: &Drive, g: &Guess) -> f64 {
        let mut all = Vec::new();
        for block in &drive.blocks {
            innovations(drive, block, g, &mut all);
        }
        let squares = all.iter().map(|i| i.value * i.value / i.variance);
        squares.sum::<f64>() / all.len() as f64
    }

    #[test]
    fn the_innovations_of_the_machine_that_it_is_are_as_large_as_expected() {
        let g = guess();
        let drive = Drive::new("a", &samples(&g, 0.2, 1), 4.6e4, 2.3);
        assert!(drive.driving_time() > 30.0);
        let right = agreement(&drive, &g);
        assert!((0.5..1.2).contains(&right), "{right}");
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
        ] {
            assert!(agreement(&drive, &wrong) > 1.02 * right, "{wrong:?}");
        }
    }

    #[test]
    fn as_many_innovations_come_at_any_guess_and_from_bad_rows() {
        let g = guess();
        let mut rows = samples(&g, 0.0, 2);
        rows[500].speed = None;
        rows[501].front_wheel_speed = Some(f64::NAN);
        rows[502].acceleration = Some(f64::INFINITY);
        let drive = Drive::new("a", &rows, 4.6e4, 2.3);
        let count = |g: &Guess| {
            let mut all = Vec::new();
            innovations(&drive, &drive.blocks[1], g, &mut all);
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
