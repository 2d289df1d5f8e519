//! Detects whether a link's sensor measures its angle from the horizontal, as an inclinometer does, or from the link before.
//!
//! While a link moves and the next one does not, the joint angle of the next one is constant. Its angle from the horizontal changes
//! by the same amount.
//! Joints that move together have any ratio of rates: if a ratio of 1 is chance, ratios near 1 are as frequent (as in
//! `estimation`'s `plausible`, which checks the mapped angles).
//! Names decide if the data do not contradict: all links may move at once.

/// Least motion of a link [rad], and share of it within which the next one moves equally.
const MOVES: f64 = 0.1;
const ALONG: f64 = 0.15;
/// Share of it up to which the next one moves at a rate near the link's.
const BESIDE: f64 = 2.0 * ALONG;
/// Largest number of rows of one motion: a slower link counts as standing.
const LONGEST: usize = 200;
/// Fewest motions for a verdict, and least ratio of one kind to the other.
const ENOUGH: usize = 5;
const RATHER: usize = 3;
/// Words in names of sensors that measure from the horizontal.
const NAMES: [&str; 7] = ["incl", "imu", "abs", "tilt", "neigung", "傾斜", "倾角"];

/// Whether the angles `next` are from the horizontal, by those of the link before, both in rad, or else by the name; returns the reason.
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

/// The reason if only the name decides.
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
        // The bucket curls with the arm, with another ratio near 1 in each motion.
        let ratio = |k: u32| 0.76 + 0.04 * f64::from(k / 314);
        let bucket: Vec<f64> = (0..4000).map(|k| -1.0 + ratio(k) * turned(k)).collect();
        assert_eq!(is_absolute("bucket", &arm, &bucket), None);
    }

    #[test]
    fn an_angle_that_moves_along_is_absolute_and_one_that_stays_is_not() {
        let boom: Vec<f64> = (0..3000)
            .map(|k| 0.4 * (0.01 * f64::from(k)).sin())
            .collect();
        // The next joint moves at other times.
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
        // All joints move at once, and only the name decides.
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
