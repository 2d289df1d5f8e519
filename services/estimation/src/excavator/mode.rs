//! A state-space mode with its inputs: standstill, detectors of changes, verdict.

pub(in crate::excavator) mod drive;
pub(in crate::excavator) mod onset;
pub(in crate::excavator) mod posture;
pub(in crate::excavator) mod posture_torque;
pub(in crate::excavator) mod state;
pub(in crate::excavator) mod torque;
pub(in crate::excavator) mod unknown_torque;
pub(in crate::excavator) mod velocity;

use super::change::ChangeDetector;
use super::delay::Entry;
use super::drive::{Drive, Driver};
use super::estimate::Method;
use super::geometry::Inertia;
use super::grid::Tick;
use super::onset::WeakOnset;
use super::posture::PostureMode;
use super::posture_torque::PostureTorque;
use super::reason::Reason;
use super::settings::Settings;
use super::standstill::{Phase, Standstill};
use super::state::State;
use super::torque::TorqueMode;
use super::velocity::VelocityMode;
use super::verdict::{Basis, Reasons, Verdict};
use super::working::{Trail, Working};

#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "no allocator; one per process")]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Mode {
    PostureTorque(PostureTorque),
    Torque(TorqueMode),
    Posture(PostureMode),
    Velocity(VelocityMode),
}

/// A mode with its inputs; rebuilt from the prior after a reset.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Core {
    mode: Mode,
    driver: Driver,
    standstill: Standstill,
    detector: ChangeDetector,
    onset: Option<WeakOnset>,
    verdict: Verdict,
}

/// Result of a tick.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Reading {
    pub(super) tick: Tick,
    pub(super) state: State,
    pub(super) reasons: Reasons,
    pub(super) held: bool,
    pub(super) code: u8,
}

/// Whether a method uses the torque, and whether it uses the posture.
pub(super) fn needs(method: Method) -> (bool, bool) {
    (
        matches!(method, Method::PostureTorque | Method::Torque),
        matches!(method, Method::PostureTorque | Method::Posture),
    )
}

impl Core {
    /// At its prior. `angle`: the velocity is differenced from a swing angle; `stood`: a standstill was seen before.
    pub(super) fn new(settings: &Settings, method: Method, angle: bool, stood: bool) -> Self {
        let (s, e) = (&settings.sensors, &settings.estimator);
        let mode = match method {
            Method::PostureTorque => Mode::PostureTorque(PostureTorque::new(settings)),
            Method::Torque => Mode::Torque(TorqueMode::new(settings)),
            Method::Posture => Mode::Posture(PostureMode::new(settings)),
            _ => Mode::Velocity(VelocityMode::new(settings)),
        };
        let posture = method == Method::Posture;
        let constant = method == Method::Velocity && e.constant_inertia;
        let mut standstill = Standstill::new(settings, angle);
        if stood {
            standstill.confirm();
        }
        Self {
            mode,
            driver: Driver::default(),
            standstill,
            detector: ChangeDetector::new(e.reject, e.q_c, s.swing_velocity_std),
            onset: (e.weak_onset && (posture || constant))
                .then(|| WeakOnset::new(settings, posture)),
            verdict: Verdict::new(),
        }
    }

    /// Goes on after a gap. The default estimator with torque and posture knows what it has learnt of the machine; any other mode begins
    /// from its prior.
    #[cold]
    pub(super) fn goes_on(&mut self, settings: &Settings, method: Method, angle: bool) {
        let mut new = Self::new(settings, method, angle, false);
        if let Some(working) = self.working() {
            working.goes_on(settings);
            core::mem::swap(&mut new.mode, &mut self.mode);
        }
        *self = new;
    }

    /// Ages what is known by `period` of a gap that has lasted for `silent` so far \[s\].
    #[cold]
    pub(super) fn waits(&mut self, settings: &Settings, period: f64, silent: f64) {
        if let Some(working) = self.working() {
            working.waits(settings, period, silent);
        }
    }

    /// Inertia at a posture; stored, so that [`Self::step`] does not compute it again.
    pub(super) fn inertia(&mut self, settings: &Settings, posture: [f64; 3]) -> &Inertia {
        self.driver.inertia(&settings.geometry, posture)
    }

    /// Advances by one tick, without the signals that the method does not use. The default estimator writes its step into `trail`.
    pub(super) fn step(
        &mut self,
        settings: &Settings,
        tick: &mut Tick,
        method: Method,
        trail: &mut Option<Trail>,
    ) -> Reading {
        let (needs_torque, needs_posture) = needs(method);
        let torque = (needs_torque && tick.torque_age.is_finite()).then_some(tick.torque);
        let mut event = false;
        if !needs_torque {
            let gated = self
                .detector
                .step(tick.velocity, tick.velocity_variance, tick.period);
            tick.velocity = gated.velocity;
            event = gated.event;
            // The method does not use a measured torque.
            tick.torque_age = f64::INFINITY;
        }
        let velocity = (tick.velocity, tick.velocity_variance);
        let phase = self.standstill.step(velocity, torque, tick.period);
        let stood_for = self.standstill.held_for();
        let reopen = phase != Phase::Held && stood_for >= settings.estimator.reopen_after - 1e-9;
        self.standstill.count(phase, tick.period);
        let geometry = needs_posture.then_some(&settings.geometry);
        let torque_std = settings.sensors.swing_torque_std;
        let drive = self.driver.step(tick, geometry, torque_std);
        if let Some(onset) = &mut self.onset {
            event |= onset.step(settings, &drive, phase);
        }
        let scale = self.turns_to_scale(settings, method, &drive);
        let mut state = self.advance(settings, &drive, (phase, reopen), event, trail);
        let held = match &self.mode {
            Mode::Posture(mode) => mode.held(),
            Mode::Velocity(mode) => mode.held(),
            Mode::PostureTorque(_) | Mode::Torque(_) => phase == Phase::Held,
        };
        // Without torque or without posture, a change of inertia cannot be distinguished from a moving arm, nor from a deviation of
        // the machine from its description.
        let identified =
            needs_torque && needs_posture || scale || settings.is_partly_identifiable();
        let basis = if identified {
            self.basis(settings)
        } else {
            Basis::Nothing
        };
        if !identified {
            state.reason = Reason::Method;
            let posture = needs_posture.then_some(tick.posture);
            let half = settings.partial_range(posture);
            state.inertia_std = half.widened(state.inertia, state.inertia_std);
            // The payload is not identifiable either: it returns to the prior.
            let prior = &settings.prior;
            state.payload = state.payload.map(|_| (prior.payload, prior.payload_std));
        }
        let accepted = tick.velocity.is_some();
        self.verdict.step(settings, tick, accepted, &state, basis);
        let needs = (needs_torque, needs_posture);
        Reading {
            tick: *tick,
            state,
            reasons: self.verdict.reasons(settings, tick, &state, basis, needs),
            held,
            code: match phase {
                _ if held => 1,
                Phase::Released(_) => 2,
                _ => 0,
            },
        }
    }

    /// Switches `posture` to the default filter with unknown torque once boom pressures weigh the load. Returns whether it is switched.
    fn turns_to_scale(&mut self, settings: &Settings, method: Method, drive: &Drive) -> bool {
        let weighs = method == Method::Posture && settings.boom.is_some();
        if weighs
            && settings.doubts.is_some()
            && drive.boom_pressure.is_some()
            && matches!(self.mode, Mode::Posture(_))
        {
            self.mode = Mode::PostureTorque(PostureTorque::new(settings));
        }
        weighs && matches!(self.mode, Mode::PostureTorque(_))
    }

    /// Advances the mode by one tick.
    fn advance(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        (phase, reopen): (Phase, bool),
        event: bool,
        trail: &mut Option<Trail>,
    ) -> State {
        match &mut self.mode {
            Mode::PostureTorque(mode) => mode.step(settings, drive, (phase, reopen), trail),
            Mode::Torque(mode) => mode.step(settings, drive, phase, reopen),
            Mode::Posture(mode) => mode.step(settings, drive, (phase, reopen), event),
            Mode::Velocity(mode) => mode.step(settings, Entry::new(drive, phase, reopen), event),
        }
    }

    /// What the identifiability of the present state is based on.
    fn basis(&self, settings: &Settings) -> Basis {
        match &self.mode {
            Mode::PostureTorque(_) => Basis::PostureTorque,
            Mode::Torque(_) => Basis::Torque {
                stood: self.standstill.seen(),
            },
            Mode::Posture(mode) => Basis::Steady(mode.unflagged_for()),
            Mode::Velocity(mode) if settings.estimator.constant_inertia => {
                Basis::Steady(mode.unflagged_for())
            }
            Mode::Velocity(_) => Basis::Nothing,
        }
    }

    /// The default estimator with torque and posture, if it is active.
    pub(super) fn working(&mut self) -> Option<&mut Working> {
        match &mut self.mode {
            Mode::PostureTorque(mode) => mode.working(),
            _ => None,
        }
    }

    /// Whether the numbers of the mode are finite, without negative variances.
    pub(super) fn is_sound(&self) -> bool {
        match &self.mode {
            Mode::PostureTorque(mode) => mode.is_sound(),
            Mode::Torque(mode) => mode.is_sound(),
            Mode::Posture(mode) => mode.is_sound(),
            Mode::Velocity(mode) => mode.is_sound(),
        }
    }

    /// Whether a standstill has been seen.
    pub(super) fn has_stood(&self) -> bool {
        self.standstill.seen()
    }
}
