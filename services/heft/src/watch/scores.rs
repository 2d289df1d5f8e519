//! Estimates beside their truth, where there is one.

use std::collections::VecDeque;

use messages::channels::Channel;
use messages::{Envelope, Message};

use crate::quantity;
use crate::tally::{Scored, Tally};

/// Number of truths stored until their estimates come.
const TRUTHS: usize = 2048;

/// The tallies of a run.
#[derive(Default)]
pub(super) struct Scores {
    truths: VecDeque<(u64, Envelope)>,
    tallies: Vec<Tally>,
}

impl Scores {
    /// Of all quantities, in the order of their first estimate.
    pub(super) fn tallies(&self) -> &[Tally] {
        &self.tallies
    }

    /// Stores a truth for its estimates.
    pub(super) fn know(&mut self, sequence: u64, truth: Envelope) {
        if self.truths.len() == TRUTHS {
            self.truths.pop_front();
        }
        self.truths.push_back((sequence, truth));
    }

    fn truth(&self, sequence: u64) -> Option<&Envelope> {
        let at = self.truths.binary_search_by_key(&sequence, |(s, _)| *s);
        Some(&self.truths[at.ok()?].1)
    }

    /// Counts every quantity of an estimate.
    pub(super) fn add<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        for quantity in quantity::of_channel(channel.name) {
            let (Some(value), Some(std)) = (
                message.number(quantity.row.name),
                message.number(quantity.std),
            ) else {
                continue;
            };
            let truth = self.truth(message.stamp().sequence);
            let truth = truth.and_then(|truth| quantity.truth(truth));
            let at = self.tallies.iter().position(|t| t.quantity == quantity);
            let at = at.unwrap_or_else(|| {
                self.tallies.push(Tally::new(quantity));
                self.tallies.len() - 1
            });
            self.tallies[at].add(Scored {
                time: message.stamp().time,
                value,
                std,
                trusted: message.bits_of("flags") & quantity.row.trusted != 0,
                truth,
            });
        }
    }
}
