//! What the motion has told of the machine's constants fades towards what the description says.
//!
//! ```text
//! c <- d + k (c - d),   P_cc <- k^2 P_cc + (1 - k^2) S,   P_co <- k P_co,   k = exp(-dt / LASTS)
//! ```
//! with c the constants, d and S what the description says of them, o the other states (Ornstein, Uhlenbeck). No model is exact: what
//! it misses pushes the constants the same way in each swing. A filter that takes them for constants knows them ever more closely, and
//! after hours believes a machine that is none. That the motion pushes no further than what is missed is due to the states' units
//! ([`super::filter`]).

use super::Working;
use super::correlations::correlate;
use super::filter::{BUCKET, Filter, GAIN, LINKS, N, SPAN, UPPER};
use super::trail::Trail;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// What motion tells counts for so long, in motion [s]. A simulated machine with pressures is trusted no more after two hours without
/// fading; with 300 s it is for all of them.
const LASTS: f64 = 300.0;
/// Between two times that it fades, in motion [s]: little fades in between.
const EVERY: f64 = 20.0;
/// Constants that grow together and leave every motion as it is.
pub(super) const CONSTANTS: [usize; 5] = [GAIN, UPPER, BUCKET, LINKS, SPAN];

impl Working {
    /// Time in motion passes.
    pub(super) fn fade(&mut self, settings: &Settings, period: f64, trail: &mut Option<Trail>) {
        self.unfaded += period;
        // Periods are rounded.
        if self.unfaded + 0.5 * period < EVERY {
            return;
        }
        let described = self.described(settings);
        let kept = exp(-core::mem::take(&mut self.unfaded) / LASTS);
        self.filter.fade(&described, kept);
        self.parallel.filter.fade(&described, kept);
        self.scale.filter.fade(&described, kept);
        self.scale.has_no_torque();
        if let Some(trail) = trail {
            trail.fade(kept);
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
    /// Of what was told this share is kept.
    pub(super) fn fade(&mut self, described: &Self, kept: f64) {
        for i in CONSTANTS {
            self.x[i] = described.x[i] + kept * (self.x[i] - described.x[i]);
            for j in 0..N {
                self.p[i][j] *= kept;
                self.p[j][i] *= kept;
            }
        }
        let lost = 1.0 - kept * kept;
        for i in CONSTANTS {
            for j in CONSTANTS {
                self.p[i][j] += lost * described.p[i][j];
            }
        }
    }
}
