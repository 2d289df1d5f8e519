//! A gap: for a while no sensor has sent a value.
//!
//! Motion, heading and content may be others after it. The machine is the same, and what was learnt of its constants stays known. It
//! ages as an Ornstein-Uhlenbeck process about the description, with covariance S:
//!
//! ```text
//! c <- d + k (c - d),   P_cc <- k^2 P_cc + (1 - k^2) S,   k = exp(-t/T)
//! ```
//! T is that of stored knowledge ([`super::recall`]). Friction and damping wander as in motion: a walk by S in [`WARMING`] is one with
//! T = 2 [`WARMING`] near its start. After hours the filter begins from the description. A coupler may have changed the bucket in a gap
//! that is long enough ([`super::attachment`]).
//!
//! A motion in progress after the gap is not used: boom and oil swing already, which no state carries. With known constants its first
//! third of a second would determine the content, 2.5 standard deviations off (five of 88 gaps on an independent plant).

use super::Working;
use super::bucket::{Bucket, Content};
use super::filter::{
    BUCKET, DAMPING, DELAY, FRICTION, Filter, GAIN, LINKS, LOSS, MOMENT, OFFSET, SLOPE, SPAN,
    UPPER, ZERO,
};
use super::motion::WARMING;
use super::recall::LASTS;
use crate::excavator::measurements::ground::Ground;
use crate::excavator::settings::Settings;
use crate::math::exp;

/// Constants of the machine and its sensors.
const LASTING: [usize; 10] = [
    OFFSET, GAIN, LOSS, MOMENT, DELAY, UPPER, BUCKET, LINKS, SPAN, ZERO,
];
/// Constants that change with the temperature of the oil.
const WARMED: [usize; 2] = [FRICTION, DAMPING];

impl Working {
    /// Forgets what a gap may have changed: content, motion and heading.
    #[cold]
    #[inline(never)]
    pub(in crate::excavator) fn goes_on(&mut self, settings: &Settings) {
        self.hold(settings, Content::Unknown, &mut None);
        self.rest(0.0, 1e-6, &mut None);
        self.bucket = Bucket::new(settings.estimator.opening_rate);
        self.ground = Ground::new();
        self.carried = None;
        (self.rides, self.joined) = (false, true);
        self.torque = 0.0;
        (self.slow_for, self.before, self.gaining) = (0.0, 0.0, 0.0);
        (self.angle, self.turn) = (0.0, (0.0, 1.0));
        let filters = [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ];
        if let Some(weigh) = &mut self.weigh {
            weigh.goes_on(filters);
        }
        for filter in self.all_filters() {
            filter.turns_anywhere();
        }
        // What an inclinometer showed was along the axes of that heading too.
        self.described[SLOPE..=SLOPE + 1].fill(0.0);
        self.ends_the_test();
        self.anew = true;
    }

    /// Ages what is known by `period` of a gap that has lasted for `silent` so far \[s\].
    #[cold]
    #[inline(never)]
    pub(in crate::excavator) fn waits(&mut self, settings: &Settings, period: f64, silent: f64) {
        self.attachment.wait(period);
        self.attachment.stands(silent);
        self.travels(period);
        let described = self.described(settings);
        for filter in self.all_filters() {
            filter.fade(&described, exp(-period / LASTS), &LASTING);
            filter.fade(&described, exp(-0.5 * period / WARMING), &WARMED);
        }
        self.scale.has_no_torque();
    }

    /// The filters, and what is stored of them.
    fn all_filters(&mut self) -> impl Iterator<Item = &mut Filter> {
        let filters = [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ];
        filters.into_iter().chain(self.recall.stored())
    }
}

impl Filter {
    /// Turns the axes of the slope by any angle: its mean is zero, and the mean square along each axis is half that of its size.
    fn turns_anywhere(&mut self) {
        let size: f64 = [SLOPE, SLOPE + 1]
            .iter()
            .map(|&i| self.x[i] * self.x[i] + self.p[i][i])
            .sum();
        for i in [SLOPE, SLOPE + 1] {
            self.set(i, 0.0, 0.5 * size, &mut None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::M;
    use super::*;
    use crate::excavator::keys::Description;

    /// A filter that knows its machine and the slope, after a gap of this length [s].
    fn after(silent: f64) -> (Working, Filter) {
        let settings = Settings::of(&Description::default());
        let mut working = Working::new(&settings, &settings.doubts.expect("doubts"));
        let prior = working.filter.clone();
        for filter in working.all_filters() {
            for i in [UPPER, FRICTION] {
                filter.x[i] += 2.0 * crate::math::sqrt(filter.p[i][i]);
                filter.p[i][i] *= 0.01;
            }
            filter.set(M, 300.0, 900.0, &mut None);
            filter.set(SLOPE, 0.03, 1e-6, &mut None);
            filter.set(SLOPE + 1, 0.0, 1e-6, &mut None);
        }
        working.goes_on(&settings);
        working.waits(&settings, silent, silent);
        (working, prior)
    }

    #[test]
    fn after_three_seconds_the_machine_is_known_and_content_and_heading_are_not() {
        let (working, prior) = after(3.0);
        for i in [UPPER, FRICTION] {
            let std = crate::math::sqrt(prior.p[i][i]);
            let moved = (working.filter.x[i] - prior.x[i]) / std;
            assert!(moved > 1.9, "{i}: {moved}");
            let left = working.filter.p[i][i] / prior.p[i][i];
            assert!(left < 0.1, "{i}: {left}");
        }
        assert_eq!(working.filter.x[M], prior.x[M]);
        assert!((working.filter.p[M][M] / prior.p[M][M] - 1.0).abs() < 1e-9);
        // A slope of .03 along any axis, and a little that was travelled.
        for i in [SLOPE, SLOPE + 1] {
            let square = working.filter.p[i][i] / (0.5 * 0.03 * 0.03);
            assert!(working.filter.x[i] == 0.0 && (1.0..1.3).contains(&square));
        }
    }

    #[test]
    fn after_a_day_the_filter_begins_from_the_description() {
        let (working, prior) = after(86_400.0);
        for i in [UPPER, FRICTION, GAIN, BUCKET] {
            let away = (working.filter.x[i] - prior.x[i]).abs();
            assert!(away < 1e-3 * crate::math::sqrt(prior.p[i][i]), "{i}");
            assert!((working.filter.p[i][i] / prior.p[i][i] - 1.0).abs() < 0.02);
        }
        assert!(working.attachment.may_be_another());
    }
}
