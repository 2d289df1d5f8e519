//! Levels joined by smooth ramps, the `pw(points, ramp)` of the scenarios.

/// 3 u^2 - 2 u^3 between u = 0 and u = 1; 0 before, 1 after.
pub(super) fn smoothstep(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Least number of points retained: more than ever have ramps under way.
const RETAINED: usize = 64;

/// A value over time: each point begins a ramp from the level before to its own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Profile {
    /// Time [s] and level; times do not decrease.
    points: Vec<(f64, f64)>,
    /// Duration of every ramp [s].
    ramp: f64,
}

impl Profile {
    pub fn new(points: &[(f64, f64)], ramp: f64) -> Self {
        Self {
            points: points.to_vec(),
            ramp,
        }
    }

    /// Begins another ramp at `time`, which is not before the last point. Old points are dropped, because a run may be endless.
    pub fn push(&mut self, time: f64, level: f64) {
        if self.points.len() >= 2 * RETAINED {
            self.points.drain(..RETAINED);
        }
        self.points.push((time, level));
    }

    /// The value at time `t` [s].
    pub fn at(&self, t: f64) -> f64 {
        // Ramps that have ended telescope to the level of the last of them.
        let ended = self.points.partition_point(|p| p.0 + self.ramp <= t).max(1);
        let Some(&(_, mut value)) = self.points.get(ended - 1) else {
            return 0.0;
        };
        for pair in self.points[ended - 1..]
            .windows(2)
            .take_while(|pair| pair[1].0 < t)
        {
            value += (pair[1].1 - pair[0].1) * smoothstep((t - pair[1].0) / self.ramp);
        }
        value
    }

    /// Whether a ramp is under way at time `t`.
    pub fn moving(&self, t: f64) -> bool {
        self.points
            .windows(2)
            .any(|p| p[0].1 != p[1].1 && p[1].0 <= t && t < p[1].0 + self.ramp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_start_at_their_points_and_join_the_levels() {
        let p = Profile::new(&[(0.0, 1.0), (2.0, 5.0), (6.0, -1.0)], 1.0);
        let at = [-1.0, 0.0, 2.0, 2.5, 3.0, 5.0, 6.5, 7.0, 99.0].map(|t| p.at(t));
        assert_eq!(at, [1.0, 1.0, 1.0, 3.0, 5.0, 5.0, 2.0, -1.0, -1.0]);
        assert!(p.moving(2.0) && p.moving(2.9) && !p.moving(3.0));
    }

    #[test]
    fn a_profile_that_goes_on_for_ever_stays_short_and_gives_the_same() {
        let level = |i: u32| f64::from(i * 7919 % 13);
        let all: Vec<_> = (0..5000).map(|i| (f64::from(i), level(i))).collect();
        let (whole, mut p) = (Profile::new(&all, 2.5), Profile::new(&all[..1], 2.5));
        for (time, level) in &all[1..] {
            p.push(*time, *level);
            assert_eq!(p.at(*time), whole.at(*time));
        }
        assert!(p.points.len() <= 2 * RETAINED);
    }

    #[test]
    fn overlapping_ramps_add_up() {
        let p = Profile::new(&[(0.0, 0.0), (1.0, 1.0), (1.5, 3.0)], 1.0);
        let by_hand = smoothstep(0.75) + 2.0 * smoothstep(0.25);
        assert!((p.at(1.75) - by_hand).abs() < 1e-15);
    }
}
