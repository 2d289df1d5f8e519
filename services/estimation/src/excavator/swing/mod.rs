//! State-space estimators behind one `step` (process `ukf`): input conditioning, choice of the
//! mode, standstill, verdict.
//!
//! The modes are extended Kalman filters and a grid. The square-root UKF on the model of mode D
//! differs by at most 0.15 standard deviations over a swing (tests/excavator_ukf.rs) and costs more.

mod answer;
mod method;

use self::method::check_method;
use super::align::Align;
use super::calibration::{Calibrated, Calibration, Progress};
use super::estimate::{Columns, Estimate, Flags, Method, Sample};
use super::grid::{Grid, PERIOD, Tick};
use super::lag::Lag;
use super::mode::{Core, Reading, needs};
use super::reason::Reason;
use super::screen::Screen;
use super::settings::Settings;
use super::settings_error::SettingsError;
use super::state::State;
use super::verdict::Reasons;
use super::working::{Trail, Working};

/// A column that has no value for this long counts as absent [s].
const PRESENCE: f64 = 1.0;

/// Swing inertia from the sensors, by any state-space mode.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SwingEstimator {
    /// With the measured noise of the velocity; that as described [rad/s].
    settings: Settings,
    described_std: f64,
    method: Method,
    columns: Columns,
    screen: Screen,
    grid: Grid,
    align: Align,
    /// Where torque and posture are measured of a machine that is not calibrated: how late they come, found from the data.
    lag: Option<Lag>,
    /// How late velocity and torque come, as stated or as found [s]; rows for which a torque stays.
    delays: [f64; 2],
    held: usize,
    calibration: Option<Calibration>,
    bias: f64,
    core: Core,
    elapsed: f64,
    /// Ticks of the grid per row of the source.
    slowness: f64,
    presence_checked: bool,
    reading: Option<Reading>,
    trailing: bool,
    /// Joint angles that have jumped count, and are put to the test.
    tests_jumps: bool,
    last: Estimate,
}

impl SwingEstimator {
    /// Checks the settings, and that the columns which `method` needs exist. `Auto` chooses by the
    /// columns, and falls back while a column has no values in the first second of the velocity.
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

    /// The settings as given.
    pub fn described(&self) -> Settings {
        let mut described = self.settings;
        described.sensors.swing_velocity_std = self.described_std;
        described
    }

    /// The method at work; never `Auto`.
    pub fn method(&self) -> Method {
        self.method
    }

    /// What the last tick did: 0 moved, 1 held, 2 set off with a measured velocity.
    #[doc(hidden)] // what a comparison with a reference implementation asks
    pub fn code(&self) -> u8 {
        self.reading.map_or(1, |reading| reading.code)
    }

    /// Details of the last tick for comparison with a reference: bucket opening, change mode, change
    /// flag of the delayed tick, probability of the drop model, velocity of the mode.
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
            drop_probability: state.drop_probability,
            velocity: state.velocity,
        }
    }

    /// Takes in one row and always answers. A row whose time does not increase is refused and
    /// changes nothing, unless one stamp was wrong or the clock was set back for good: then the
    /// estimator begins anew.
    pub fn step(&mut self, sample: &Sample) -> Estimate {
        self.step_with(sample, &mut |_| {})
    }

    /// The same, for an analysis off line: `see` gets what each tick did, in order, once [`Self::keep_trail`] has been called and
    /// while the default with torque and posture is at work.
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

    /// Angles that have jumped, and stay where they are, count again where an emptied bucket can tell whether they are right.
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

    /// Keeps what each tick does for [`Self::step_with`]; false where this method has nothing to keep.
    pub fn keep_trail(&mut self) -> bool {
        self.trailing = self.core.working().is_some();
        self.core
            .working()
            .into_iter()
            .for_each(Working::keep_trail);
        self.trailing
    }

    /// One tick of the grid; true where the filter was set back to its prior.
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

    /// The torque is seen to be held, or not any more: joined by lines it is late by the hold, half of which was in what was
    /// stated, if anything was.
    fn hold(&mut self, period: f64) -> bool {
        let rows = self.screen.torque_held();
        // Stamps that jitter make a hold longer and shorter by a row.
        let same = rows == self.held || rows.min(self.held) > 1 && rows.abs_diff(self.held) < 3;
        if self.lag.is_none() || same {
            return false;
        }
        self.held = rows;
        let stated = self.settings.sensors.delays;
        let late = (rows - 1) as f64 * period;
        let unsaid = if stated[1] > 0.0 { 0.5 * late } else { late };
        let delays = [stated[0], stated[1] + unsaid];
        self.lag = stated_lag(&self.settings, delays, 0.5 * late).map(Lag::new);
        self.is_late(delays)
    }

    /// Whether torque and velocity come together as stated; true where they do not and all begins anew.
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
        // By as much as both come behind the joint angles, they are late all the same.
        let both = velocity.min(torque);
        self.is_late([both + (-late).max(0.0), both + late.max(0.0)])
    }

    /// Velocity and torque come so late; true where all begins anew for that.
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

    /// True while bias and noise are being measured.
    fn calibrates(&mut self, tick: &Tick, trail: &mut Option<Trail>) -> bool {
        let Some(calibration) = &mut self.calibration else {
            return false;
        };
        match calibration.step(tick, self.slowness) {
            Progress::Measuring => {
                // The estimate waits, but what the detectors see counts if nothing is measured.
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
        // Who begins anew cannot tell whether they are right.
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

    /// Nothing to go by yet: the prior at this posture.
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

    /// After the first second of the velocity `auto` gives up columns that never had a value, and takes them up when one comes. Before
    /// that second the source is silent, and says nothing of its columns.
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

    /// Whether the method uses torque, posture.
    fn needs(&self) -> (bool, bool) {
        needs(self.method)
    }
}

/// What a reference implementation would show besides the estimate.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Details {
    /// The bucket opens.
    pub opening: bool,
    /// A change of payload was declared less than 0.3 s ago.
    pub change_mode: bool,
    /// The tick behind the estimate lies in a change of torque.
    pub flagged: bool,
    /// Probability of the drop model (variant `Drop`).
    pub drop_probability: f64,
    /// Velocity of the tick behind the estimate [rad/s].
    pub velocity: f64,
}

/// How much later the torque comes than the velocity, and its standard deviation with what else may be late [s]; nothing where
/// the machine is calibrated.
fn stated_lag(settings: &Settings, delays: [f64; 2], unsaid: f64) -> Option<[f64; 2]> {
    let std = settings.doubts?.delay_std;
    let total = crate::math::sqrt(std * std + unsaid * unsaid);
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
