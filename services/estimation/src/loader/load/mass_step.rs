//! A load that is weighed: a step of the mass moves the centre of gravity at once.
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
//! A bucket holds its load some three quarters of its reach ahead of the front axle, so lam is known again to a few percent;
//! its height is anything from the ground to above the machine, so h keeps its value and loses its certainty. Where nobody
//! tells when the boom moves, the height of a loaded machine stays uncertain. When the mass comes back to that of the empty
//! machine, so does its centre of gravity.

use crate::loader::keys::Prior;
use crate::math::sqrt;

/// Mean and standard deviation of the load's way ahead of the front axle, in bucket reaches.
const ARM: f64 = 0.75;
const ARM_STD: f64 = 0.2;
/// Standard deviation of the load's height over that of the machine.
pub const HEIGHT_SPREAD: f64 = 0.7;
/// A change below this share of the mass is noise of the weighing.
const LEAST_STEP: f64 = 0.01;
/// A load has come or gone when the mass has held for this long [s].
const SETTLED: f64 = 1.0;
/// Within this share the mass is that of the empty machine again.
const SAME: f64 = 0.02;

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

/// Memory of the mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Load {
    /// The mass that counts, and when it became so [kg], [s].
    anchor: Option<f64>,
    quiet: f64,
    /// Mass before the step that goes on.
    from: f64,
    /// Share of the mass that this step has moved so far.
    moved: f64,
    /// The least mass that held: the empty machine.
    empty: Option<(f64, Option<Centre>)>,
}

/// What a row's mass does to the estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// dm/M.
    pub share: f64,
    /// Variance that comes with it, in units of the squared errors of arm and height.
    pub variance: f64,
    /// The machine is empty again, as it was.
    pub restored: Option<Centre>,
}

impl Load {
    /// Takes the mass of a row, `dt` after the one before; `centre` is what is known of the centre of gravity.
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
            // What is known of the machine before it is loaded is worth remembering.
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

    /// The step is over: the machine may be the empty one again.
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

    /// Centre of gravity with this load, where nothing but that of the empty machine is known; `reach` in wheelbases.
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

    /// The machine is the empty one, and its mass has held.
    pub fn is_empty(&self) -> bool {
        self.moved == 0.0 && self.share() <= SAME
    }

    /// Share of the mass that is load.
    pub fn share(&self) -> f64 {
        match (self.anchor, self.empty) {
            (Some(mass), Some((least, _))) => ((mass - least) / mass).max(0.0),
            _ => 0.0,
        }
    }
}

impl Shift {
    /// The ratio after the shift, and the standard deviation that comes with it; `reach` is that of the bucket in wheelbases.
    pub fn ratio(&self, ratio: f64, reach: f64) -> (f64, f64) {
        let arm = 1.0 + ARM * reach;
        let std = ARM_STD * reach * sqrt(self.variance);
        (ratio + self.share * (arm - ratio), std)
    }

    /// Standard deviation that comes with the shift of the height.
    pub fn height_std(&self, height: f64) -> f64 {
        HEIGHT_SPREAD * height * sqrt(self.variance)
    }
}
