//! The statistics of all tables, plots and evaluations, defined once, so that a percentile is the same number everywhere.

pub mod judge;

use estimation::HALF_WIDTH_95;

/// Arithmetic mean; 0 for an empty slice.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        values.iter().sum::<f64>() / values.len() as f64
    }
}

/// Population standard deviation; 0 for an empty slice.
pub fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let squares: Vec<f64> = values.iter().map(|v| (v - centre).powi(2)).collect();
    mean(&squares).sqrt()
}

/// Largest absolute value; 0 for an empty slice.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

/// The percentile `share` (0 to 1), interpolated between neighbours; 0 for an empty slice.
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() {
        0.0
    } else {
        quantile(&sorted, share)
    }
}

/// The median; 0 for an empty slice.
pub fn median(values: &[f64]) -> f64 {
    percentile(values, 0.5)
}

/// The 95th percentile; 0 for an empty slice.
pub fn p95(values: &[f64]) -> f64 {
    percentile(values, 0.95)
}

/// Standard error of [`mean`]; 0 for an empty slice.
pub fn mean_error(values: &[f64]) -> f64 {
    deviation(values) / (values.len().max(1) as f64).sqrt()
}

/// Standard error of [`p95`]: half the distance between the percentiles one standard deviation of the rank below and above. It
/// assumes no distribution.
pub fn p95_error(values: &[f64]) -> f64 {
    let rank = (0.95 * 0.05 / values.len().max(1) as f64).sqrt();
    0.5 * (percentile(values, 0.95 + rank) - percentile(values, 0.95 - rank))
}

/// The percentage of true values; 0 for none.
pub fn percentage(values: impl IntoIterator<Item = bool>) -> f64 {
    let hits: Vec<f64> = values
        .into_iter()
        .map(|hit| if hit { 100.0 } else { 0.0 })
        .collect();
    mean(&hits)
}

/// Distance of each of several values (value, standard deviation) from their median, in standard deviations. It is the modified
/// z-score of Iglewicz and Hoaglin (1993), with the value's own variance added to that of the scatter. Several outliers do not
/// mask one another. `None` for fewer than four values, where the outlier is not identifiable.
pub fn standing(values: &[(f64, f64)]) -> Option<Vec<f64>> {
    if values.len() < 4 {
        return None;
    }
    let centre = median(&values.iter().map(|v| v.0).collect::<Vec<_>>());
    let distances: Vec<f64> = values.iter().map(|v| (v.0 - centre).abs()).collect();
    // 1.4826: ratio of the standard deviation of a normal distribution to its median absolute deviation.
    let scatter = 1.4826 * median(&distances);
    let score = |&(value, std): &(f64, f64)| {
        let expected = (scatter * scatter + std * std).sqrt();
        let distance = value - centre;
        if distance == 0.0 {
            0.0
        } else {
            distance / expected
        }
    };
    Some(values.iter().map(score).collect())
}

/// Limit of [`standing`] beyond which a value is an outlier (Iglewicz and Hoaglin 1993).
pub const STANDS_OUT: f64 = 3.5;

/// Count, mean and standard deviation (population) of a sample, and its largest magnitude.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Summary {
    /// Number of values.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Largest absolute value.
    pub max_abs: f64,
}

impl Summary {
    /// Summary of the finite `values`; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let count = finite().count();
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let mean = finite().sum::<f64>() / n;
        let variance = finite().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        Some(Self {
            count,
            mean,
            std: variance.sqrt(),
            max_abs: finite().fold(0.0, |m, v| m.max(v.abs())),
        })
    }
}

/// Quantile `q` (0 to 1) of sorted values, linearly interpolated; NaN for none.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = q.clamp(0.0, 1.0) * last as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    sorted[low] + (place - low as f64) * (sorted[high] - sorted[low])
}

/// Density of the normal distribution.
pub fn normal_density(x: f64, mean: f64, std: f64) -> f64 {
    let z = (x - mean) / std;
    (-0.5 * z * z).exp() / (std * (2.0 * std::f64::consts::PI).sqrt())
}

/// A histogram as densities, comparable with a normal density.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Bounds of the bins, one more than there are bins.
    pub edges: Vec<f64>,
    /// Share of the samples per bin, divided by its width.
    pub density: Vec<f64>,
}

impl Histogram {
    /// Histogram over mean ± 4 standard deviations; values outside count in the outermost bins.
    pub fn of(values: &[f64], bins: usize) -> Option<Self> {
        let summary = Summary::of(values)?;
        let half = if summary.std > 0.0 {
            4.0 * summary.std
        } else {
            0.5
        };
        let low = summary.mean - half;
        let width = 2.0 * half / bins as f64;
        let mut density = vec![0.0; bins];
        for v in values.iter().filter(|v| v.is_finite()) {
            let bin = ((v - low) / width).floor().clamp(0.0, bins as f64 - 1.0) as usize;
            density[bin] += 1.0 / (summary.count as f64 * width);
        }
        let edges = (0..=bins).map(|i| low + width * i as f64).collect();
        Some(Self { edges, density })
    }
}

/// Autocorrelation of `values` about their mean at lags 0 to `lags`; empty for a constant.
pub fn autocorrelation(values: &[f64], lags: usize) -> Vec<f64> {
    let Some(summary) = Summary::of(values) else {
        return Vec::new();
    };
    let centred: Vec<f64> = values.iter().map(|v| v - summary.mean).collect();
    let power: f64 = centred.iter().map(|v| v * v).sum();
    if power <= 0.0 || !power.is_finite() {
        return Vec::new();
    }
    (0..=lags.min(values.len() - 1))
        .map(|lag| {
            let shifted = centred[lag..].iter().zip(&centred);
            shifted.map(|(a, b)| a * b).sum::<f64>() / power
        })
        .collect()
}

/// Central 95 % interval of a chi-square variable with `freedom` degrees, divided by `freedom`
/// (Wilson and Hilferty's approximation, better than 1 % from 10 degrees on).
pub fn mean_chi_square_95(freedom: f64) -> (f64, f64) {
    let variance = 2.0 / (9.0 * freedom);
    let bound = |z: f64| (1.0 - variance + z * variance.sqrt()).max(0.0).powi(3);
    (bound(-HALF_WIDTH_95), bound(HALF_WIDTH_95))
}

/// Mean over the last `window` values, at each value.
pub fn moving_mean(values: &[f64], window: usize) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = Vec::with_capacity(values.len());
    for (i, v) in values.iter().enumerate() {
        sum += v;
        if i >= window {
            sum -= values[i - window];
        }
        out.push(sum / (i + 1).min(window) as f64);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fixed sequence, uniform on 0..1 and as white as a 64-bit LCG is.
    fn uniform(n: usize) -> Vec<f64> {
        let mut state = 1u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..n).map(|_| next()).collect()
    }

    #[test]
    fn summary_and_quantiles_of_a_known_sample() {
        let s = Summary::of(&[1.0, f64::NAN, 3.0, -4.0]).expect("values");
        assert_eq!((s.count, s.mean, s.max_abs), (3, 0.0, 4.0));
        assert!((s.std - (26.0f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(quantile(&[0.0, 1.0, 2.0, 3.0, 4.0], 0.9), 3.6);
        assert!(quantile(&[], 0.5).is_nan());
        assert_eq!(Summary::of(&[f64::NAN]), None);
    }

    #[test]
    fn a_histogram_encloses_the_area_one() {
        let h = Histogram::of(&uniform(1000), 24).expect("values");
        let area: f64 = h
            .density
            .iter()
            .zip(h.edges.windows(2))
            .map(|(d, e)| d * (e[1] - e[0]))
            .sum();
        assert!((area - 1.0).abs() < 1e-12);
    }

    #[test]
    fn white_noise_stays_in_the_band_and_a_ramp_does_not() {
        let n = 4000;
        let r = autocorrelation(&uniform(n), 40);
        assert_eq!(r[0], 1.0);
        let outside = r[1..]
            .iter()
            .filter(|v| v.abs() > HALF_WIDTH_95 / (n as f64).sqrt())
            .count();
        assert!(
            outside <= 5,
            "{outside} of 40 outside: 2 expected, 5 is the 98 % bound"
        );
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(autocorrelation(&ramp, 1)[1] > 0.9);
        assert!(autocorrelation(&[2.0; 10], 3).is_empty());
    }

    #[test]
    fn chi_square_bounds_agree_with_the_tables() {
        // Chi-square with 50 degrees: 32.357 and 71.420.
        let (low, high) = mean_chi_square_95(50.0);
        assert!((low * 50.0 - 32.357).abs() < 0.05 && (high * 50.0 - 71.420).abs() < 0.05);
    }

    #[test]
    fn a_moving_mean_forgets_what_left_the_window() {
        assert_eq!(moving_mean(&[1.0, 3.0, 5.0, 7.0], 2), [1.0, 2.0, 4.0, 6.0]);
    }

    #[test]
    fn percentiles_interpolate_between_neighbours() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(
            [0.0, 0.5, 1.0].map(|p| percentile(&values, p)),
            [1.0, 2.5, 4.0]
        );
        assert_eq!(percentile(&[], 0.5), 0.0);
    }

    #[test]
    fn the_deviation_is_that_of_the_population() {
        assert_eq!(
            (
                mean(&[1.0, 3.0]),
                deviation(&[1.0, 3.0]),
                largest(&[-3.0, 1.0])
            ),
            (2.0, 1.0, 3.0)
        );
        assert_eq!(percentage([true, true, false, false]), 50.0);
    }

    #[test]
    fn one_machine_of_five_stands_out_unless_its_interval_says_that_it_may_not() {
        let others = [(1.0, 0.01), (1.02, 0.01), (0.99, 0.01), (1.01, 0.01)];
        let with = |odd| [&others[..], &[odd]].concat();
        let sure = standing(&with((1.3, 0.01))).expect("five");
        assert!(sure[4] > STANDS_OUT && sure[..4].iter().all(|z| z.abs() < STANDS_OUT));
        let vague = standing(&with((1.3, 0.2))).expect("five");
        assert!(vague[4].abs() < STANDS_OUT);
        assert_eq!(standing(&others[..3]), None);
        assert_eq!(standing(&[(2.0, 0.0); 4]), Some(vec![0.0; 4]));
    }
}
