//! White noise of a loader's sensors: the rest of a signal without its course.
//!
//! The third difference of a fast-sampled signal is nearly all noise: motion at 2 Hz retains a five-hundredth of
//! its amplitude at 100 Hz. White noise is equal in successive rows, in every second and in every third. Where
//! it is not (a filtered sensor, a coarse one, a fast motion), the described value stays, with a remark.

use config::{Loader as Description, Tables as _};
use estimation::Quantity;
use estimation::loader::Sample;

use super::Input;
use crate::column::percentile;

/// Number of rows between the terms of a difference.
const STRIDES: [usize; 3] = [1, 2, 3];
/// Largest ratio of the noises at these strides that still counts as white noise.
const WHITE: f64 = 1.25;
/// Least number of differences.
const FEWEST: usize = 1000;
/// Largest relative deviation of a time step within a difference.
const UNEVEN: f64 = 0.2;

/// A channel: key of its noise, its name, and its value.
type Channel = (&'static str, &'static str, fn(&Sample) -> Option<f64>);
const CHANNELS: [Channel; 5] = [
    ("sensors.speed_std", "speed", |s| s.speed),
    ("sensors.wheel_speed_std", "front wheel speed", |s| {
        s.front_wheel_speed
    }),
    ("sensors.wheel_speed_std", "rear wheel speed", |s| {
        s.rear_wheel_speed
    }),
    ("sensors.slope_std", "slope", |s| s.slope),
    ("sensors.acceleration_std", "acceleration", |s| {
        s.acceleration
    }),
];

/// Identified noises, and remarks on the others.
#[derive(Debug, Clone, Default)]
pub struct Noises {
    /// Keys with their values; of two wheels the larger one.
    pub found: Vec<(&'static str, Quantity)>,
    /// Remarks.
    pub remarks: Vec<String>,
}

impl Noises {
    /// The noises of recordings of one machine.
    pub fn of(inputs: &[&Input], described: &Description) -> Self {
        let mut noises = Self::default();
        for (key, name, of) in CHANNELS {
            let Some(seen) = seen(inputs, of) else {
                continue;
            };
            let was = described.number(key).unwrap_or(f64::NAN);
            let [low, high] = [f64::min, f64::max]
                .map(|f| seen.iter().map(|q| q.value).reduce(f).unwrap_or_default());
            if low <= 0.0 || high > WHITE * low {
                noises.remarks.push(format!(
                    "the noise of the {name} is not white: {:.2e} from row to row, {:.2e} over every third; {key} stays {was}",
                    seen[0].value, seen[2].value
                ));
            }
            // The key has a value from the other wheel.
            else if let Some((_, other)) = noises.found.iter_mut().find(|(k, _)| *k == key) {
                if seen[0].value > other.value {
                    *other = seen[0];
                }
            } else {
                noises.found.push((key, seen[0]));
            }
        }
        // One wheel whose noise is not white rejects both.
        let is_doubted = |key: &str| noises.remarks.iter().any(|r| r.contains(key));
        noises.found.retain(|(key, _)| !is_doubted(key));
        noises
    }
}

/// Noise of a channel at each stride; `None` for a missing channel.
fn seen(inputs: &[&Input], of: fn(&Sample) -> Option<f64>) -> Option<[Quantity; 3]> {
    let at = |stride| {
        let inputs = inputs.iter();
        let all: Vec<f64> = inputs
            .flat_map(|i| differences(&i.samples, of, stride))
            .collect();
        noise(&all)
    };
    let [a, b, c] = STRIDES.map(at);
    Some([a?, b?, c?])
}

/// Magnitudes of the third differences of finite values at equidistant times.
fn differences(rows: &[Sample], of: fn(&Sample) -> Option<f64>, stride: usize) -> Vec<f64> {
    let steps = rows.windows(2).map(|w| w[1].time - w[0].time).collect();
    let step = percentile(steps, 0.5) * stride as f64;
    let even = |a: &Sample, b: &Sample| (b.time - a.time - step).abs() < UNEVEN * step;
    let difference = |window: &[Sample]| {
        let four = [0, 1, 2, 3].map(|i| &window[i * stride]);
        if !four.windows(2).all(|w| even(w[0], w[1])) {
            return None;
        }
        let [a, b, c, d] = four.map(|s| of(s).unwrap_or(f64::NAN));
        Some((d - 3.0 * c + 3.0 * b - a).abs()).filter(|size| size.is_finite())
    };
    rows.windows(3 * stride + 1)
        .filter_map(difference)
        .collect()
}

/// Standard deviation of the noise from the magnitudes of third differences, which contain 1, 9, 9, 1 times its variance. It uses their
/// median, which is robust to outliers. The median determines a normal standard deviation to 1.17 over the root of their number, of
/// which a quarter are independent.
fn noise(sizes: &[f64]) -> Option<Quantity> {
    (sizes.len() >= FEWEST).then(|| {
        let value = 1.4826 * percentile(sizes.to_vec(), 0.5) / 20_f64.sqrt();
        Quantity {
            value,
            std: 1.17 * value / (sizes.len() as f64 / 4.0).sqrt(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loader::StatedLoad;
    use crate::loader::made::noise as uniform;

    fn inputs(noise: impl Fn(&mut u64) -> f64) -> Input {
        let mut state = 5;
        let row = |k: i32| {
            let time = f64::from(k) * 0.01;
            Sample {
                time,
                speed: Some(2.0 + f64::sin(3.0 * time) + noise(&mut state)),
                ..Sample::default()
            }
        };
        Input {
            name: "a".into(),
            samples: (0..6000).map(row).collect(),
            stated: StatedLoad::default(),
            payload: None,
        }
    }

    /// Nearly normal, variance 1.
    fn normal(state: &mut u64) -> f64 {
        (0..4).map(|_| uniform(state)).sum::<f64>() / 2.0
    }

    #[test]
    fn white_noise_is_found_under_motion_and_outliers() {
        let outlier = |state: &mut u64| {
            let far = if uniform(state) > 1.7 { 40.0 } else { 1.0 };
            0.03 * far * normal(state)
        };
        let noises = Noises::of(&[&inputs(outlier)], &Description::default());
        let [(key, found)] = noises.found[..] else {
            panic!("one signal: {noises:?}");
        };
        assert_eq!(key, "sensors.speed_std");
        assert!(
            (found.value - 0.03).abs() < 0.003 && found.std < 0.002,
            "{found:?}"
        );
    }

    #[test]
    fn coarse_and_quiet_signals_stay_as_described() {
        for noise in [
            |_: &mut u64| 0.0,
            |state: &mut u64| {
                let fine = 0.01 * normal(state);
                (fine / 0.2).round() * 0.2
            },
        ] {
            let noises = Noises::of(&[&inputs(noise)], &Description::default());
            assert_eq!(noises.found, []);
            assert!(noises.remarks[0].contains("sensors.speed_std stays 0.02"));
        }
    }
}
