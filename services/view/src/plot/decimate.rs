//! Decimation that preserves the appearance: the extremes of each stretch are retained.

/// At most `limit` of `points`, in order: the first lowest and first highest of each stretch. A stretch with a gap (a value that
/// is not finite) retains the gap.
pub fn decimate(points: &[(f64, f64)], limit: usize) -> Vec<(f64, f64)> {
    if points.len() <= limit {
        return points.to_vec();
    }
    // At most three per stretch: lowest, highest, gap; the last point is added.
    let stretch = points.len().div_ceil(((limit - 1) / 3).max(1));
    let mut out = Vec::with_capacity(limit);
    for part in points.chunks(stretch) {
        let mut kept = extremes(part);
        kept.sort_unstable();
        kept.dedup();
        out.extend(kept.into_iter().map(|i| part[i]));
    }
    if let (Some(last), Some(kept)) = (points.last(), out.last())
        && last.0 > kept.0
    {
        out.push(*last);
    }
    out
}

fn extremes(part: &[(f64, f64)]) -> Vec<usize> {
    let finite = || (0..part.len()).filter(|&i| part[i].1.is_finite());
    let low = finite().min_by(|&a, &b| part[a].1.total_cmp(&part[b].1));
    let high = finite().max_by(|&a, &b| part[a].1.total_cmp(&part[b].1).then(b.cmp(&a)));
    let gap = (0..part.len()).find(|&i| !part[i].1.is_finite());
    [low, high, gap].into_iter().flatten().collect()
}

/// At most `limit` points of a band, each the hull of its stretch.
pub(super) fn decimate_band(points: &[(f64, f64, f64)], limit: usize) -> Vec<(f64, f64, f64)> {
    if points.len() <= limit {
        return points.to_vec();
    }
    let hull = |part: &[(f64, f64, f64)]| {
        let low = part.iter().map(|p| p.1).fold(f64::NAN, f64::min);
        let high = part.iter().map(|p| p.2).fold(f64::NAN, f64::max);
        (part[part.len() / 2].0, low, high)
    };
    points
        .chunks(points.len().div_ceil(limit))
        .map(hull)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_spike_among_a_million_survives() {
        let mut points: Vec<_> = (0..1_000_000).map(|i| (f64::from(i), 0.0)).collect();
        points[543_210].1 = 1.0;
        points[700_001].1 = f64::NAN;
        let few = decimate(&points, 2000);
        assert!(few.len() <= 2000);
        assert!(few.contains(&(543_210.0, 1.0)));
        assert!(few.iter().any(|p| p.1.is_nan()), "the gap stays a gap");
        assert!(few.windows(2).all(|w| w[0].0 < w[1].0), "in order");
        assert_eq!(few.last().map(|p| p.0), Some(999_999.0));
    }

    #[test]
    fn a_band_stays_outside_its_samples() {
        let points: Vec<_> = (0..10_000)
            .map(|i| (f64::from(i), -f64::from(i % 7), f64::from(i % 5)))
            .collect();
        let few = decimate_band(&points, 100);
        assert_eq!(few.len(), 100);
        assert!(few.iter().all(|p| p.1 == -6.0 && p.2 == 4.0));
    }
}
