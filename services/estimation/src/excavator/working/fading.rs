//! What the motion has told of the machine's constants fades towards what the description says.
//!
//! ```text
//! c <- d + k (c - d),   P_cc <- k^2 P_cc + (1 - k^2) S,   P_co <- k P_co,   k = exp(-dt / LASTS)
//! ```
//! with c the constants, d and S what the description says of them, o the other states (Ornstein, Uhlenbeck). No model is exact: what
//! it misses pushes the constants the same way in each swing. A filter that takes them for constants knows them ever more closely, and
//! after hours believes a machine that is none. That the motion pushes no further than what is missed is due to the states' units
//! ([`super::filter`]).
//!
//! Pressures alone are told the same by the drawing's errors in each cycle of digging and dumping, and no swing contradicts them. So
//! what they tell counts for a cycle; that of the slope too, which they tell from the same postures.

use super::Working;
use super::correlations::correlate;
use super::filter::{BUCKET, Filter, GAIN, LINKS, N, SLOPE, SPAN, UPPER};
use super::trail::Trail;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// What motion tells counts for so long, in motion [s]. A simulated machine with pressures is trusted no more after two hours without
/// fading; with 300 s it is for all of them.
const LASTS: f64 = 300.0;
/// Between two times that it fades, in motion [s]: little fades in between.
const EVERY: f64 = 20.0;
/// The same of what pressures alone tell [s]: a cycle of an excavator lasts 15 to 25 s. From 5 to 40 s no sound machine is trusted wrongly;
/// with 300 s the inertia is a tenth too small after half an hour, for each of four simulated machines.
const LASTS_ALONE: f64 = 20.0;
const EVERY_ALONE: f64 = 2.0;
/// Constants that grow together and leave every motion as it is.
pub(super) const CONSTANTS: [usize; 5] = [GAIN, UPPER, BUCKET, LINKS, SPAN];
/// Those that pressures alone tell only from the postures of a cycle.
const CONSTANTS_ALONE: [usize; 7] = [GAIN, UPPER, BUCKET, LINKS, SPAN, SLOPE, SLOPE + 1];

impl Working {
    /// Time in motion passes.
    pub(super) fn fade(&mut self, settings: &Settings, period: f64, trail: &mut Option<Trail>) {
        if let Some(kept) = self.kept(period, (LASTS, EVERY)) {
            self.fade_all(settings, (&CONSTANTS, kept), trail);
        }
    }

    /// A block of the pressures is over in which joints have moved, and no torque has ever told anything.
    #[inline(never)]
    pub(super) fn fade_alone(
        &mut self,
        settings: &Settings,
        period: f64,
        trail: &mut Option<Trail>,
    ) {
        if let Some(kept) = self.kept(period, (LASTS_ALONE, EVERY_ALONE)) {
            self.fade_all(settings, (&CONSTANTS_ALONE, kept), trail);
        }
    }

    /// The share that is kept, where enough time has passed.
    fn kept(&mut self, period: f64, (lasts, every): (f64, f64)) -> Option<f64> {
        self.unfaded += period;
        // Periods are rounded.
        (self.unfaded + 0.5 * period >= every)
            .then(|| exp(-core::mem::take(&mut self.unfaded) / lasts))
    }

    #[inline(never)]
    fn fade_all(
        &mut self,
        settings: &Settings,
        (states, kept): (&'static [usize], f64),
        trail: &mut Option<Trail>,
    ) {
        let described = self.described(settings);
        for filter in [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ] {
            filter.fade(&described, kept, states);
        }
        self.scale.has_no_torque();
        if let Some(trail) = trail {
            trail.fade(states, kept);
        }
    }

    /// What the description says of all states.
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
    /// Of what was told of these states this share is kept.
    pub(super) fn fade(&mut self, described: &Self, kept: f64, states: &[usize]) {
        for &i in states {
            self.x[i] = described.x[i] + kept * (self.x[i] - described.x[i]);
            for j in 0..N {
                self.p[i][j] *= kept;
                self.p[j][i] *= kept;
            }
        }
        let lost = 1.0 - kept * kept;
        for &i in states {
            for &j in states {
                self.p[i][j] += lost * described.p[i][j];
            }
        }
    }
}
