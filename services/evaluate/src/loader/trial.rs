//! One simulated run through several filters at once.

use estimation::loader::{Estimate, Settings};
use sim::loader::{Row, Run, Simulation};

use super::candidate::Candidate;
use super::score::Score;
use crate::Error;

/// Runs every candidate on the same rows; `look` receives each answer: candidate, row, estimate.
pub(super) fn each_row(
    run: &Run,
    candidates: &[Candidate],
    look: impl FnMut(usize, &Row, &Estimate),
) -> Result<(), Error> {
    each_row_adjusted(run, candidates, |_| {}, look)
}

/// As [`each_row`]; `adjust` changes the candidates' settings.
pub(super) fn each_row_adjusted(
    run: &Run,
    candidates: &[Candidate],
    adjust: impl Fn(&mut Settings),
    mut look: impl FnMut(usize, &Row, &Estimate),
) -> Result<(), Error> {
    let mut simulation = Simulation::new(run).map_err(Error::refused)?;
    let (nominal, machine) = (*simulation.nominal(), *simulation.machine());
    let Some(first) = simulation.next() else {
        return Ok(());
    };
    let mut filters = candidates
        .iter()
        .map(|candidate| {
            let known = candidate.nominal(&nominal, &machine);
            let mut settings = candidate.settings(&known, &first);
            adjust(&mut settings);
            candidate.estimator(&settings)
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(Error::refused)?;
    for row in std::iter::once(first).chain(simulation) {
        for (k, (filter, candidate)) in filters.iter_mut().zip(candidates).enumerate() {
            if let Some(payload) = candidate.payload(&row) {
                filter.set_payload(Some(payload));
            }
            look(k, &row, &filter.step(&candidate.sample(&nominal, &row)));
        }
    }
    Ok(())
}

/// The scores of every candidate over the scenario's window of evaluation.
pub(super) fn scores(run: &Run, candidates: &[Candidate]) -> Result<Vec<Score>, Error> {
    scores_adjusted(run, candidates, |_| {})
}

/// As [`scores`]; `adjust` changes the candidates' settings.
pub(super) fn scores_adjusted(
    run: &Run,
    candidates: &[Candidate],
    adjust: impl Fn(&mut Settings),
) -> Result<Vec<Score>, Error> {
    let from = run.scenario.evaluated_from();
    let mut scores = vec![Score::default(); candidates.len()];
    each_row_adjusted(run, candidates, adjust, |k, row, estimate| {
        if row.time >= from {
            scores[k].take(row, estimate);
        }
    })?;
    Ok(scores)
}
