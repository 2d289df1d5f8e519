//! Joint paths of boom, arm and bucket in the working cycle.

use crate::blend::{transition, transition_rate};

/// Angles of boom (to the horizontal, up positive), arm (relative to the boom) and bucket (relative to
/// the arm) \[rad\], or their rates [rad/s].
pub type Posture = [f64; 3];

/// A smooth move of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Beginning \[s\].
    pub from: f64,
    /// End \[s\].
    pub to: f64,
    /// Change of the angle \[deg\].
    pub degrees: f64,
}

/// The path of one joint: a start angle and moves that are added to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Angle before the first move \[deg\].
    pub start_degrees: f64,
    /// Its moves, in any order.
    pub moves: Vec<Move>,
}

impl Joint {
    /// A joint that starts at an angle \[deg\] and makes moves `(from [s], to [s], change [deg])`.
    pub fn new(start_degrees: f64, moves: &[(f64, f64, f64)]) -> Self {
        let moves = moves
            .iter()
            .map(|&(from, to, degrees)| Move { from, to, degrees })
            .collect();
        Self {
            start_degrees,
            moves,
        }
    }

    /// Angle \[rad\].
    pub fn angle(&self, time: f64) -> f64 {
        let moved = self
            .moves
            .iter()
            .map(|m| m.degrees * transition(time, m.from, m.to));
        (self.start_degrees + moved.sum::<f64>()).to_radians()
    }

    /// Rate of the angle [rad/s].
    pub fn rate(&self, time: f64) -> f64 {
        let rates = self
            .moves
            .iter()
            .map(|m| m.degrees * transition_rate(time, m.from, m.to));
        rates.sum::<f64>().to_radians()
    }
}

/// The paths of boom, arm and bucket.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Boom, arm, bucket.
    pub joints: [Joint; 3],
}

impl Path {
    /// Loading, transporting and unloading, 0 to 13 s: the paper's cycle (Figs. 7, 8).
    pub fn base() -> Self {
        let arm = [(0.8, 3.2, -30.0), (3.2, 5.4, -6.0), (5.8, 10.0, 52.0)];
        let bucket = [(1.4, 3.4, -50.0), (5.8, 9.2, -25.0), (9.3, 10.6, 75.0)];
        Self {
            joints: [boom(), Joint::new(-110.0, &arm), Joint::new(-35.0, &bucket)],
        }
    }

    /// The same cycle with the arm extended late, so that the inertia changes little during the swing.
    pub fn gentle() -> Self {
        let arm = [(0.8, 3.2, -30.0), (3.2, 5.4, -6.0), (8.4, 10.8, 52.0)];
        let bucket = [(1.4, 3.4, -50.0), (8.4, 9.6, -25.0), (9.8, 11.0, 75.0)];
        Self {
            joints: [boom(), Joint::new(-110.0, &arm), Joint::new(-35.0, &bucket)],
        }
    }

    /// All joints at rest at the angles of the base path at 5.5 s.
    pub fn constant() -> Self {
        Self {
            joints: [55.0, -146.0, -85.0].map(|degrees| Joint::new(degrees, &[])),
        }
    }

    /// The posture at a time \[rad\].
    pub fn posture(&self, time: f64) -> Posture {
        self.joints.each_ref().map(|joint| joint.angle(time))
    }

    /// The rates of the joints at a time [rad/s].
    pub fn rate(&self, time: f64) -> Posture {
        self.joints.each_ref().map(|joint| joint.rate(time))
    }
}

fn boom() -> Joint {
    Joint::new(40.0, &[(3.2, 5.6, 15.0), (5.6, 8.0, 6.0)])
}
