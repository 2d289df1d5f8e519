//! Endless work: dig, swing, dump, swing back.

use super::path::{Joint, Path};
use super::payload::Load;
use super::plant::Plant;
use super::plants::at_rest;
use super::plateaus::{Plateaus, Targets};

/// Length of one working cycle [s].
const LENGTH: f64 = 16.0;
/// Payloads of successive cycles [kg].
const PAYLOADS: [f64; 4] = [288.0, 423.0, 200.0, 350.0];
/// Iterations of the speed of the swing back; each reduces the error of the angle to about a tenth.
const CORRECTIONS: usize = 4;

/// The plant; with `payload`, every bucket carries it.
pub(super) fn plant(payload: Option<f64>) -> Plant {
    let starts = (0..PAYLOADS.len()).map(|i| i as f64 * LENGTH);
    let loads = starts.clone().zip(PAYLOADS).map(|(start, mass)| Load {
        mass: payload.unwrap_or(mass),
        fill: (start + 1.5, start + 3.4),
        dump: (start + 9.6, start + 10.5),
    });
    let mut plant = at_rest(path(), loads.collect());
    for start in starts {
        let working = Targets::working(start + 5.5, start + 7.5, start + 9.3);
        let there = Plateaus::new(&plant, working);
        let swing = there.solve();
        let angle = there.angle(swing);
        let back = back(&plant, start, angle);
        plant.swings.extend([swing, back]);
    }
    plant.period = PAYLOADS.len() as f64 * LENGTH;
    plant
}

/// The swing back over `angle` [rad].
fn back(plant: &Plant, start: f64, angle: f64) -> super::torque::Swing {
    let mut targets = Targets::back(start + 11.2, start + 13.0, start + 14.8);
    for _ in 0..CORRECTIONS {
        let solver = Plateaus::new(plant, targets);
        targets.peak *= angle / -solver.angle(solver.solve());
    }
    Plateaus::new(plant, targets).solve()
}

/// The base path with a return of boom and arm, once per cycle.
fn path() -> Path {
    let mut path = Path::base();
    path.joints[0]
        .moves
        .extend(Joint::new(0.0, &[(11.3, 13.5, -21.0)]).moves);
    path.joints[1]
        .moves
        .extend(Joint::new(0.0, &[(11.3, 14.0, -16.0)]).moves);
    for joint in &mut path.joints {
        let once = joint.moves.clone();
        for i in 1..PAYLOADS.len() {
            let later = i as f64 * LENGTH;
            joint.moves.extend(once.iter().map(|m| super::path::Move {
                from: m.from + later,
                to: m.to + later,
                ..*m
            }));
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_ends_in_the_posture_and_with_the_load_with_which_it_begins() {
        let plant = plant(None);
        let (begin, end) = (
            plant.path.posture(0.0),
            plant.path.posture(plant.period - 1e-9),
        );
        for (a, b) in begin.iter().zip(end) {
            // Sums of twenty moves of tens of degrees: rounding.
            assert!((a - b).abs() < 1e-12);
        }
        assert_eq!(plant.payload(plant.period - 1e-9), 0.0);
        assert_eq!(plant.torque(plant.period - 1e-9), 0.0);
    }
}
