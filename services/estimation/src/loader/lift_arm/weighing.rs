//! A row with all its signals: the moment in this posture, what it says of payload, stops and sensors, and the answer.

use super::LiftWitness;
use super::changed::Bucket;
use super::content::Motion;
use super::drives;
use super::geometry::{Posture, Shown};
use super::numbers::{FRICTION, TURN};
use super::stops::End;
use crate::Quantity;
use crate::loader::sample::Sample;
use crate::math::norm;

/// Standard deviations below zero beyond which a bucket at the lower end of the arm's travel rests on a stop or the ground.
const CARRIED: f64 = 1.9;

impl LiftWitness {
    pub(super) fn weigh(
        &mut self,
        [lift, bucket]: [f64; 2],
        mut posture: Posture,
        sample: &Sample,
        dt: f64,
    ) {
        let stance = self.drawing.stance(&self.drawing.values, &posture);
        self.seals.take(stance.rod_length, dt);
        let low = self.drawing.is_low(posture.arm);
        let (pushes, driving) = (self.drive.pushes(), drives(sample));
        let mut motion = self.content.motion(
            self.rates,
            self.drawing.values[TURN],
            [low, pushes],
            sample.speed,
            dt,
        );
        self.learn(&posture, &motion);
        let (drawing, values) = (&self.drawing, &self.drawing.values);
        posture.seals = self.seals.share();
        let shown = drawing.shown(values, &stance, &posture);
        // A low bucket rests only while the machine stands. Driven low it is carried, or levels: then the cylinders carry almost nothing.
        let rests = low && !driving;
        let pressed = drawing.pressed(values, shown.lever, &posture);
        self.watch_steps((&shown, pressed), &motion, [rests, pushes], dt);
        if !self.drawing.carries_itself(&shown) {
            motion = self.content.put_down(&motion);
        }
        self.take(&shown, [posture.head, lift], driving, &motion, dt);
        // While the moment swings, the content is unknown.
        motion.open |= self.scale.swings();
        posture.rest = self.scale.rest();
        let (drawing, values) = (&self.drawing, &self.drawing.values);
        let shown = Shown {
            lifting: drawing.lifted(values, shown.lever, &posture),
            ..shown
        };
        let payload = self.scale.payload();
        let empty = drawing.empty_at(values, &stance);
        let known = (!motion.open).then_some(payload);
        let moment = shown.lifting / shown.per_load;
        let at = low.then_some([lift, bucket]);
        let weights = [moment, drawing.capacity];
        let forward = sample.speed.unwrap_or(0.0) * dt;
        if self.grading.see(known, at, weights, forward) {
            motion = self.content.put_down(&motion);
        }
        // One number a row, but all in the first.
        loop {
            let payloads = [shown.payload(), payload.value];
            let doubts = &mut self.doubts;
            doubts.see(&mut self.drawing, (&stance, &posture), payloads, &empty);
            if doubts.are_whole() {
                break;
            }
        }
        let drawn = self.doubts.shown();
        let std = norm(&[payload.std, drawn]);
        let shown = Quantity { std, ..payload };
        // The ground may carry a low bucket, so only a high one hangs free.
        let hangs = !low && self.below.explains(shown);
        let capacity = self.drawing.capacity;
        let tare = self.emptied.see(payload, &motion, hangs, capacity);
        self.doubts.empty(tare);
        let row = Bucket {
            shown: payload,
            doubts: &self.doubts,
            motion: &motion,
            in_the_air: (!low).then_some(bucket),
            is_empty: tare.is_some_and(|tare| tare.at_dump),
            rests,
            capacity,
        };
        self.changed.see(&row, dt);
        if !motion.open {
            self.below.see(shown, empty.most(), rests, dt);
        }
        let answer = self.answer(&empty, &empty, payload, motion.open);
        self.answer.insert(answer).carried.rests = motion.held;
    }

    /// Detects steps of the moment `pressed` by the pressures that no content makes. `rests`: the ground may carry a part of it; `pushes`:
    /// the wheels push.
    fn watch_steps(
        &mut self,
        (shown, pressed): (&Shown, f64),
        motion: &Motion,
        [rests, pushes]: [bool; 2],
        dt: f64,
    ) {
        let acts =
            motion.turning || pushes || self.stops.carry() && !self.moment_steps.is_stepping();
        let rows = [shown.payload(), pressed, shown.per_load];
        let Quantity { value, std } = self.scale.payload();
        // The payload is unknown while the ground carries a part of it.
        let is_known = !(motion.open || rests && value < -std);
        let known = is_known.then_some(value);
        if let Some(step) = self.moment_steps.see(rows, known, acts, dt) {
            let landed = rests && step.level < 0.0;
            let turned = step.by.abs() < 2.0 * self.friction(shown);
            let empty = shown.empty / shown.per_load;
            self.changed.step(step, empty, landed || turned);
        }
    }

    /// Updates the payload with a row, and detects stops, saturation, jumps and ground contact.
    fn take(
        &mut self,
        shown: &Shown,
        [head, lift]: [f64; 2],
        driving: bool,
        motion: &Motion,
        dt: f64,
    ) {
        self.stops.see(lift);
        let drawing = &self.drawing;
        self.scale.walk(drawing, &self.seals, motion, dt);
        if self.stops.carry() {
            self.scale.stop();
            return;
        }
        let moves = motion.lifting || driving;
        if self.saturation.see(head, moves, dt) {
            return;
        }
        self.scale
            .step(drawing, shown, &self.seals, motion, self.drive.measured, dt);
        let is_low = self.stops.is_at(End::Lower, lift);
        if self.stops.is_at(End::Upper, lift) && self.scale.presses(shown, motion) {
            self.scale.stop();
            self.stops.meet(End::Upper, lift);
        } else if is_low && self.scale.swings() && self.is_less_than_nothing(shown.payload(), shown)
        {
            self.scale.stop();
            self.stops.meet(End::Lower, lift);
        } else if is_low
            && !motion.open
            && self.is_less_than_nothing(self.scale.payload().value, shown)
        {
            // It rests without a swing at contact: the payload is unknown.
            self.scale.forget(drawing);
            self.stops.meet(End::Lower, lift);
        } else if self.scale.jumped() {
            self.scale.open(drawing);
            self.scale.dig(drawing, dt);
            self.content.touch();
        } else if motion.held {
            self.scale.dig(drawing, dt);
        }
    }

    /// The cylinders carry significantly less than the empty arm and bucket, given the deviations of drawing and seals.
    fn is_less_than_nothing(&self, payload: f64, shown: &Shown) -> bool {
        let seals = self.seals.unknown() * self.friction(shown);
        let off = self.doubts.off();
        payload - off.value < -CARRIED * norm(&[seals, off.std])
    }

    /// Friction of the seals, as a payload [kg].
    fn friction(&self, shown: &Shown) -> f64 {
        let (drawing, v) = (&self.drawing, &self.drawing.values);
        v[FRICTION] * drawing.full_force(v) * shown.lever / shown.per_load
    }

    /// Updates the bucket turn from the angles. The measured moment stays; with another lever it is another payload.
    fn learn(&mut self, posture: &Posture, motion: &Motion) {
        let (Some(linkage), Some(angles)) = (&mut self.linkage, self.angles) else {
            return;
        };
        if !self.signals.measure_tilt() {
            return;
        }
        let Some(turn) = linkage.see(angles, motion.lifting && !motion.held) else {
            return;
        };
        let old = self.drawing;
        self.know(TURN, turn);
        let moments = [&old, &self.drawing].map(|d| d.moments(&d.values, posture));
        self.scale.redraw(moments);
    }
}
