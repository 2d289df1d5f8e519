//! The moment about the boom foot that the boom's cylinders carry.
//!
//! ```text
//! tau = sum_i m_i [x_i (g + z_i'') - z_i (x_i'' + g pitch - w^2 (x_0 + x_i))]
//!       + sum_j [I_j alpha_j'' + w^2 (I_j - I_axial,j) sin(alpha_j) cos(alpha_j)]
//!       + sum_j [A_j cos(alpha_j) + B_j sin(alpha_j)]          what the drawing misses, learnt by `calibrate`
//!                                                      i = boom, arm, bucket, payload;  j = boom, arm, bucket
//! r F = (1 + s) tau + r (z + f + F_c d)            F = n (A_h p_h - A_r p_r)
//! after a stop (kept F_c + h) d in place of F_c d
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x_i, z_i | centre of mass from the boom foot, forward and up | m |
//! | alpha_i | angle of the link to the horizontal | rad |
//! | r | lever of the cylinders ([`super::super::cylinder`]) | m |
//! | s, z | span and zero of the moment: areas, lengths, zeros of the pressures; slow states | -, N |
//! | f | rest of the friction, of the drawing and of the load's centre; a state of some seconds | N |
//! | F_c, d | friction of the seals, and its direction: Dahl's model over the travel of the cylinder | N, - |
//! | kept, h | described share of it that a stop leaves, and what it leaves beyond that: a slow state | -, N |
//!
//! Second derivatives need smooth angles: everything is averaged over blocks of 0.2 s, and three blocks make one measurement of the
//! middle one. The mean of three blocks in the proportion 1 : 4 : 1 is smoothed as their second difference is (a quadratic
//! spline).

use super::super::cylinder::Cylinder;
use super::super::geometry::{Geometry, Turns};
use crate::math::{exp, sin_cos, sqrt};

pub use crate::GRAVITY;
/// Length of a block \[s\], and the least part of it in which the pressures must be there.
const BLOCK: f64 = 0.2;
const PRESENT: f64 = 0.3;
/// Pressures stand for the time since the ones before, at most this long [s]. So 20 a second weigh; ten a second, read beside angles
/// that move, make more of the loads doubtful than none do.
const STANDS: f64 = 0.018;
/// A lever shorter than this is in line with the pin: force and load tell nothing of each other \[m\].
const LEAST_LEVER: f64 = 1e-3;
/// Travel within which the seals' friction follows the motion (Dahl) \[m\].
const TRAVEL: f64 = 0.5e-3;
/// Less travel than this in a block, or than so many deviations of the noise of two blocks' angles, is standing \[m\].
const STILL: f64 = 1e-3;
const NOISE: f64 = 3.0;
/// The same of the angle of a link to the horizontal [rad], and the angles that it is the sum of.
const TURNED: f64 = 1e-3;
const ANGLES: f64 = 3.0;
/// While joints move, what the drawing misses is another one after this time \[s\]. The seals' friction at rest does not fade: it stays what the stop left.
pub const FADING: f64 = 3.0;
/// Error of the mean acceleration of a link [rad/s^2], and the share of the dynamic part that three blocks miss.
const ACCELERATION: f64 = 0.02;
const MISSED: f64 = 0.15;

/// Share of the seals' friction that is another one at each time, while the cylinder moves and while it stands.
const UNMODELLED: [f64; 2] = [0.15, 0.49];
/// Share of the moment that the drawing misses at each posture: centres of mass beside the lines of the pins.
const DRAWN: f64 = 0.01;

/// Boom, arm, bucket, payload.
const BODIES: usize = 4;

/// Sums, then means, over a block.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Block {
    time: f64,
    alpha: [f64; 3],
    /// Sine and cosine of alpha.
    sin: [f64; 3],
    cos: [f64; 3],
    moment: f64,
    lever: f64,
    length: f64,
    spin: f64,
    turn: [f64; 2],
    constant: bool,
    touches: bool,
    /// Length of the block \[s\]: 0.2 where rows divide it.
    whole: f64,
    /// Ticks, and variance of the mean angle by the noise of the sensors [rad^2].
    ticks: f64,
    noise: f64,
}

/// The moment of a block with what it depends on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moment {
    /// Lever times force [N m].
    pub measured: f64,
    /// Of the described empty machine on level ground [N m].
    pub empty: f64,
    /// The same without accelerations of the joints: with those of the swing [N m].
    pub still: f64,
    /// Per kilogram of payload, without accelerations [N m/kg].
    pub still_payload: f64,
    /// Part of boom and arm in it [N m].
    pub links: f64,
    /// Per kilogram of payload [N m/kg].
    pub per_payload: f64,
    /// Per kilogram of bucket [N m/kg].
    pub per_bucket: f64,
    /// Change of the empty machine's moment with the pitch [N m/rad].
    pub tilt: f64,
    /// The same per kilogram of payload [N m/(kg rad)].
    pub tilt_payload: f64,
    /// Cosine and sine of the angles of boom, arm and bucket to the horizontal.
    pub directions: [[f64; 2]; 3],
    /// Lever \[m\].
    pub lever: f64,
    /// Direction in which the cylinder moves or moved last, as far as its seals have followed: 1 where it extends.
    pub side: f64,
    /// The same of their friction: a stop leaves the described share of it.
    pub direction: f64,
    /// The cylinder moves.
    pub moves: bool,
    /// How the direction of the moving seals' friction differs from that at the measurement before; 0 is that of a cylinder that stands.
    pub turned: f64,
    /// The ground may carry part of it.
    pub touches: bool,
    /// Sine and cosine of the swing angle.
    pub turn: [f64; 2],
    /// Variance of what the accelerations miss [(N m)^2].
    pub variance: f64,
    /// Time since the measurement before \[s\].
    pub period: f64,
    /// No joint has moved for so long \[s\].
    pub stood: f64,
}

impl Moment {
    /// Variance of f that friction of this size \[N\] and the drawing leave [N^2]: it lasts for [`FADING`].
    #[must_use]
    pub fn rest(&self, friction: f64) -> f64 {
        let unmodelled = UNMODELLED[usize::from(!self.moves)] * friction;
        let drawn = DRAWN * self.measured / self.lever;
        unmodelled * unmodelled + drawn * drawn
    }

    /// What f keeps of what it was: all of it in a posture that stays, once the stop has left its friction. If it faded there, one error
    /// would tell the other states something each time.
    #[must_use]
    pub fn kept(&self) -> f64 {
        if self.stood > FADING {
            1.0
        } else {
            exp(-self.period / FADING)
        }
    }
}

/// What boom, arm and bucket do at a tick.
#[derive(Debug, Clone, Copy)]
pub(in crate::excavator) struct Front {
    /// Time since the tick before \[s\].
    pub(in crate::excavator) period: f64,
    /// Joint angles \[rad\].
    pub(in crate::excavator) posture: [f64; 3],
    pub(in crate::excavator) turns: Turns,
    /// Variance of a joint angle by the noise of its sensor [rad^2].
    pub(in crate::excavator) posture_variance: f64,
    /// Head and rod side of the boom's cylinders \[Pa\].
    pub(in crate::excavator) pressures: Option<[f64; 2]>,
    /// Swing velocity [rad/s], sine and cosine of the swing angle.
    pub(in crate::excavator) velocity: f64,
    pub(in crate::excavator) turn: (f64, f64),
}

/// Collects blocks.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::excavator) struct BoomMoment {
    block: Block,
    elapsed: f64,
    /// Time since the last pressures \[s\].
    unread: f64,
    last: [Option<Block>; 2],
    direction: f64,
    /// Direction of the moving seals' friction at the last measurement.
    rubbed: f64,
    since: f64,
    /// The posture that no joint has left for so long [rad, s].
    posture: [f64; 3],
    stood: f64,
}

impl BoomMoment {
    pub(in crate::excavator) fn new() -> Self {
        Self {
            block: Block::default(),
            elapsed: 0.0,
            unread: 0.0,
            last: [None; 2],
            direction: 0.0,
            rubbed: 0.0,
            since: 0.0,
            posture: [0.0; 3],
            stood: 0.0,
        }
    }

    /// Time since the last pressures \[s\].
    pub(in crate::excavator) fn unread(&self) -> f64 {
        self.unread
    }

    /// One tick; whether the bucket's content is constant, and whether it may touch the ground. The moment of the block before the
    /// last, where three are there.
    pub(in crate::excavator) fn step(
        &mut self,
        geometry: &Geometry,
        cylinder: &Cylinder,
        front: &Front,
        (constant, touches): (bool, bool),
    ) -> Option<Moment> {
        let dt = front.period;
        self.block.constant = constant && (self.elapsed == 0.0 || self.block.constant);
        self.block.touches |= touches;
        self.elapsed += dt;
        self.unread += dt;
        if let Some(pressures) = front.pressures {
            let force = cylinder.force(pressures);
            let stands = core::mem::take(&mut self.unread).min(STANDS);
            self.block.add(cylinder, front, (force, stands));
        }
        if self.elapsed < BLOCK - 0.5 * dt {
            return None;
        }
        let whole = core::mem::take(&mut self.elapsed);
        let block = Block {
            whole,
            ..core::mem::take(&mut self.block)
        };
        self.since += whole;
        if block.time < PRESENT * whole || whole > 1.5 * BLOCK {
            self.last = [None; 2];
            return None;
        }
        self.next(geometry, cylinder, block.mean())
    }

    fn next(&mut self, geometry: &Geometry, cylinder: &Cylinder, newest: Block) -> Option<Moment> {
        let [oldest, middle] = self.last;
        self.last = [middle, Some(newest)];
        let middle = middle?;
        let travel = newest.length - middle.length;
        let sign = travel.signum();
        let noise = middle.lever.abs() * sqrt(newest.noise + middle.noise);
        let still = STILL.max(NOISE * noise);
        let follows = 1.0 - exp(-(travel.abs() - 0.5 * still).max(0.0) / TRAVEL);
        // Of the middle block: half of the way there.
        let before = self.direction;
        self.direction += follows * (sign - self.direction);
        let moves = travel.abs() > still;
        self.stood += newest.whole;
        if newest.has_left(self.posture) {
            (self.posture, self.stood) = (newest.alpha, 0.0);
        }
        let kept = if moves { 1.0 } else { cylinder.kept };
        let side = 0.5 * (before + self.direction);
        let oldest = oldest?;
        if !(oldest.constant && middle.constant && newest.constant) {
            return None;
        }
        let blocks = [&oldest, &middle, &newest];
        let mut moment = moment(geometry, cylinder, blocks, (side, kept), moves, self.stood);
        moment.touches = blocks.iter().any(|block| block.touches);
        moment.period = core::mem::take(&mut self.since);
        let rubs = if moves { side } else { 0.0 };
        moment.turned = rubs - core::mem::replace(&mut self.rubbed, rubs);
        // A cylinder in line with the pin carries nothing, whatever it presses.
        (moment.lever.abs() > LEAST_LEVER).then_some(moment)
    }
}

impl Block {
    /// A force, and the posture with it, for the time `dt`.
    fn add(&mut self, cylinder: &Cylinder, front: &Front, (force, dt): (f64, f64)) {
        let [boom, arm, bucket] = front.posture;
        let alpha = [boom, boom + arm, boom + arm + bucket];
        for (i, (sin, cos)) in front.turns.into_iter().enumerate() {
            self.alpha[i] += dt * alpha[i];
            self.sin[i] += dt * sin;
            self.cos[i] += dt * cos;
        }
        let (length, lever) = cylinder.lever_turned(front.turns[0]);
        self.ticks += 1.0;
        self.noise += front.posture_variance;
        self.time += dt;
        self.moment += dt * lever * force;
        self.lever += dt * lever;
        self.length += dt * length;
        self.spin += dt * front.velocity * front.velocity;
        self.turn[0] += dt * front.turn.0;
        self.turn[1] += dt * front.turn.1;
    }

    /// A link has another direction than in a posture.
    fn has_left(&self, posture: [f64; 3]) -> bool {
        let noise = NOISE * sqrt(2.0 * ANGLES * self.noise);
        let links = self.alpha.into_iter().zip(posture);
        links
            .into_iter()
            .any(|(now, then)| (now - then).abs() > TURNED.max(noise))
    }

    /// Mean places of the centres of mass: linear in the sines and cosines.
    fn bodies(&self, g: &Geometry) -> [(f64, f64); BODIES] {
        let ([l1, l2], [c1, c2, c3]) = (g.lengths, g.centres);
        let along = |(x, z): (f64, f64), i: usize, length: f64, rise: f64| {
            let (sin, cos) = (self.sin[i], self.cos[i]);
            (x + length * cos - rise * sin, z + length * sin + rise * cos)
        };
        let [boom, bucket, payload] = g.rises;
        let arm_pin = along((0.0, 0.0), 0, l1, 0.0);
        let bucket_pin = along(arm_pin, 1, l2, 0.0);
        [
            along((0.0, 0.0), 0, c1, boom),
            along(arm_pin, 1, c2, 0.0),
            along(bucket_pin, 2, c3, bucket),
            along(bucket_pin, 2, g.payload_centre, payload),
        ]
    }

    fn mean(mut self) -> Self {
        let share = 1.0 / self.time;
        let all = self.alpha.iter_mut().chain(&mut self.sin);
        let all = all.chain(&mut self.cos).chain(&mut self.turn);
        all.for_each(|sum| *sum *= share);
        for sum in [
            &mut self.moment,
            &mut self.lever,
            &mut self.length,
            &mut self.spin,
        ] {
            *sum *= share;
        }
        self.noise /= self.ticks * self.ticks;
        self
    }
}

/// The moment of the middle one of three blocks.
fn moment(
    g: &Geometry,
    cylinder: &Cylinder,
    blocks: [&Block; 3],
    (side, kept): (f64, f64),
    moves: bool,
    stood: f64,
) -> Moment {
    let smooth = |[a, b, c]: [f64; 3]| (a + 4.0 * b + c) / 6.0;
    let square = blocks[1].whole * blocks[2].whole;
    // In a posture that all blocks have in common second differences are noise, the same in what is expected and in what each state
    // does to it: in an hour that drives the states away.
    let accelerates = if stood < 1.5 * BLOCK { 1.0 } else { 0.0 };
    let bent = |[a, b, c]: [f64; 3]| accelerates * (a - 2.0 * b + c) / square;
    let spin = smooth(blocks.map(|b| b.spin));
    let bodies = blocks.map(|b| b.bodies(g));
    let places: [_; BODIES] =
        core::array::from_fn(|i| (bodies.map(|of| of[i].0), bodies.map(|of| of[i].1)));
    let mut per_mass = [0.0; BODIES];
    let mut tilt = [0.0; BODIES];
    let mut dynamic = [0.0; BODIES];
    for i in 0..BODIES {
        let (x, z) = (smooth(places[i].0), smooth(places[i].1));
        let (ax, az) = (bent(places[i].0), bent(places[i].1));
        dynamic[i] = x * az - z * ax;
        per_mass[i] = x * GRAVITY + dynamic[i] + z * spin * (g.boom_pin + x);
        tilt[i] = -z * GRAVITY;
    }
    let (mut links, mut empty, mut moving, mut swinging) = (0.0, 0.0, 0.0, 0.0);
    let mut directions = [[0.0; 2]; 3];
    for i in 0..3 {
        let (sin, cos) = sin_cos(smooth(blocks.map(|b| b.alpha[i])));
        directions[i] = [cos, sin];
        empty += cylinder.missed[i][0] * cos + cylinder.missed[i][1] * sin;
        let turning = g.inertias[i] * bent(blocks.map(|b| b.alpha[i]));
        let spread = spin * (g.inertias[i] - g.axial_inertias[i]) * sin * cos;
        let own = g.masses[i] * per_mass[i] + turning + spread;
        empty += own;
        links += if i < 2 { own } else { 0.0 };
        moving += g.masses[i] * dynamic[i] + turning;
        let (x, z) = (smooth(places[i].0), smooth(places[i].1));
        swinging += g.masses[i] * (x * x + z * z) + g.inertias[i];
    }
    let missed = MISSED * moving;
    let bends = accelerates * (blocks[0].noise + 4.0 * blocks[1].noise + blocks[2].noise);
    let noise = swinging * sqrt(ACCELERATION * ACCELERATION + bends / (square * square));
    let empties = (0..3).map(|i| g.masses[i] * tilt[i]).sum();
    Moment {
        measured: smooth(blocks.map(|b| b.moment)),
        empty,
        still: empty - moving,
        still_payload: per_mass[3] - dynamic[3],
        links,
        per_payload: per_mass[3],
        per_bucket: per_mass[2],
        tilt: empties,
        tilt_payload: tilt[3],
        directions,
        lever: smooth(blocks.map(|b| b.lever)),
        side,
        direction: kept * side,
        moves,
        turned: 0.0,
        touches: false,
        turn: [
            smooth(blocks.map(|b| b.turn[0])),
            smooth(blocks.map(|b| b.turn[1])),
        ],
        variance: missed * missed + noise * noise,
        period: 0.0,
        stood,
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::excavator::geometry::turns;
    use crate::excavator::keys::Description;
    use std::vec::Vec;

    /// The moments of a boom that stands at this angle for a while at 100 Hz, its angles noisy [rad].
    fn stands(moments: &mut BoomMoment, boom: f64, seconds: u32, noise: f64) -> Vec<Moment> {
        let mut d = Description::default();
        let c = &mut d.boom_cylinder;
        (c.count, c.head_area, c.rod_area) = (1.0, 0.01, 0.007);
        (c.base_distance, c.rod_distance, c.angle) = (0.6, 1.3, 1.3);
        let cylinder = Cylinder::of_boom(&d).expect("a cylinder");
        let geometry = Geometry::of(&d);
        let rows = (0..100 * seconds).map(|k| {
            let posture = [boom + noise * sin_cos(7.3 * f64::from(k)).0, -1.5, -0.5];
            Front {
                period: 0.01,
                posture,
                turns: turns(posture),
                posture_variance: 0.5 * noise * noise,
                pressures: Some([8e6, 1e6]),
                velocity: 0.0,
                turn: (0.0, 1.0),
            }
        });
        rows.filter_map(|front| moments.step(&geometry, &cylinder, &front, (true, false)))
            .collect()
    }

    #[test]
    fn who_stands_is_not_accelerated_by_the_noise_of_the_angles() {
        let found = stands(&mut BoomMoment::new(), 0.5, 20, 1e-3);
        let [first, .., last] = found.as_slice() else {
            panic!("moments");
        };
        assert!(first.empty != first.still, "it may have come from a motion");
        assert!((last.empty, last.stood > 10.0) == (last.still, true));
    }

    #[test]
    fn what_the_drawing_misses_stays_in_a_posture_and_is_another_one_after_a_motion() {
        let mut moments = BoomMoment::new();
        let found = stands(&mut moments, 0.5, 1200, 1e-3);
        let kept = |of: &[Moment]| of.iter().map(Moment::kept).product::<f64>();
        assert!(kept(&found) > 0.3, "once: {}", kept(&found));
        let raised = stands(&mut moments, 0.52, 3, 1e-3);
        assert!(kept(&raised) < 0.5, "{}", kept(&raised));
        // A boom that creeps by a millimetre in a minute is soon in another posture too.
        let creeps: Vec<Moment> = (1..=60)
            .flat_map(|k| stands(&mut moments, 0.52 + 5e-4 * f64::from(k), 1, 1e-3))
            .collect();
        assert!(kept(&creeps) < 0.01, "{}", kept(&creeps));
    }
}
