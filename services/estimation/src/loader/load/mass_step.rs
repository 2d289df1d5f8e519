//! Shift of the centre of gravity by a step of the reported mass.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | M, dm | `mass` | mass with the load; its step | kg |
//! | X | `ARM` | where the load sits, in wheelbases ahead of the rear axle: (l + x_p)/l | 1 |
//! | h_p | - | height of the load | m |
//!
//! ```text
//! lam+ = lam + (dm/M)(X - lam),   h+ = h + (dm/M)(h_p - h)
//! ```
//! A bucket holds its load some three quarters of its reach ahead of the front axle, so lam stays known to a few percent. The height of the
//! load is between the ground and above the machine, so h retains its value and its deviation grows. Where motion of the boom is not
//! reported, the height of a loaded machine stays uncertain. When the mass returns to that of the empty machine, its centre of gravity is
//! restored.
//!
//! A recording may begin with a load. Then the first mass exceeds the described one, and counts as a step from it ([`is_load`]).

use core::f64::consts::TAU;

use crate::loader::keys::Prior;
use crate::math::{exp, sqrt};

/// Mean and standard deviation of the load's distance ahead of the front axle, in bucket reaches.
const ARM: f64 = 0.75;
const ARM_STD: f64 = 0.2;
/// Standard deviation of the load's height, as a share of the height of the machine's centre of gravity.
pub const HEIGHT_SPREAD: f64 = 0.7;
/// Share of the mass below which a change is noise of the weighing.
const LEAST_STEP: f64 = 0.01;
/// Time of constant mass after which a step is complete [s].
const SETTLED: f64 = 1.0;
/// Tolerance within which the mass is that of the empty machine, as a share.
const SAME: f64 = 0.02;

/// Standard deviation of the described mass, as a share: options, tyres, a full tank.
const DESCRIBED_STD: f64 = 0.05;
/// Largest load of a loader over its own mass.
const LARGEST: f64 = 0.5;
/// Share of the recordings that begin with a load.
const BEGINS_LOADED: f64 = 0.3;

/// Probability that a first mass, beyond the described one by this share of it, is that of a load and not of another description.
///
/// ```text
/// q/(1 - q) = Q/(1 - Q) (1/.5)/N(x; 0, .05^2),   0 < x < .5,   Q = .3
/// ```
pub fn is_load(excess: f64) -> f64 {
    if !(0.0..LARGEST).contains(&excess) {
        return 0.0;
    }
    let z = excess / DESCRIBED_STD;
    let described = exp(-0.5 * z * z) / (DESCRIBED_STD * sqrt(TAU));
    let load = BEGINS_LOADED / LARGEST;
    load / (load + (1.0 - BEGINS_LOADED) * described)
}

/// Centre of gravity of the empty machine: height, ratio, and their standard deviations.
pub type Centre = [(f64, f64); 2];

impl Prior {
    /// The centre of gravity of the empty machine.
    pub fn centre(&self) -> Centre {
        [
            (self.cg_height, self.cg_height_std),
            (self.cg_ratio, self.cg_ratio_std),
        ]
    }
}

/// State of the mass and its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Load {
    /// Mass that counts [kg], and time for which it has been constant [s].
    anchor: Option<f64>,
    quiet: f64,
    /// Mass before the present step [kg].
    from: f64,
    /// Change of the mass by this step so far, as a share; 0 between steps.
    moved: f64,
    /// Empty machine: least constant mass [kg], and its centre of gravity.
    empty: Option<(f64, Option<Centre>)>,
}

/// Effect of a row's mass on the estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// dm/M.
    pub share: f64,
    /// Variance of the shift, in units of the squared deviations of the load's distance and height.
    pub variance: f64,
    /// Centre of gravity of the empty machine, where the mass has returned to it.
    pub restored: Option<Centre>,
}

impl Load {
    /// The machine starts with the load by which its first mass exceeds that of its description [kg]: the next row is a step from the latter.
    pub fn starts(&mut self, described: f64) {
        self.anchor = Some(described);
    }

    /// Updates with the mass of a row, `dt` after the last; `centre`: present estimate of the centre of gravity.
    pub fn weigh(&mut self, mass: f64, centre: Centre, dt: f64) -> Option<Shift> {
        let anchor = *self.anchor.get_or_insert(mass);
        if (mass - anchor).abs() < LEAST_STEP * anchor {
            self.quiet += dt;
            return (self.quiet >= SETTLED && self.moved != 0.0)
                .then(|| self.settle(anchor))
                .flatten();
        }
        if self.moved == 0.0 {
            self.from = anchor;
            let (least, known) = self.empty.unwrap_or((anchor, None));
            // The estimate of the empty machine is stored before it is loaded.
            if anchor <= (1.0 + SAME) * least {
                self.empty = Some((anchor.min(least), Some(centre)));
            } else {
                self.empty = Some((least, known));
            }
        }
        self.anchor = Some(mass);
        self.quiet = 0.0;
        let moved = (mass - self.from) / mass;
        let variance = (moved * moved - self.moved * self.moved).max(0.0);
        self.moved = moved;
        Some(Shift {
            share: (mass - anchor) / mass,
            variance,
            restored: None,
        })
    }

    /// Ends a step, and restores the centre of gravity of the empty machine where its mass has returned.
    fn settle(&mut self, mass: f64) -> Option<Shift> {
        self.moved = 0.0;
        let (least, known) = self.empty?;
        let same = (mass - least).abs() <= SAME * least;
        if mass < (1.0 - SAME) * least {
            self.empty = Some((mass, None));
        }
        let restored = known.filter(|_| same)?;
        Some(Shift {
            restored: Some(restored),
            ..Shift::default()
        })
    }

    /// Prior of the centre of gravity with this load, from that of the empty machine; `reach` of the bucket in wheelbases.
    pub fn expected(&self, [height, ratio]: Centre, reach: f64) -> Centre {
        let share = self.share();
        let loaded = |(centre, std): (f64, f64), load: f64, load_std: f64| {
            let (std, load_std) = ((1.0 - share) * std, share * load_std);
            let variance = std * std + load_std * load_std;
            (centre + share * (load - centre), sqrt(variance))
        };
        [
            loaded(height, height.0, HEIGHT_SPREAD * height.0),
            loaded(ratio, 1.0 + ARM * reach, ARM_STD * reach),
        ]
    }

    /// The machine is empty, and no step is going on.
    pub fn is_empty(&self) -> bool {
        self.moved == 0.0 && self.share() <= SAME
    }

    /// Load over mass.
    pub fn share(&self) -> f64 {
        match (self.anchor, self.empty) {
            (Some(mass), Some((least, _))) => ((mass - least) / mass).max(0.0),
            _ => 0.0,
        }
    }
}

impl Shift {
    /// Ratio after the shift, and its added standard deviation; `reach` of the bucket in wheelbases.
    pub fn ratio(&self, ratio: f64, reach: f64) -> (f64, f64) {
        let arm = 1.0 + ARM * reach;
        let std = ARM_STD * reach * sqrt(self.variance);
        (ratio + self.share * (arm - ratio), std)
    }

    /// Standard deviation added to the height.
    pub fn height_std(&self, height: f64) -> f64 {
        HEIGHT_SPREAD * height * sqrt(self.variance)
    }
}
