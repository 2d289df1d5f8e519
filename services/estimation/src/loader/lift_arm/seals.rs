//! Friction of the cylinder's seals, as a play operator: it opposes the last motion of the rod, and remains while the rod stands.
//!
//! A play of half-width w follows the length l of the rod (Prandtl; Dahl's model moves within .4 mm, but the angle is not measured as well):
//! ```text
//! share = (l - anchor)/w,   |share| <= 1: the anchor is dragged along
//! ```

/// Time constant of the smoothed length of the rod [s].
const SMOOTH: f64 = 0.2;
/// Half-width of the play [m]: four standard deviations of an angle's noise of 2 mrad on a lever of 1 m, smoothed.
const PLAY: f64 = 1.5e-3;

/// Share of the friction beyond which it acts fully against the motion.
const AGAINST: f64 = 0.9;
/// Standard deviation of friction, as a share of its size: within the play, and fully against the motion.
const WITHIN_PLAY: f64 = 0.7;
const FULLY_AGAINST: f64 = 0.25;

/// State of the play.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Seals {
    /// Smoothed length and anchor [m].
    rod: Option<(f64, f64)>,
    /// The rod has moved through the play, so the direction is known.
    known: bool,
    /// Friction as a share of its size, positive while the rod extends; 0 while the direction is unknown.
    share: f64,
}

impl Seals {
    /// Updates with the length of the cylinder [m].
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

    /// Resets the play: the last motion is unknown.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Friction as a share of its size, positive while the rod extends; 0 while the direction is unknown.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Standard deviation of friction, as a share of its size.
    pub fn unknown(&self) -> f64 {
        match (self.known, self.share.abs() > AGAINST) {
            (false, _) => 1.0,
            (true, false) => WITHIN_PLAY,
            (true, true) => FULLY_AGAINST,
        }
    }
}
