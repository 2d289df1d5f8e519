//! Swinging load: a part of the load that lags behind the upper body.
//!
//! ```text
//! xi'' + 2 zeta W xi' + W^2 xi = -w'          p = J w + s L m xi'
//! ```
//! A share s of the load's inertia L m swings at the rate W behind the upper body by xi; p is the momentum of the whole machine, which the
//! torques change. The rate of a load depends on its suspension. There is therefore a share for each of [`RATES`], and a load between two
//! rates has a share of both.

/// Rates of swinging loads, from 2.5 m below a hook to .25 m in a bucket, an eighth apart [rad/s].
pub const RATES: [f64; 11] = [2.0, 2.24, 2.5, 2.8, 3.15, 3.55, 4.0, 4.5, 5.0, 5.6, 6.3];
/// Damping ratio of each.
const DAMPING: f64 = 0.06;
/// A longer step resets the motion \[s\].
const GAP: f64 = 0.1;

/// Velocity of a load at each rate relative to the upper body, from the velocity of the latter [rad/s].
pub fn velocities(time: &[f64], velocity: &[f64]) -> Vec<[f64; RATES.len()]> {
    let mut angles = [0.0; RATES.len()];
    let mut rates = [0.0; RATES.len()];
    (0..time.len())
        .map(|k| {
            let last = k.saturating_sub(1);
            let dt = time[k] - time[last];
            if dt > GAP {
                (angles, rates) = ([0.0; RATES.len()], [0.0; RATES.len()]);
                return rates;
            }
            let gained = velocity[k] - velocity[last];
            for ((angle, rate), own) in angles.iter_mut().zip(&mut rates).zip(RATES) {
                *rate -= dt * own * (2.0 * DAMPING * *rate + own * *angle) + gained;
                *angle += dt * *rate;
            }
            rates
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::filter::{self, Guess};
    use super::super::series::Series;
    use super::*;
    use estimation::excavator::{Geometry, Sample};

    /// Swinging part of the machine's inertia, and the whole [kg m^2].
    const SHARE: f64 = 0.1;
    const INERTIA: f64 = 20e3;

    #[test]
    fn what_hangs_stays_behind_at_first_and_then_comes_along() {
        let time: Vec<f64> = (0..6000).map(|k| 0.01 * f64::from(k)).collect();
        let velocity: Vec<f64> = time.iter().map(|t| f64::from(*t > 1.0)).collect();
        let rates = velocities(&time, &velocity);
        for (i, own) in RATES.into_iter().enumerate() {
            let after = |elapsed: f64| rates[((1.0 + elapsed) / 0.01) as usize][i];
            assert!((after(0.02) + 1.0).abs() < 0.1, "{}", after(0.02));
            assert!(after(core::f64::consts::PI / own) > 0.6);
            assert!(after(58.0).abs() < 1e-3);
        }
    }

    /// A swing under a torque of 10 kN m for a second, in which a load in the bucket swings at
    /// this rate, with this damping ratio.
    fn swing((own, damping): (f64, f64)) -> Series {
        let (mut body, mut behind, mut angle) = (0.0, 0.0, 0.0);
        let samples: Vec<Sample> = (0..400)
            .map(|k| {
                let time = 0.01 * f64::from(k);
                let torque = 10e3 * f64::from((100..200).contains(&k));
                let sample = Sample {
                    time,
                    velocity: Some(body),
                    torque: Some(torque),
                    posture: [0.6, -1.5, -0.6].map(Some),
                    ..Sample::default()
                };
                for _ in 0..10 {
                    let pull = own * (2.0 * damping * behind + own * angle);
                    let gained = (torque + SHARE * INERTIA * pull) / ((1.0 - SHARE) * INERTIA);
                    behind -= 0.001 * (pull + gained);
                    angle += 0.001 * behind;
                    body += 0.001 * gained;
                }
                sample
            })
            .collect();
        Series::new("a", &samples, &Geometry::default(), [0.0; 3])
    }

    /// Sum of the squared innovations with these swinging shares.
    fn squares(series: &Series, swinging: [f64; RATES.len()]) -> f64 {
        let payload = 100.0;
        let lever = INERTIA / (payload * series.leverage[0]);
        let guess = Guess {
            damping: 0.0,
            friction: 0.0,
            efficiency: 1.0,
            offset: 0.0,
            gain: 1.0,
            upper_inertia: 0.0,
            link_scale: 0.0,
            bucket_scale: 0.0,
            delay: 0.0,
            motion_std: 1e-3,
            torque_std: 1.0,
            payload,
            lever,
            centre: [0.0; 2],
            swinging,
            angle_offsets: [0.0; 3],
            upper_moment: 0.0,
            slope: [0.0; 2],
        };
        let mut innovations = Vec::new();
        let swing = series.swings.first().expect("a swing");
        filter::innovations(series, swing, &guess, &mut innovations);
        innovations.iter().map(|i| i.value * i.value).sum()
    }

    #[test]
    fn a_load_that_swings_is_no_other_inertia() {
        let series = swing((RATES[1], DAMPING));
        let [rigid, known] = [0.0, SHARE].map(|share| {
            let mut swinging = [0.0; RATES.len()];
            swinging[1] = share;
            squares(&series, swinging)
        });
        assert!(known < 0.02 * rigid, "{known} {rigid}");
    }

    #[test]
    fn one_that_swings_between_two_rates_has_a_share_of_both() {
        for (at, pair) in RATES.windows(2).enumerate() {
            let series = swing(((pair[0] * pair[1]).sqrt(), 0.03));
            let mut swinging = [0.0; RATES.len()];
            let rigid = squares(&series, swinging);
            (swinging[at], swinging[at + 1]) = (0.5 * SHARE, 0.5 * SHARE);
            let known = squares(&series, swinging);
            // With the rates a quarter apart, .3 of it remains at the fastest.
            assert!(known < 0.14 * rigid, "{pair:?} {}", known / rigid);
        }
    }
}
