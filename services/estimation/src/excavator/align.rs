//! Aligns signals with stated delays to a common time.
//!
//! A value stamped t of a signal that is delayed by d was true at t - d. A late torque drives a model whose posture is already
//! ahead. A late velocity differs by more than `d w'` where the torque changes fast. So stated delays are removed in whole ticks:
//! every signal waits for the latest one. The models carry the remainder of at most half a tick, and unstated delays
//! ([`super::working`] has them as a state).

use super::grid::{PERIOD, Tick};

/// Longest wait [ticks]; the models carry the rest of a longer delay.
const LONGEST: usize = 24;

/// Stated delays of velocity and torque, in whole ticks.
fn ticks(delays: [f64; 2]) -> [usize; 2] {
    delays.map(|d| ((d / PERIOD + 0.5).max(0.0) as usize).min(LONGEST))
}

/// Rest of the stated delays after removal of whole ticks: that of the velocity minus that of the torque [s].
pub(super) fn rest(delays: [f64; 2]) -> f64 {
    let [velocity, torque] = ticks(delays).map(|n| n as f64 * PERIOD);
    (delays[0] - velocity) - (delays[1] - torque)
}

/// The last ticks, and how long each signal waits; `None` without delays.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Align(Option<Waiting>);

#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Waiting {
    ring: [Tick; LONGEST + 1],
    count: usize,
    /// Wait of velocity, torque, posture [s].
    waits: [f64; 3],
}

impl Align {
    /// From the stated delays of velocity and torque [s].
    pub(super) fn new(delays: [f64; 2]) -> Self {
        let late = ticks(delays);
        let latest = late[0].max(late[1]);
        let wait = |n: usize| n as f64 * PERIOD;
        Self((latest > 0).then(|| Waiting {
            ring: [Tick::default(); LONGEST + 1],
            count: 0,
            waits: [wait(latest - late[0]), wait(latest - late[1]), wait(latest)],
        }))
    }

    /// Discards the stored ticks.
    pub(super) fn clear(&mut self) {
        if let Some(waiting) = &mut self.0 {
            waiting.count = 0;
        }
    }

    /// Takes a tick. Returns the tick of the common time, once all signals of it are there.
    pub(super) fn pass(&mut self, tick: &Tick) -> Option<Tick> {
        match &mut self.0 {
            Some(waiting) => waiting.pass(tick),
            None => Some(*tick),
        }
    }
}

impl Waiting {
    fn pass(&mut self, tick: &Tick) -> Option<Tick> {
        let [velocity, torque, posture] = self.waits;
        self.ring[self.count % self.ring.len()] = *tick;
        self.count += 1;
        let whole = self.before(tick.time - posture)?;
        let motion = self.before(tick.time - velocity)?;
        let driven = self.before(tick.time - torque)?;
        Some(Tick {
            velocity: motion.velocity,
            velocity_variance: motion.velocity_variance,
            torque: driven.torque,
            share: driven.share,
            torque_age: driven.torque_age,
            ..whole
        })
    }

    /// The newest tick that is at most half a tick later than `time`.
    fn before(&self, time: f64) -> Option<Tick> {
        let n = self.ring.len();
        let mut found = None;
        for age in 0..n.min(self.count) {
            let tick = &self.ring[(self.count - 1 - age) % n];
            if found.is_none() && tick.time < time + 0.5 * PERIOD {
                found = Some(*tick);
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_signal_meets_the_others_of_its_time() {
        let mut align = Align::new([0.0, 0.031]);
        assert!((rest([0.0, 0.031]) + 0.001).abs() < 1e-12);
        let mut last = None;
        for k in 0..100 {
            let time = f64::from(k) * PERIOD;
            last = align.pass(&Tick {
                time,
                velocity: Some(time),
                torque: time - 0.03,
                posture: [time; 3],
                ..Tick::default()
            });
            assert_eq!(last.is_some(), k >= 3, "{k}");
        }
        let last = last.expect("a tick");
        for value in [last.velocity.unwrap_or(0.0), last.torque, last.posture[0]] {
            assert!((value - 0.96).abs() < 1e-9, "{last:?}");
        }
    }

    #[test]
    fn without_a_stated_delay_nothing_waits() {
        let tick = Tick {
            time: 5.0,
            ..Tick::default()
        };
        assert_eq!(Align::new([0.0, 0.004]).pass(&tick), Some(tick));
        assert_eq!(rest([0.0, 0.004]), -0.004);
        // A delay beyond the longest wait leaves a rest.
        assert!((rest([0.5, 0.0]) - 0.26).abs() < 1e-12);
    }
}
