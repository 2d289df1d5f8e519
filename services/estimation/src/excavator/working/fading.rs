//! Fading of the machine's constants towards their description.
//!
//! ```text
//! c <- d + k (c - d),   P_cc <- k^2 P_cc + (1 - k^2) S,   P_co <- k P_co,   k = exp(-dt / LASTS)
//! ```
//! c are the constants, d and S their described values and covariance, o the other states (Ornstein, Uhlenbeck). No model is exact: its
//! errors push the constants in the same direction in each swing. A filter that takes them for constant becomes ever more certain, and
//! after hours trusts a machine that does not exist. The motion pushes no further than the model's errors, because of the states' units
//! ([`super::filter`]).
//!
//! With pressures alone, the drawing's errors act equally in each cycle of digging and dumping, and no swing contradicts them. Their
//! information therefore lasts for one cycle. So does that about the slope, which comes from the same postures.

use super::Working;
use super::correlations::correlate;
use super::filter::{BUCKET, Filter, GAIN, LINKS, N, SLOPE, SPAN, UPPER};
use super::trail::Trail;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// Time constant of what motion has identified, in motion [s]. Without fading, a simulated machine with pressures is no longer trusted
/// after two hours. With 300 s it is, for all of them.
const LASTS: f64 = 300.0;
/// Time between two steps of fading, in motion [s]: little fades in between.
const EVERY: f64 = 20.0;
/// Time constant with pressures alone [s]: a cycle of an excavator lasts 15 to 25 s. From 5 to 40 s no sound machine is trusted wrongly.
/// With 300 s the inertia is a tenth too small after half an hour, for each of four simulated machines.
const LASTS_ALONE: f64 = 20.0;
/// Time between two steps of fading with pressures alone [s].
const EVERY_ALONE: f64 = 2.0;
/// Constants that can grow together without changing any motion.
pub(super) const CONSTANTS: [usize; 5] = [GAIN, UPPER, BUCKET, LINKS, SPAN];
/// Constants that pressures alone identify only from the postures of a cycle.
const CONSTANTS_ALONE: [usize; 7] = [GAIN, UPPER, BUCKET, LINKS, SPAN, SLOPE, SLOPE + 1];

impl Working {
    /// Advances the time in motion, and fades the constants when it is due.
    pub(super) fn fade(&mut self, settings: &Settings, period: f64, trail: &mut Option<Trail>) {
        if let Some(remaining) = self.remaining(period, (LASTS, EVERY)) {
            self.fade_all(settings, (&CONSTANTS, remaining), trail);
        }
    }

    /// The same after a block of the pressures in which joints have moved, before any torque has informed the filter.
    #[inline(never)]
    pub(super) fn fade_alone(
        &mut self,
        settings: &Settings,
        period: f64,
        trail: &mut Option<Trail>,
    ) {
        if let Some(remaining) = self.remaining(period, (LASTS_ALONE, EVERY_ALONE)) {
            self.fade_all(settings, (&CONSTANTS_ALONE, remaining), trail);
        }
    }

    /// Returns the share of the deviations that remains, once enough time has passed.
    fn remaining(&mut self, period: f64, (lasts, every): (f64, f64)) -> Option<f64> {
        self.unfaded += period;
        // Periods are rounded.
        (self.unfaded + 0.5 * period >= every)
            .then(|| exp(-core::mem::take(&mut self.unfaded) / lasts))
    }

    #[inline(never)]
    fn fade_all(
        &mut self,
        settings: &Settings,
        (states, remaining): (&'static [usize], f64),
        trail: &mut Option<Trail>,
    ) {
        let described = self.described(settings);
        for filter in [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ] {
            filter.fade(&described, remaining, states);
        }
        self.scale.has_no_torque();
        if let Some(trail) = trail {
            trail.fade(states, remaining);
        }
    }

    /// Description of all states, with its covariance.
    pub(super) fn described(&self, settings: &Settings) -> Filter {
        let mut described = Filter::new(self.described, &self.stated);
        if let Some((doubts, found)) = settings.doubts.as_ref().and_then(|d| Some((d, d.found?))) {
            correlate(&mut described, doubts, found);
        }
        if let Some(weigh) = &self.weigh {
            weigh.correlate(&mut described);
        }
        described
    }
}

impl Filter {
    /// Fades these states towards their description; the share `remaining` of the deviation remains.
    pub(super) fn fade(&mut self, described: &Self, remaining: f64, states: &[usize]) {
        for &i in states {
            self.x[i] = described.x[i] + remaining * (self.x[i] - described.x[i]);
            for j in 0..N {
                self.p[i][j] *= remaining;
                self.p[j][i] *= remaining;
            }
        }
        let lost = 1.0 - remaining * remaining;
        for &i in states {
            for &j in states {
                self.p[i][j] += lost * described.p[i][j];
            }
        }
    }
}
