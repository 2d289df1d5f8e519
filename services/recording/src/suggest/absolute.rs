//! Does a link's sensor measure its angle from the horizontal, as an inclinometer does, or from the link before?
//!
//! While a link moves and the next one does not, a joint angle of the next one stays, and an angle from the horizontal moves along.
//! Joints that are moved together have any ratio of rates: where 1 is chance, ratios beside it are as frequent (as in
//! `estimation`'s `plausible`, which looks at what a map made of the angles).
//! Names tell too, where the data do not say otherwise: all links may move at once.

/// A link that has moved by this much has moved [rad]; the next one moves along within this share of it.
const MOVES: f64 = 0.1;
const ALONG: f64 = 0.15;
/// Off by up to this share it moves at a rate beside the link's.
const BESIDE: f64 = 2.0 * ALONG;
/// So many rows at most for one motion: a link that is slower counts as standing.
const LONGEST: usize = 200;
/// Motions that tell something, and how many times more of one kind than of the other.
const ENOUGH: usize = 5;
const RATHER: usize = 3;
/// Words in the names of sensors that measure from the horizontal.
const NAMES: [&str; 7] = ["incl", "imu", "abs", "tilt", "neigung", "傾斜", "倾角"];

/// Whether the angles `next` are from the horizontal, by those of the link before, both in rad, or else by the name.
pub(super) fn is_absolute(name: &str, before: &[f64], next: &[f64]) -> Option<&'static str> {
    let (mut along, mut alone, mut beside, mut from) = (0, 0, 0, 0);
    for at in 1..before.len().min(next.len()) {
        let (link, other) = (before[at] - before[from], next[at] - next[from]);
        if !(link.is_finite() && other.is_finite()) || at - from > LONGEST {
            from = at;
        } else if link.abs() > MOVES {
            let within = |x: f64, share: f64| x.abs() < share * link.abs();
            let follows = within(other - link, ALONG);
            along += usize::from(follows);
            beside += usize::from(!follows && within(other - link, BESIDE));
            alone += usize::from(within(other, ALONG));
            from = at;
        }
    }
    if along >= ENOUGH && along > RATHER * alone.max(beside) {
        Some("it moves along with the link before")
    } else if (along + alone < ENOUGH || alone <= RATHER * along) && by_name(name) {
        Some(BY_NAME)
    } else {
        None
    }
}

/// Why, where only the name tells.
pub(super) const BY_NAME: &str = "an inclinometer by its name";

/// Whether the name is that of a sensor that measures from the horizontal.
pub(super) fn by_name(name: &str) -> bool {
    let name = name.to_lowercase();
    NAMES.iter().any(|word| name.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_that_a_program_moves_together_are_no_absolute_angles() {
        let turned = |k: u32| 0.4 * (1.0 - (0.02 * f64::from(k)).cos());
        let arm: Vec<f64> = (0..4000).map(|k| -1.4 + turned(k)).collect();
        // The bucket curls with the arm, in each motion at another ratio about 1.
        let ratio = |k: u32| 0.76 + 0.04 * f64::from(k / 314);
        let bucket: Vec<f64> = (0..4000).map(|k| -1.0 + ratio(k) * turned(k)).collect();
        assert_eq!(is_absolute("bucket", &arm, &bucket), None);
    }

    #[test]
    fn an_angle_that_moves_along_is_absolute_and_one_that_stays_is_not() {
        let boom: Vec<f64> = (0..3000)
            .map(|k| 0.4 * (0.01 * f64::from(k)).sin())
            .collect();
        // The next joint moves in other seconds.
        let joint: Vec<f64> = (0..3000)
            .map(|k| {
                -1.0 + if k % 900 < 600 {
                    0.0
                } else {
                    0.3 * (0.02 * f64::from(k)).sin()
                }
            })
            .collect();
        let sum: Vec<f64> = boom.iter().zip(&joint).map(|(a, b)| a + b).collect();
        assert_eq!(is_absolute("arm", &boom, &joint), None);
        assert!(is_absolute("arm", &boom, &sum).is_some());
        assert_eq!(is_absolute("arm_imu", &boom, &joint), None);
        // All joints move at once, and the name says what the data cannot.
        let joint: Vec<f64> = (0..3000)
            .map(|k| 0.5 * (0.013 * f64::from(k)).sin())
            .collect();
        let sum: Vec<f64> = boom.iter().zip(&joint).map(|(a, b)| a + b).collect();
        assert!(is_absolute("arm_tilt", &boom, &sum).is_some());
        assert_eq!(is_absolute("arm", &boom, &sum), None);
        let still = vec![0.3; 100];
        assert!(is_absolute("arm_imu", &still, &still).is_some());
        assert_eq!(is_absolute("arm_deg", &still, &still), None);
    }
}
