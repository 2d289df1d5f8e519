//! A prepared recording: time, velocity or angle, torque, inertia from the posture, and
//! its swings.

use std::ops::Range;

use estimation::excavator::{Geometry, Inertia, Sample, true_posture};

use super::swinging::{self, RATES};
use super::torque::Torque;
use crate::column::{increasing, moving_mean, percentile};

/// Half width of the window that smooths the posture, and the velocity to find the swings [s].
const WINDOW: f64 = 0.04;
/// Share of the fast velocities above which the machine swings.
const MOVING: f64 = 0.03;
/// The same limit in standard deviations of the smoothed velocity.
const NOISES: f64 = 6.0;
/// Shortest swing [s].
const SHORTEST: f64 = 0.3;
/// Longest block; a longer swing becomes several [s].
const LONGEST: f64 = 4.0;
/// Least duration of a standstill that determines the bias of the velocity [s].
const STAND: f64 = 0.5;
/// Largest bias; a larger mean at standstill is motion [rad/s].
const BIAS_MAX: f64 = 0.03;
/// Rate of the bucket angle above which the bucket opens [rad/s].
const OPENING: f64 = 0.35;
/// Time before and after an opening of the bucket in which the load is unknown [s].
const AROUND_OPENING: (f64, f64) = (0.1, 0.5);

/// Measured signal of the swing motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measured {
    /// A velocity [rad/s].
    Velocity,
    /// The angle of an encoder \[rad\].
    Angle,
}

/// Content of the bucket during a swing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// The load of the recording.
    Stated,
    /// Empty bucket.
    Empty,
}

/// One swing, or a part of a long one.
#[derive(Debug, Clone, PartialEq)]
pub struct Swing {
    /// Rows of the recording.
    pub rows: Range<usize>,
    /// 1 anticlockwise, -1 clockwise.
    pub direction: f64,
    /// Content of the bucket.
    pub load: Load,
}

/// A prepared recording.
#[derive(Debug, Clone)]
pub struct Series {
    /// Its name, for sentences.
    pub name: String,
    /// Measured signal of the swing motion.
    pub measured: Measured,
    /// Whether all three joint angles are measured.
    pub has_posture: bool,
    /// Time of each row \[s\].
    pub time: Vec<f64>,
    /// Velocity without its bias, or angle; missing values are NaN.
    pub value: Vec<f64>,
    /// Smoothed velocity [rad/s].
    pub velocity: Vec<f64>,
    /// Inertia of boom and arm as described [kg m^2].
    pub links: Vec<f64>,
    /// Inertia of the bucket as described [kg m^2].
    pub bucket: Vec<f64>,
    /// Inertia per kilogram of payload [m^2].
    pub leverage: Vec<f64>,
    /// Derivatives of the latter with respect to the place of the load's centre, along and beside the line from the bucket's pin to its tip
    /// \[m\].
    pub per_centre: Vec<[f64; 2]>,
    /// Derivatives of inertia and leverage with respect to each joint angle [kg m^2/rad, m^2/rad].
    pub per_angle: Vec<[[f64; 2]; 3]>,
    /// First moments of boom and arm, and of the bucket, as described [kg m].
    pub moment: Vec<[f64; 2]>,
    /// The same per kilogram of payload \[m\].
    pub radius: Vec<f64>,
    /// Cosine and sine of the angle swung since the start.
    pub heading: Vec<[f64; 2]>,
    /// Relative velocity of a load swinging at each rate, against the upper body [rad/s].
    pub swinging: Vec<[f64; RATES.len()]>,
    /// Torque.
    pub torque: Torque,
    /// Swings.
    pub swings: Vec<Swing>,
    /// Share of the rows whose time did not increase.
    pub refused: f64,
    /// Bias of the velocity that was removed [rad/s].
    pub bias: f64,
}

/// Measured value of each row; missing values are NaN.
fn values(samples: &[Sample], measured: Measured) -> Vec<f64> {
    let value = |s: &Sample| match measured {
        Measured::Velocity => s.velocity,
        Measured::Angle => s.angle,
    };
    samples
        .iter()
        .map(|s| finite(value(s)).unwrap_or(f64::NAN))
        .collect()
}

/// The inertia of each row, from its joint angles.
fn inertias(geometry: &Geometry, [boom, arm, bucket]: &[Vec<f64>; 3]) -> Vec<Inertia> {
    let angles = boom.iter().zip(arm).zip(bucket);
    angles
        .map(|((boom, arm), bucket)| geometry.inertia([*boom, *arm, *bucket]))
        .collect()
}

/// Derivatives of inertia and leverage of each row with respect to each joint angle [kg m^2/rad, m^2/rad].
fn per_angle(geometry: &Geometry, postures: &[Vec<f64>; 3]) -> Vec<[[f64; 2]; 3]> {
    const STEP: f64 = 1e-3;
    let row = |k: usize| {
        std::array::from_fn(|joint| {
            let [above, below] = [STEP, -STEP].map(|by| {
                let mut posture = std::array::from_fn(|i| postures[i][k]);
                posture[joint] += by;
                geometry.inertia(posture)
            });
            [
                above.empty - below.empty,
                above.per_payload - below.per_payload,
            ]
            .map(|d| 0.5 * d / STEP)
        })
    };
    (0..postures[0].len()).map(row).collect()
}

/// Derivatives of the leverage of each row with respect to the place of the load's centre, along and beside the line from the bucket's pin to its tip
/// \[m\].
fn per_centre(geometry: &Geometry, postures: &[Vec<f64>; 3]) -> Vec<[f64; 2]> {
    const STEP: f64 = 1e-3;
    let moved = |along: f64, beside: f64| {
        let mut geometry = *geometry;
        geometry.payload_centre += along;
        geometry.rises[2] += beside;
        inertias(&geometry, postures)
    };
    let slope =
        |above: &Inertia, below: &Inertia| 0.5 * (above.per_payload - below.per_payload) / STEP;
    let along = [moved(STEP, 0.0), moved(-STEP, 0.0)];
    let beside = [moved(0.0, STEP), moved(0.0, -STEP)];
    let row = |k: usize| [&along, &beside].map(|[above, below]| slope(&above[k], &below[k]));
    (0..postures[0].len()).map(row).collect()
}

/// Inertia of each row, and derivatives of inertia and leverage.
struct Postures {
    inertias: Vec<Inertia>,
    per_angle: Vec<[[f64; 2]; 3]>,
    per_centre: Vec<[f64; 2]>,
}

impl Postures {
    fn of(geometry: &Geometry, postures: &[Vec<f64>; 3]) -> Self {
        Self {
            inertias: inertias(geometry, postures),
            per_angle: per_angle(geometry, postures),
            per_centre: per_centre(geometry, postures),
        }
    }

    /// A constant inertia, where no posture is measured.
    fn constant(geometry: &Geometry, rows: usize) -> Self {
        let none = Inertia {
            empty: geometry.upper_inertia,
            ..Inertia::default()
        };
        Self {
            inertias: vec![none; rows],
            per_angle: vec![[[0.0; 2]; 3]; rows],
            per_centre: vec![[0.0; 2]; rows],
        }
    }
}

impl Series {
    /// Prepares a recording. Rows whose time does not increase are left out. `offsets`: described ones of the joint angles \[rad\].
    #[must_use]
    pub fn new(name: &str, samples: &[Sample], geometry: &Geometry, offsets: [f64; 3]) -> Self {
        let rows = samples.len();
        let samples = increasing(samples, |s| s.time);
        let has = |f: &dyn Fn(&Sample) -> Option<f64>| {
            let count = samples.iter().filter(|s| finite(f(s)).is_some()).count();
            10 * count > samples.len()
        };
        let measured = if has(&|s| s.velocity) {
            Measured::Velocity
        } else {
            Measured::Angle
        };
        let has_posture = (0..3).all(|i| has(&|s| s.posture[i]));
        let time: Vec<f64> = samples.iter().map(|s| s.time).collect();
        let mut value = values(&samples, measured);
        let mut velocity = smoothed(&time, &value, measured);
        let limit = moving_limit(&time, &value, &velocity, measured);
        let bias = match measured {
            Measured::Velocity => bias(&time, &value, &velocity, limit),
            Measured::Angle => 0.0,
        };
        value.iter_mut().for_each(|v| *v -= bias);
        velocity.iter_mut().for_each(|v| *v -= bias);
        // Noise of an angle would become noise of the inertia, which the filter does not model.
        let postures: [Vec<f64>; 3] = std::array::from_fn(|i| {
            let angle = filled(&time, &samples, |s| true_posture(s.posture, offsets)[i]);
            moving_mean(&time, &angle, WINDOW)
        });
        let Postures {
            inertias,
            per_angle,
            per_centre,
        } = match has_posture {
            true => Postures::of(geometry, &postures),
            false => Postures::constant(geometry, time.len()),
        };
        let of = |f: fn(&Inertia) -> f64| inertias.iter().map(f).collect::<Vec<f64>>();
        let bucket_mass = geometry.masses[2];
        let moments = inertias.iter();
        let moments = moments.map(|j| [j.links_moment, bucket_mass * j.bucket_radius]);
        let torque: Vec<(f64, f64)> = samples
            .iter()
            .filter_map(|s| finite(s.torque).map(|v| (s.time, v)))
            .collect();
        let torque = Torque::new(&torque, |t| at(&time, &velocity, t));
        let opens = has_posture.then(|| openings(&time, &postures[2]));
        let angle = if has(&|s| s.angle) {
            filled(&time, &samples, |s| s.angle)
        } else {
            turned(&time, &velocity)
        };
        let mut series = Self {
            name: name.to_owned(),
            measured,
            has_posture,
            value,
            links: of(|j| j.links),
            bucket: inertias
                .iter()
                .map(|j| bucket_mass * j.per_bucket)
                .collect(),
            leverage: of(|j| j.per_payload),
            per_angle,
            per_centre,
            moment: moments.collect(),
            radius: of(|j| j.radius),
            heading: angle.iter().map(|a| [a.cos(), a.sin()]).collect(),
            swinging: swinging::velocities(&time, &velocity),
            time,
            velocity,
            torque,
            swings: Vec::new(),
            refused: 1.0 - samples.len() as f64 / rows.max(1) as f64,
            bias,
        };
        series.swings = series.find_swings(limit, &opens.unwrap_or_default());
        series
    }

    /// Median time between rows \[s\].
    #[must_use]
    pub fn period(&self) -> f64 {
        let steps = self.time.windows(2).map(|w| w[1] - w[0]);
        percentile(steps.collect(), 0.5)
    }

    /// Duration of the swings in one direction \[s\].
    #[must_use]
    pub fn moving_time(&self, direction: f64) -> f64 {
        let swings = self.swings.iter().filter(|s| s.direction == direction);
        swings.fold(0.0, |sum, s| sum + self.duration(s))
    }

    /// Duration of a swing \[s\].
    #[must_use]
    pub fn duration(&self, swing: &Swing) -> f64 {
        let rows = &swing.rows;
        self.time[rows.end - 1] - self.time[rows.start]
    }

    fn find_swings(&self, limit: f64, opens: &[bool]) -> Vec<Swing> {
        let longest_step = (5.0 * self.period()).max(0.1);
        let moves = |k: usize| self.velocity[k].abs() > limit && !opens.get(k).is_some_and(|o| *o);
        let mut swings = Vec::new();
        let mut k = 0;
        while k < self.time.len() {
            if !moves(k) {
                k += 1;
                continue;
            }
            let first = k;
            while k + 1 < self.time.len()
                && moves(k + 1)
                && self.velocity[k + 1].signum() == self.velocity[first].signum()
                && self.time[k + 1] - self.time[k] < longest_step
            {
                k += 1;
            }
            k += 1;
            self.add_pieces(&mut swings, first..k, longest_step);
        }
        swings
    }

    /// Cuts a long swing into blocks; leaves out blocks that are short or without torque.
    fn add_pieces(&self, swings: &mut Vec<Swing>, rows: Range<usize>, longest_step: f64) {
        let length = self.time[rows.end - 1] - self.time[rows.start];
        // At most as many pieces as rows, in case the rows are far apart.
        let pieces = ((length / LONGEST).ceil().max(1.0) as usize).min(rows.len());
        let share = rows.len() / pieces;
        for piece in 0..pieces {
            let first = rows.start + piece * share;
            let last = if piece + 1 == pieces {
                rows.end
            } else {
                first + share
            };
            let (from, to) = (self.time[first], self.time[last - 1]);
            let gap = self.torque.widest_gap(from, to);
            if to - from >= SHORTEST && gap < longest_step {
                swings.push(Swing {
                    rows: first..last,
                    direction: self.velocity[first].signum(),
                    load: Load::Stated,
                });
            }
        }
    }
}

fn finite(value: Option<f64>) -> Option<f64> {
    value.filter(|v| v.is_finite())
}

/// A column with its gaps interpolated linearly.
fn filled(time: &[f64], samples: &[Sample], column: impl Fn(&Sample) -> Option<f64>) -> Vec<f64> {
    let known = samples
        .iter()
        .filter_map(|s| finite(column(s)).map(|v| (s.time, v)));
    let (at_time, values): (Vec<f64>, Vec<f64>) = known.unzip();
    time.iter().map(|&t| at(&at_time, &values, t)).collect()
}

/// Integral of a velocity without gaps.
fn turned(time: &[f64], velocity: &[f64]) -> Vec<f64> {
    let mut angle = 0.0;
    (0..time.len())
        .map(|k| {
            let last = k.saturating_sub(1);
            angle += 0.5 * (velocity[last] + velocity[k]) * (time[k] - time[last]);
            angle
        })
        .collect()
}

/// Linear interpolation between points, constant outside; 0 without points.
#[must_use]
pub fn at(time: &[f64], values: &[f64], t: f64) -> f64 {
    let next = time.partition_point(|x| *x <= t);
    match (next.checked_sub(1), values.get(next)) {
        (None, Some(first)) => *first,
        (None, None) => 0.0,
        (Some(k), None) => values[k],
        (Some(k), Some(above)) => {
            let share = (t - time[k]) / (time[next] - time[k]);
            values[k] + share * (above - values[k])
        }
    }
}

fn smoothed(time: &[f64], values: &[f64], measured: Measured) -> Vec<f64> {
    match measured {
        Measured::Velocity => {
            let mean = moving_mean(time, values, WINDOW);
            // A gap counts as standstill.
            mean.into_iter()
                .map(|v| if v.is_nan() { 0.0 } else { v })
                .collect()
        }
        Measured::Angle => slopes(time, values),
    }
}

/// Slope of the regression line through the values around each time.
fn slopes(time: &[f64], values: &[f64]) -> Vec<f64> {
    let half = if time.len() > 1 {
        let period = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
        ((WINDOW / period).ceil() as usize).max(2)
    } else {
        1
    };
    (0..time.len())
        .map(|k| {
            let window = k.saturating_sub(half)..(k + half + 1).min(time.len());
            let points = window.filter(|&i| values[i].is_finite());
            let (mut n, mut st, mut sy, mut stt, mut sty) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for i in points {
                let (t, y) = (time[i] - time[k], values[i] - values[k]);
                if y.is_finite() {
                    n += 1.0;
                    st += t;
                    sy += y;
                    stt += t * t;
                    sty += t * y;
                }
            }
            let spread = n * stt - st * st;
            if spread > 0.0 {
                (n * sty - st * sy) / spread
            } else {
                0.0
            }
        })
        .collect()
}

/// The velocity above which the machine swings: a share of the fast velocities, and above the noise of the
/// smoothed velocity.
fn moving_limit(time: &[f64], value: &[f64], velocity: &[f64], measured: Measured) -> f64 {
    let sizes: Vec<f64> = velocity.iter().map(|v| v.abs()).collect();
    let steps = time.windows(2).map(|w| w[1] - w[0]).collect();
    let period = percentile(steps, 0.5).max(1e-9);
    let n = (2.0 * WINDOW / period).max(2.0);
    // Median magnitudes of differences: 0.6745 standard deviations, of two or of 1, -2, 1 samples.
    let noise = match measured {
        Measured::Velocity => {
            let steps = value.windows(2).map(|w| (w[1] - w[0]).abs());
            percentile(steps.collect(), 0.5) / (0.6745 * 2.0_f64.sqrt()) / n.sqrt()
        }
        Measured::Angle => {
            let bends = value.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
            let noise = percentile(bends.collect(), 0.5) / (0.6745 * 6.0_f64.sqrt());
            noise * (12.0 / n.powi(3)).sqrt() / period
        }
    };
    (MOVING * percentile(sizes, 0.98)).max(NOISES * noise)
}

/// Mean velocity at standstill; 0 where the machine never stands.
fn bias(time: &[f64], value: &[f64], velocity: &[f64], limit: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut first = 0;
    for k in 0..=time.len() {
        let stands = k < time.len() && velocity[k].abs() < limit.min(BIAS_MAX);
        if stands {
            continue;
        }
        if k > first && time[k - 1] - time[first] > STAND {
            let (from, to) = (time[first] + 0.5 * WINDOW, time[k - 1] - 3.0 * WINDOW);
            for i in first..k {
                if value[i].is_finite() && (from..to).contains(&time[i]) {
                    sum += value[i];
                    count += 1;
                }
            }
        }
        first = k + 1;
    }
    if count >= 50 { sum / count as f64 } else { 0.0 }
}

/// The rows in which the load may change because the bucket opens.
fn openings(time: &[f64], bucket: &[f64]) -> Vec<bool> {
    let rate = slopes(time, bucket);
    let (before, after) = AROUND_OPENING;
    let mut opens = vec![false; time.len()];
    for k in (0..time.len()).filter(|&k| rate[k] > OPENING) {
        let first = time.partition_point(|t| *t < time[k] - before);
        let last = time.partition_point(|t| *t < time[k] + after);
        opens[first..last].fill(true);
    }
    opens
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two seconds of rest, a swing of two seconds, rest, a swing back.
    fn there_and_back(bias: f64) -> Vec<Sample> {
        (0..1200)
            .map(|k| {
                let t = k as f64 * 0.01;
                let pulse = |from: f64| {
                    let u = (t - from) / 2.0;
                    if (0.0..1.0).contains(&u) {
                        (core::f64::consts::PI * u).sin()
                    } else {
                        0.0
                    }
                };
                Sample {
                    time: t,
                    velocity: Some(pulse(2.0) - pulse(7.0) + bias),
                    torque: Some(0.0),
                    ..Sample::default()
                }
            })
            .collect()
    }

    #[test]
    fn swings_are_found_with_their_direction_and_the_bias_is_taken_off() {
        let series = Series::new("a", &there_and_back(0.01), &Geometry::default(), [0.0; 3]);
        let directions: Vec<f64> = series.swings.iter().map(|s| s.direction).collect();
        assert_eq!(directions, [1.0, -1.0]);
        // The last hundredths of a second before a swing belong to the standstill.
        assert!((series.bias - 0.01).abs() < 1e-4, "{}", series.bias);
        assert!((series.duration(&series.swings[0]) - 2.0).abs() < 0.1);
    }

    #[test]
    fn a_machine_that_stands_has_no_swings_and_bad_rows_do_no_harm() {
        let mut samples = there_and_back(0.0);
        samples.iter_mut().for_each(|s| s.velocity = Some(0.0));
        samples[3].time = f64::NAN;
        samples[9].time = -1.0;
        samples[10].torque = Some(f64::INFINITY);
        let series = Series::new("a", &samples, &Geometry::default(), [0.0; 3]);
        assert!(series.swings.is_empty());
        assert_eq!(series.time.len(), 1198);
        assert!(
            Series::new("a", &[], &Geometry::default(), [0.0; 3])
                .swings
                .is_empty()
        );
    }

    /// Inertia of boom, arm and bucket at a row.
    fn attachment(series: &Series, row: usize) -> f64 {
        series.links[row] + series.bucket[row]
    }

    #[test]
    fn the_noise_of_the_joint_angles_is_not_one_of_the_inertia() {
        let largest_step = |noise: f64| {
            let mut samples = there_and_back(0.0);
            for (k, sample) in samples.iter_mut().enumerate() {
                let sign = [1.0, -1.0][k % 2];
                sample.posture = [0.6, -1.5, -0.6].map(|q| Some(q + sign * noise));
            }
            let series = Series::new("a", &samples, &Geometry::default(), [0.0; 3]);
            let whole: Vec<f64> = (0..series.links.len())
                .map(|k| attachment(&series, k))
                .collect();
            let steps = whole.windows(2).map(|w| (w[1] - w[0]).abs());
            steps.fold(0.0, f64::max)
        };
        // Three joints that step by 2 mrad would be 0.9 kg m^2; the mean of nine rows leaves a ninth.
        assert!(largest_step(0.001) < 0.3, "{}", largest_step(0.001));
    }

    #[test]
    fn an_offset_of_a_joint_angle_is_identified_by_the_derivatives() {
        let off = [0.02, -0.03, 0.04];
        let series = |off: [f64; 3]| {
            let mut samples = there_and_back(0.0);
            for sample in &mut samples {
                sample.posture = std::array::from_fn(|i| Some([0.6, -1.5, -0.6][i] + off[i]));
            }
            Series::new("a", &samples, &Geometry::default(), [0.0; 3])
        };
        let (measured, truth) = (series([0.0; 3]), series(off));
        let by = |part: usize| -> f64 {
            let each = off.iter().zip(measured.per_angle[0]);
            each.map(|(off, per)| off * per[part]).sum()
        };
        // The remaining error is of second order: the square of .03.
        for (by, before, after) in [
            (by(0), attachment(&measured, 0), attachment(&truth, 0)),
            (by(1), measured.leverage[0], truth.leverage[0]),
        ] {
            assert!(
                (before + by - after).abs() < 2e-3 * after,
                "{before} {by} {after}"
            );
            assert!((before - after).abs() > 1e-2 * after, "{before} {after}");
        }
    }

    #[test]
    fn lines_are_followed_between_points() {
        assert_eq!(at(&[0.0, 1.0], &[2.0, 4.0], 0.25), 2.5);
        assert_eq!(at(&[0.0, 1.0], &[2.0, 4.0], 9.0), 4.0);
        assert_eq!(at(&[], &[], 9.0), 0.0);
    }
}
