//! Signals that are stated to come late, brought to one time.
//!
//! A value stamped t of a signal that is d late was true at t - d. A late torque drives a model whose posture is already
//! further on, and a late velocity differs by more than `d w'` where the torque changes fast; so what is stated is taken
//! out exactly, in whole ticks: every signal waits until the latest one has come. What is left, at most half a tick, and what
//! nobody stated is for the models ([`super::working`] has it as a state).

use super::grid::{PERIOD, Tick};

/// Longest wait [ticks]; what is beyond is left to the models.
const LONGEST: usize = 24;

/// Stated delays of velocity and torque, in whole ticks.
fn ticks(delays: [f64; 2]) -> [usize; 2] {
    delays.map(|d| ((d / PERIOD + 0.5).max(0.0) as usize).min(LONGEST))
}

/// What whole ticks leave of the stated delays: that of the velocity less that of the torque [s].
pub(super) fn rest(delays: [f64; 2]) -> f64 {
    let [velocity, torque] = ticks(delays).map(|n| n as f64 * PERIOD);
    (delays[0] - velocity) - (delays[1] - torque)
}

/// The last ticks, and how long each signal waits; none where nothing is late.
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
    /// For stated delays of velocity and torque [s].
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

    /// Forgets what has been.
    pub(super) fn clear(&mut self) {
        if let Some(waiting) = &mut self.0 {
            waiting.count = 0;
        }
    }

    /// Takes a tick and gives that of the common time, once there is one.
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

    /// The newest tick that is not later than a time, but for half a tick.
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
        // Beyond the ring the rest stays.
        assert!((rest([0.5, 0.0]) - 0.26).abs() < 1e-12);
    }
}
