//! The pressures beside the torque: their start, their moments in the filters, and their contradictions with the torque.

use super::Working;
use super::bucket::Content;
use super::filter::{GAIN, M, SPAN, W, ZERO};
use super::trail::Trail;
use super::weigh::Weigh;
use crate::excavator::drive::Drive;
use crate::excavator::measurements::boom_moment::FADING;
use crate::excavator::settings::Settings;

impl Working {
    /// Takes in the moment of the boom cylinders, where one is complete. Returns whether the load must be another one.
    pub(super) fn weigh(
        &mut self,
        settings: &Settings,
        drive: &Drive,
        (content, stands): (Content, bool),
        trail: &mut Option<Trail>,
    ) -> bool {
        let Some(weigh) = &mut self.weigh else {
            return false;
        };
        let motion = (self.turn, self.filter.x[W]);
        let opens = self.bucket.is_settling();
        let moment = weigh.step(
            settings,
            drive,
            motion,
            (content, opens, self.ground.may_touch()),
        );
        self.begin_weighing(drive, trail);
        let Some(moment) = moment else {
            return false;
        };
        if moment.stood < FADING && !self.parallel.is_driven() {
            self.fade_alone(settings, moment.period, trail);
        }
        let anything = self.anything();
        let Some(weigh) = &self.weigh else {
            return false;
        };
        let known = !self.attachment.may_be_another();
        let alone = self
            .scale
            .weigh(weigh, settings, &moment, (self.rated, known));
        if self.parallel.is_driven() {
            self.doubt_pressures();
        } else if self.scale.is_misled() {
            self.contradiction.outright();
        }
        let Some(weigh) = &mut self.weigh else {
            return false;
        };
        let parallel = &mut self.parallel.filter;
        let believes = !self.scale.is_doubted();
        let innovation = weigh.measure(settings, &moment, (&mut self.filter, believes), trail);
        let other = weigh.measure(settings, &moment, (parallel, believes), &mut None);
        if !believes {
            if moment.touches {
                return weigh.sets_down(alone, (self.scale.filter.load(), self.rated));
            }
            if self.carries() {
                let load = (self.filter.load(), self.filter.p[M][M]);
                self.scale.sees(load, anything);
            }
            return false;
        }
        let load = (self.filter.load(), self.rated);
        if moment.touches {
            return weigh.sets_down(innovation, load);
        }
        let (gate, usual) = (settings.estimator.gate, self.contradiction.usual());
        self.parallel.weigh([innovation, other], gate, usual);
        weigh.watch(&moment, innovation, load, stands);
        let renews = weigh.renews(innovation, drive.posture[2]);
        if renews && innovation.value < 0.0 {
            // The ground may carry what is missing.
            self.ground.rests();
        }
        let same = self.parallel.is_driven() || !self.attachment.may_be_another();
        if renews && self.bucket.is_emptied() && same {
            // Nothing has been filled into an emptied bucket.
            self.contradiction.outright();
        }
        renews
    }

    /// Compares torque and pressures. Where they begin to contradict each other, the torque goes on alone.
    fn doubt_pressures(&mut self) {
        if self.is_beyond() {
            self.contradiction.outright();
        }
        if self.scale.doubts(self.contradiction.is_open()) {
            self.tail.forget();
            // The torque weighs again what both have weighed.
            let anything = self.anything();
            for filter in [&mut self.filter, &mut self.parallel.filter] {
                filter.p[M][M] += anything;
            }
        }
    }

    /// Starts the measurement by pressures: from now on they weigh beside the torque.
    fn begin_weighing(&mut self, drive: &Drive, trail: &mut Option<Trail>) {
        let filters = [
            &mut self.filter,
            &mut self.parallel.filter,
            &mut self.scale.filter,
        ];
        let weigh = self.weigh.as_mut();
        let Some(stated) = weigh.and_then(|weigh| weigh.begin(drive, filters, trail)) else {
            return;
        };
        for (i, std) in [SPAN, ZERO].into_iter().zip(stated) {
            self.restate(i, std);
        }
        self.recall.forget();
        self.parallel.is_joined_by_pressures();
        let std = self.weighed_gain;
        if std < self.stated[GAIN] && !self.parallel.is_driven() {
            self.restate(GAIN, std);
            self.filter.set(GAIN, 0.0, std * std, trail);
            self.parallel.knows_gain(std);
        }
    }

    /// Updates the hypothesis of a gain that is off, where pressures weigh beside a torque that has informed the filter.
    pub(super) fn doubt_gain(&mut self, drive: &Drive) {
        if self.weighs() && self.tail.is_due(drive.period) && self.parallel.is_driven() {
            let known = (self.stated[GAIN], self.disagreement());
            self.tail.ask(&self.filter, known, &drive.now, &self.sticks);
        }
    }

    /// Returns whether pressures weigh and are trusted.
    pub(super) fn weighs(&self) -> bool {
        self.weigh.as_ref().is_some_and(Weigh::is_there) && !self.scale.is_doubted()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::keys::Description;

    #[test]
    fn a_gain_is_known_better_where_pressures_weigh_beside_the_torque() {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance) = (0.6, 1.3);
        let settings = Settings::of(&d);
        let doubts = settings.doubts.expect("doubts");
        let mut working = Working::new(&settings, &doubts);
        let variances = |working: &Working| {
            [&working.filter, &working.parallel.filter].map(|filter| filter.p[GAIN][GAIN])
        };
        let before = variances(&working);
        assert!((before[0] - doubts.gain_std * doubts.gain_std).abs() < 1e-12);
        let drive = Drive {
            boom_pressure: Some([12e6, 1e6]),
            ..Drive::default()
        };
        working.begin_weighing(&drive, &mut None);
        let after = variances(&working);
        assert!((after[0] - doubts.weighed_gain_std * doubts.weighed_gain_std).abs() < 1e-12);
        // The parallel filter's gain stays open.
        assert!(after[1] < before[1] && after[1] > 50.0 * after[0]);
        // What motion has identified since is not reset.
        working.filter.p[GAIN][GAIN] = 1e-4;
        working.begin_weighing(&drive, &mut None);
        assert!((working.filter.p[GAIN][GAIN] - 1e-4).abs() < 1e-12);
    }
}
