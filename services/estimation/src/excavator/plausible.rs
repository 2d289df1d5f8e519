//! Checks whether data and description belong to one machine, in the expected units and signs.
//!
//! Torque over acceleration determines the size of a machine within its first swings, by least squares of
//! ```text
//! T = c1 J_e(q) w' + c2 w + c3 sgn w + S(q) g (c4 sin psi + c5 cos psi)        S: first moment of the links; c4, c5: 0 +- 4 degrees
//! ```
//! c1 is near 1 if both belong to one machine, a thousandth if the torque is in kN m, and negative if a sign is wrong. Angles that are
//! measured against the horizontal move with the link before them; joint angles do not.

use nalgebra::{SMatrix, SVector};

use super::estimate::Sample;
use super::geometry::Geometry;
use super::joints;
use super::measurements::boom_moment::GRAVITY;
use super::mismatch::Mismatch;
use crate::math::sin_cos;

/// Number of regressors.
const N: usize = 5;
/// Duration over which the velocity is differenced and joint motions are compared [s].
const SPAN: f64 = 0.1;
/// Least velocity of a swing, and velocity that no excavator exceeds [rad/s].
const SWINGS: f64 = 0.1;
const FASTEST: f64 = 4.0;
/// Velocity that no excavator reaches [revolutions per minute]; larger values are in degrees per second.
const FASTEST_RPM: f64 = 15.0;
/// Slope on which no excavator swings [rad]: 30 degrees, twice what manufacturers allow.
const STEEPEST: f64 = 0.52;
/// Least number of swinging spans for a result: 10 s.
const ENOUGH: f64 = 100.0;
/// Least share of the torque's mean square that the regression explains.
const EXPLAINED: f64 = 0.6;
/// A machine of plausible size must leave at least `RATHER_OTHER` times the residual of the fit more, and `LEFT` of the torque's square.
const RATHER_OTHER: f64 = 3.0;
const LEFT: f64 = 0.1;
/// Standard deviation of the ground's slope [rad], and of the model error as a share of the torque's rms; both are common to all spans.
/// In a swing sin psi resembles the acceleration: without a prior a slope of 30 degrees may replace the inertia.
const SLOPE: f64 = 0.07;
const MODEL: f64 = 0.1;
/// Range of c1 by other torques or payloads than stated, and by masses guessed from the operating mass.
const ALIKE: [f64; 2] = [0.5, 2.2];
/// Range of the factor of a torque in kN m or in MN m, relative to a thousandth or a millionth.
const UNIT: [f64; 2] = [0.3, 3.0];
/// Least angle by which a moving link turns in a span [rad]. The next link moves along if it turns equally, within the share `ALONG`.
const MOVES: f64 = 0.02;
const ALONG: f64 = 0.1;
/// Joints that an operator or a program moves together have any ratio of rates. If a ratio of 1 is chance, ratios off by up to this
/// share are as frequent as those within `ALONG`.
const BESIDE: f64 = 2.0 * ALONG;
/// A joint outside its range in more than one of this many swinging spans has another sign or zero.
const OFTEN_BEYOND: f64 = 4.0;
/// Least number of spans in which the next link moves along, and of motions that contain them: a single motion at equal rates is chance.
const FOLLOWS: u32 = 15;
const MOTIONS: u32 = 4;
/// The number of these spans must exceed `RATHER` times that of the spans in which the next link stays, or has a slightly different
/// rate. It must also be at least one in `OFTEN` of the spans in which the link before moves.
const RATHER: u32 = 4;
const OFTEN: u32 = 4;

/// Collects the rows of a recording.
#[derive(Debug, Clone)]
pub struct Plausible {
    geometry: Geometry,
    last: Option<(f64, f64, [f64; 3])>,
    torque: f64,
    rows: f64,
    turn: f64,
    spans: f64,
    fast: f64,
    /// Sum of the swinging speeds, in the unit of the data.
    speeds: f64,
    large: [f64; 2],
    steep: f64,
    exchanged: f64,
    /// Spans in which boom, arm, bucket are outside their range.
    beyond: [f64; 3],
    normal: SMatrix<f64, N, N>,
    product: SVector<f64, N>,
    square: f64,
    /// Motion of arm and bucket relative to the link before.
    pairs: [Pair; 2],
}

/// Counts of spans in which a link moves, by the motion of the next link.
#[derive(Debug, Clone, Copy, Default)]
struct Pair {
    moved: u32,
    along: u32,
    alone: u32,
    beside: u32,
    /// Motions in which the next link moves along, and whether this is one.
    motions: u32,
    follows: bool,
}

impl Pair {
    fn see(&mut self, link: f64, next: f64) {
        let within = |x: f64, share: f64| x.abs() < share * link.abs();
        let moves = link.abs() > MOVES;
        let follows = moves && within(next - link, ALONG);
        self.moved += u32::from(moves);
        self.along += u32::from(follows);
        self.beside += u32::from(moves && !follows && within(next - link, BESIDE));
        self.alone += u32::from(moves && within(next, ALONG));
        self.motions += u32::from(follows && !self.follows);
        self.follows = follows;
    }

    /// Whether the next link's angle is measured against the horizontal.
    fn is_absolute(&self) -> bool {
        self.along >= FOLLOWS
            && self.motions >= MOTIONS
            && self.along > RATHER * self.alone.max(self.beside)
            && OFTEN * self.along >= self.moved
    }
}

impl Plausible {
    /// For a described machine.
    #[must_use]
    pub fn new(geometry: Geometry) -> Self {
        Self {
            geometry,
            last: None,
            torque: 0.0,
            rows: 0.0,
            turn: 0.0,
            spans: 0.0,
            fast: 0.0,
            speeds: 0.0,
            large: [0.0; 2],
            steep: 0.0,
            exchanged: 0.0,
            beyond: [0.0; 3],
            normal: SMatrix::zeros(),
            product: SVector::zeros(),
            square: 0.0,
            pairs: [Pair::default(); 2],
        }
    }

    /// Takes a row; values that are not finite count as missing.
    pub fn push(&mut self, sample: &Sample) {
        let values = [sample.velocity, sample.torque]
            .into_iter()
            .chain(sample.posture)
            .collect_array();
        let Some([velocity, torque, boom, arm, bucket]) = values else {
            return;
        };
        let posture = [boom, arm, bucket].map(joints::joint);
        self.torque += torque;
        self.rows += 1.0;
        let Some((time, before, joints)) = self.last else {
            self.begin(sample.time, velocity, posture);
            return;
        };
        let span = sample.time - time;
        if span < SPAN {
            return;
        }
        if span < 2.0 * SPAN {
            self.follow(joints, posture);
            self.swing(span, [before, velocity], posture, sample.inclination);
        }
        self.begin(sample.time, velocity, posture);
    }

    fn begin(&mut self, time: f64, velocity: f64, posture: [f64; 3]) {
        self.last = time.is_finite().then_some((time, velocity, posture));
        (self.torque, self.rows) = (0.0, 0.0);
    }

    fn follow(&mut self, before: [f64; 3], now: [f64; 3]) {
        let moved: [f64; 3] = core::array::from_fn(|i| now[i] - before[i]);
        for (i, pair) in self.pairs.iter_mut().enumerate() {
            pair.see(moved[i], moved[i + 1]);
        }
    }

    fn swing(
        &mut self,
        span: f64,
        [before, now]: [f64; 2],
        posture: [f64; 3],
        inclination: [Option<f64>; 2],
    ) {
        let velocity = 0.5 * (before + now);
        self.turn = (self.turn + velocity * span) % core::f64::consts::TAU;
        if velocity.abs() < SWINGS || before * now <= 0.0 {
            return;
        }
        let torque = self.torque / self.rows;
        let (sin, cos) = sin_cos(self.turn);
        let inertia = self.geometry.inertia(posture);
        let weight = inertia.links_moment * GRAVITY;
        let x = SVector::from([
            inertia.empty * (now - before) / span,
            velocity,
            velocity.signum(),
            weight * sin,
            weight * cos,
        ]);
        self.spans += 1.0;
        self.fast += f64::from(u8::from(velocity.abs() > FASTEST));
        self.speeds += velocity.abs();
        let steep = |angle: Option<f64>| angle.is_some_and(|a| a.abs() > STEEPEST);
        self.steep += f64::from(u8::from(inclination.into_iter().any(steep)));
        self.large[0] += f64::from(u8::from(posture[0].abs() > FASTEST));
        self.large[1] += f64::from(u8::from(posture[1].abs() > FASTEST));
        self.exchanged += f64::from(u8::from(posture[0] < -0.3 && posture[1] > 0.0));
        for (beyond, possible) in self.beyond.iter_mut().zip(joints::possible(posture)) {
            *beyond += f64::from(u8::from(!possible));
        }
        self.normal += x * x.transpose();
        self.product += x * torque;
        self.square += torque * torque;
    }

    /// The mismatch, if any. Faults that would explain others come first.
    #[must_use]
    pub fn mismatch(&self) -> Option<Mismatch> {
        if self.spans < ENOUGH {
            return None;
        }
        let most = |count: f64| count > 0.5 * self.spans;
        if self.large.into_iter().any(most) {
            return Some(Mismatch::AngleDegrees);
        }
        if most(self.fast) {
            return Some(if self.speeds > FASTEST_RPM * self.spans {
                Mismatch::Degrees
            } else {
                Mismatch::Revolutions
            });
        }
        if most(self.steep) {
            return Some(Mismatch::SlopeDegrees);
        }
        if self.exchanged > 0.9 * self.spans {
            return Some(Mismatch::Exchanged);
        }
        let [_, arm, bucket] = self.beyond.map(|count| OFTEN_BEYOND * count > self.spans);
        if arm || bucket {
            return Some(Mismatch::Beyond { arm, bucket });
        }
        let [arm, bucket] = self.pairs.map(|pair| pair.is_absolute());
        if arm || bucket {
            return Some(Mismatch::Absolute { arm, bucket });
        }
        self.size()
    }

    fn size(&self) -> Option<Mismatch> {
        let mut normal = self.normal;
        for slope in 3..N {
            normal[(slope, slope)] += self.square * (MODEL / SLOPE) * (MODEL / SLOPE);
        }
        let normal = normal.cholesky()?;
        let found = normal.solve(&self.product);
        let explained = found.dot(&self.product) / self.square;
        let ratio = found[0];
        if !(explained > EXPLAINED && ratio.is_finite()) {
            return None;
        }
        // Share of the torque's square that c1 of the nearest plausible machine adds to the residual, the other coefficients fitted again.
        let off = ratio - ratio.clamp(ALIKE[0], ALIKE[1]);
        let left = off * off / normal.inverse()[(0, 0)] / self.square;
        if left < LEFT || left < RATHER_OTHER * (1.0 - explained) {
            return None;
        }
        let about = |unit: f64| (UNIT[0]..=UNIT[1]).contains(&(ratio / unit));
        Some(match ratio {
            _ if ratio < 0.0 => Mismatch::Sign,
            _ if about(1e-3) => Mismatch::Kilonewtons(ratio),
            _ if about(1e-6) => Mismatch::Meganewtons,
            _ => Mismatch::Size(ratio),
        })
    }
}

/// Collects exactly `N` values, if all are present and finite.
trait CollectArray {
    fn collect_array(self) -> Option<[f64; N]>;
}

impl<I: Iterator<Item = Option<f64>>> CollectArray for I {
    fn collect_array(mut self) -> Option<[f64; N]> {
        let mut array = [0.0; N];
        for value in &mut array {
            *value = self.next()?.filter(|v| v.is_finite())?;
        }
        Some(array)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math::tanh;

    /// Mismatch of a swinging machine whose rows are changed by `change`.
    fn found(change: impl Fn(&mut Sample)) -> Option<Mismatch> {
        let geometry = Geometry::default();
        let mut plausible = Plausible::new(geometry);
        let velocity = |t: f64| 0.8 * tanh(3.0 * sin_cos(1.1 * t).0);
        for k in 0..6000 {
            let t = 0.01 * f64::from(k);
            let boom = 0.5 + 0.3 * sin_cos(0.7 * t).0;
            let arm = -1.4 + 0.5 * tanh(4.0 * sin_cos(0.9 * t + 1.0).0);
            let posture = [boom, arm, -0.6 + 0.4 * tanh(6.0 * sin_cos(0.5 * t).0)];
            let w = velocity(t);
            let acceleration = (velocity(t + 0.005) - velocity(t - 0.005)) / 0.01;
            let inertia = geometry.inertia(posture).with_payload(150.0);
            let mut sample = Sample {
                time: t,
                velocity: Some(w),
                torque: Some(inertia * acceleration + 1500.0 * w + 250.0 * w.signum()),
                posture: posture.map(Some),
                ..Sample::default()
            };
            change(&mut sample);
            plausible.push(&sample);
        }
        plausible.mismatch()
    }

    fn times(value: &mut Option<f64>, factor: f64) {
        *value = value.map(|value| value * factor);
    }

    #[test]
    fn what_is_of_another_unit_sign_order_or_machine_is_named() {
        assert_eq!(found(|_| {}), None);
        assert_eq!(found(|s| times(&mut s.torque, 1.25)), None);
        let kilo = found(|s| times(&mut s.torque, 1e-3));
        assert!(
            matches!(kilo, Some(Mismatch::Kilonewtons(ratio)) if (0.5e-3..2e-3).contains(&ratio))
        );
        let mega = found(|s| times(&mut s.torque, 1e-6));
        assert_eq!(mega, Some(Mismatch::Meganewtons));
        assert_eq!(found(|s| times(&mut s.torque, -1.0)), Some(Mismatch::Sign));
        assert_eq!(
            found(|s| times(&mut s.velocity, 57.3)),
            Some(Mismatch::Degrees)
        );
        let revolutions = found(|s| times(&mut s.velocity, 9.55));
        assert_eq!(revolutions, Some(Mismatch::Revolutions));
        let slope = |s: &mut Sample, unit: f64| {
            let turned = unit * 0.07;
            s.inclination = [Some(turned), Some(-0.5 * turned)];
        };
        assert_eq!(found(|s| slope(s, 1.0)), None);
        assert_eq!(found(|s| slope(s, 57.3)), Some(Mismatch::SlopeDegrees));
        let degrees = |s: &mut Sample| s.posture.iter_mut().for_each(|q| times(q, 57.3));
        assert_eq!(found(degrees), Some(Mismatch::AngleDegrees));
        assert_eq!(found(|s| s.posture.swap(0, 1)), Some(Mismatch::Exchanged));
        let larger = found(|s| times(&mut s.torque, 14.0));
        assert!(matches!(larger, Some(Mismatch::Size(ratio)) if (12.0..22.0).contains(&ratio)));
    }

    #[test]
    fn a_small_ratio_is_written_as_a_fraction() {
        let words = |ratio| std::format!("{}", Mismatch::Size(ratio));
        assert!(words(4e-4).ends_with("moves 1/2500 of the described inertia"));
        assert!(words(14.0).ends_with("moves 14.00 times the described inertia"));
    }

    #[test]
    fn angles_against_the_horizontal_are_distinguished_from_those_of_joints() {
        let absolute = |s: &mut Sample| {
            let [Some(boom), Some(arm), Some(bucket)] = s.posture else {
                return;
            };
            s.posture = [boom, boom + arm, boom + arm + bucket].map(Some);
        };
        let both = Mismatch::Absolute {
            arm: true,
            bucket: true,
        };
        assert_eq!(found(absolute), Some(both));
    }

    #[test]
    fn one_motion_of_two_joints_at_the_same_rate_is_chance() {
        // After 5 s the arm always moves opposite to the boom.
        let together = |s: &mut Sample| {
            let turned = 0.5 * sin_cos(1.2 * s.time).0;
            let arm = if s.time < 5.0 { turned } else { -turned };
            s.posture = [0.5 + turned, -1.4 + arm, -0.6].map(Some);
        };
        assert_eq!(found(together), None);
    }

    #[test]
    fn joints_that_a_program_moves_together_are_no_absolute_angles() {
        // Arm and bucket curl at the same time, with another ratio in each motion.
        let together = |s: &mut Sample| {
            let motion = f64::from((s.time / 5.0) as u32);
            let turned = 0.4 * (1.0 - sin_cos(core::f64::consts::TAU * s.time / 5.0).1);
            let ratio = 0.8 + 0.031 * motion;
            s.posture = [0.5, -1.4 + turned, -1.0 + ratio * turned].map(Some);
        };
        assert_eq!(found(together), None);
    }

    /// Mismatch of a machine that swings to and fro in one smooth motion each, its torque times `factor`.
    fn found_in_cycles(factor: f64) -> Option<Mismatch> {
        let geometry = Geometry::default();
        let mut plausible = Plausible::new(geometry);
        let (period, angle) = (6.0, 2.0);
        for k in 0..9000 {
            let t = 0.01 * f64::from(k);
            let there = if (t / period) % 2.0 < 1.0 { 1.0 } else { -1.0 };
            let share = (t / period) % 1.0;
            let velocity = there * angle * 6.0 * share * (1.0 - share) / period;
            let acceleration = there * angle * 6.0 * (1.0 - 2.0 * share) / (period * period);
            let posture = [0.5 + 0.1 * share, -1.4, -0.6];
            let inertia =
                geometry
                    .inertia(posture)
                    .with_payload(if there > 0.0 { 250.0 } else { 0.0 });
            let torque = inertia * acceleration + 1700.0 * velocity + 350.0 * velocity.signum();
            plausible.push(&Sample {
                time: t,
                velocity: Some(velocity),
                torque: Some(factor * torque),
                posture: posture.map(Some),
                ..Sample::default()
            });
        }
        plausible.mismatch()
    }

    #[test]
    fn equal_swings_to_and_fro_distinguish_a_machine_from_a_slope() {
        assert_eq!(found_in_cycles(1.0), None);
        assert_eq!(found_in_cycles(1.3), None);
        assert_eq!(found_in_cycles(-1.0), Some(Mismatch::Sign));
        assert!(matches!(found_in_cycles(8.0), Some(Mismatch::Size(ratio)) if ratio > 4.0));
        assert!(matches!(found_in_cycles(0.1), Some(Mismatch::Size(ratio)) if ratio < 0.25));
    }
}
