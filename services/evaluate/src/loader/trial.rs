//! One simulated run through several filters at once.

use estimation::loader::{Estimate, Settings};
use sim::loader::{Row, Run, Simulation};

use super::candidate::Candidate;
use super::score::Score;
use crate::Error;

/// Drives every candidate through the same rows; `look` sees each answer: candidate, row, estimate.
pub(super) fn each_row(
    run: &Run,
    candidates: &[Candidate],
    look: impl FnMut(usize, &Row, &Estimate),
) -> Result<(), Error> {
    each_row_told(run, candidates, |_| {}, look)
}

/// The same; `tell` changes what the candidates begin with.
fn each_row_told(
    run: &Run,
    candidates: &[Candidate],
    tell: impl Fn(&mut Settings),
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
            tell(&mut settings);
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
    scores_told(run, candidates, |_| {})
}

/// The same; `tell` changes what the candidates begin with.
pub(super) fn scores_told(
    run: &Run,
    candidates: &[Candidate],
    tell: impl Fn(&mut Settings),
) -> Result<Vec<Score>, Error> {
    let from = run.scenario.evaluated_from();
    let mut scores = vec![Score::default(); candidates.len()];
    each_row_told(run, candidates, tell, |k, row, estimate| {
        if row.time >= from {
            scores[k].take(row, estimate);
        }
    })?;
    Ok(scores)
}
