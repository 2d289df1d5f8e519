//! Checks that pitch and roll rotate with the swing. On ground of one slope, uphill at the angle u, a machine of heading h is inclined by
//! pitch = s cos(h - u) and roll = s sin(h - u). With the swing velocity w = dh/dt that is
//!
//! d pitch/dt = -w roll, d roll/dt = w pitch,
//!
//! for any slope and machine. Both rates change sign if one of the two columns has the opposite sign, if they are exchanged, or if
//! the swing is positive clockwise. If both have the opposite sign nothing changes.

use estimation::excavator::Sample;
use recording::Finding;

/// Duration of a block \[s\]: longer than the noise of inclinometers, shorter than a swing.
const BLOCK: f64 = 0.5;
/// Time between rows above which a new block starts \[s\].
const APART: f64 = 0.2;
/// Least change of pitch and roll predicted from the swing, as the root of the sum of squares \[rad\]: recorded on slopes of 3 to 5
/// degrees .07 to .13 in a minute.
const TURNED: f64 = 0.03;
/// Correlation of measured and predicted changes below which the signs contradict. Recorded: .90 to .99.
const AGAINST: f64 = -0.7;

/// Sums of pitch and roll over the rows of a block, and their change predicted from the swing.
#[derive(Clone, Copy, Default)]
struct Block {
    begin: f64,
    end: f64,
    rows: f64,
    sum: [f64; 2],
    turned: [f64; 2],
}

/// Compares measured changes of pitch and roll with those predicted from the swing.
#[derive(Default)]
pub(super) struct Ground {
    block: Option<Block>,
    before: Option<Block>,
    /// Sums of squares of the predicted changes and of the measured ones, and of their products.
    said: f64,
    did: f64,
    both: f64,
}

impl Ground {
    pub(super) fn see(&mut self, sample: &Sample) {
        let (Some(velocity), [Some(pitch), Some(roll)]) = (sample.velocity, sample.inclination)
        else {
            (self.block, self.before) = (None, None);
            return;
        };
        let new = Block {
            begin: sample.time,
            end: sample.time,
            ..Block::default()
        };
        let mut block = self.block.unwrap_or(new);
        let step = sample.time - block.end;
        if !(0.0..APART).contains(&step) {
            (block, self.before) = (new, None);
        } else {
            block.turned[0] -= velocity * roll * step;
            block.turned[1] += velocity * pitch * step;
        }
        block.end = sample.time;
        block.rows += 1.0;
        block.sum = [block.sum[0] + pitch, block.sum[1] + roll];
        if block.end - block.begin < BLOCK {
            self.block = Some(block);
            return;
        }
        self.block = Some(new);
        if let Some(before) = self.before.replace(block) {
            self.compare(&before, &block);
        }
    }

    /// Compares the changes from the middle of a block to that of the next.
    fn compare(&mut self, before: &Block, block: &Block) {
        for axis in 0..2 {
            let said = 0.5 * (before.turned[axis] + block.turned[axis]);
            let did = block.sum[axis] / block.rows - before.sum[axis] / before.rows;
            self.said += said * said;
            self.did += did * did;
            self.both += said * did;
        }
    }

    /// The fault and its remedy, if signs or columns contradict.
    pub(super) fn fault(&self) -> Option<Finding> {
        let correlation = self.both / (self.said * self.did).sqrt();
        (self.said > TURNED * TURNED && correlation < AGAINST).then(|| {
            Finding::new(
                "pitch and roll turn against the swing: one of them has the other sign, they are exchanged, or the swing is positive clockwise",
                "write `sign = -1` in a signal map for that one, exchange them, or write `sign = -1` for swing_velocity and swing_torque (docs/map.md)",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fault of a machine that swings to and fro on this slope, with inclinometers of .2 degrees noise.
    fn said(slope: f64, change: fn([f64; 2]) -> [f64; 2]) -> Option<Finding> {
        let mut ground = Ground::default();
        for k in 0..6000 {
            let time = 0.01 * f64::from(k);
            let heading = 1.0 - (0.6 * time).cos();
            let noise = |phase: f64| 0.0035 * (1234.5 * time + phase).sin();
            let inclined = [
                slope * heading.cos() + noise(0.0),
                slope * heading.sin() + noise(1.0),
            ];
            ground.see(&Sample {
                time,
                velocity: Some(0.6 * (0.6 * time).sin()),
                inclination: change(inclined).map(Some),
                ..Sample::default()
            });
        }
        ground.fault()
    }

    #[test]
    fn a_sign_and_an_exchange_are_reported_and_sound_ones_are_not() {
        for slope in [0.0, 0.002, 0.05, -0.05] {
            assert_eq!(said(slope, |it| it), None, "{slope}");
        }
        let wrong: [fn([f64; 2]) -> [f64; 2]; 3] = [
            |[pitch, roll]| [-pitch, roll],
            |[pitch, roll]| [pitch, -roll],
            |[pitch, roll]| [roll, pitch],
        ];
        for change in wrong {
            let words = said(0.05, change).expect("a doubt");
            assert!(words.what.contains("turn against the swing"), "{words}");
            assert_eq!(said(0.0, change), None, "level ground tells nothing");
        }
    }
}
