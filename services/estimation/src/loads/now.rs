//! What the bucket holds now: always a value, never a jump back to the prior.
//!
//! Where the content may have changed, an estimator opens its payload to the prior (mean p0, variance S). A controller
//! keeps the last value instead, with a deviation that covers what may have happened, and takes from the estimator only
//! what it learns after that:
//!
//! ```text
//! information   i = 1/s^2 - 1/S,          its value   y = (p/s^2 - p0/S)/i
//! held          V = v + (k - p0)^2 + S,   now = (k/V + y i)/(1/V + i)
//! ```

use super::row::Row;
use crate::Quantity;
use crate::math::sqrt;

/// What the bucket holds now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Now {
    /// Payload \[kg\].
    pub kg: f64,
    /// Standard deviation, which grows with time and by what may have changed \[kg\].
    pub std: f64,
    /// Time since it was last weighed; `None` if it never was \[s\].
    pub age: Option<f64>,
}

/// A variance that grows by more than this from one row to the next was opened.
const OPENED: f64 = 1.5;
/// Where the estimator has learnt so much that the share left of its variance is below this, it is followed.
const LEARNT: f64 = 0.02;
/// Material falls off a bucket that stays closed: random walk, in rated payloads per root second.
const CREEP: f64 = 0.002;
/// Without any estimate the bucket may be filled or emptied within some seconds: rated payloads per second.
const UNSEEN: f64 = 0.2;
/// Standard deviation of a content of which nothing is known, in rated payloads.
const UNKNOWN: f64 = 0.6;

/// The last known payload, and what may have changed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Holding {
    rated: f64,
    now: Option<Quantity>,
    /// The estimator's payload when it was opened, and what was held then.
    opened: Option<(Quantity, Quantity)>,
    last: Option<Quantity>,
    seen: Option<f64>,
    time: f64,
}

impl Holding {
    pub(super) fn new(rated: f64) -> Self {
        Self {
            rated,
            now: None,
            opened: None,
            last: None,
            seen: None,
            time: 0.0,
        }
    }

    /// Takes a row, `dt` after the one before. `weighed`: it tells the content.
    pub(super) fn step(&mut self, row: &Row, dt: f64, weighed: bool) {
        self.time = row.time;
        let Some(p) = row.weighed() else {
            self.last = None;
            return self.unseen(dt);
        };
        let held = *self.now.get_or_insert(p);
        let variance = |q: Quantity| q.std * q.std;
        let widened = match self.last {
            Some(last) => variance(p) > OPENED * variance(last),
            None => variance(p) > variance(held),
        };
        if widened {
            let off = held.value - p.value;
            let std = sqrt(variance(held) + off * off + variance(p));
            let value = held.value;
            self.opened = Some((p, Quantity { value, std }));
        }
        self.last = Some(p);
        self.now = Some(match self.opened {
            Some((open, held)) if variance(p) > LEARNT * variance(open) => {
                let (own, was) = (1.0 / variance(p), 1.0 / variance(open));
                let (information, kept) = ((own - was).max(0.0), 1.0 / variance(held));
                let moment = if information > 0.0 {
                    p.value * own - open.value * was
                } else {
                    0.0
                };
                let sum = kept + information;
                Quantity {
                    value: (held.value * kept + moment) / sum,
                    std: sqrt(1.0 / sum),
                }
            }
            _ => {
                self.opened = None;
                p
            }
        });
        if let Some((_, held)) = &mut self.opened {
            let creep = CREEP * self.rated;
            held.std = sqrt(variance(*held) + creep * creep * dt);
        }
        if weighed {
            self.seen = Some(row.time);
        }
    }

    /// Time goes on without an estimate.
    fn unseen(&mut self, dt: f64) {
        if let Some(now) = &mut self.now {
            let most = (UNKNOWN * self.rated).max(now.std);
            now.std = (now.std + UNSEEN * self.rated * dt).min(most);
        }
    }

    /// What the bucket holds now. Before any estimate: half of the rated payload, give or take.
    pub(super) fn now(&self) -> Now {
        let nothing = Quantity {
            value: 0.5 * self.rated,
            std: UNKNOWN * self.rated,
        };
        let now = self.now.unwrap_or(nothing);
        Now {
            kg: now.value,
            std: now.std,
            age: self.seen.map(|seen| (self.time - seen).max(0.0)),
        }
    }
}
