//! What motion has told of what turns, since it was known before: where the model holds, it has moved by as much as its variance has lost.

use super::filter::{BUCKET, Filter, GAIN, LINKS, M, UPPER};
use crate::excavator::geometry::Inertia;

/// Share of its variance that what turns must have lost to have been told.
const TOLD: f64 = 0.5;
/// Within so many standard deviations it is as foreseen.
const AGREES: f64 = 2.0;
/// What motion has told of what turns per measured torque: by how much it has moved [kg m^2], and how much variance it has lost, from
/// how much [(kg m^2)^2].
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    pub(super) by: f64,
    pub(super) lost: f64,
    pub(super) variance: f64,
}

impl Moved {
    /// Whether it is as was foreseen: where the model holds it has moved by as much as its variance has lost.
    pub(super) fn is_foreseen(&self) -> bool {
        self.lost > TOLD * self.variance && self.by * self.by < AGREES * AGREES * self.lost
    }
}

impl Filter {
    /// What motion has told since this of what turns per measured torque; with a content of none, of this variance [kg^2].
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

    /// By what an emptied bucket moves what swings have told of what turns, when the torque is `wrong` by a factor; with the posture.
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
        let tell = |filter: &mut Filter, wrong: f64| {
            let value = (wrong - 1.0) * now.empty - filter.combination(&row).0;
            let variance = 1e-4 * now.empty * now.empty;
            filter.measure(row, value, variance, 1e9, &mut None);
        };
        let content = 17.0 * 17.0;
        known.set(M, 0.0, content, &mut None);
        (0..3).for_each(|_| tell(&mut known, 1.0));
        let mut after = known.clone();
        after.set(M, 0.0, content, &mut None);
        (0..9).for_each(|_| tell(&mut after, wrong));
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
