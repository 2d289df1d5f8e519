//! Do pitch and roll turn with the machine? On ground of one slope, uphill at the angle u, a machine that heads h is inclined by
//! pitch = s cos(h - u) and roll = s sin(h - u). With the swing velocity w = dh/dt that is
//!
//! d pitch/dt = -w roll, d roll/dt = w pitch,
//!
//! whatever slope and machine. Both change sign where one of the two columns has the other sign, where they are exchanged, and
//! where the swing is positive clockwise. Where both have the other sign nothing changes.

use estimation::excavator::Sample;

/// Length of a block \[s\]: long beside the noise of inclinometers, short beside a swing.
const BLOCK: f64 = 0.5;
/// Rows that are further apart are of two blocks \[s\].
const APART: f64 = 0.2;
/// So far the swing must have turned pitch and roll, as the root of the sum of squares \[rad\]: recorded on slopes of 3 to 5 degrees
/// .07 to .13 in a minute.
const TURNED: f64 = 0.03;
/// Correlation of what they did with what the swing says. Recorded: .90 to .99.
const AGAINST: f64 = -0.7;

/// Means of pitch and roll, and how far the swing turned them, over the rows of a block.
#[derive(Clone, Copy, Default)]
struct Block {
    begin: f64,
    end: f64,
    rows: f64,
    sum: [f64; 2],
    turned: [f64; 2],
}

/// Looks at both beside the swing.
#[derive(Default)]
pub(super) struct Ground {
    block: Option<Block>,
    before: Option<Block>,
    /// Sums of squares of what the swing says and of what they did, and of products.
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

    /// From the middle of a block to that of the next.
    fn compare(&mut self, before: &Block, block: &Block) {
        for axis in 0..2 {
            let said = 0.5 * (before.turned[axis] + block.turned[axis]);
            let did = block.sum[axis] / block.rows - before.sum[axis] / before.rows;
            self.said += said * said;
            self.did += did * did;
            self.both += said * did;
        }
    }

    /// That one of them is not what it is called.
    pub(super) fn fault(&self) -> Option<String> {
        let correlation = self.both / (self.said * self.did).sqrt();
        (self.said > TURNED * TURNED && correlation < AGAINST).then(|| {
            "pitch and roll turn against the swing: one of them has the other sign, they are exchanged, or the swing is positive clockwise\n  \
             what to do: write `sign = -1` in a signal map for that one, exchange them, or write `sign = -1` for swing_velocity and swing_torque (docs/map.md)"
                .into()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Swings to and fro on this slope, seen by inclinometers of .2 degrees.
    fn said(slope: f64, change: fn([f64; 2]) -> [f64; 2]) -> Option<String> {
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
    fn a_sign_and_an_exchange_are_told_and_sound_ones_are_not() {
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
            assert!(words.contains("turn against the swing"), "{words}");
            assert_eq!(said(0.0, change), None, "level ground tells nothing");
        }
    }
}
