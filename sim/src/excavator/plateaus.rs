//! Torque plateaus with which a swing reaches its speed and comes to rest in time.

use super::plant::{Motion, Plant, Point};
use super::torque::Swing;

/// Integration step [s].
const STEP: f64 = 1e-3;
/// Time before the end of the torque to which the end velocity refers [s].
const BEFORE_END: f64 = 0.06;
/// Most iterations of Newton's method; from the start values below it needs five or six.
const ITERATIONS: usize = 30;
/// Tolerance of the velocities [rad/s].
const TOLERANCE: f64 = 1e-13;

/// Times and speeds of a swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Targets {
    /// Begin of acceleration, begin of braking, end of the torque \[s\].
    pub times: (f64, f64, f64),
    /// Velocity when braking begins, negative for a swing clockwise [rad/s].
    pub peak: f64,
    /// Velocity 0.06 s before the torque is gone, of the sign of `peak` [rad/s].
    pub last: f64,
}

impl Targets {
    /// The swing of the working cycle: 0.90 rad/s, slowed down to 0.010 rad/s.
    pub fn working(start: f64, turn: f64, end: f64) -> Self {
        Self {
            times: (start, turn, end),
            peak: 0.90,
            last: 0.010,
        }
    }

    /// The swing back.
    pub fn back(start: f64, turn: f64, end: f64) -> Self {
        Self {
            times: (start, turn, end),
            peak: -0.80,
            last: -0.010,
        }
    }

    fn swing(&self, [accelerate, brake]: [f64; 2]) -> Swing {
        let (start, turn, end) = self.times;
        Swing {
            start,
            turn,
            end,
            accelerate,
            brake,
        }
    }
}

/// A plant for the solver: the inertia does not depend on the torque, so it is computed once.
pub struct Plateaus<'a> {
    plant: &'a Plant,
    targets: Targets,
    /// Inertia and rate every half step from the start of the swing.
    points: Vec<Point>,
}

impl<'a> Plateaus<'a> {
    /// Prepares the solver for a swing of `plant`, which is at rest at its begin.
    pub fn new(plant: &'a Plant, targets: Targets) -> Self {
        let (start, _, end) = targets.times;
        let halves = 2 * ((end - BEFORE_END - start) / STEP).round().max(1.0) as usize;
        let points = (0..=halves)
            .map(|i| plant.point(start + 0.5 * STEP * i as f64))
            .collect();
        Self {
            plant,
            targets,
            points,
        }
    }

    /// The swing whose plateaus Ta, Tb meet the targets, by Newton's method in two dimensions. Without convergence (a machine
    /// that cannot move at all) it is the last iterate.
    pub fn solve(&self) -> Swing {
        let sign = self.targets.peak.signum();
        let mut plateau = [4000.0 * sign, 2000.0 * sign];
        for _ in 0..ITERATIONS {
            let miss = self.miss(plateau);
            if miss.iter().all(|m| m.abs() < TOLERANCE) {
                break;
            }
            let correction = solve(self.jacobian(plateau, miss), miss);
            plateau = [plateau[0] - correction[0], plateau[1] - correction[1]];
        }
        self.targets.swing(plateau)
    }

    /// Angle of a swing up to 0.06 s before the end of its torque \[rad\].
    pub fn angle(&self, swing: Swing) -> f64 {
        self.run(swing).1.angle
    }

    /// Errors of peak and last velocity for a pair of plateaus.
    fn miss(&self, plateau: [f64; 2]) -> [f64; 2] {
        let (peak, last) = self.run(self.targets.swing(plateau));
        [peak - self.targets.peak, last.velocity - self.targets.last]
    }

    /// The velocity when braking begins, and the motion at the end.
    fn run(&self, swing: Swing) -> (f64, Motion) {
        let turn = ((swing.turn - swing.start) / STEP).round() as usize;
        let mut motion = Motion::default();
        let mut peak = 0.0;
        for (k, points) in self.points.windows(3).step_by(2).enumerate() {
            let at = |half: usize| Point {
                torque: swing.torque(swing.start + STEP * (k as f64 + 0.5 * half as f64)),
                ..points[half]
            };
            motion = self
                .plant
                .machine
                .advance(motion, STEP, &[at(0), at(1), at(2)]);
            if k + 1 == turn {
                peak = motion.velocity;
            }
        }
        (peak, motion)
    }

    /// Columns: derivatives by Ta and by Tb, as forward differences of 1e-3 N m.
    fn jacobian(&self, plateau: [f64; 2], miss: [f64; 2]) -> [[f64; 2]; 2] {
        let difference = 1e-3;
        [[difference, 0.0], [0.0, difference]].map(|d| {
            let moved = self.miss([plateau[0] + d[0], plateau[1] + d[1]]);
            [
                (moved[0] - miss[0]) / difference,
                (moved[1] - miss[1]) / difference,
            ]
        })
    }
}

/// Solves the 2 by 2 system with the given columns by Cramer's rule.
fn solve([p, q]: [[f64; 2]; 2], right: [f64; 2]) -> [f64; 2] {
    let determinant = p[0] * q[1] - q[0] * p[1];
    if determinant == 0.0 {
        return [0.0, 0.0];
    }
    [
        (right[0] * q[1] - q[0] * right[1]) / determinant,
        (p[0] * right[1] - right[0] * p[1]) / determinant,
    ]
}
