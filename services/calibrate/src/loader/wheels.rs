//! Axle loads, radii, slips and the balance of force:
//! ```text
//! s_i = L(F_i)/K_i,  F_i = (T_i/g_i - I v'/r)/r
//! s_i grows by 1 + V (F_0/F_zi)^2: on bumps the load of an axle varies by V F_0^2, and the mean of 1/F_z is the larger
//! L(F) = mu [(1 - w) atanh u + w 3 (1 - (1 - |u|)^(1/3)) sign u],  u = F/(mu F_zi)
//! F_zf = m g lam - m h a/l,  F_zr = m g (1 - lam) + m h a/l
//! r_i = r (1 + d_i) (1 - rho (F_zi/F_0 - 1)),  K_i = K q_i (F_zi/F_0)^-p,  F_0 = m_0 g/2 of the empty machine
//! m a = F_f + F_r - c m g sign(v)
//! ```

use super::GRAVITY;
use super::drive::Drive;
use super::guess::Guess;

/// Least load of an axle, as a share of the weight.
const LEAST_LOAD: f64 = 0.02;
/// Largest used share of a tyre's friction.
const MOST_FRICTION: f64 = 0.98;

/// Torques and gravity at one time.
#[derive(Clone, Copy)]
pub struct Acting {
    /// True torques [N m] and their rates [N m/s].
    pub torque: [f64; 2],
    pub torque_rate: [f64; 2],
    /// Gravity along the road [m/s^2].
    pub along: f64,
}

impl Acting {
    /// The same in row `k`.
    pub fn at(drive: &Drive, g: &Guess, k: usize) -> Self {
        let (row, share) = drive.place(k, g.torque_delay);
        let mixed = |column: &[f64]| column[row] + share * (column[row + 1] - column[row]);
        Self {
            torque: [0, 1].map(|i| mixed(&drive.torques[i]) / g.torque_gains[i]),
            torque_rate: [0, 1].map(|i| mixed(&drive.torque_rates[i]) / g.torque_gains[i]),
            along: GRAVITY * g.prompt_slope(drive.slope[k], g.force(drive, k)).sin(),
        }
    }
}

/// Load of an axle [N] under a specific force.
pub fn load(g: &Guess, i: usize, a: f64) -> f64 {
    let weight = g.mass * GRAVITY;
    let transfer = g.mass * g.height * a / g.wheelbase;
    let load = if i == 0 {
        weight * g.ratio - transfer
    } else {
        weight * (1.0 - g.ratio) + transfer
    };
    load.max(LEAST_LOAD * weight)
}

/// Rolling radius of an axle under a load [m].
pub fn radius(g: &Guess, i: usize, load: f64) -> f64 {
    let excess = load / (0.5 * g.empty_mass * GRAVITY) - 1.0;
    g.radius * (1.0 + g.radius_errors[i]) * (1.0 - g.load_sensitivity * excess)
}

/// Specific force from the torques [m/s^2].
pub fn balance(g: &Guess, acting: &Acting, forward: f64, a: f64) -> f64 {
    let spin = 2.0 * g.axle_inertia / (g.radius * g.radius);
    let pull: f64 = (0..2)
        .map(|i| acting.torque[i] / radius(g, i, load(g, i, a)))
        .sum();
    let rolling = g.rolling_resistance * g.mass * GRAVITY * forward;
    (pull - rolling + spin * acting.along) / (g.mass + spin)
}

/// State of an axle under its torque.
pub struct Slipping {
    /// Rolling radius [m].
    pub radius: f64,
    /// Rim speed over road speed.
    pub faster: f64,
    /// Rim speed from the winding of the tyre [m/s].
    pub wound: f64,
}

/// Slip under a pull \[N\], times the stiffness.
fn law(g: &Guess, pull: f64, load: f64) -> f64 {
    if !g.friction.is_finite() {
        return pull / load;
    }
    let used = (pull / (g.friction * load)).clamp(-MOST_FRICTION, MOST_FRICTION);
    let smooth = 0.5 * ((1.0 + used) / (1.0 - used)).ln();
    let brush = (3.0 * (1.0 - (1.0 - used.abs()).cbrt())).copysign(used);
    g.friction * (smooth + g.brush * (brush - smooth))
}

/// State of axle `i` under these torques and a specific force `a`.
pub fn slipping(g: &Guess, i: usize, acting: &Acting, forward: f64, a: f64) -> Slipping {
    let load = load(g, i, a);
    let relative = load / (0.5 * g.empty_mass * GRAVITY);
    let radius = radius(g, i, load);
    let gain = g.stiffness_ratio.sqrt();
    let stiffness = g.stiffness
        * if i == 0 { gain } else { 1.0 / gain }
        * (-g.load_exponent * relative.ln()).exp();
    let pull = (acting.torque[i] - g.axle_inertia * (a - acting.along) / radius) / radius;
    let slip = law(g, pull, load);
    let varied = 1.0 + g.load_variance / (relative * relative);
    let slip = slip * varied / stiffness;
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
