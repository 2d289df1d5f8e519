//! Presence of the numbers of a recorded channel.

use messages::Value;
use messages::channels;
use messages::words::Presence;

use crate::RecordedField;

/// Finds the numbers that were not measured, or are not estimated.
pub(crate) struct Recorded {
    presence: Option<Presence>,
    /// Position of the field with the bits of presence.
    at: Option<usize>,
    /// For each field its bit, 0 if it is always present.
    bits: Vec<u32>,
}

impl Recorded {
    /// For a channel with these fields; all are present in an unknown channel.
    pub(crate) fn of(channel: &str, fields: &[RecordedField]) -> Self {
        let presence = channels::find(channel).and_then(|c| Presence::of(&c.payload.shape()));
        let at = presence.and_then(|p| fields.iter().position(|f| f.name == p.field));
        let presence = presence.filter(|_| at.is_some());
        let bits = fields
            .iter()
            .map(|f| presence.map_or(0, |p| p.bit(&f.name)));
        Self {
            presence,
            at,
            bits: bits.collect(),
        }
    }

    /// Whether the number at a position of a message is absent.
    pub(crate) fn lacks(&self, values: &[Value]) -> impl Fn(usize) -> bool {
        let set = self.at.map_or(0, |at| values[at].as_f64() as u32);
        move |i| {
            let is_missing = |p: Presence| p.is_missing(values[i], self.bits[i], set);
            self.presence.is_some_and(is_missing)
        }
    }
}
