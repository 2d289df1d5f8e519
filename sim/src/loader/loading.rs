//! Loading of a truck, cycle by cycle: drive into the heap, fill the bucket, reverse, drive to the truck while lifting, dump,
//! return.

use super::arm::Stance;
use super::plant::Machine;
use crate::blend::{transition, transition_rate};
use crate::noise::Noise;

/// Length of one cycle [s].
pub(super) const PERIOD: f64 = 26.0;
/// Number of drawn loads, after which they repeat.
const LOADS: usize = 64;
/// Full bucket, in masses of the machine; range of the loads and of the remainder that sticks, in full buckets.
const RATED: f64 = 0.32;
const FILLED: (f64, f64) = (0.55, 1.0);
const STICKS: (f64, f64) = (0.005, 0.03);
/// Times of filling and emptying the bucket [s].
const FILL: (f64, f64) = (5.4, 6.8);
const DUMP: (f64, f64) = (17.3, 18.3);
/// Times at which it enters the heap, and at which it leaves [s].
const ENTER: (f64, f64) = (4.9, 5.3);
const LEAVE: (f64, f64) = (6.7, 7.0);
/// Force of the heap, backward and down, in weights of the machine.
const HEAP: [f64; 2] = [0.2, 0.03];
/// Changes of the speed: from, to [s], by [m/s].
const SPEED: &[(f64, f64, f64)] = &[
    (0.4, 2.0, 2.4),
    (3.4, 4.8, -1.9),
    (5.0, 6.4, -0.3),
    (6.6, 7.4, -0.2),
    (7.8, 9.4, -2.2),
    (10.6, 12.0, 2.2),
    (12.4, 14.0, 2.2),
    (15.2, 16.6, -2.2),
    (19.6, 21.0, -2.2),
    (22.2, 23.6, 2.2),
];
/// Gain of the driver's speed correction [1/s].
const CORRECTION: f64 = 1.5;
/// Arm and bucket at the beginning [rad], and their moves: from, to [s], by [rad].
const START: Stance = Stance {
    lift: -0.80,
    bucket: 0.05,
};
const LIFT: &[(f64, f64, f64)] = &[(5.2, 7.4, 0.25), (11.5, 16.2, 0.97), (20.0, 24.4, -1.22)];
const BUCKET: &[(f64, f64, f64)] = &[(5.4, 6.9, 0.80), (17.0, 18.2, -1.60), (19.2, 20.8, 0.80)];

/// The driver's plan.
#[derive(Clone, Debug)]
pub(super) struct Loading {
    loads: Vec<[f64; 2]>,
    mass: f64,
}

impl Loading {
    /// The plan of a machine; every load is `asked` [kg], or drawn.
    pub fn new(machine: &Machine, asked: Option<f64>, mut noise: Noise) -> Self {
        let rated = RATED * machine.mass;
        let mut draw = |(from, to): (f64, f64)| rated * noise.uniform(from, to);
        let loads = (0..LOADS)
            .map(|_| [draw(FILLED), draw(STICKS)])
            .map(|[load, sticks]| match asked {
                Some(asked) => [asked, (sticks / load).min(0.1) * asked],
                None => [load, sticks],
            });
        Self {
            loads: loads.collect(),
            mass: machine.mass,
        }
    }

    /// Mass in the bucket \[kg\].
    pub fn load(&self, t: f64) -> f64 {
        let cycle = (t / PERIOD).floor();
        let of = |cycle: f64| self.loads[cycle.rem_euclid(LOADS as f64) as usize];
        let before = if cycle >= 1.0 {
            of(cycle - 1.0)[1]
        } else {
            0.0
        };
        let [load, sticks] = of(cycle);
        let since = t - cycle * PERIOD;
        let filled = before + (load - before) * transition(since, FILL.0, FILL.1);
        filled + (sticks - load) * transition(since, DUMP.0, DUMP.1)
    }

    /// Stance of arm and bucket.
    pub fn stance(&self, t: f64) -> Stance {
        let since = t.rem_euclid(PERIOD);
        let moved = |moves: &[(f64, f64, f64)]| -> f64 {
            moves
                .iter()
                .map(|m| m.2 * transition(since, m.0, m.1))
                .sum()
        };
        Stance {
            lift: START.lift + moved(LIFT),
            bucket: START.bucket + moved(BUCKET),
        }
    }

    /// Whether the arm or the bucket moves.
    pub fn moves(&self, t: f64) -> bool {
        let since = t.rem_euclid(PERIOD);
        let within = |m: &(f64, f64, f64)| (m.0..m.1).contains(&since);
        LIFT.iter().chain(BUCKET).any(within)
    }

    /// Share of the bucket in the heap, 0 to 1.
    pub fn contact(&self, t: f64) -> f64 {
        let since = t.rem_euclid(PERIOD);
        transition(since, ENTER.0, ENTER.1) * (1.0 - transition(since, LEAVE.0, LEAVE.1))
    }

    /// Force of the heap on the bucket: backward, down [N].
    pub fn heap(&self, t: f64) -> [f64; 2] {
        HEAP.map(|share| share * 9.81 * self.mass * self.contact(t))
    }

    /// Force of both axles that follows the plan at a speed [N].
    pub fn traction(&self, machine: &Machine, mass: f64, t: f64, speed: f64) -> f64 {
        let since = t.rem_euclid(PERIOD);
        let (mut wanted, mut acceleration) = (0.0, 0.0);
        for (from, to, change) in SPEED {
            wanted += change * transition(since, *from, *to);
            acceleration += change * transition_rate(since, *from, *to);
        }
        let rolling = machine.rolling_resistance * 9.81 * (wanted / 0.1).tanh();
        mass * (acceleration + CORRECTION * (wanted - speed) + rolling) + self.heap(t)[0]
    }
}

#[cfg(test)]
mod tests {
    use super::super::arm::LiftArm;
    use super::*;

    #[test]
    fn a_cycle_ends_as_it_begins_with_what_sticks_in_the_bucket() {
        let plan = Loading::new(&Machine::NOMINAL, None, Noise::new(4));
        for moves in [LIFT, BUCKET, SPEED] {
            assert!(moves.iter().map(|m| m.2).sum::<f64>().abs() < 1e-9);
        }
        let [load, sticks] = plan.loads[0];
        assert!((plan.load(10.0) - load).abs() < 1e-9);
        assert!((plan.load(PERIOD - 1e-6) - plan.load(PERIOD)).abs() < 1e-6);
        assert!((plan.load(PERIOD) - sticks).abs() < 1e-9 && plan.load(0.0) == 0.0);
    }

    #[test]
    fn the_load_is_low_in_the_heap_and_high_over_the_truck() {
        let plan = Loading::new(&Machine::NOMINAL, None, Noise::new(4));
        let arm = LiftArm::of(&Machine::NOMINAL);
        let height = |t| arm.place(&plan.stance(t))[1];
        assert!((0.1..0.7).contains(&height(5.0)) && (2.2..3.6).contains(&height(16.8)));
    }
}
