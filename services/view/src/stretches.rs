//! Segments of a run: swings of an excavator, drives of a loader, each with its verdicts.

use crate::estimate::Estimate;
use crate::judgement::Judgement;
use crate::words::run_judgements;

/// Least duration of a pause that ends a stretch \[s\].
pub const PAUSE: f64 = 0.3;
/// Least duration of a stretch \[s\].
pub const SHORTEST: f64 = 1.0;

/// A stretch of motion.
#[derive(Debug, Clone)]
pub struct Stretch {
    /// Begin \[s\].
    pub start: f64,
    /// Duration \[s\].
    pub duration: f64,
    /// Judgement of each headline quantity: the last trusted one within the stretch, else the last one.
    pub reported: Vec<Judgement>,
    /// Index of the estimate of the first of them.
    pub index: usize,
}

/// The stretches in which the machine moves: `speed` is at least `least`, short pauses included.
pub fn stretches<E: Estimate>(
    estimates: &[E],
    speed: impl Fn(&E) -> f64,
    least: f64,
) -> Vec<Stretch> {
    let time = |i: usize| estimates[i].stamp().time;
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (i, estimate) in estimates.iter().enumerate() {
        if speed(estimate) < least {
            continue;
        }
        match found.last_mut() {
            Some((_, end)) if time(i) - time(*end) < PAUSE => *end = i,
            _ => found.push((i, i)),
        }
    }
    let long = found
        .into_iter()
        .filter(|(a, b)| time(*b) - time(*a) >= SHORTEST);
    long.map(|(first, last)| {
        let judgements = run_judgements(&estimates[first..=last]);
        Stretch {
            start: time(first),
            duration: time(last) - time(first),
            index: first + judgements.first().map_or(0, |j| j.index),
            reported: judgements.into_iter().map(|j| j.reported).collect(),
        }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, Stamp, excavator_bits as x};

    /// Moves from 1 to 4 s with a pause of 0.1 s, and for 0.5 s at 6 s.
    fn run() -> Vec<ExcavatorEstimate> {
        let estimate = |i: i32| {
            let t = f64::from(i) * 0.1;
            let moves =
                (1.0..2.0).contains(&t) || (2.1..4.0).contains(&t) || (6.0..6.5).contains(&t);
            ExcavatorEstimate {
                stamp: Stamp {
                    time: t,
                    ..Default::default()
                },
                velocity: if moves { -0.5 } else { 0.0 },
                inertia: 5000.0 + t,
                inertia_std: 50.0,
                estimated: x::INERTIA,
                flags: if (2.95..3.05).contains(&t) {
                    x::TRUSTED
                } else {
                    0
                },
                ..Default::default()
            }
        };
        (0..80).map(estimate).collect()
    }

    #[test]
    fn a_short_pause_does_not_end_a_swing_and_a_twitch_is_none() {
        let found = stretches(&run(), |e| e.velocity.abs(), 0.05);
        assert_eq!(found.len(), 1);
        assert!((found[0].start - 1.0).abs() < 0.05 && (found[0].duration - 2.9).abs() < 0.15);
    }

    #[test]
    fn what_was_trusted_within_the_swing_is_reported() {
        let found = stretches(&run(), |e| e.velocity.abs(), 0.05);
        assert!(found[0].reported[0].trusted);
        assert_eq!(found[0].index, 30);
    }
}
