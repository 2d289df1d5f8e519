//! Friction of the cylinder's seals: it opposes the last motion of the rod, and keeps doing so while the rod stands.
//!
//! A play of half-width w follows the rod (Prandtl; Dahl's model moves within .4 mm, but the angle is not measured as well):
//! ```text
//! share = (l - anchor)/w,   |share| <= 1: the anchor is dragged along
//! ```

/// Smoothing of the rod's length [s].
const SMOOTH: f64 = 0.2;
/// Half-width of the play [m]: four standard deviations of an angle's noise of 2 mrad on a lever of 1 m, smoothed.
const PLAY: f64 = 1.5e-3;

/// From this share on friction is against the motion.
const AGAINST: f64 = 0.9;
/// How far friction is not known, as a share of it: within the play, and against the motion.
const WITHIN_PLAY: f64 = 0.7;
const FULLY_AGAINST: f64 = 0.25;

/// Memory of the rod.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Seals {
    /// Smoothed length and anchor [m].
    rod: Option<(f64, f64)>,
    /// The rod has moved through the play: the direction is known.
    known: bool,
    /// Friction as a share of its size, positive while the rod goes out; 0 while nothing is known.
    share: f64,
}

impl Seals {
    /// Takes the length of the cylinder [m].
    pub fn take(&mut self, length: f64, dt: f64) {
        let (smooth, anchor) = self.rod.get_or_insert((length, length));
        *smooth += (dt / SMOOTH).min(1.0) * (length - *smooth);
        let away = *smooth - *anchor;
        if away.abs() > PLAY {
            *anchor = *smooth - PLAY.copysign(away);
            self.known = true;
        }
        if self.known {
            self.share = (*smooth - *anchor) / PLAY;
        }
    }

    /// Nothing is known of the last motion.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Friction as a share of its size, positive while the rod goes out; 0 while nothing is known.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// How far friction is not known, as a share of its size.
    pub fn unknown(&self) -> f64 {
        match (self.known, self.share.abs() > AGAINST) {
            (false, _) => 1.0,
            (true, false) => WITHIN_PLAY,
            (true, true) => FULLY_AGAINST,
        }
    }
}
