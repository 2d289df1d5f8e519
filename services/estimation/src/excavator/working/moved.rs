//! Change of the estimated inertia by motion since an earlier estimate. Where the model holds, its mean square equals the variance lost.

use super::filter::{BUCKET, Filter, GAIN, LINKS, M, UPPER};
use crate::excavator::geometry::Inertia;

/// Share of its variance that the inertia must have lost to count as estimated.
const LEARNT: f64 = 0.5;
/// Gate within which the change is as predicted [standard deviations of the variance lost].
const AGREES: f64 = 2.0;
/// Change of the inertia per measured torque, by motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// Change of the value [kg m^2].
    pub(super) by: f64,
    /// Variance lost [(kg m^2)^2].
    pub(super) lost: f64,
    /// Variance before [(kg m^2)^2].
    pub(super) variance: f64,
}

impl Moved {
    /// Returns whether enough variance was lost, and the change lies within the gate that it sets.
    pub(super) fn is_foreseen(&self) -> bool {
        self.lost > LEARNT * self.variance && self.by * self.by < AGREES * AGREES * self.lost
    }
}

impl Filter {
    /// Returns the change from this filter to `after` of the inertia per measured torque, with an empty content of variance `content`
    /// [kg^2].
    pub(super) fn moved(&self, after: &Self, content: f64, now: &Inertia) -> Moved {
        let content_row = (M, now.per_payload);
        let [upper, bucket, links, gain] = [
            (UPPER, 1.0),
            (BUCKET, now.per_bucket),
            (LINKS, now.links),
            (GAIN, -now.empty),
        ];
        let (before, of_machine) = self.combination(&[upper, bucket, links, gain]);
        let variance = of_machine + now.per_payload * now.per_payload * content;
        let (value, left) = after.combination(&[content_row, upper, bucket, links, gain]);
        Moved {
            by: value - before,
            lost: variance - left,
            variance,
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Working;
    use super::*;
    use crate::excavator::drive::Drive;
    use crate::excavator::keys::Description;
    use crate::excavator::settings::Settings;

    /// Change by an emptied bucket after correct swings, when the torque is then `wrong` by a factor; with the posture.
    pub(in super::super) fn moved(settings: &Settings, wrong: f64) -> (Moved, Drive) {
        let working = Working::new(settings, &settings.doubts.expect("doubts"));
        let posture = [0.6, -1.8, -1.5];
        let now = settings.geometry.inertia(posture);
        let mut known = working.filter;
        let row = [
            (M, now.per_payload),
            (UPPER, 1.0),
            (BUCKET, now.per_bucket),
            (LINKS, now.links),
            (GAIN, -now.empty),
        ];
        let measure = |filter: &mut Filter, wrong: f64| {
            let value = (wrong - 1.0) * now.empty - filter.combination(&row).0;
            let variance = 1e-4 * now.empty * now.empty;
            filter.measure(row, value, variance, 1e9, &mut None);
        };
        let content = 17.0 * 17.0;
        known.set(M, 0.0, content, &mut None);
        (0..3).for_each(|_| measure(&mut known, 1.0));
        let mut after = known.clone();
        after.set(M, 0.0, content, &mut None);
        (0..9).for_each(|_| measure(&mut after, wrong));
        let drive = Drive {
            posture,
            now,
            ..Drive::default()
        };
        (known.moved(&after, content, &now), drive)
    }

    #[test]
    fn a_machine_that_turns_as_it_did_agrees_and_one_with_another_torque_does_not() {
        let settings = Settings::of(&Description::default());
        for (wrong, agrees) in [(1.0, true), (1.1, false), (0.9, false)] {
            let (moved, _) = moved(&settings, wrong);
            assert_eq!(moved.is_foreseen(), agrees, "{wrong}");
        }
    }
}
