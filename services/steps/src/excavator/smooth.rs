//! Smoothed estimates of a recording, from all its rows (`heft estimate --smooth`).

use config::Excavator as Description;
use estimation::Quantity;
use estimation::excavator::{Settings, Smoothed, Smoother, SwingEstimator, Trail};
use messages::{ExcavatorEstimate, ExcavatorSensors, excavator_bits as bits};

use super::{columns, method, sample};
use crate::Error;

/// Smoothed estimate of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past {
    /// Payload \[kg\].
    pub payload: Quantity,
    /// Inertia [kg m^2].
    pub inertia: Quantity,
    converged: bool,
}

impl Past {
    /// Writes the smoothed estimate into a filtered one. Excitation, consistency and doubts stay unchanged.
    pub fn put(&self, estimate: &mut ExcavatorEstimate) {
        if estimate.flags & bits::REFUSED != 0 {
            return;
        }
        (estimate.inertia, estimate.inertia_std) = (self.inertia.value, self.inertia.std);
        (estimate.payload, estimate.payload_std) = (self.payload.value, self.payload.std);
        let sure = self.converged && estimate.flags & bits::CHANGING == 0;
        let set = |flags: u32, bit: u32, on: bool| if on { flags | bit } else { flags & !bit };
        let flags = set(estimate.flags, bits::CONVERGED, sure);
        let needed =
            bits::EXCITED | bits::CONSISTENT | bits::FRESH | bits::CONVERGED | bits::IDENTIFIABLE;
        estimate.flags = set(flags, bits::TRUSTED, flags & needed == needed);
    }
}

/// The smoothed estimates of the rows, none for rows before the first tick. A refused row has the estimate of the previous one.
///
/// It stores some two kilobytes for every hundredth of a second.
///
/// # Errors
/// The method is unknown or has no smoother, or the description has a value that it cannot use.
pub fn past(
    description: &Description,
    name: &str,
    rows: impl Iterator<Item = ExcavatorSensors>,
) -> Result<Vec<Option<Past>>, Error> {
    let mut rows = rows.peekable();
    let settings = Settings::of(description);
    let there = rows.peek().map(columns).unwrap_or_default();
    let refused = || {
        Error::settings(format!(
            "{name} has no smoother: torque, posture and the default variant are needed"
        ))
    };
    let mut estimator =
        SwingEstimator::new(&settings, method(name)?, there).map_err(Error::settings)?;
    if !estimator.keep_trail() {
        return Err(refused());
    }
    let mut trails: Vec<Trail> = Vec::new();
    let mut ends: Vec<usize> = Vec::new();
    for row in rows {
        estimator.step_with(&sample(&row), &mut |trail| trails.push(*trail));
        ends.push(trails.len());
    }
    let mut smoother = Smoother::default();
    let mut moments: Vec<Smoothed> = trails.iter().rev().map(|t| smoother.back(t)).collect();
    moments.reverse();
    let past = |end: &usize| {
        let moment = moments.get(end.checked_sub(1)?)?;
        Some(Past {
            payload: moment.payload,
            inertia: moment.inertia,
            converged: moment.converged(settings.estimator.converged_share),
        })
    };
    Ok(ends.iter().map(past).collect())
}
