//! The innovations of one stretch of driving.
//!
//! State: speed v and specific force a along the body, a random walk. Per row, one after the other:
//! ```text
//! v' = a - g sin(slope - b)
//! accelerometer    a
//! balance of force (g_f T_f/r_f + g_r T_r/r_r - f m g + 2 I/r^2 g sin slope)/(m + 2 I/r^2) = a
//! speed            v - tau v'
//! wheels           w_i = (v + |v| s_i + L s_i')/r_i
//! s_i = F_i/(K_i F_zi),  F_i = (g_i T_i - I v'/r)/r
//! F_zf = m g lam - m h a/l,  F_zr = m g (1 - lam) + m h a/l
//! r_i = r (1 + d_i) (1 - rho (F_zi/(m g/2) - 1))
//! ```
//! (the numbers are those of the loader's specification of the process; slip as there, relative to the
//! faster of wheel and road). Slips are a few thousandths: the difference of the two wheels tells the
//! radii where nothing pulls, the stiffness, load shares and load sensitivity where something does.

use super::drive::Drive;
use crate::fit::GATE;
use crate::model::Innovation;

const GRAVITY: f64 = 9.81;

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
    /// Slip stiffness in front.
    pub stiffness: f64,
    /// Stiffness behind over that in front.
    pub stiffness_ratio: f64,
    /// True over measured torque, per axle.
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
    /// Noise of the accelerometer [m/s^2].
    pub acceleration_std: f64,
    /// Noise of the balance of force [m/s^2].
    pub balance_std: f64,
    /// Walk of the specific force [m/s^2/sqrt(s)].
    pub jerk_std: f64,
    /// Noise of the slope, as one of the acceleration [rad].
    pub slope_std: f64,
}

/// What acts at one time.
#[derive(Clone, Copy)]
struct Acting {
    torque: [f64; 2],
    torque_rate: [f64; 2],
    along: f64,
}

/// Time over which a torque is differentiated [s].
const RATE: f64 = 0.02;

fn acting(drive: &Drive, g: &Guess, time: f64) -> Acting {
    let torque = |i: usize, t: f64| {
        g.torque_gains[i] * drive.value(&drive.torques[i], t + g.torque_delay)
    };
    let slope = drive.value(&drive.slope, time + g.slope_delay) - g.slope_bias;
    Acting {
        torque: [torque(0, time), torque(1, time)],
        torque_rate: [0, 1]
            .map(|i| (torque(i, time + RATE) - torque(i, time - RATE)) / (2.0 * RATE)),
        along: GRAVITY * slope.sin(),
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

/// Appends the innovations of a stretch.
pub fn innovations(drive: &Drive, block: &std::ops::Range<usize>, g: &Guess, out: &mut Vec<Innovation>) {
    let Some(first) = block.clone().find(|&k| drive.speed[k].is_finite()) else {
        return;
    };
    let begin = acting(drive, g, drive.time[first]);
    let mut state = State {
        v: drive.speed[first],
        a: balance(g, &begin),
        vv: g.speed_std * g.speed_std,
        va: 0.0,
        aa: 1.0,
    };
    let mut last = begin;
    for k in first + 1..block.end {
        let dt = drive.time[k] - drive.time[k - 1];
        let now = acting(drive, g, drive.time[k]);
        state.predict(dt, 0.5 * (last.along + now.along), g);
        last = now;
        let mut take = |innovation: Option<Innovation>| out.extend(innovation);
        if drive.has_acceleration {
            take(state.measure(drive.acceleration[k], state.a, [0.0, 1.0], g.acceleration_std));
        }
        take(state.measure(balance(g, &now), state.a, [0.0, 1.0], g.balance_std));
        let rate = state.a - now.along;
        let late = state.v - g.speed_delay * rate;
        take(state.measure(drive.speed[k], late, [1.0, -g.speed_delay], g.speed_std));
        for i in 0..2 {
            let (wheel, slope) = wheel(g, i, &now, state.v, state.a);
            take(state.measure(drive.wheels[i][k], wheel, [slope, 0.0], g.wheel_std));
        }
    }
}

/// The specific force that the torques make [m/s^2].
fn balance(g: &Guess, acting: &Acting) -> f64 {
    let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
    let pull: f64 = (0..2)
        .map(|i| acting.torque[i] / (g.radius * (1.0 + g.radius_errors[i])))
        .sum();
    (pull - g.rolling_resistance * g.mass * GRAVITY + spin * acting.along) / (g.mass + spin)
}

/// Speed of a wheel and its slope with the speed.
fn wheel(g: &Guess, i: usize, acting: &Acting, v: f64, a: f64) -> (f64, f64) {
    let weight = g.mass * GRAVITY;
    let transfer = g.mass * g.height * a / g.wheelbase;
    let load = if i == 0 {
        weight * g.ratio - transfer
    } else {
        weight * (1.0 - g.ratio) + transfer
    }
    .max(0.02 * weight);
    let radius = g.radius
        * (1.0 + g.radius_errors[i])
        * (1.0 - g.load_sensitivity * (load / (0.5 * weight) - 1.0));
    let stiffness = if i == 0 { g.stiffness } else { g.stiffness * g.stiffness_ratio };
    let pull = (acting.torque[i] - g.axle_inertia * (a - acting.along) / radius) / radius;
    let slip = (pull / (stiffness * load)).clamp(-0.5, 0.5);
    let slip_rate = acting.torque_rate[i] / (radius * stiffness * load);
    // Relative to the faster of wheel and road: the wheel where it drives, the road where it brakes.
    let drives = slip * v >= 0.0;
    let faster = if drives { 1.0 / (1.0 - slip.abs()) } else { 1.0 - slip.abs() };
    ((v * faster + g.relaxation_length * slip_rate) / radius, faster / radius)
}

impl State {
    fn predict(&mut self, dt: f64, along: f64, g: &Guess) {
        self.v += dt * (self.a - along);
        let slope = GRAVITY * g.slope_std * dt;
        self.vv += dt * (2.0 * self.va + dt * self.aa) + slope * slope;
        self.va += dt * self.aa;
        self.aa += g.jerk_std * g.jerk_std * dt;
    }

    /// One measurement with its prediction and its row.
    fn measure(&mut self, value: f64, predicted: f64, row: [f64; 2], std: f64) -> Option<Innovation> {
        if !value.is_finite() {
            return None;
        }
        let across = [
            self.vv * row[0] + self.va * row[1],
            self.va * row[0] + self.aa * row[1],
        ];
        let variance = row[0] * across[0] + row[1] * across[1] + std * std;
        let innovation = value - predicted;
        let used = variance.max(innovation * innovation / (GATE * GATE));
        self.v += across[0] * innovation / used;
        self.a += across[1] * innovation / used;
        self.vv -= across[0] * across[0] / used;
        self.va -= across[0] * across[1] / used;
        self.aa -= across[1] * across[1] / used;
        Some(Innovation {
            value: innovation,
            variance,
        })
    }
}
