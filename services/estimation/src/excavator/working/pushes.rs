//! Changes during a swing without a joint motion: of the payload, or by something that pushes the upper body.

use super::Working;
use super::bucket::Content;
use super::filter::M;
use super::standing::is_quiet;
use super::trail::Trail;
use crate::excavator::settings::Settings;

/// Threshold of the CUSUM of normalised innovations: the payload has changed without a joint motion.
pub(super) const CHANGE: f64 = 10.0;
/// Level of the same sum above which the payload may have changed.
pub(super) const SUSPICIOUS: f64 = 4.0;

impl Working {
    /// Tests whether the payload changes without a joint motion; `z`: normalised innovation. Returns true where it changes again although
    /// its variance was raised: then the cause is no payload.
    pub(super) fn watch_payload(&mut self, s: &Settings, z: f64) -> bool {
        let weight = (self.filter.x[M], self.filter.p[M][M]);
        let anything = self.anything();
        if self.change.push(z.clamp(-3.0, 3.0)) {
            // Without a torque, the motion carries no information about the payload.
            self.rides = is_quiet(s, self.torque);
            if self.rides {
                self.agreement.interrupt();
                return false;
            }
            for filter in [&mut self.filter, &mut self.parallel.filter] {
                filter.p[M][M] += anything;
            }
            self.agreement.contradict();
            let again = core::mem::replace(&mut self.changed, true);
            if !again {
                self.contradiction.changed(weight);
            }
            return again;
        }
        if self.changed && !self.pushed {
            self.changed = !self.contradiction.withdraws(weight, anything);
        }
        false
    }

    /// Tests whether something pushes the upper body: the change is no payload, or one that no bucket can hold.
    pub(super) fn watch_pushes(
        &mut self,
        s: &Settings,
        no_payload: bool,
        trail: &mut Option<Trail>,
    ) {
        let (weight, range) = (self.filter.payload(&self.sticks), s.payload_range());
        let beyond = weight != weight.clamp(range[0], range[1]) && !self.attachment.is_possible();
        let pushes = beyond && {
            let row = self.filter.payload_row(&self.sticks);
            let payload = (weight, self.filter.combination(&row).1);
            self.contradiction.weighs(payload, range, self.changed)
        };
        if pushes || no_payload {
            self.contradiction.pushes();
            self.pushed = true;
            self.hold(s, Content::Unknown, trail);
        }
    }
}
