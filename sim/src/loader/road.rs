//! Roads: slope and roughness over the distance, from random phases.
//!
//! The grid starts at -10 m with 2 cm between points. The slope is a sum of waves of 12, 18, 24 and 30 m,
//! the roughness of waves with 0.05 to 0.99 periods per metre in steps of 0.01. So the slope repeats
//! exactly every 360 m and the roughness every 100 m; one period of each is stored, and the road has no end.

use std::f64::consts::TAU;

use crate::noise::Noise;

/// First grid point [m].
const START: f64 = -10.0;
/// Distance between grid points [m].
pub(super) const SPACING: f64 = 0.02;
const SLOPE_WAVELENGTHS: [f64; 4] = [12.0, 18.0, 24.0, 30.0];
const SLOPE_PERIOD: usize = 18_000;
const ROUGHNESS_WAVES: usize = 95;
const ROUGHNESS_PERIOD: usize = 5_000;
/// The roughness fades in between -2 m and +2 m; from this point (+4 m) on it is periodic.
const PERIODIC_FROM: usize = 700;

/// Amplitude and roughness of a road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Amplitude A of the slope \[deg\]; its rms value is A/1.8.
    pub slope_amplitude_deg: f64,
    /// Roughness coefficient G_d at 0.1 periods per metre [m^3].
    pub roughness: f64,
    /// Length over which the rms slope is normalised \[m\].
    pub length: f64,
}

/// The phases of all waves of a road \[rad\].
#[derive(Clone, Debug, PartialEq)]
pub struct Phases {
    /// Of the slope.
    pub slope: [f64; 4],
    /// Of the roughness.
    pub roughness: [f64; ROUGHNESS_WAVES],
}

impl Phases {
    /// Independent phases, uniform on a circle.
    pub fn draw(noise: &mut Noise) -> Self {
        Self {
            slope: std::array::from_fn(|_| noise.uniform(0.0, TAU)),
            roughness: std::array::from_fn(|_| noise.uniform(0.0, TAU)),
        }
    }
}

/// A road, tabulated.
#[derive(Clone, Debug)]
pub struct Road {
    slope: Vec<f64>,
    /// Height [m] and its derivative along the road.
    profile: Vec<[f64; 2]>,
    /// Position at which a machine in the opposite direction starts [m].
    turned_at: Option<f64>,
}

impl Road {
    /// Tabulates the road.
    pub fn new(surface: &Surface, phases: &Phases) -> Self {
        let height = heights(surface.roughness, &phases.roughness);
        let mut profile = vec![[0.0; 2]; PERIODIC_FROM + ROUGHNESS_PERIOD + 1];
        for (k, point) in profile.iter_mut().enumerate() {
            let before = if k == 0 { height[0] } else { height[k - 1] };
            *point = [height[k], (height[k + 1] - before) / (2.0 * SPACING)];
        }
        Self {
            slope: slopes(surface, &phases.slope),
            profile,
            turned_at: None,
        }
    }

    /// The same road for a machine that starts at this position and drives back \[m\].
    #[must_use]
    pub fn turned(self, turned_at: Option<f64>) -> Self {
        Self { turned_at, ..self }
    }

    /// Slope at distance `x`, positive uphill \[rad\].
    pub fn slope(&self, x: f64) -> f64 {
        match self.turned_at {
            None => self.slope_there(x),
            Some(at) => -self.slope_there(at - x),
        }
    }

    /// Height above the smooth road \[m\] and its derivative along the road, at distance `x`.
    pub fn profile(&self, x: f64) -> [f64; 2] {
        match self.turned_at {
            None => self.profile_there(x),
            Some(at) => {
                let [height, derivative] = self.profile_there(at - x);
                [height, -derivative]
            }
        }
    }

    fn slope_there(&self, x: f64) -> f64 {
        let (k, share) = cell(x);
        let k = k.rem_euclid(SLOPE_PERIOD as i64) as usize;
        self.slope[k] + share * (self.slope[k + 1] - self.slope[k])
    }

    fn profile_there(&self, x: f64) -> [f64; 2] {
        let (k, share) = cell(x);
        if k < 0 {
            return self.profile[0];
        }
        let mut k = k as usize;
        if k >= PERIODIC_FROM + ROUGHNESS_PERIOD {
            k = PERIODIC_FROM + (k - PERIODIC_FROM) % ROUGHNESS_PERIOD;
        }
        let ([y0, d0], [y1, d1]) = (self.profile[k], self.profile[k + 1]);
        [y0 + share * (y1 - y0), d0 + share * (d1 - d0)]
    }
}

/// The grid cell of a distance, and the position in it, 0 to 1.
fn cell(x: f64) -> (i64, f64) {
    let place = (x - START) * (1.0 / SPACING);
    let k = place as i64 - i64::from(place < 0.0);
    (k, place - k as f64)
}

fn grid(k: usize) -> f64 {
    START + SPACING * k as f64
}

/// One period of the slope, with its first point repeated.
fn slopes(surface: &Surface, phases: &[f64; 4]) -> Vec<f64> {
    let raw = |k: usize| -> f64 {
        let waves = SLOPE_WAVELENGTHS.iter().zip(phases);
        waves
            .map(|(length, phase)| (TAU * grid(k) / length + phase).sin())
            .sum()
    };
    let mut slope: Vec<f64> = (0..SLOPE_PERIOD).map(raw).collect();
    slope.push(slope[0]);
    let points = ((surface.length - START) / SPACING).round() as usize;
    let scale = surface.slope_amplitude_deg.to_radians() / deviation(&slope, points) / 1.8;
    slope.iter_mut().for_each(|s| *s *= scale);
    slope
}

/// Population standard deviation of the slope over the first `points` of the grid.
fn deviation(slope: &[f64], points: usize) -> f64 {
    let values = || (0..points).map(|k| slope[k % SLOPE_PERIOD]);
    let mean = values().sum::<f64>() / points as f64;
    (values().map(|v| (v - mean).powi(2)).sum::<f64>() / points as f64).sqrt()
}

/// Heights over the fade-in, one period, and two further points for the differences.
fn heights(roughness: f64, phases: &[f64; ROUGHNESS_WAVES]) -> Vec<f64> {
    let waves: Vec<(f64, f64, f64)> = phases
        .iter()
        .enumerate()
        .map(|(j, phase)| {
            let n = 0.05 + 0.01 * j as f64;
            (
                (2.0 * roughness * (n / 0.1).powi(-2) * 0.01).sqrt(),
                TAU * n,
                *phase,
            )
        })
        .collect();
    let raw = |x: f64| {
        waves
            .iter()
            .map(|(a, n, phase)| a * (n * x + phase).sin())
            .sum::<f64>()
    };
    let period: Vec<f64> = (0..ROUGHNESS_PERIOD).map(|k| raw(grid(k))).collect();
    (0..PERIODIC_FROM + ROUGHNESS_PERIOD + 2)
        .map(|k| period[k % ROUGHNESS_PERIOD] * super::profile::smoothstep((grid(k) + 2.0) / 4.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURFACE: Surface = Surface {
        slope_amplitude_deg: 4.0,
        roughness: 128e-6,
        length: 260.0,
    };

    #[test]
    fn the_rms_slope_is_the_amplitude_over_1_8() {
        let road = Road::new(&SURFACE, &Phases::draw(&mut Noise::new(1)));
        let count = 13_500;
        let square: f64 = (0..count).map(|k| road.slope(grid(k)).powi(2)).sum();
        // The mean over 270 m is not exactly zero, so the rms value slightly exceeds the deviation.
        let rms = (square / count as f64).sqrt();
        assert!(
            (rms / (4f64.to_radians() / 1.8) - 1.0).abs() < 0.01,
            "{rms}"
        );
    }

    #[test]
    fn the_road_goes_on_smoothly_where_its_tables_repeat() {
        let road = Road::new(&SURFACE, &Phases::draw(&mut Noise::new(2)));
        for x in [104.0, 204.0, 350.0, 710.0] {
            let (before, after) = (road.profile(x - 0.01), road.profile(x + 0.01));
            // The road's curvature is far below 1/m: over 2 cm height and slope hardly change.
            assert!((before[0] - after[0]).abs() < 0.02 * 0.2, "{x}");
            assert!((before[1] - after[1]).abs() < 0.02, "{x}");
            assert!(
                (road.slope(x - 0.01) - road.slope(x + 0.01)).abs() < 1e-3,
                "{x}"
            );
        }
    }

    #[test]
    fn driven_back_the_road_goes_down_where_it_went_up() {
        let there = Road::new(&SURFACE, &Phases::draw(&mut Noise::new(4)));
        let back = there.clone().turned(Some(200.0));
        for x in [5.0, 60.0, 195.5] {
            assert_eq!(back.slope(x), -there.slope(200.0 - x));
            let ([h, d], [height, derivative]) = (back.profile(x), there.profile(200.0 - x));
            assert_eq!([h, -d], [height, derivative]);
        }
    }

    #[test]
    fn a_flat_road_is_flat_and_behind_the_start_the_road_is_smooth() {
        let flat = Surface {
            slope_amplitude_deg: 0.0,
            ..SURFACE
        };
        let road = Road::new(&flat, &Phases::draw(&mut Noise::new(3)));
        assert_eq!(road.slope(17.0), 0.0);
        assert_eq!(road.profile(-2.5), [0.0, 0.0]);
        assert_eq!(road.profile(-1e6), [0.0, 0.0]);
        assert!(road.slope(-1e6).is_finite());
    }
}
