//! Score of an estimator against the truth, by the papers' rule: relative errors while the motion is informative of the
//! parameter.

use crate::estimate::{Estimate, Parameter};
use crate::run::{Estimator, MachineRun};
use statistics::Summary;
use statistics::judge::is_covered;

/// The score of one estimator for one parameter.
#[derive(Debug, Clone, Default)]
pub struct Score {
    /// Relative errors while excited, 100 (estimate/truth - 1) [%].
    pub errors: Vec<f64>,
    /// The trusted ones of these errors [%].
    pub trusted_errors: Vec<f64>,
    /// Share of the excited samples whose 95 % interval held the truth.
    pub coverage: f64,
    /// The same share of the trusted samples.
    pub trusted_coverage: f64,
    /// Share of all samples that are trusted.
    pub trusted_share: f64,
}

impl Score {
    /// Scores `estimator`; without truth only the trusted share is known.
    pub fn of<E: Estimate>(
        run: &MachineRun<E>,
        estimator: &Estimator<E>,
        parameter: &Parameter<E, E::Truth>,
    ) -> Self {
        let mut score = Self::default();
        let (mut held, mut held_trusted, mut trusted_count) = (0usize, 0usize, 0usize);
        let truths = run.truth_of(&estimator.estimates);
        let all = estimator.estimates.iter().zip(truths);
        let is_extreme = |e: &E| estimator.extremes.contains(&e.stamp().sequence);
        let mut count = 0;
        for (estimate, truth) in all.filter(|(e, _)| !is_extreme(e)) {
            count += 1;
            let trusted = estimate.flags() & parameter.trusted != 0;
            trusted_count += usize::from(trusted);
            let truth = truth.map_or(f64::NAN, |t| parameter.truth(t));
            let (value, std) = (parameter.value(estimate), parameter.std(estimate));
            let error = 100.0 * (value / truth - 1.0);
            if estimate.flags() & parameter.excited == 0 || !error.is_finite() {
                continue;
            }
            let inside = is_covered(value, std, truth);
            score.errors.push(error);
            held += usize::from(inside);
            if trusted {
                score.trusted_errors.push(error);
                held_trusted += usize::from(inside);
            }
        }
        score.coverage = share(held, score.errors.len());
        score.trusted_coverage = share(held_trusted, score.trusted_errors.len());
        score.trusted_share = share(trusted_count, count);
        score
    }

    /// Mean, standard deviation and largest error while excited [%].
    pub fn summary(&self) -> Option<Summary> {
        Summary::of(&self.errors)
    }
}

fn share(part: usize, whole: usize) -> f64 {
    if whole == 0 {
        f64::NAN
    } else {
        part as f64 / whole as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, ExcavatorTruth, Stamp, excavator_bits as bits};

    #[test]
    fn errors_count_only_while_excited_and_coverage_knows_the_trusted() {
        let row = |sequence, inertia, flags| ExcavatorEstimate {
            stamp: Stamp {
                sequence,
                ..Default::default()
            },
            inertia,
            inertia_std: 10.0,
            estimated: bits::INERTIA,
            flags,
            ..Default::default()
        };
        let trusted = bits::EXCITED | bits::TRUSTED;
        let estimates = vec![
            row(0, 500.0, 0),
            row(1, 1010.0, trusted),
            row(2, 990.0, trusted),
            row(3, 900.0, bits::EXCITED),
        ];
        let truth = (0..4).map(|sequence| ExcavatorTruth {
            stamp: Stamp {
                sequence,
                ..Default::default()
            },
            inertia: 1000.0,
            known: 1,
            ..Default::default()
        });
        let estimator = Estimator {
            channel: "excavator/inertia_rls".into(),
            estimates,
            extremes: Default::default(),
        };
        let run = MachineRun {
            estimators: vec![estimator.clone()],
            truth: truth.collect(),
        };
        let score = Score::of(&run, &estimator, &ExcavatorEstimate::PARAMETERS[0]);
        assert_eq!(score.errors.len(), 3);
        assert!((score.summary().expect("errors").mean + 100.0 / 30.0).abs() < 1e-9);
        assert!((score.coverage - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!((score.trusted_coverage, score.trusted_share), (1.0, 0.5));
        // The last one was retained as an extreme, so it does not count.
        let thinned = Estimator {
            extremes: [3].into(),
            ..estimator
        };
        let score = Score::of(&run, &thinned, &ExcavatorEstimate::PARAMETERS[0]);
        assert_eq!(score.errors.len(), 2);
        assert_eq!((score.coverage, score.trusted_share), (1.0, 2.0 / 3.0));
    }
}
