//! Present content of the bucket: always a value, without jumps back to the prior.
//!
//! Where the content may have changed, an estimator resets its payload to the prior (mean p0, variance S). A controller
//! holds the last value instead, with a standard deviation that covers the possible change, and uses only
//! the information that the estimator gains afterwards:
//!
//! ```text
//! information   i = 1/s^2 - 1/S,          of the value   y = (p/s^2 - p0/S)/i
//! held          V = v + (k - p0)^2 + S,   now = (k/V + y i)/(1/V + i)
//! ```

use super::row::Row;
use crate::Quantity;
use crate::math::sqrt;

/// Present content of the bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Now {
    /// Payload \[kg\].
    pub kg: f64,
    /// Standard deviation; it grows with time and with possible changes \[kg\].
    pub std: f64,
    /// Time since it was last weighed; `None` if it never was \[s\].
    pub age: Option<f64>,
}

/// Ratio of a variance to that of the previous row above which the estimator has reset it.
const OPENED: f64 = 1.5;
/// Ratio of the estimator's variance to that at the reset below which its value is used directly.
const LEARNT: f64 = 0.02;
/// Random walk of the content of a closed bucket, from which material falls, in rated payloads per root second.
const CREEP: f64 = 0.002;
/// Growth of the standard deviation without any estimate, in rated payloads per second: a bucket is filled or emptied within seconds.
const UNSEEN: f64 = 0.2;
/// Standard deviation of an unknown content, in rated payloads.
const UNKNOWN: f64 = 0.6;

/// Last known payload and its possible change.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Holding {
    rated: f64,
    now: Option<Quantity>,
    /// Payload of the estimator at its reset, and the payload held then.
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

    /// Takes a row, `dt` after the previous one. `weighed`: it determines the content.
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
                let (information, prior) = ((own - was).max(0.0), 1.0 / variance(held));
                let moment = if information > 0.0 {
                    p.value * own - open.value * was
                } else {
                    0.0
                };
                let sum = prior + information;
                Quantity {
                    value: (held.value * prior + moment) / sum,
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

    /// Widens the held value over `dt` without an estimate.
    fn unseen(&mut self, dt: f64) {
        if let Some(now) = &mut self.now {
            let most = (UNKNOWN * self.rated).max(now.std);
            now.std = (now.std + UNSEEN * self.rated * dt).min(most);
        }
    }

    /// The present content of the bucket. Before any estimate: half of the rated payload, with [`UNKNOWN`].
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
