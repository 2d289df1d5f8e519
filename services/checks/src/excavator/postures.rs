//! Detects joint angles that are exchanged, have the opposite sign, or another reference: the correction that gives postures within
//! the machine's range.

use core::f64::consts::FRAC_PI_2;

use recording::Finding;

/// Ranges of boom, arm and bucket angle that machines reach \[rad\]. Recorded: -.3 to 1.2, -2.4 to -.8, -1.6 to .3.
const REACHED: [[f64; 2]; 3] = [[-0.9, 1.4], [-2.9, -0.3], [-2.9, 1.3]];
/// Fewest rows for a verdict.
const FEWEST: u32 = 1000;
/// Share of rows out of range above which the angles are wrong, and below which a correction explains them.
const WRONG: f64 = 0.05;
const RIGHT: f64 = 0.01;

/// A hypothesis: its name, the remedy, and the corrected posture.
type Hypothesis = (&'static str, &'static str, fn([f64; 3]) -> [f64; 3]);

const EXCHANGE: &str = "exchange the two in the signal map";
const HYPOTHESES: [Hypothesis; 7] = [
    ("", "", |q| q),
    (
        "boom_angle and arm_angle seem to be exchanged",
        EXCHANGE,
        |q| [q[1], q[0], q[2]],
    ),
    (
        "arm_angle and bucket_angle seem to be exchanged",
        EXCHANGE,
        |q| [q[0], q[2], q[1]],
    ),
    (
        "boom_angle and bucket_angle seem to be exchanged",
        EXCHANGE,
        |q| [q[2], q[1], q[0]],
    ),
    (
        "all three joint angles seem to have the other sign",
        "in the signal map `sign = -1` for each; up is positive (docs/signs-excavator.svg)",
        |q| q.map(|angle| -angle),
    ),
    // Where the arm is measured from the horizontal too, this correction alone explains the postures as well.
    (
        "bucket_angle seems to be measured from the horizontal",
        "subtract the angle of the link before in the signal map, and that of the boom from the arm if it is measured so too (docs/map.md)",
        |q| [q[0], q[1], q[2] - q[1] - q[0]],
    ),
    (
        "boom_angle seems to be measured from the vertical",
        "in the signal map `offset = -1.5708` for it; up from the horizontal is positive",
        |q| [q[0] - FRAC_PI_2, q[1], q[2]],
    ),
];

/// Counts postures out of range.
#[derive(Default)]
pub(super) struct Postures {
    rows: u32,
    beyond: [u32; HYPOTHESES.len()],
}

impl Postures {
    pub(super) fn see(&mut self, posture: [f64; 3]) {
        self.rows += 1;
        for (beyond, (.., right)) in self.beyond.iter_mut().zip(HYPOTHESES) {
            let is_reached = |(q, [from, to]): (f64, [f64; 2])| (from..=to).contains(&q);
            let is_had = right(posture).into_iter().zip(REACHED).all(is_reached);
            *beyond += u32::from(!is_had);
        }
    }

    /// The only hypothesis that explains the postures, if they are wrong.
    pub(super) fn fault(&self) -> Option<Finding> {
        let share = |beyond: u32| f64::from(beyond) / f64::from(self.rows);
        if self.rows < FEWEST || share(self.beyond[0]) < WRONG {
            return None;
        }
        let mut explaining = HYPOTHESES
            .iter()
            .zip(self.beyond)
            .filter(|(_, beyond)| share(*beyond) < RIGHT);
        let ((what, remedy, _), _) = explaining.next()?;
        explaining.next().is_none().then(|| {
            Finding::new(
                format!("{what}: only so are the postures those of a machine"),
                *remedy,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    type Change = fn([f64; 3]) -> [f64; 3];

    #[test]
    fn exchanged_angles_and_signs_are_named() {
        // Dig, swing, dump: boom, arm, bucket.
        let cycle = [[0.1, -2.2, -1.4], [0.9, -1.8, -1.5], [1.1, -1.5, 0.0]];
        let said = |change: Change| {
            let mut postures = Postures::default();
            for _ in 0..1000 {
                cycle.iter().for_each(|q| postures.see(change(*q)));
            }
            text(postures.fault())
        };
        assert_eq!(said(|q| q), "");
        let from_horizontal = |q: [f64; 3]| [q[0], q[1], q[0] + q[1] + q[2]];
        let all_from_horizontal = |q: [f64; 3]| [q[0], q[0] + q[1], q[0] + q[1] + q[2]];
        let from_vertical = |q: [f64; 3]| [q[0] + FRAC_PI_2, q[1], q[2]];
        let undone = HYPOTHESES[1..5].iter().map(|it| (it, it.2));
        let others: [(_, Change); 3] = [
            (&HYPOTHESES[5], from_horizontal),
            (&HYPOTHESES[5], all_from_horizontal),
            (&HYPOTHESES[6], from_vertical),
        ];
        for ((what, remedy, _), change) in undone.chain(others) {
            let said = said(change);
            assert!(
                said.starts_with(what) && said.ends_with(remedy),
                "{what}: {said}"
            );
        }
        // A fault that is none of the hypotheses.
        assert_eq!(said(|q| [q[0], -q[1], q[2]]), "");
    }
}
