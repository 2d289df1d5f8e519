//! The innovations of one swing.
//!
//! The state is the angle, the momentum p = J w, and the noise n of the last torque sample, which enters
//! two steps by half. With the trapezoidal rule, exact for a momentum that posture changes without force:
//! ```text
//! p (1 + b dt/2J) = p_ (1 - b dt/2J_) + (eta I_d + I_b/eta - o ...)/gain - T_f s dt
//!                   + g S (c cos psi + l sin psi) dt + k (n_ + n)
//! angle = angle_ + dt/2 (p_/J_ + p/J);   y = p/J + v   or   y = angle + v
//! ```
//! The slope of the ground, across (c, left side low) and along the machine (l, nose up) where it stood at psi = 0,
//! pulls at the first moment S of upper body, attachment and load. I_d and I_b are the torque's integrals while driving and braking ([`super::torque`]). The regressors'
//! noise is in the model, as that of the torque in n and that of the velocity in v; that is why this
//! likelihood has no bias where least squares has 2 %.
//!
//! Delays: a value stamped t was true at t - delay. The filter runs at the time of the velocity; the
//! torque is read `delay` of velocity minus that of torque earlier, the posture likewise where the
//! velocity is the late one.

use estimation::excavator::GRAVITY;

use super::series::{Load, Measured, Series, Swing};
use super::swinging::RATES;
use super::torque::Impulse;
use crate::fit::GATE;
use crate::model::Innovation;

/// The machine and its sensors, as one guess.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Viscous damping b [N m s/rad].
    pub damping: f64,
    /// Coulomb friction T_f [N m].
    pub friction: f64,
    /// Efficiency of the drive, driving eta, braking 1/eta.
    pub efficiency: f64,
    /// Measured torque where there is none [N m].
    pub offset: f64,
    /// Measured over true torque.
    pub gain: f64,
    /// Inertia of the upper body [kg m^2].
    pub upper_inertia: f64,
    /// Masses and inertias of boom, arm and bucket against the described ones.
    pub link_scale: f64,
    /// Delay of the velocity, less that of the torque [s].
    pub delay: f64,
    /// Noise of the velocity [rad/s], or of the angle [rad].
    pub motion_std: f64,
    /// Noise of the torque per sample [N m].
    pub torque_std: f64,
    /// Load of the recording [kg].
    pub payload: f64,
    /// Inertia of a load against the one that its place in the bucket, as described, gives it.
    pub lever: f64,
    /// Shares of the load that swing at each of the rates.
    pub swinging: [f64; RATES.len()],
    /// True joint angles less the measured ones [rad].
    pub zeros: [f64; 3],
    /// First moment of the upper body [kg m].
    pub upper_moment: f64,
    /// Slope of the ground across and along the machine at the beginning of the recording [rad].
    pub slope: [f64; 2],
}

/// State and covariance, written out: angle a, momentum p, noise n of the last torque sample.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    angle: f64,
    momentum: f64,
    noise: f64,
    aa: f64,
    ap: f64,
    an: f64,
    pp: f64,
    pn: f64,
    nn: f64,
}

/// Inertia at a time, by straight lines between the rows.
struct Inertias<'a> {
    series: &'a Series,
    guess: &'a Guess,
    payload: f64,
    late: f64,
}

impl Inertias<'_> {
    fn row(&self, k: usize) -> f64 {
        let s = self.series;
        let g = self.guess;
        let [mut links, mut leverage] = [s.links[k], s.leverage[k]];
        for (zero, [of_links, of_load]) in g.zeros.iter().zip(s.per_angle[k]) {
            links += zero * of_links;
            leverage += zero * of_load;
        }
        g.upper_inertia + g.link_scale * links + g.lever * self.payload * leverage
    }

    /// What the swinging load takes of the momentum, as a velocity of the whole machine of inertia `j` [rad/s].
    fn dragged(&self, k: usize, j: f64) -> f64 {
        let (s, g) = (self.series, self.guess);
        let shares = g.swinging.iter().zip(s.swinging[k]);
        let velocity: f64 = shares.map(|(share, rate)| share * rate).sum();
        g.lever * self.payload * s.leverage[k] * velocity / j
    }

    /// What a slope of the ground makes of the weight [N m].
    fn pull(&self, k: usize) -> f64 {
        let (s, g) = (self.series, self.guess);
        let moment = g.upper_moment + g.link_scale * s.moment[k] + self.payload * s.radius[k];
        let [cos, sin] = s.heading[k];
        GRAVITY * moment * (g.slope[0] * cos + g.slope[1] * sin)
    }

    /// At the time that the velocity of row `k` tells of.
    fn at(&self, k: usize) -> f64 {
        if self.late <= 0.0 {
            return self.row(k);
        }
        let time = &self.series.time;
        let t = time[k] - self.late;
        let mut below = k;
        while below > 0 && time[below] > t {
            below -= 1;
        }
        if below == k || time[below] > t {
            return self.row(below);
        }
        let share = (t - time[below]) / (time[below + 1] - time[below]);
        (1.0 - share) * self.row(below) + share * self.row(below + 1)
    }
}

/// Appends the innovations of a swing: one for every measured row but the first.
pub fn innovations(series: &Series, swing: &Swing, guess: &Guess, out: &mut Vec<Innovation>) {
    let inertia = Inertias {
        series,
        guess,
        payload: match swing.load {
            Load::Stated => guess.payload,
            Load::Empty => 0.0,
        },
        late: guess.delay.max(0.0),
    };
    let Some(first) = swing.rows.clone().find(|&k| series.value[k].is_finite()) else {
        return;
    };
    let rows = first..swing.rows.end;
    let variance = guess.motion_std * guess.motion_std;
    let mut j_last = inertia.at(first);
    let mut dragged = inertia.dragged(first, j_last);
    let mut state = State::start(series, guess, first, (j_last, dragged));
    let mut cursor = 0;
    let mut until = series
        .torque
        .until(series.time[first] - guess.delay, &mut cursor);
    for k in rows.skip(1) {
        let dt = series.time[k] - series.time[k - 1];
        let j = inertia.at(k);
        let impulse = series
            .torque
            .until(series.time[k] - guess.delay, &mut cursor);
        let outside = inertia.pull(k) - guess.friction * swing.direction;
        let force = force(guess, &impulse.since(&until)) + outside * dt;
        state.predict(guess, force, [j_last, j], dt);
        let behind = inertia.dragged(k, j);
        state.angle -= 0.5 * dt * (dragged + behind);
        (until, j_last, dragged) = (impulse, j, behind);
        if series.value[k].is_finite() {
            out.push(match series.measured {
                Measured::Velocity => {
                    state.correct_velocity(series.value[k] + dragged, j, variance)
                }
                Measured::Angle => state.correct_angle(series.value[k], variance),
            });
        }
    }
}

/// What arrives of the drive's impulse [N m s].
fn force(g: &Guess, step: &Impulse) -> f64 {
    let driving = step.driving - g.offset * step.driving_time;
    let braking = step.braking - g.offset * step.braking_time;
    (g.efficiency * driving + braking / g.efficiency) / g.gain
}

impl State {
    /// At the first measured row: what that row says, and no more.
    fn start(series: &Series, guess: &Guess, first: usize, (inertia, dragged): (f64, f64)) -> Self {
        let (value, variance) = (series.value[first], guess.motion_std * guess.motion_std);
        let noise = Self {
            nn: guess.torque_std * guess.torque_std,
            ..Self::default()
        };
        match series.measured {
            Measured::Velocity => Self {
                momentum: inertia * (value + dragged),
                pp: inertia * inertia * variance,
                ..noise
            },
            Measured::Angle => {
                let velocity = series.velocity[first];
                let spread = 0.3 * inertia * velocity;
                Self {
                    angle: value,
                    momentum: inertia * (velocity + dragged),
                    aa: variance,
                    pp: spread * spread,
                    ..noise
                }
            }
        }
    }

    /// Over one step, by the equations above.
    fn predict(&mut self, g: &Guess, force: f64, [j_last, j]: [f64; 2], dt: f64) {
        let below = 1.0 + 0.5 * dt * g.damping / j;
        let keep = (1.0 - 0.5 * dt * g.damping / j_last) / below;
        // Of the noise of the torque, before and now, to momentum and angle.
        let noise = 0.5 * dt / (g.gain * below);
        let (turn, kick) = (0.5 * dt * (1.0 / j_last + keep / j), 0.5 * dt * noise / j);
        let s = g.torque_std * g.torque_std;
        let before = self.momentum;
        let momentum = keep * before + noise * self.noise + force / below;
        let Self {
            aa,
            ap,
            an,
            pp,
            pn,
            nn,
            ..
        } = *self;
        let (a_p, a_n) = (ap + turn * pp + kick * pn, an + turn * pn + kick * nn);
        *self = Self {
            angle: self.angle + 0.5 * dt * (before / j_last + momentum / j),
            momentum,
            noise: 0.0,
            aa: aa + turn * (ap + a_p) + kick * (an + a_n) + kick * kick * s,
            ap: keep * a_p + noise * a_n + kick * noise * s,
            an: kick * s,
            pp: keep * (keep * pp + 2.0 * noise * pn) + noise * noise * (nn + s),
            pn: noise * s,
            nn: s,
        };
    }

    fn correct_velocity(&mut self, value: f64, j: f64, variance: f64) -> Innovation {
        let across = [self.ap / j, self.pp / j, self.pn / j];
        self.correct(value - self.momentum / j, across, across[1] / j + variance)
    }

    fn correct_angle(&mut self, value: f64, variance: f64) -> Innovation {
        let across = [self.aa, self.ap, self.an];
        self.correct(value - self.angle, across, self.aa + variance)
    }

    /// With an innovation, its covariance with the state, and its variance. One beyond the gate corrects
    /// as one at the gate would, of a larger variance.
    fn correct(&mut self, innovation: f64, [a, p, n]: [f64; 3], expected: f64) -> Innovation {
        let used = expected.max(innovation * innovation / (GATE * GATE));
        let gain = innovation / used;
        self.angle += a * gain;
        self.momentum += p * gain;
        self.noise += n * gain;
        self.aa -= a * a / used;
        self.ap -= a * p / used;
        self.an -= a * n / used;
        self.pp -= p * p / used;
        self.pn -= p * n / used;
        self.nn -= n * n / used;
        Innovation {
            value: innovation,
            variance: expected,
        }
    }
}
