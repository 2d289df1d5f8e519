//! The processes that a sample passes on its path to a user of the estimate, by the table of processes.

use messages::{Hop, Machine};
use runtime::Arrival;
use steps::stages::{Pipeline, Role, Stage};

/// A chain: the source, some steps, and the probe in the place of a user.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Machine of the chain.
    pub machine: Machine,
    source: &'static str,
    steps: Vec<(&'static str, Hop)>,
}

impl Chain {
    /// The chain that leads to the probe.
    pub fn of(machine: Machine) -> Self {
        let pipeline = Pipeline::of(machine);
        let find = |is: fn(&Role) -> bool| pipeline.stages.iter().find(|s| is(&s.role));
        let probe = find(|role| matches!(role, Role::Probe(_)));
        let last = probe
            .and_then(Stage::input)
            .and_then(|c| pipeline.writer(c));
        let path = last.map_or_else(Vec::new, |last| pipeline.path_to(last));
        let steps = path
            .iter()
            .filter_map(|row| Some((pipeline.writer(row.output())?.name, row.hop())));
        Self {
            machine,
            source: find(|role| matches!(role, Role::Source { .. })).map_or("", |s| s.name),
            steps: steps.collect(),
        }
    }

    /// Number of processes, including the probe.
    pub fn processes(&self) -> usize {
        self.steps.len() + 2
    }

    /// Names of the hops.
    pub fn hops(&self) -> Vec<String> {
        let steps = self.steps.iter().map(|(name, _)| *name);
        let names: Vec<&str> = [self.source].into_iter().chain(steps).collect();
        let next = names[1..].iter().chain(&["user"]);
        let pairs = names.iter().zip(next);
        pairs.map(|(from, to)| format!("{from} to {to}")).collect()
    }

    /// Time of each hop \[ns\].
    pub fn spans(&self, arrival: &Arrival) -> Vec<u64> {
        let marks = self.steps.iter().map(|(_, hop)| match hop {
            Hop::Filter => arrival.filter_ns,
            Hop::Estimate => arrival.estimate_ns,
        });
        let mut before = arrival.sensor_ns;
        let since = |mark: u64| mark.saturating_sub(std::mem::replace(&mut before, mark));
        marks.chain([arrival.received_ns]).map(since).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chains_are_those_of_the_table() {
        let arrival = Arrival {
            sequence: 0,
            sensor_ns: 1,
            filter_ns: 10,
            estimate_ns: 100,
            received_ns: 1000,
        };
        let excavator = Chain::of(Machine::Excavator);
        assert_eq!(
            excavator.hops(),
            ["sensor to kalman", "kalman to rls", "rls to user"]
        );
        assert_eq!(excavator.spans(&arrival), [9, 90, 900]);
        let loader = Chain::of(Machine::Loader);
        assert_eq!(loader.hops(), ["sensor to ukf", "ukf to user"]);
        assert_eq!(loader.spans(&arrival), [99, 900]);
        assert_eq!(loader.processes(), 3);
    }
}
