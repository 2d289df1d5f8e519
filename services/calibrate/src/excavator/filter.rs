//! Innovations of one swing.
//!
//! The state is the angle, the momentum p = J w, and the noise n of the last torque sample, half of which enters
//! each of two steps. With the trapezoidal rule, exact for a momentum that posture changes without force:
//! ```text
//! p (1 + b dt/2J) = p_ (1 - b dt/2J_) + (eta I_d + I_b/eta - o ...)/gain - T_f s dt
//!                   + g S (c cos psi + l sin psi) dt + k (n_ + n)
//! angle = angle_ + dt/2 (p_/J_ + p/J);   y = p/J + v   or   y = angle + v
//! ```
//! The slope of the ground acts on the first moment S of upper body, attachment and load. It is given across (c, left side low) and
//! along the machine (l, nose up) where it stood at psi = 0. I_d and I_b are the torque's integrals while driving and braking
//! ([`super::torque`]). The model includes the regressors' noise, that of the torque in n and that of the velocity in v. This
//! likelihood therefore has no bias where least squares has 2 %.
//!
//! Delays: a value stamped t was true at t - delay. The filter runs at the time of the velocity. The
//! torque is read earlier by the delay of velocity minus that of torque; the posture likewise, where the
//! velocity is the delayed one.

use estimation::excavator::GRAVITY;

use super::series::{Load, Measured, Series, Swing};
use super::swinging::RATES;
use super::torque::Impulse;
use crate::fit::GATE;
use crate::model::Innovation;

/// Machine, sensors and load at one place of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// Viscous damping b [N m s/rad].
    pub damping: f64,
    /// Coulomb friction T_f [N m].
    pub friction: f64,
    /// Efficiency of the drive: eta while driving, 1/eta while braking.
    pub efficiency: f64,
    /// Measured torque at zero true torque [N m].
    pub offset: f64,
    /// Measured over true torque.
    pub gain: f64,
    /// Inertia of the upper body [kg m^2].
    pub upper_inertia: f64,
    /// Masses and inertias of boom and arm over the described ones.
    pub link_scale: f64,
    /// The same of the bucket.
    pub bucket_scale: f64,
    /// Delay of the velocity minus that of the torque [s].
    pub delay: f64,
    /// Noise of the velocity [rad/s], or of the angle [rad].
    pub motion_std: f64,
    /// Noise of the torque per sample [N m].
    pub torque_std: f64,
    /// Load of the recording [kg].
    pub payload: f64,
    /// Inertia of a load over that from its described position in the bucket.
    pub lever: f64,
    /// Place of the load's centre beyond the described one, along and beside the line from the bucket's pin to its tip \[m\].
    pub centre: [f64; 2],
    /// Shares of the load that swing at each of the rates.
    pub swinging: [f64; RATES.len()],
    /// Offsets of the joint angles beyond the described ones, measured less true \[rad\].
    pub angle_offsets: [f64; 3],
    /// First moment of the upper body [kg m].
    pub upper_moment: f64,
    /// Slope of the ground across and along the machine at the start of the recording [rad].
    pub slope: [f64; 2],
}

/// State and covariance, element by element: angle a, momentum p, noise n of the last torque sample.
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

/// Inertia at a time, by linear interpolation between the rows.
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
        let [mut links, mut leverage] = [s.links[k], self.leverage(k)];
        // What the offsets do to the bucket is scaled as boom and arm: an error of second order.
        for (offset, [of_links, of_load]) in g.angle_offsets.iter().zip(s.per_angle[k]) {
            links -= offset * of_links;
            leverage -= offset * of_load;
        }
        g.upper_inertia
            + g.link_scale * links
            + g.bucket_scale * s.bucket[k]
            + g.lever * self.payload * leverage
    }

    /// Inertia per kilogram of load at the measured posture [m^2].
    fn leverage(&self, k: usize) -> f64 {
        let [along, beside] = self.guess.centre;
        let [by_along, by_beside] = self.series.per_centre[k];
        self.series.leverage[k] + along * by_along + beside * by_beside
    }

    /// Relative momentum of the swinging load, divided by the inertia 1/`ease` of the whole machine [rad/s].
    fn dragged(&self, k: usize, ease: f64) -> f64 {
        if self.payload == 0.0 {
            return 0.0;
        }
        let (s, g) = (self.series, self.guess);
        let shares = g.swinging.iter().zip(s.swinging[k]);
        let velocity: f64 = shares.map(|(share, rate)| share * rate).sum();
        g.lever * self.payload * self.leverage(k) * velocity * ease
    }

    /// Moment of gravity due to a slope of the ground [N m].
    fn pull(&self, k: usize) -> f64 {
        let (s, g) = (self.series, self.guess);
        let [links, bucket] = s.moment[k];
        let attachment = g.link_scale * links + g.bucket_scale * bucket;
        let moment = g.upper_moment + attachment + self.payload * s.radius[k];
        let [cos, sin] = s.heading[k];
        GRAVITY * moment * (g.slope[0] * cos + g.slope[1] * sin)
    }

    /// Inertia at the true time of the velocity of row `k`.
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

/// Appends the innovations of a swing: one for each measured row except the first.
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
    let drive = Drive::of(guess);
    let j = inertia.at(first);
    // A division takes as long as ten products: each inertia is divided by once.
    let mut ease_last = 1.0 / j;
    let mut dragged = inertia.dragged(first, ease_last);
    let mut state = State::start(series, guess, first, (j, dragged));
    let begin = series.time[first] - guess.delay;
    let mut cursor = series.torque.cursor(begin);
    let mut until = series.torque.until(begin, &mut cursor);
    for k in rows.skip(1) {
        let dt = series.time[k] - series.time[k - 1];
        let ease = 1.0 / inertia.at(k);
        let impulse = series
            .torque
            .until(series.time[k] - guess.delay, &mut cursor);
        let outside = inertia.pull(k) - guess.friction * swing.direction;
        let force = drive.force(&impulse.since(&until)) + outside * dt;
        state.predict(&drive, force, [ease_last, ease], dt);
        let behind = inertia.dragged(k, ease);
        state.angle -= 0.5 * dt * (dragged + behind);
        (until, ease_last, dragged) = (impulse, ease, behind);
        if series.value[k].is_finite() {
            out.push(match series.measured {
                Measured::Velocity => {
                    state.correct_velocity(series.value[k] + dragged, ease, variance)
                }
                Measured::Angle => state.correct_angle(series.value[k], variance),
            });
        }
    }
}

/// Properties of the drive for all rows of a swing.
struct Drive {
    damping: f64,
    offset: f64,
    /// True over measured impulse while driving, and while braking.
    driving: f64,
    braking: f64,
    /// True over measured torque.
    scale: f64,
    torque_variance: f64,
}

impl Drive {
    fn of(g: &Guess) -> Self {
        Self {
            damping: g.damping,
            offset: g.offset,
            driving: g.efficiency / g.gain,
            braking: 1.0 / (g.efficiency * g.gain),
            scale: 1.0 / g.gain,
            torque_variance: g.torque_std * g.torque_std,
        }
    }

    /// True impulse of a measured one [N m s].
    fn force(&self, step: &Impulse) -> f64 {
        let driving = step.driving - self.offset * step.driving_time;
        let braking = step.braking - self.offset * step.braking_time;
        self.driving * driving + self.braking * braking
    }
}

impl State {
    /// State from the first measured row alone.
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

    /// Predicts one step, by the equations above; `ease` is 1/J.
    fn predict(&mut self, drive: &Drive, force: f64, [ease_last, ease]: [f64; 2], dt: f64) {
        let half = 0.5 * dt;
        let drag = half * drive.damping;
        let through = 1.0 / (1.0 + drag * ease);
        let keep = (1.0 - drag * ease_last) * through;
        // Factors of the torque noise, before and now, in momentum and angle.
        let noise = half * drive.scale * through;
        let (turn, kick) = (half * (ease_last + keep * ease), half * noise * ease);
        let s = drive.torque_variance;
        let before = self.momentum;
        let momentum = keep * before + noise * self.noise + force * through;
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
            angle: self.angle + half * (before * ease_last + momentum * ease),
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

    fn correct_velocity(&mut self, value: f64, ease: f64, variance: f64) -> Innovation {
        let across = [self.ap * ease, self.pp * ease, self.pn * ease];
        let innovation = value - self.momentum * ease;
        self.correct(innovation, across, across[1] * ease + variance)
    }

    fn correct_angle(&mut self, value: f64, variance: f64) -> Innovation {
        let across = [self.aa, self.ap, self.an];
        self.correct(value - self.angle, across, self.aa + variance)
    }

    /// Updates with an innovation, its covariance with the state, and its variance. One beyond the gate corrects
    /// like one at the gate with a larger variance.
    fn correct(&mut self, innovation: f64, [a, p, n]: [f64; 3], expected: f64) -> Innovation {
        let used = expected.max(innovation * innovation / (GATE * GATE));
        let share = 1.0 / used;
        let (of_a, of_p, of_n) = (a * share, p * share, n * share);
        self.angle += of_a * innovation;
        self.momentum += of_p * innovation;
        self.noise += of_n * innovation;
        self.aa -= a * of_a;
        self.ap -= a * of_p;
        self.an -= a * of_n;
        self.pp -= p * of_p;
        self.pn -= p * of_n;
        self.nn -= n * of_n;
        Innovation {
            value: innovation,
            variance: expected,
        }
    }
}
