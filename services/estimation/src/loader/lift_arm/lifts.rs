//! Mean moments of the lift cylinders over blocks of a recording, for `calibrate`, which identifies span, offset and friction.
//!
//! ```text
//! F - F_f = tau/r,   tau = empty + m_p k        F: force by the pressures; F_f: friction; r: lever; k: moment of a kilogram
//! ```
//! In a block the machine stands and the arm moves, so friction acts fully against the rod's motion. Blocks in which the bucket turns, the
//! rod rests or the machine drives are left out.

use super::drawing::Drawing;
use super::geometry::{Posture, USUAL_ROD_PRESSURE, turns};
use super::linkage::Linkage;
use super::numbers::{
    BASE, CYLINDER_ANGLE, EYE, FRICTION, HEAD_AREA, HEAD_ZERO, LENGTH, LIFT_ZERO, LOAD_DISTANCE,
    OFFSET, PIVOT_X, PIVOT_Z, ROD_AREA, ROD_ZERO, SPAN, TILT_ZERO,
};
use super::seals::Seals;
use super::signals::Signals;
use super::turn::Turn;
use crate::GRAVITY;
use crate::loader::sample::Sample;
use crate::loader::settings::Settings;
use crate::math::{norm, sin_cos};
use crate::{FULL_PRESSURE, Quantity};

/// Duration of a block, and the longest gap between rows \[s\].
const BLOCK: f64 = 0.2;
const GAP: f64 = 0.25;
/// Speed below which the machine stands [m/s].
const STANDS: f64 = 0.1;
/// Least lever of a cylinder that measures a moment [m].
const LEAST_LEVER: f64 = 1e-3;
/// Rates beyond which the bucket turns, and the arm moves [rad/s].
const TURNS: f64 = 0.05;
const MOVES: f64 = 0.01;
/// Share of the friction from which it acts fully against the motion.
const FULLY: f64 = 0.99;
/// Standard deviations of friction fully against the motion, and of a drawing's moments, as shares of each.
const FRICTION_LEFT: f64 = 0.15;
const DRAWN: f64 = 0.003;
/// Standard deviation of a load's place across the line from the pin, as a share of that along it.
const BESIDE: f64 = 0.5;

/// Mean moments of a block. Forces are those of all cylinders together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftMoment {
    /// Lever of the cylinders \[m\].
    pub lever: f64,
    /// Moment by the pressures, less the described friction [N m].
    pub measured: f64,
    /// Moment of the empty arm and bucket as described [N m].
    pub empty: f64,
    /// Moment of a kilogram of load [N m/kg].
    pub per_load: f64,
    /// Derivatives of both moments by the slope, nose up [N m/rad], [N m/(rad kg)].
    pub tilt: [f64; 2],
    /// Cosine and sine of the angles of arm and bucket to the horizontal.
    pub turns: [f64; 4],
    /// Direction of the rod, 1 where it extends, else -1.
    pub direction: f64,
    /// Variance of errors that last for seconds: friction and drawing [N^2].
    pub rest: f64,
    /// Variance of the noise of the pressures [N^2].
    pub noise: f64,
    /// Duration of the block \[s\].
    pub period: f64,
}

/// Prior of the lift cylinders before a recording. Forces are those of all cylinders together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftKnown {
    /// Friction of the seals \[N\].
    pub friction: Quantity,
    /// Relative standard deviation of the moment.
    pub span_std: f64,
    /// Standard deviation of the zero error of the force \[N\].
    pub offset_std: f64,
    /// Correlation of span and offset.
    pub correlation: f64,
    /// Force of all cylinders at the pressure at which friction is stated \[N\].
    pub full_force: f64,
}

/// An arm at rest, by its angle and that of the bucket to the horizontal \[rad\], at half of the full pressure.
fn still([arm, bucket]: [f64; 2]) -> Posture {
    Posture {
        arm: Turn::of(arm),
        bucket: Turn::of(bucket),
        head: 0.5 * FULL_PRESSURE,
        rod: 0.0,
        gravity: GRAVITY,
        acceleration: 0.0,
        seals: 0.0,
        rest: 0.0,
    }
}

/// Computes the mean moments of a recording's blocks.
#[derive(Clone, Debug)]
pub struct Lifts {
    drawing: Drawing,
    seals: Seals,
    last: Option<Row>,
    block: Block,
    linkage: Linkage,
    signals: Signals,
    /// Greatest age of a value that counts [s].
    fresh: f64,
}

/// Arm and bucket in a row.
#[derive(Clone, Copy, Debug)]
struct Row {
    time: f64,
    lift: f64,
    bucket: f64,
}

/// Sums over a block, and its first row.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: Option<Row>,
    sums: [f64; 10],
    rows: f64,
    /// Direction of the rod, 0 where it is not the same in all rows.
    direction: f64,
}

impl Block {
    const NONE: Self = Self {
        first: None,
        sums: [0.0; 10],
        rows: 0.0,
        direction: 0.0,
    };
}

impl Lifts {
    /// Returns none where no lift arm is described.
    #[must_use]
    pub fn new(settings: &Settings) -> Option<Self> {
        let drawing = Drawing::of(settings)?;
        Some(Self {
            drawing,
            seals: Seals::default(),
            last: None,
            block: Block::NONE,
            linkage: Linkage::NEW,
            signals: Signals::NONE,
            fresh: settings.estimator.fresh,
        })
    }

    /// Prior by the machine file.
    #[must_use]
    pub fn known(&self) -> LiftKnown {
        let d = &self.drawing;
        let full_force = d.full_force(&d.values);
        let posture = still([0.0; 2]);
        let here = d.lifting(&d.values, &posture);
        let mut off = self.drawing;
        let effects = [HEAD_AREA, BASE, EYE, CYLINDER_ANGLE].map(|number| {
            off.put_off(number);
            off.lifting(&off.moved, &posture) / here - 1.0
        });
        let per_pascal = full_force / (d.values[HEAD_AREA] * FULL_PRESSURE);
        let zeros = [(HEAD_ZERO, HEAD_AREA), (ROD_ZERO, ROD_AREA)]
            .map(|(zero, area)| d.std[zero] * d.values[area] * per_pascal);
        let or = |stated: f64, usual: f64| if stated > 0.0 { stated } else { usual };
        LiftKnown {
            friction: Quantity {
                value: full_force * d.values[FRICTION],
                std: full_force * d.std[FRICTION],
            },
            span_std: or(d.std[SPAN], norm(&effects)),
            offset_std: or(d.std[OFFSET], norm(&zeros)),
            correlation: d.correlation,
            full_force,
        }
    }

    /// Place of a load by the machine file: ahead of the front axle, and above the ground \[m\]; angles of the arm to the horizontal, and of
    /// the bucket to the arm \[rad\].
    #[must_use]
    pub fn load_place(&self, lift: f64, tilt: f64) -> [Quantity; 2] {
        let (posture, mut off) = (still([lift, lift + tilt]), self.drawing);
        let here = off.load_place(&off.values, &posture);
        let along = [
            LENGTH,
            PIVOT_X,
            PIVOT_Z,
            LIFT_ZERO,
            TILT_ZERO,
            LOAD_DISTANCE,
        ]
        .map(|number| {
            off.put_off(number);
            let there = off.load_place(&off.moved, &posture);
            [there[0] - here[0], there[1] - here[1]]
        });
        let [.., [x, z]] = along;
        let across = [-z, x].map(|by| BESIDE * by);
        core::array::from_fn(|axis| Quantity {
            value: here[axis],
            std: norm(&[norm(&along.map(|by| by[axis])), across[axis]]),
        })
    }

    /// Estimate of the bucket turn by the rows so far; none where it is stated.
    #[must_use]
    pub fn bucket_turn(&self) -> Option<Quantity> {
        self.drawing.learns_turn.then(|| self.linkage.untouched())
    }

    /// Updates with a row. Returns the mean moments of a block that ended with it.
    pub fn step(&mut self, sample: &Sample) -> Option<LiftMoment> {
        let now = self.signals.take(sample, self.fresh);
        let (lift, head) = (now.lift?, sample.lift_head_pressure?);
        if now.tilt.is_none() && self.signals.measure_tilt() {
            return None;
        }
        let row = Row {
            time: sample.time,
            lift,
            bucket: self.drawing.bucket_angle(lift, now.tilt),
        };
        if ![row.time, lift, row.bucket, head]
            .iter()
            .all(|x| x.is_finite())
        {
            return None;
        }
        let before = self.last.replace(row);
        let dt = before.map_or(0.0, |before| row.time - before.time);
        if !(dt > 0.0 && dt < GAP) {
            self.seals.forget();
            self.block = Block::NONE;
            return None;
        }
        self.seals.take(self.drawing.rod_length(Turn::of(lift)), dt);
        let share = self.seals.share();
        let stands = sample.speed.is_none_or(|v| v.abs() < STANDS);
        let moves = stands && share.abs() >= FULLY;
        self.linkage
            .see([lift, row.bucket], moves && now.tilt.is_some());
        if !moves {
            self.block = Block::NONE;
            return None;
        }
        let rod = now.rod.unwrap_or(USUAL_ROD_PRESSURE);
        self.add(&row, [head, rod], sample, share.signum());
        self.end(&row)
    }

    fn posture(&self, row: &Row, [head, rod]: [f64; 2], sample: &Sample) -> Posture {
        let slope = sample.slope.filter(|s| s.is_finite()).unwrap_or(0.0);
        let specific = sample.acceleration.filter(|a| a.is_finite());
        Posture {
            arm: Turn::of(row.lift),
            bucket: Turn::of(row.bucket),
            head,
            rod,
            gravity: self.drawing.gravity(slope),
            acceleration: specific.unwrap_or(GRAVITY * sin_cos(slope).0),
            seals: 0.0,
            rest: 0.0,
        }
    }

    fn add(&mut self, row: &Row, pressures: [f64; 2], sample: &Sample, direction: f64) {
        let (d, v) = (&self.drawing, &self.drawing.values);
        let posture = self.posture(row, pressures, sample);
        let (empty, per_load) = d.moments(v, &posture);
        // The derivative by the slope is the difference by a specific force of 1 g along the body.
        let pushed = Posture {
            acceleration: posture.acceleration + GRAVITY,
            ..posture
        };
        let along = d.moments(v, &pushed);
        let friction = direction * v[FRICTION] * d.full_force(v) * d.lever(posture.arm);
        let measured = d.lifting(v, &posture) - friction;
        let [arm_cosine, arm_sine, bucket_cosine, bucket_sine] = turns(&posture);
        let parts = [
            d.lever(posture.arm),
            measured,
            empty,
            per_load,
            along.0 - empty,
            along.1 - per_load,
            arm_cosine,
            arm_sine,
            bucket_cosine,
            bucket_sine,
        ];
        let block = &mut self.block;
        if block.first.is_none() {
            *block = Block {
                first: Some(*row),
                direction,
                ..Block::NONE
            };
        } else if block.direction != direction {
            block.direction = 0.0;
        }
        block
            .sums
            .iter_mut()
            .zip(parts)
            .for_each(|(sum, part)| *sum += part);
        block.rows += 1.0;
    }

    fn end(&mut self, row: &Row) -> Option<LiftMoment> {
        let first = self.block.first?;
        let period = row.time - first.time;
        if period < BLOCK {
            return None;
        }
        let block = core::mem::replace(&mut self.block, Block::NONE);
        let [lift, bucket] = [row.lift - first.lift, row.bucket - first.bucket];
        // A linkage turns the bucket by 0 to 1 times the arm's turn.
        let by_linkage = bucket.clamp(lift.min(0.0), lift.max(0.0));
        let turning = (bucket - by_linkage).abs() > TURNS * period;
        if turning || lift.abs() < MOVES * period || block.direction == 0.0 {
            return None;
        }
        let [
            lever,
            measured,
            empty,
            per_load,
            tilt,
            tilt_load,
            turned @ ..,
        ] = block.sums.map(|sum| sum / block.rows);
        let known = self.known();
        let left = [
            FRICTION_LEFT * known.friction.value,
            DRAWN * measured / lever,
        ];
        let noise = self.drawing.force_std();
        (lever.abs() > LEAST_LEVER).then_some(LiftMoment {
            lever,
            measured,
            empty,
            per_load,
            tilt: [tilt, tilt_load],
            turns: turned,
            direction: block.direction,
            rest: left[0] * left[0] + left[1] * left[1],
            noise: noise * noise / block.rows,
            period,
        })
    }
}
