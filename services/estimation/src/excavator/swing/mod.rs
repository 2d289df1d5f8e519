//! State-space estimators behind one `step` (process `ukf`): conditioning of inputs, choice of the mode,
//! standstill, verdict.
//!
//! The modes are extended Kalman filters and a grid. A square-root UKF on the model of mode D differs by at most
//! 0.15 standard deviations over a swing (tests/excavator_ukf.rs), and needs more time.

mod answer;
mod method;

use self::method::check_method;
use super::align::Align;
use super::calibration::{Calibrated, Calibration, Progress};
use super::estimate::{Columns, Estimate, Flags, Method, Sample};
use super::grid::{Fill, Grid, LONG_GAP, PERIOD, Tick};
use super::lag::Lag;
use super::mode::{Core, Reading, needs};
use super::reason::Reason;
use super::screen::Screen;
use super::settings::Settings;
use super::settings_error::SettingsError;
use super::state::State;
use super::verdict::Reasons;
use super::working::{Trail, Working};

/// Time without a value after which a column counts as absent [s].
const PRESENCE: f64 = 1.0;

/// Estimates the swing inertia from the sensors, by any state-space mode.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SwingEstimator {
    /// Settings with the measured noise of the velocity, and its described noise [rad/s].
    settings: Settings,
    described_std: f64,
    method: Method,
    columns: Columns,
    screen: Screen,
    grid: Grid,
    align: Align,
    /// Estimator of the lag of torque and velocity, on an uncalibrated machine with torque and posture.
    lag: Option<Lag>,
    /// Delays of velocity and torque, stated or estimated [s]; rows for which a torque is held.
    delays: [f64; 2],
    held: usize,
    calibration: Option<Calibration>,
    bias: f64,
    core: Core,
    elapsed: f64,
    /// Time for which no sensor has sent a value [s].
    silent: f64,
    /// Ticks of the grid per row of the source.
    slowness: f64,
    presence_checked: bool,
    reading: Option<Reading>,
    trailing: bool,
    /// Displaced joint angles count, and are tested.
    tests_jumps: bool,
    last: Estimate,
}

impl SwingEstimator {
    /// Checks the settings and the columns that `method` needs. `Auto` chooses by the columns, and falls back while a
    /// column has no values in the first second of the velocity.
    pub fn new(
        settings: &Settings,
        method: Method,
        columns: Columns,
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        let auto = method == Method::Auto;
        let method = if auto {
            Method::for_columns(columns)
        } else {
            method
        };
        check_method(settings, method, columns)?;
        let e = &settings.estimator;
        Ok(Self {
            settings: *settings,
            described_std: settings.sensors.swing_velocity_std,
            method,
            columns,
            screen: Screen::new(&settings.sensors),
            grid: Grid::new(settings, !columns.velocity),
            align: Align::new(settings.sensors.delays),
            lag: stated_lag(settings, settings.sensors.delays, 0.0)
                .filter(|_| method == Method::PostureTorque)
                .map(Lag::new),
            delays: settings.sensors.delays,
            held: 1,
            calibration: e.calibrate_at_rest.then(|| Calibration::new(settings)),
            bias: 0.0,
            core: Core::new(settings, method, !columns.velocity, false),
            elapsed: 0.0,
            silent: 0.0,
            slowness: 1.0,
            presence_checked: !auto,
            reading: None,
            trailing: false,
            tests_jumps: false,
            last: Estimate {
                inertia: settings.prior.inertia,
                inertia_std: settings.prior.inertia_std,
                method,
                flags: Flags {
                    held: true,
                    ..Flags::default()
                },
                ..Estimate::default()
            },
        })
    }

    /// The settings as stated.
    pub fn described(&self) -> Settings {
        let mut described = self.settings;
        described.sensors.swing_velocity_std = self.described_std;
        described
    }

    /// The active method; never `Auto`.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Phase of the last tick: 0 moving, 1 held, 2 set off with a measured velocity.
    #[doc(hidden)] // for comparison with a reference implementation
    pub fn code(&self) -> u8 {
        self.reading.map_or(1, |reading| reading.code)
    }

    /// Details of the last tick for comparison with a reference: opening of the bucket, change mode, change flag of
    /// the delayed tick, velocity of the mode.
    #[doc(hidden)]
    pub fn details(&self) -> Details {
        let state = self
            .reading
            .map(|reading| reading.state)
            .unwrap_or_default();
        Details {
            opening: state.opening,
            change_mode: state.change_mode,
            flagged: state.flagged,
            velocity: state.velocity,
        }
    }

    /// Takes one row and always returns an estimate. A row whose time does not increase is refused and changes
    /// nothing, unless one stamp was wrong or the clock was permanently set back; then the estimator restarts.
    pub fn step(&mut self, sample: &Sample) -> Estimate {
        self.step_with(sample, &mut |_| {})
    }

    /// The same for an offline analysis: `see` receives each tick of the default estimator with torque and posture, in order, after
    /// [`Self::keep_trail`] was called.
    pub fn step_with(&mut self, sample: &Sample, see: &mut impl FnMut(&Trail)) -> Estimate {
        if self.last.reason == Reason::Jump || self.tests_jumps {
            self.test_jumps();
        }
        let mut sample = *sample;
        let Some(row) = self.screen.accept(&mut sample) else {
            let mut again = self.last;
            again.refused = self.screen.refused();
            again.flags.refused = true;
            return again;
        };
        let mut reset = row.set_back;
        if row.set_back {
            self.grid = Grid::new(&self.described(), !self.columns.velocity);
            self.align.clear();
            self.restart(false);
        }
        self.grid.steps(self.screen.velocity_steps());
        self.grid.posture_noise(self.screen.posture_noise());
        reset |= self.hold(row.period);
        if let Some(fill) = self.grid.push(&sample, row.period) {
            if fill.restart {
                self.align.clear();
                self.restart(false);
                reset = true;
            }
            if sample.velocity.or(sample.angle).is_some() {
                self.slowness = fill.slowness();
            } else if let Some(restarts) = self.wait_for_values(&fill) {
                self.last = self.estimate(&sample, reset | restarts);
                return self.last;
            }
            for tick in fill.ticks() {
                let mut trail = None;
                reset |= self.tick(&tick, &mut trail);
                if let Some(trail) = &trail {
                    see(trail);
                }
            }
        }
        let answer = self.estimate(&sample, reset);
        self.last = answer;
        answer
    }

    /// Lets displaced joint angles that stay as they are count again, where an emptied bucket can test them.
    #[cold]
    fn test_jumps(&mut self) {
        let Some(working) = self.core.working() else {
            return;
        };
        if self.tests_jumps && !working.tests_jumps() {
            self.screen.believe_jumps();
            self.tests_jumps = false;
        } else if !self.screen.is_displaced() {
            working.ends_the_test();
            self.tests_jumps = false;
        } else if let Some(jumps) = self.screen.jumps_that_stay()
            && working.puts_to_the_test(jumps, &self.settings)
        {
            self.screen.admit_jumps();
            self.tests_jumps = true;
        }
    }

    /// Records each tick for [`Self::step_with`]. Returns false if this method has no trail.
    pub fn keep_trail(&mut self) -> bool {
        self.trailing = self.core.working().is_some();
        self.core
            .working()
            .into_iter()
            .for_each(Working::keep_trail);
        self.trailing
    }

    /// Takes one tick of the grid. Returns whether the filter was reset to its prior.
    fn tick(&mut self, tick: &Tick, trail: &mut Option<Trail>) -> bool {
        let mut reset = self.check_presence(tick) | self.find_lag(tick);
        let Some(mut tick) = self.align.pass(tick) else {
            self.wait(tick);
            return reset;
        };
        let needs_posture = self.needs().1;
        if self.calibrates(&tick, trail) || needs_posture && !self.grid.has_posture() {
            self.wait(&tick);
            return reset;
        }
        tick.velocity = tick.velocity.map(|y| y - self.bias);
        tick.velocity_variance *= self.noise_ratio();
        self.reading = Some(
            self.core
                .step(&self.settings, &mut tick, self.method, trail),
        );
        if !self.core.is_sound() {
            self.restart(false);
            *trail = None;
            reset = true;
        }
        reset
    }

    /// Handles a row without values. Once none has come for longer than a gap that is filled, the filter restarts and waits, since anything
    /// may have moved. Returns whether it restarts; `None` while it goes on.
    #[cold]
    fn wait_for_values(&mut self, fill: &Fill) -> Option<bool> {
        let tick = fill.now();
        if !tick.is_empty() {
            return None;
        }
        let before = if fill.before().is_empty() {
            self.silent
        } else {
            0.0
        };
        self.silent = before + tick.period;
        if self.silent <= LONG_GAP {
            return None;
        }
        let restarts = before <= LONG_GAP;
        if restarts {
            self.align.clear();
            self.restart(false);
        }
        self.wait(tick);
        Some(restarts)
    }

    /// Follows a change of the torque's hold. An interpolated torque is late by the hold, of which a stated delay includes half. Returns
    /// whether the estimator restarts.
    fn hold(&mut self, period: f64) -> bool {
        let rows = self.screen.torque_held();
        // Jittering stamps change the length of a hold by a row.
        let same = rows == self.held || rows.min(self.held) > 1 && rows.abs_diff(self.held) < 3;
        if self.lag.is_none() || same {
            return false;
        }
        self.held = rows;
        let stated = self.settings.sensors.delays;
        let late = (rows - 1) as f64 * period;
        let unstated = if stated[1] > 0.0 { 0.5 * late } else { late };
        let delays = [stated[0], stated[1] + unstated];
        self.lag = stated_lag(&self.settings, delays, 0.5 * late).map(Lag::new);
        self.is_late(delays)
    }

    /// Compares torque and velocity with their present lag. Returns whether another lag is found and the estimator restarts.
    fn find_lag(&mut self, tick: &Tick) -> bool {
        if !self.grid.has_posture() {
            return false;
        }
        let Some(lag) = &mut self.lag else {
            return false;
        };
        let [velocity, torque] = self.delays;
        let inertia = self.core.inertia(&self.settings, tick.posture).empty;
        let Some(found) = lag.push(tick, inertia, torque - velocity) else {
            return false;
        };
        let late = f64::from(found) * PERIOD;
        // A delay common to both, relative to the joint angles, is retained.
        let both = velocity.min(torque);
        self.is_late([both + (-late).max(0.0), both + late.max(0.0)])
    }

    /// Sets the delays of velocity and torque. Returns whether the estimator restarts because of them.
    fn is_late(&mut self, delays: [f64; 2]) -> bool {
        let ticks = |delays: [f64; 2]| delays.map(|delay| crate::math::round(delay / PERIOD));
        let same = ticks(delays) == ticks(self.delays);
        self.delays = delays;
        if !same {
            self.align = Align::new(delays);
            let stood = self.core.has_stood();
            self.restart(stood);
        }
        !same
    }

    /// Measured over described variance of the velocity.
    fn noise_ratio(&self) -> f64 {
        let ratio = self.settings.sensors.swing_velocity_std / self.described_std;
        ratio * ratio
    }

    /// Whether bias and noise are still being measured.
    fn calibrates(&mut self, tick: &Tick, trail: &mut Option<Trail>) -> bool {
        let Some(calibration) = &mut self.calibration else {
            return false;
        };
        match calibration.step(tick, self.slowness) {
            Progress::Measuring => {
                // The estimate waits, but the detectors run on, in case the measurement fails.
                if !self.needs().1 || self.grid.has_posture() {
                    self.core
                        .step(&self.settings, &mut tick.clone(), self.method, trail);
                }
                return true;
            }
            Progress::Stood(found) => self.calibrated(found),
            Progress::Failed => {}
        }
        self.calibration = None;
        false
    }

    fn calibrated(&mut self, found: Calibrated) {
        self.bias = found.bias;
        self.settings.sensors.swing_velocity_std *= found.noise;
        self.restart(true);
    }

    fn restart(&mut self, stood: bool) {
        // A restarted filter cannot test displaced joint angles.
        self.screen.refuse_jumps();
        self.tests_jumps = false;
        self.core = Core::new(&self.settings, self.method, !self.columns.velocity, stood);
        if self.trailing {
            self.core
                .working()
                .into_iter()
                .for_each(Working::keep_trail);
        }
        self.reading = None;
    }

    /// Reports the prior at this posture while there is no estimate.
    fn wait(&mut self, tick: &Tick) {
        let posture = self.grid.has_posture().then_some(tick.posture);
        self.reading = Some(Reading {
            tick: *tick,
            state: prior_state(&self.settings, self.needs().1, posture),
            reasons: Reasons {
                consistent: true,
                fresh: tick.velocity.is_some(),
                ..Reasons::default()
            },
            held: true,
            code: 1,
        });
    }

    /// After the first second of the velocity `auto` drops columns that never had a value, and adds them when one comes. Before the first
    /// velocity the source is silent, and its columns are not checked.
    fn check_presence(&mut self, tick: &Tick) -> bool {
        if self.presence_checked || self.elapsed == 0.0 && tick.velocity.is_none() {
            return false;
        }
        self.elapsed += tick.period;
        if self.elapsed < PRESENCE {
            return false;
        }
        let mut columns = self.columns;
        columns.torque &= self.grid.torque().is_some();
        columns.posture &= self.grid.has_posture();
        let (all, method) = (
            Method::for_columns(self.columns),
            Method::for_columns(columns),
        );
        self.presence_checked = method == all;
        let gives_up = self.method == all;
        let (before, now) = (needs(self.method), needs(method));
        let takes_up = now.0 >= before.0 && now.1 >= before.1;
        if method == self.method
            || !(gives_up || takes_up)
            || check_method(&self.settings, method, columns).is_err()
        {
            return false;
        }
        self.method = method;
        let stood = self.core.has_stood();
        self.restart(stood);
        true
    }

    /// Whether the method uses the torque, and whether it uses the posture.
    fn needs(&self) -> (bool, bool) {
        needs(self.method)
    }
}

/// Details that a reference implementation shows besides the estimate.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Details {
    /// The bucket opens.
    pub opening: bool,
    /// A change of payload was declared less than 0.3 s ago.
    pub change_mode: bool,
    /// The tick of the estimate is flagged as a change of torque.
    pub flagged: bool,
    /// Velocity at the tick of the estimate [rad/s].
    pub velocity: f64,
}

/// Lag of the torque behind the velocity, and its standard deviation including that of an unstated delay [s]; `None` on a calibrated
/// machine.
fn stated_lag(settings: &Settings, delays: [f64; 2], unstated: f64) -> Option<[f64; 2]> {
    let std = settings.doubts?.delay_std;
    let total = crate::math::sqrt(std * std + unstated * unstated);
    Some([delays[1] - delays[0], total])
}

fn prior_state(settings: &Settings, uses_posture: bool, posture: Option<[f64; 3]>) -> State {
    let prior = &settings.prior;
    match posture {
        Some(posture) if uses_posture => {
            let now = settings.geometry.inertia(posture);
            State {
                inertia: now.with_payload(prior.payload),
                inertia_std: now.per_payload * prior.payload_std,
                payload: Some((prior.payload, prior.payload_std)),
                ..State::default()
            }
        }
        _ => State {
            inertia: prior.inertia,
            inertia_std: prior.inertia_std,
            ..State::default()
        },
    }
}
