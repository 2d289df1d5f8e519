//! Payload changes during the swing: the base path with other bucket moves.

use super::path::{Joint, Path};
use super::payload::Load;
use super::plant::Plant;
use super::plants::{at_rest, swing, working_swing};

/// Time from the first motion of the bucket to the first falling material [s].
const UNTIL_MATERIAL: f64 = 0.15;
/// Time in which a full bucket opens [s].
const OPENING: f64 = 0.9;

/// A change of the payload, or a motion that resembles one.
pub(super) struct Event {
    /// Mass before a dump, or after a pick-up [kg].
    pub payload: f64,
    /// First and last time of the change [s].
    pub change: (f64, f64),
    /// The bucket's move: from, to [s], by [deg].
    opening: Option<(f64, f64, f64)>,
    /// Share of the payload that is dumped or picked up.
    share: f64,
    /// Whether the share is picked up.
    gained: bool,
}

impl Event {
    /// The bucket opens by 75 degrees in 0.9 s and is empty 0.65 s after the first material has left.
    pub fn dump(opens: f64) -> Self {
        let first = opens + UNTIL_MATERIAL;
        Self {
            payload: 423.0,
            change: (first, first + 0.65),
            opening: Some((opens, opens + OPENING, 75.0)),
            share: 1.0,
            gained: false,
        }
    }

    /// The bucket opens by 35 degrees and loses half of its load.
    pub fn half(opens: f64) -> Self {
        Self {
            opening: Some((opens, opens + OPENING, 35.0)),
            share: 0.5,
            ..Self::dump(opens)
        }
    }

    /// The load leaves within `duration`, beginning 0.1 s after the bucket moves.
    pub fn slow(opens: f64, duration: f64) -> Self {
        let (first, last) = (opens + 0.1, opens + 0.1 + duration);
        Self {
            change: (first, last),
            opening: Some((opens, last, 75.0)),
            ..Self::dump(opens)
        }
    }

    /// The bucket opens by 60 degrees and retains its 288 kg.
    pub fn open(opens: f64) -> Self {
        Self {
            payload: 288.0,
            change: (opens, opens + OPENING),
            opening: Some((opens, opens + OPENING, 60.0)),
            share: 0.0,
            gained: false,
        }
    }

    /// An empty bucket opens by 75 degrees.
    pub fn open_empty(opens: f64) -> Self {
        let opening = Some((opens, opens + OPENING, 75.0));
        Self {
            payload: 0.0,
            opening,
            ..Self::open(opens)
        }
    }

    /// The load leaves without a motion of the bucket.
    pub fn still(first: f64, duration: f64) -> Self {
        Self {
            change: (first, first + duration),
            opening: None,
            ..Self::dump(first)
        }
    }

    /// An empty bucket takes up 300 kg in 0.6 s.
    pub fn pick_up(first: f64) -> Self {
        Self {
            payload: 300.0,
            gained: true,
            ..Self::still(first, 0.6)
        }
    }

    /// The plant with a payload of `mass` before a dump, or after a pick-up.
    pub fn plant(&self, mass: f64) -> Plant {
        let mut path = Path::base();
        let mut moves = vec![(1.4, 3.4, -50.0)];
        moves.extend(self.opening);
        path.joints[2] = Joint::new(-35.0, &moves);

        let changing = Load {
            mass: mass * self.share,
            ..Load::kept(0.0)
        };
        let changing = if self.gained {
            Load {
                fill: self.change,
                ..changing
            }
        } else {
            Load {
                fill: (1.5, 3.4),
                dump: self.change,
                ..changing
            }
        };
        let kept = Load {
            mass: mass * (1.0 - self.share),
            fill: (1.5, 3.4),
            ..Load::kept(0.0)
        };
        swing(at_rest(path, vec![kept, changing]), working_swing())
    }
}
