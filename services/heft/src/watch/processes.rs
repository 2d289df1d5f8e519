//! Reports of the processes of a run on themselves: health, counts, states.

use std::collections::BTreeMap;

use messages::keyframe::Collector;
use messages::{Health, Keyframe, Machine, Snapshot};
use steps::stages::Pipeline;

use super::counts::Counts;

/// The processes of a machine, by their rows in its pipeline.
#[derive(Default)]
pub struct Processes {
    pipeline: Option<&'static Pipeline>,
    health: BTreeMap<u32, Health>,
    /// Counts of processes that died.
    before: BTreeMap<u32, Counts>,
    /// Parts of their states, and their latest complete ones.
    collectors: BTreeMap<u32, Collector>,
    states: BTreeMap<u32, Snapshot>,
    /// The source is as fast as its readers: samples have no due times, and none is late.
    pub(super) is_unpaced: bool,
}

impl Processes {
    pub(super) fn of(machine: Machine) -> Self {
        Self {
            pipeline: Some(Pipeline::of(machine)),
            ..Self::default()
        }
    }

    /// Their pipeline.
    pub(super) fn pipeline(&self) -> Option<&'static Pipeline> {
        self.pipeline
    }

    /// Takes a report; returns the name of the process.
    pub(super) fn note_health(&mut self, health: &Health) -> Option<&'static str> {
        let before = self.health.insert(health.process, *health);
        if let Some(before) = before.filter(|b| b.pid != health.pid) {
            self.before.entry(health.process).or_default().add(&before);
        }
        self.pipeline.map(|p| p.process_name(health.process))
    }

    /// Takes a part of a state.
    pub(super) fn note_state(&mut self, piece: &Keyframe) {
        let collector = self.collectors.entry(piece.process).or_default();
        if let Some(state) = collector.take(piece) {
            self.states.insert(piece.process, state);
        }
    }

    /// The values of a map by process, with the names of the processes.
    fn named<'a, T>(
        &'a self,
        of: &'a BTreeMap<u32, T>,
    ) -> impl Iterator<Item = (&'static str, &'a T)> {
        let pipeline = self.pipeline.into_iter();
        pipeline.flat_map(move |p| of.iter().map(|(i, value)| (p.process_name(*i), value)))
    }

    /// Latest health of all of them, by name.
    pub fn all_health(&self) -> impl Iterator<Item = (&'static str, &Health)> {
        self.named(&self.health)
    }

    /// Latest health of the process called `name`.
    pub fn health(&self, name: &str) -> Option<&Health> {
        let mut all = self.all_health();
        all.find_map(|(process, health)| (process == name).then_some(health))
    }

    /// Latest complete state of the process called `name`.
    pub fn state(&self, name: &str) -> Option<&Snapshot> {
        let mut all = self.named(&self.states);
        all.find_map(|(process, state)| (process == name).then_some(state))
    }

    /// Counts of all of them, by name.
    pub(super) fn counts(&self) -> impl Iterator<Item = (&'static str, Counts)> {
        self.all_health().map(|(name, health)| {
            let before = self.before.get(&health.process).copied();
            let mut counts = before.unwrap_or_default();
            counts.add(health);
            counts.late = if self.is_unpaced { 0 } else { counts.late };
            (name, counts)
        })
    }

    /// Counts of the process called `name`.
    pub fn counts_of(&self, name: &str) -> Counts {
        let found = self.counts().find(|(process, _)| *process == name);
        found.map_or(Counts::default(), |(_, counts)| counts)
    }

    /// Samples lost by all processes together.
    pub(super) fn lost(&self) -> u64 {
        self.counts().map(|(_, counts)| counts.lost).sum()
    }
}
