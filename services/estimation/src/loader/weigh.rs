//! The static reference: centre of gravity from axle weights on level and on tilted ground.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | F_f, F_r | `front_load`, `rear_load` | weighed axle loads | N or kg, the same for both |
//! | th | `pitch` | inclination of the line between the wheel contacts, front up positive | rad |
//! | s | - | share of the front axle, F_f/(F_f + F_r) | - |
//! | lam, h | result | ratio and height of the centre of gravity | -, m |
//!
//! Moments about the wheel contacts give s = lam - (h/l) tan th, whether the scales lie in the inclined plane or level under the
//! wheels. So lam and h/l are intercept and slope of a straight line through the readings. Level readings alone give lam; the
//! height needs at least two inclinations. After Fig. 6 of Yang, Wang, Han 2021, who average ten readings.
//!
//! The standard deviations follow from the scatter of the readings about the line and the stated accuracy of the scales. The latter
//! counts like two further readings, because two or three readings are weak evidence. This is no calibration: an error common to
//! all readings (a scale that reads high) does not average out.

use core::fmt;

use crate::Quantity;
use crate::math::{sin_cos, sqrt};

/// Weight of the stated accuracy, in readings.
const STATED_WEIGHT: f64 = 2.0;

/// Range of inclinations, as tan, below which the height is not estimated.
const LEAST_TILT: f64 = 0.02;

/// Largest inclination: a steeper machine would roll off its scales [rad].
const STEEPEST: f64 = 0.8;

/// One weighing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Inclination, front up positive \[rad\].
    pub pitch: f64,
    /// Load on the front axle.
    pub front_load: f64,
    /// Load on the rear axle, in the same unit.
    pub rear_load: f64,
}

/// Pitch of a level reading \[rad\]: its cosine is 1 to .12 %, a fourth of what axle scales err by.
const LEVEL: f64 = 0.05;

/// Readings so far: running means and centred sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighing {
    wheelbase: f64,
    scale_std: f64,
    count: u32,
    load: f64,
    level: u32,
    level_load: f64,
    tilt: f64,
    share: f64,
    tilt_squared: f64,
    tilt_share: f64,
    share_squared: f64,
    least_tilt: f64,
    largest_tilt: f64,
}

/// Centre of gravity from weighing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Share of the weight on the front axle on level ground.
    pub cg_ratio: Quantity,
    /// Height above ground \[m\]; `None` without two different inclinations.
    pub cg_height: Option<Quantity>,
    /// Distance from the front axle to the centre of gravity \[m\].
    pub cg_distance: Quantity,
    /// Mean total load, in the unit of the readings.
    pub load: f64,
    /// The same of the level readings alone: on a ramp, scales may show the weight or its part across the ramp.
    pub level_load: Option<f64>,
    /// Scatter of a single reading of the share.
    pub share_std: f64,
    /// Number of readings.
    pub readings: u32,
}

/// Why a reading or a weighing cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WeighError {
    /// The wheelbase is not positive and finite \[m\].
    Wheelbase(f64),
    /// The accuracy of the scales is not positive and finite.
    ScaleStd(f64),
    /// A pitch of 0.8 rad or more, or one that is not finite \[rad\].
    Pitch(f64),
    /// Loads that are not finite, or an axle that pulls.
    Loads(f64, f64),
    /// No reading.
    NoReadings,
}

impl fmt::Display for WeighError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wheelbase(l) => write!(f, "the wheelbase is {l} m, it must be positive"),
            Self::ScaleStd(s) => {
                write!(f, "the accuracy of the scales is {s}, it must be positive")
            }
            Self::Pitch(p) => write!(
                f,
                "the pitch is {p} rad, it must lie within -{STEEPEST} .. {STEEPEST} rad"
            ),
            Self::Loads(front, rear) => {
                write!(
                    f,
                    "the axle loads are {front:?} and {rear:?}, both must be positive numbers"
                )
            }
            Self::NoReadings => f.write_str("there is no reading"),
        }
    }
}

impl core::error::Error for WeighError {}

impl Weighing {
    /// No readings yet; `scale_std` is the relative standard deviation of one axle load, 0.005 for common axle scales.
    ///
    /// # Errors
    /// A number that is not positive.
    pub fn new(wheelbase: f64, scale_std: f64) -> Result<Self, WeighError> {
        if !(wheelbase > 0.0 && wheelbase.is_finite()) {
            return Err(WeighError::Wheelbase(wheelbase));
        }
        if !(scale_std > 0.0 && scale_std.is_finite()) {
            return Err(WeighError::ScaleStd(scale_std));
        }
        Ok(Self {
            wheelbase,
            scale_std,
            count: 0,
            load: 0.0,
            level: 0,
            level_load: 0.0,
            tilt: 0.0,
            share: 0.0,
            tilt_squared: 0.0,
            tilt_share: 0.0,
            share_squared: 0.0,
            least_tilt: f64::INFINITY,
            largest_tilt: f64::NEG_INFINITY,
        })
    }

    /// Adds a reading; a bad one is refused and changes nothing.
    ///
    /// # Errors
    /// The pitch or a load cannot be true.
    pub fn add(&mut self, reading: &Reading) -> Result<(), WeighError> {
        let Reading {
            pitch,
            front_load,
            rear_load,
        } = *reading;
        if !(pitch.is_finite() && pitch.abs() < STEEPEST) {
            return Err(WeighError::Pitch(pitch));
        }
        let load = front_load + rear_load;
        if !(front_load > 0.0 && rear_load > 0.0 && load.is_finite()) {
            return Err(WeighError::Loads(front_load, rear_load));
        }
        let (sine, cosine) = sin_cos(pitch);
        let (tilt, share) = (sine / cosine, front_load / load);
        self.count += 1;
        let weight = 1.0 / f64::from(self.count);
        let (from_tilt, from_share) = (tilt - self.tilt, share - self.share);
        self.load += weight * (load - self.load);
        if pitch.abs() < LEVEL {
            self.level += 1;
            self.level_load += (load - self.level_load) / f64::from(self.level);
        }
        self.tilt += weight * from_tilt;
        self.share += weight * from_share;
        self.tilt_squared += from_tilt * (tilt - self.tilt);
        self.tilt_share += from_tilt * (share - self.share);
        self.share_squared += from_share * (share - self.share);
        self.least_tilt = self.least_tilt.min(tilt);
        self.largest_tilt = self.largest_tilt.max(tilt);
        Ok(())
    }

    /// Returns the centre of gravity from the readings.
    ///
    /// # Errors
    /// There is no reading.
    pub fn reference(&self) -> Result<Reference, WeighError> {
        if self.count == 0 {
            return Err(WeighError::NoReadings);
        }
        let tilted = self.largest_tilt - self.least_tilt >= LEAST_TILT;
        let slope = if tilted {
            self.tilt_share / self.tilt_squared
        } else {
            0.0
        };
        let share_std = self.share_std(slope, tilted);
        // Level readings need no slope; all at one inclination leave lam and h mixed, which the interval must cover.
        let ratio = self.share - slope * self.tilt;
        let leverage = if tilted {
            self.tilt * self.tilt / self.tilt_squared
        } else {
            0.0
        };
        let unknown_height = if tilted { 0.0 } else { self.tilt };
        let mean_variance = 1.0 / f64::from(self.count) + leverage;
        let ratio_std =
            sqrt(share_std * share_std * mean_variance + unknown_height * unknown_height);
        let height = tilted.then(|| Quantity {
            value: -slope * self.wheelbase,
            std: share_std / sqrt(self.tilt_squared) * self.wheelbase,
        });
        Ok(Reference {
            cg_ratio: Quantity {
                value: ratio,
                std: ratio_std,
            },
            cg_height: height,
            cg_distance: Quantity {
                value: (1.0 - ratio) * self.wheelbase,
                std: ratio_std * self.wheelbase,
            },
            load: self.load,
            level_load: (self.level > 0).then_some(self.level_load),
            share_std,
            readings: self.count,
        })
    }

    /// Standard deviation of one reading: residuals and stated accuracy, weighted by their numbers of readings.
    fn share_std(&self, slope: f64, tilted: bool) -> f64 {
        let stated = core::f64::consts::SQRT_2 * self.share * (1.0 - self.share) * self.scale_std;
        let residual = (self.share_squared - slope * self.tilt_share).max(0.0);
        let fitted = if tilted { 2.0 } else { 1.0 };
        let freedom = (f64::from(self.count) - fitted).max(0.0);
        sqrt((residual + STATED_WEIGHT * stated * stated) / (freedom + STATED_WEIGHT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHEELBASE: f64 = 2.3;

    /// Loads of a machine with lam = 0.45, h = 0.9 m, 4700 kg.
    fn exact(pitch: f64) -> Reading {
        let share = 0.45 - 0.9 / WHEELBASE * (sin_cos(pitch).0 / sin_cos(pitch).1);
        Reading {
            pitch,
            front_load: 4700.0 * share,
            rear_load: 4700.0 * (1.0 - share),
        }
    }

    fn weigh(readings: &[Reading]) -> Reference {
        let mut weighing = Weighing::new(WHEELBASE, 0.005).unwrap();
        for reading in readings {
            weighing.add(reading).unwrap();
        }
        weighing.reference().unwrap()
    }

    #[test]
    fn exact_readings_give_ratio_and_height() {
        let reference = weigh(&[exact(0.0), exact(0.15), exact(-0.1)]);
        assert!((reference.cg_ratio.value - 0.45).abs() < 1e-12);
        assert!((reference.cg_height.unwrap().value - 0.9).abs() < 1e-12);
        assert!((reference.cg_distance.value - 0.55 * WHEELBASE).abs() < 1e-12);
        assert!((reference.load - 4700.0).abs() < 1e-9);
    }

    #[test]
    fn level_readings_carry_no_information_about_the_height() {
        let reference = weigh(&[exact(0.0), exact(0.001), exact(-0.001)]);
        assert_eq!(reference.cg_height, None);
        assert!((reference.cg_ratio.value - 0.45).abs() < 1e-3);
    }

    /// Ten readings each at two inclinations, errors of 0.5 % alternating in sign: the interval holds and shrinks.
    #[test]
    fn repeated_readings_narrow_the_interval() {
        let noisy = |k: usize| {
            let mut reading = exact(if k % 4 < 2 { 0.0 } else { 0.2 });
            reading.front_load *= if k.is_multiple_of(2) { 1.005 } else { 0.995 };
            reading
        };
        let readings: [Reading; 40] = core::array::from_fn(noisy);
        let (few, many) = (weigh(&readings[..4]), weigh(&readings));
        let height = many.cg_height.unwrap();
        assert!((height.value - 0.9).abs() < 2.0 * height.std);
        assert!(height.std < 0.5 * few.cg_height.unwrap().std);
        // Share noise 0.005 * 0.45 * 0.55; a difference of two means of 20 over tan 0.2.
        assert!(
            (many.share_std - 0.00124).abs() < 2e-4,
            "{}",
            many.share_std
        );
    }

    #[test]
    fn bad_readings_are_refused_and_change_nothing() {
        let mut weighing = Weighing::new(WHEELBASE, 0.005).unwrap();
        weighing.add(&exact(0.0)).unwrap();
        let before = weighing;
        for bad in [
            Reading {
                pitch: f64::NAN,
                ..exact(0.0)
            },
            Reading {
                pitch: 1.0,
                ..exact(0.0)
            },
            Reading {
                front_load: -1.0,
                ..exact(0.0)
            },
            Reading {
                rear_load: f64::INFINITY,
                ..exact(0.0)
            },
        ] {
            assert!(weighing.add(&bad).is_err());
        }
        assert_eq!(weighing, before);
        assert_eq!(
            Weighing::new(WHEELBASE, 0.005).unwrap().reference(),
            Err(WeighError::NoReadings)
        );
        assert!(Weighing::new(0.0, 0.005).is_err());
    }
}
