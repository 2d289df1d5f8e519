//! Default of mode D on a calibrated machine: detects changes of the payload by itself.
//!
//! Filter 1 assumes a constant payload until the bucket opens or an alarm is raised; filter 2 always lets the
//! payload change. The payload enters the motion only through d(g w)/dt, which nearly vanishes in a dump while
//! braking, so the estimate then depends on prior knowledge. While the bucket opens by rho [rad/s] the payload
//! leaves as `m' = rho (u - 1.4 m)` with a free u. The interval widens with the opening, before the material
//! moves. Changes without an opening are detected by comparison of the two filters, and by sums of filter 1's
//! innovations.

use crate::excavator::drive::Drive;
use crate::excavator::opening::Opening;
use crate::excavator::payload::{Change, Model, Outcome, PayloadFilter, reading};
use crate::excavator::settings::Settings;
use crate::excavator::standstill::Phase;
use crate::excavator::state::State;
use crate::math::{exp, ln, sqrt};

/// Ticks of change mode after an alarm (0.30 s).
const CHANGE: u32 = 30;
/// Ticks after an opening in which the last of the material may still leave (0.20 s).
const SETTLING: u32 = 20;
/// Sum of innovations, and difference of the filters in standard deviations, from which on an estimate is not
/// trusted. They are reached in 3 % of an undisturbed swing, and shorten by a fifth the time in which a change
/// without an opening is trusted.
const SUSPICIOUS_SUM: f64 = 3.0;
const SUSPICIOUS_DIFFERENCE: f64 = 1.4;
/// Time constants of the free change of payload, in an opening and after an alarm [s].
const OPENING_TIME: f64 = 0.5;
const CHANGE_TIME: f64 = 0.3;

/// Share of the mean square of the innovations that remains after `SQUARE_TIME` [s]; larger squares count as `SQUARE_MOST`.
const SQUARE_DECAY: f64 = 0.98;
const SQUARE_TIME: f64 = 0.01;
const SQUARE_MOST: f64 = 9.0;
/// Excess of the mean square over 1 that counts as chance.
const SQUARE_CHANCE: f64 = 0.15;
/// Least standard deviation of the filters' difference, and standard deviation of the payload above which their comparison restarts
/// [kg of the reference machine].
const LEAST_STD: f64 = 20.0;
const UNSURE_STD: f64 = 40.0;
/// Difference of disagreeing filters in standard deviations, and number of consecutive ticks of disagreement that declare a change.
const DISAGREE: f64 = 2.5;
const DISAGREED: u32 = 5;
/// Largest contribution of an innovation to the sums, and drift that each tick subtracts from them [standard deviations].
const SUM_MOST: f64 = 3.0;
const SUM_DRIFT: f64 = 0.5;
/// Sum of innovations and difference of the filters beyond which the interval widens.
const WIDENING_SUM: f64 = 4.0;
const WIDENING_DIFFERENCE: f64 = 1.8;

/// The two filters, the bucket's opening and the alarm.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct ChangingPayload {
    /// Largest free change during an opening [kg/rad], free change after an alarm [kg/s].
    opening_change_max: f64,
    change_rate_std: f64,
    opening_decay: f64,
    change_threshold: f64,
    /// Payload on this machine that corresponds to a kilogram on the reference machine.
    kilogram: f64,
    model: Model,
    /// Filter 1: constant payload, except during an opening or after an alarm.
    constant: PayloadFilter,
    /// Filter 2: the payload always changes.
    moving: PayloadFilter,
    opening: Opening,
    /// Ticks left after an opening in which material may still leave.
    settling: u32,
    /// The innovations or the difference of the filters make a change possible, but not yet likely.
    suspicious: bool,
    /// Ticks of change mode left (hc).
    change: u32,
    /// Filter 1 let the payload change in the last tick (actp).
    active: bool,
    /// Consecutive ticks in which the filters disagree (cz).
    disagree: u32,
    up: f64,
    down: f64,
    /// Mean normalised innovation squared of filter 1 (n2).
    noise: f64,
    /// Last reported variance of the payload [kg^2].
    variance: f64,
}

impl ChangingPayload {
    pub(in crate::excavator) fn new(settings: &Settings) -> Self {
        let model = Model::new(settings, false);
        let constant = PayloadFilter::new(&model);
        let mut moving = constant.clone();
        let e = &settings.estimator;
        let kilogram = settings.geometry.payload_scale();
        let change_rate_std = e.change_rate_std * kilogram;
        moving.restart_drive(change_rate_std * change_rate_std);
        Self {
            opening_change_max: e.opening_change_max * kilogram,
            change_rate_std,
            opening_decay: e.opening_decay,
            change_threshold: e.change_threshold,
            kilogram,
            model,
            constant,
            moving,
            opening: Opening::new(e.opening_rate),
            settling: 0,
            suspicious: false,
            change: 0,
            active: false,
            disagree: 0,
            up: 0.0,
            down: 0.0,
            noise: 1.0,
            variance: 0.0,
        }
    }

    /// Takes one tick; `reopen` after a long stand.
    pub(in crate::excavator) fn step(
        &mut self,
        drive: &Drive,
        phase: Phase,
        reopen: bool,
    ) -> State {
        let rho = self.opening.step(drive);
        self.settling = if self.opening.is_open() {
            SETTLING
        } else {
            self.settling.saturating_sub(1)
        };
        if reopen {
            self.constant.reopen(&self.model);
            self.moving.reopen(&self.model);
        }
        if phase != Phase::Moving {
            return self.rest(drive, phase);
        }
        let change_mode = self.change > 0;
        self.change = self.change.saturating_sub(1);
        let active = self.opening.is_open() || change_mode;
        let outcome = self.advance(drive, rho, change_mode, active);
        let (scale, inflation) = self.compare(drive, &outcome, active);
        let mut variance =
            self.constant.payload().1.max(0.0) * scale * scale + inflation * inflation;
        if drive.velocity.is_none() {
            // Without a measurement the variance does not decrease, even if the filters converge.
            variance = variance.max(self.variance);
        }
        self.variance = variance;
        let changing = self.change > 0 || self.opening.is_open();
        let mut state = reading(
            &self.model,
            &self.constant,
            drive,
            &outcome,
            variance,
            changing,
        );
        state.unsettled |= self.settling > 0 || self.suspicious;
        state.change_mode = self.change > 0;
        state.opening = self.opening.is_open();
        state
    }

    fn rest(&mut self, drive: &Drive, phase: Phase) -> State {
        let std = self.change_rate_std;
        self.constant.rest(&self.model, drive, phase);
        self.moving.rest(&self.model, drive, phase);
        self.constant.restart_drive(0.0);
        self.moving.restart_drive(std * std);
        self.change = 0;
        self.active = false;
        self.hold_off();
        let variance = self.constant.payload().1;
        self.variance = variance;
        let opening = self.opening.is_open();
        let mut state = reading(
            &self.model,
            &self.constant,
            drive,
            &Outcome::default(),
            variance,
            opening,
        );
        state.opening = opening;
        state
    }

    fn hold_off(&mut self) {
        self.disagree = 0;
        self.up = 0.0;
        self.down = 0.0;
    }

    /// Advances both filters by one step.
    fn advance(&mut self, drive: &Drive, rho: f64, change_mode: bool, active: bool) -> Outcome {
        let (m, variance) = self.constant.payload();
        let own = (m.max(0.0) + 2.0 * sqrt(variance.max(0.0))).min(self.opening_change_max);
        let alarm_std = self.change_rate_std;
        if active && !self.active {
            let std = if change_mode { alarm_std } else { own };
            self.constant.restart_drive(std * std);
        }
        if self.active && !active {
            self.constant.restart_drive(0.0);
        }
        self.active = active;
        let decay = self.opening_decay * rho;
        let (weight, std, time) = if change_mode {
            (rho + 1.0, alarm_std, CHANGE_TIME)
        } else {
            (rho, own, OPENING_TIME)
        };
        let one = Change {
            weight,
            decay,
            std,
            time,
        };
        let two = Change {
            weight: rho + 1.0,
            decay,
            std: alarm_std,
            time: CHANGE_TIME,
        };
        let outcome = self.constant.step(&self.model, drive, one);
        self.moving.step(&self.model, drive, two);
        outcome
    }

    /// Compares the two filters. Returns a factor of the standard deviation, and a standard deviation that is added.
    fn compare(&mut self, drive: &Drive, outcome: &Outcome, active: bool) -> (f64, f64) {
        let zz = outcome.innovation.normalised();
        if drive.velocity.is_some() {
            let share = 1.0 - exp(ln(SQUARE_DECAY) * drive.period / SQUARE_TIME);
            self.noise += share * ((zz * zz).min(SQUARE_MOST) - self.noise);
        }
        let scale = sqrt((self.noise - SQUARE_CHANCE).max(1.0));
        let (m1, v1) = self.constant.payload();
        let (m2, v2) = self.moving.payload();
        let extra = v2 - v1;
        let least = LEAST_STD * self.kilogram;
        let std = sqrt(extra.max(least * least));
        let mut difference = m2 - m1;
        let z = difference / (std * scale);
        self.disagree = if z.abs() > DISAGREE && !active {
            self.disagree + 1
        } else {
            0
        };
        let zc = (zz / scale).clamp(-SUM_MOST, SUM_MOST);
        self.up = (self.up + zc - SUM_DRIFT).max(0.0);
        self.down = (self.down - zc - SUM_DRIFT).max(0.0);
        let unsure = UNSURE_STD * self.kilogram;
        if active || v1 > unsure * unsure {
            self.hold_off();
        }
        let level = self.up.max(self.down);
        let alarm = self.disagree >= DISAGREED || level > self.change_threshold;
        if alarm {
            self.constant = self.moving.clone();
            self.hold_off();
            self.change = CHANGE;
            self.active = true;
            difference = 0.0;
        }
        self.suspicious =
            !active && (self.up.max(self.down) > SUSPICIOUS_SUM || z.abs() > SUSPICIOUS_DIFFERENCE);
        let mut inflation = (difference.abs() - std * scale).max(0.0);
        if !active
            && !alarm
            && (self.up.max(self.down) > WIDENING_SUM || z.abs() > WIDENING_DIFFERENCE)
        {
            inflation = sqrt(extra.max(0.0) + 4.0 * difference * difference);
        }
        (scale, inflation)
    }

    /// Whether the numbers of both filters are finite, without negative variances.
    pub(in crate::excavator) fn is_sound(&self) -> bool {
        self.constant.is_sound() && self.moving.is_sound()
    }
}
