//! The residuals of one stretch of driving, in bins of half a second.
//!
//! The wheel speed determines the speed once its slip s_i is known, and the slip follows from the torque ([`super::wheels`]):
//! ```text
//! u_i = (r_i w_i - L s_i') (1 - |s_i|) where the wheel drives, over (1 - |s_i|) where it brakes
//! s + tau_s s' = b + th + kappa (a/g - th)
//! ```
//! with the specific force a of the accelerometer minus its zero z, or of the torques without one, and the reading s of the slope
//! sensor. A bin has the first three residuals, two seconds have the last:
//!
//! | residual | determines |
//! |---|---|
//! | u_f - u_r, mean | radii, their load sensitivity, stiffness of the axles, loads |
//! | speed - u(t - tau), mean | radii, stiffness, delay of the speed |
//! | accelerometer - balance of force, mean | torque gains against the mass, z + c g forward and z - c g backward |
//! | change of u from second to second - integral of a - g sin th | z - g b, delay of the slope sensor, its sensitivity to acceleration |
//!
//! Driving forward alone therefore leaves one sum of the zeros z and b and of the rolling resistance c undetermined. It retains the
//! width of their priors, unless the machine also drives in reverse, or the same path out and back ([`super::out_and_back`]).
//!
//! The body pitches and heaves, axle loads and tyres follow with a lag, and bumps turn all of it into noise of a few hertz. A filter
//! that treats every row as white noise around this model is overconfident in wrong values. Means of all signals over half a second
//! nearly satisfy the model without these lags, their regressors have little noise, and the remaining scatter shows between stretches.

use std::ops::Range;

use super::drive::Drive;
use super::guess::Guess;
use super::wheels::{Acting, Slipping, balance, slipping};
use crate::model::Innovation;

/// Number of bins in a window over which motion and slope are averaged: the change of the slope must exceed its noise, which
/// otherwise hides a part of its delay.
const WINDOW: usize = 2;
/// Longest delay of the speed [s]: rows within it from the start of a stretch have no speed residual.
pub const LONGEST_DELAY: f64 = 0.45;

/// Predicted signals of a row; NaN where a signal is missing.
struct Expected {
    /// Speeds from the wheels [m/s].
    speeds: [f64; 2],
    /// Specific force from the torques [m/s^2].
    balance: f64,
    /// Rate of the speed, from specific force and slope [m/s^2].
    rate: f64,
}

impl Expected {
    fn of(drive: &Drive, g: &Guess, k: usize) -> Self {
        let acting = Acting::at(drive, g, k);
        let wheels = [drive.wheels[0][k], drive.wheels[1][k]];
        let forward = (wheels[0] + wheels[1]).signum();
        let measured = g.force(drive, k);
        let a = if measured.is_finite() {
            measured
        } else {
            balance(g, &acting, forward, balance(g, &acting, forward, 0.0))
        };
        Self {
            speeds: [0, 1].map(|i| {
                let Slipping {
                    radius,
                    faster,
                    wound,
                } = slipping(g, i, &acting, forward, a);
                (radius * wheels[i] - wound) / faster
            }),
            balance: balance(g, &acting, forward, a),
            rate: a - acting.along,
        }
    }

    fn speed(&self) -> f64 {
        0.5 * (self.speeds[0] + self.speeds[1])
    }
}

/// Appends the residuals of a stretch: always the same number.
pub fn residuals(drive: &Drive, block: &Range<usize>, g: &Guess, out: &mut Vec<Innovation>) {
    let first = block.start;
    let shown: Vec<Expected> = block.clone().map(|k| Expected::of(drive, g, k)).collect();
    for bin in drive.bins(block) {
        let mean = |of: &dyn Fn(usize) -> f64| mean(bin.clone().map(of));
        let wheels = mean(&|k| shown[k - first].speeds[0] - shown[k - first].speeds[1]);
        out.push(residual(wheels, g.scatter.wheels));
        let is_late = drive.time[bin.start] - drive.time[first] > LONGEST_DELAY;
        let speed = mean(&|k| {
            let (row, share) = drive.place(k, -g.speed_delay);
            let at = |row: usize| {
                shown
                    .get(row.wrapping_sub(first))
                    .map_or(f64::NAN, Expected::speed)
            };
            let before = at(row);
            let then = if share > 0.0 { at(row + 1) } else { before };
            drive.speed[k] - before - share * (then - before)
        });
        out.push(residual(
            if is_late { speed } else { f64::NAN },
            g.scatter.speed,
        ));
        if drive.has_acceleration {
            let force = mean(&|k| g.force(drive, k) - shown[k - first].balance);
            // In units of the reading, whose noise it is: a share of it would be the smaller, the larger the squat.
            out.push(residual(g.reading(force), g.scatter.force));
        }
    }
    for pair in pairs(drive, block) {
        let at = |k: usize| &shown[k - first];
        let difference = |of: &dyn Fn(usize) -> f64| {
            let [before, after] = [&pair.before, &pair.after].map(|window| {
                let sum: f64 = window.clone().map(of).sum();
                sum / window.len() as f64
            });
            after - before
        };
        let gained = pair.steps().map(|(k, weight)| {
            let step = drive.time[k + 1] - drive.time[k];
            weight * 0.5 * step * (at(k).rate + at(k + 1).rate)
        });
        let change = difference(&|k| at(k).speed()) - gained.sum::<f64>();
        // The integral of the slope's rate is its change.
        let late = g.delayed() * difference(&|k| drive.slope[k]);
        out.push(residual(change + late, g.scatter.motion));
    }
}

/// Two successive windows: the difference of a signal's means is its rate, weighted by a triangle over both.
pub struct Pair {
    before: Range<usize>,
    after: Range<usize>,
}

impl Pair {
    /// Each step to the next row, as its first row and its weight.
    pub fn steps(&self) -> impl Iterator<Item = (usize, f64)> {
        let (middle, end) = (self.after.start, self.after.end);
        let (up, down) = (self.before.len() as f64, self.after.len() as f64);
        (self.before.start..end - 1).map(move |k| {
            let weight = if k < middle {
                (k + 1 - self.before.start) as f64 / up
            } else {
                (end - 1 - k) as f64 / down
            };
            (k, weight)
        })
    }
}

/// The pairs of windows of a stretch, each of [`WINDOW`] bins.
pub fn pairs(drive: &Drive, block: &Range<usize>) -> Vec<Pair> {
    let bins = drive.bins(block);
    let windows: Vec<Range<usize>> = bins
        .chunks_exact(WINDOW)
        .map(|bins| bins[0].start..bins[WINDOW - 1].end)
        .collect();
    windows
        .windows(2)
        .map(|two| Pair {
            before: two[0].clone(),
            after: two[1].clone(),
        })
        .collect()
}

/// Mean of the finite values; NaN where they are fewer than half.
fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let all = values.len();
    let (sum, count) = values
        .filter(|v| v.is_finite())
        .fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    if 2 * count >= all {
        sum / count.max(1) as f64
    } else {
        f64::NAN
    }
}

/// A residual; a missing one is zero with variance 1, without information.
fn residual(value: f64, std: f64) -> Innovation {
    if value.is_finite() {
        Innovation {
            value,
            variance: std * std,
        }
    } else {
        Innovation {
            value: 0.0,
            variance: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::made::{guess, samples};

    /// Mean of the squares over the predicted variances.
    fn agreement(drive: &Drive, g: &Guess) -> f64 {
        let mut all = Vec::new();
        for block in &drive.blocks {
            residuals(drive, block, g, &mut all);
        }
        let squares = all.iter().map(|i| i.value * i.value / i.variance);
        squares.sum::<f64>() / all.len() as f64
    }

    #[test]
    fn the_residuals_of_the_machine_that_it_is_are_as_large_as_the_noise() {
        let g = guess();
        let drive = Drive::new("a", &samples(&g, 0.2, 1), 4.6e4, 2.3);
        assert!(drive.driving_time() > 50.0);
        let right = agreement(&drive, &g);
        assert!((0.3..1.2).contains(&right), "{right}");
        for wrong in [
            Guess {
                radius_errors: [0.003, -0.001],
                ..g
            },
            Guess {
                stiffness: 17.0,
                ..g
            },
            Guess {
                speed_delay: 0.08,
                ..g
            },
            Guess {
                torque_gains: [1.06, 1.04],
                ..g
            },
            Guess {
                slope_bias: 0.008,
                ..g
            },
            Guess {
                slope_delay: 0.1,
                ..g
            },
            Guess {
                slope_sensitivity: 0.25,
                ..g
            },
        ] {
            assert!(agreement(&drive, &wrong) > 1.1 * right, "{wrong:?}");
        }
    }

    #[test]
    fn as_many_residuals_come_at_any_guess_and_from_bad_rows() {
        let g = guess();
        let mut rows = samples(&g, 0.0, 2);
        rows[500].speed = None;
        rows[501].front_wheel_speed = Some(f64::NAN);
        rows[502].acceleration = Some(f64::INFINITY);
        let drive = Drive::new("a", &rows, 4.6e4, 2.3);
        let count = |g: &Guess| {
            let mut all = Vec::new();
            residuals(&drive, &drive.blocks[1], g, &mut all);
            assert!(all.iter().all(|i| i.value.is_finite() && i.variance > 0.0));
            all.len()
        };
        let late = Guess {
            speed_delay: 0.19,
            ..g
        };
        assert_eq!(count(&g), count(&late));
    }
}
