//! Every moment of a recording as all its rows see it (`heft estimate --smooth`).

use config::Excavator as Description;
use estimation::excavator::{Settings, Smoothed, Smoother, SwingEstimator, Trail};
use estimation::{HALF_WIDTH_95, Quantity};
use messages::{ExcavatorEstimate, ExcavatorSensors, excavator_bits as bits};

use super::{columns, method, sample};
use crate::Error;

/// A moment as all rows see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past {
    /// Payload \[kg\].
    pub payload: Quantity,
    /// Inertia in the posture of the row [kg m^2].
    pub inertia: Quantity,
    /// Share of the inertia that the interval may have where an estimate is to be trusted.
    converged: f64,
}

impl Past {
    /// Puts the moment into an estimate that knew nothing of later rows. Excitation and consistency stay as they were.
    pub fn put(&self, estimate: &mut ExcavatorEstimate) {
        (estimate.inertia, estimate.inertia_std) = (self.inertia.value, self.inertia.std);
        (estimate.payload, estimate.payload_std) = (self.payload.value, self.payload.std);
        let sure = HALF_WIDTH_95 * self.inertia.std < self.converged * self.inertia.value
            && estimate.flags & bits::CHANGING == 0;
        let set = |flags: u32, bit: u32, on: bool| if on { flags | bit } else { flags & !bit };
        let flags = set(estimate.flags, bits::CONVERGED, sure);
        let needed =
            bits::EXCITED | bits::CONSISTENT | bits::FRESH | bits::CONVERGED | bits::IDENTIFIABLE;
        estimate.flags = set(flags, bits::TRUSTED, flags & needed == needed);
    }
}

/// The moments of some rows, none where a row was refused or came before the first estimate.
///
/// It keeps some two kilobytes for every hundredth of a second.
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
    let mut ends: Vec<(usize, [Option<f64>; 3])> = Vec::new();
    for row in rows {
        let row = sample(&row);
        estimator.step_with(&row, &mut |trail| trails.push(*trail));
        ends.push((trails.len(), row.posture));
    }
    let mut smoother = Smoother::default();
    let mut moments: Vec<Smoothed> = trails.iter().rev().map(|t| smoother.back(t)).collect();
    moments.reverse();
    let mut last = None;
    let smoothed = ends.iter().map(|(end, posture)| {
        if let [Some(boom), Some(arm), Some(bucket)] = *posture {
            last = Some([boom, arm, bucket]);
        }
        let moment = moments.get(end.checked_sub(1)?)?;
        Some(at(&settings, moment, last?))
    });
    Ok(smoothed.collect())
}

fn at(settings: &Settings, moment: &Smoothed, posture: [f64; 3]) -> Past {
    // The tick may be older than the row.
    let payload = moment.payload.value;
    let [now, then] = [posture, moment.posture].map(|q| settings.geometry.inertia(q));
    let moved = now.with_payload(payload) - then.with_payload(payload);
    Past {
        payload: moment.payload,
        inertia: Quantity {
            value: moment.inertia.value + moved,
            std: moment.inertia.std,
        },
        converged: settings.estimator.converged_share,
    }
}
