//! Means of signals over successive blocks of rows.

/// The present block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Blocks<const N: usize> {
    /// Integrals over the block, and its length [s].
    #[cfg_attr(feature = "serde", serde(with = "crate::written"))]
    sums: [f64; N],
    time: f64,
}

impl<const N: usize> Default for Blocks<N> {
    fn default() -> Self {
        Self {
            sums: [0.0; N],
            time: 0.0,
        }
    }
}

impl<const N: usize> Blocks<N> {
    /// Adds a row of `dt`. Returns the means of a block of this length that it ends [s].
    pub fn add(&mut self, row: [f64; N], dt: f64, length: f64) -> Option<[f64; N]> {
        for (sum, value) in self.sums.iter_mut().zip(row) {
            *sum += value * dt;
        }
        self.time += dt;
        // The nearest row ends the block, whatever the rounding.
        if self.time < length - 0.5 * dt {
            return None;
        }
        let block = core::mem::take(self);
        Some(block.sums.map(|sum| sum / block.time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_ends_with_the_nearest_row_and_the_next_begins_empty() {
        let mut blocks = Blocks::default();
        let mut ended = [None; 40];
        for (k, ended) in ended.iter_mut().enumerate() {
            let time = 0.01 * k as f64;
            *ended = blocks.add([k as f64, 1.0], (time + 0.01) - time, 0.2);
        }
        let ends = ended
            .iter()
            .enumerate()
            .filter_map(|(k, means)| Some((k, (*means)?)));
        let mut expected = [(19, 9.5), (39, 29.5)].into_iter();
        for (k, [mean, one]) in ends {
            let (row, of_rows) = expected.next().unwrap();
            assert_eq!(k, row);
            assert!((mean - of_rows).abs() < 1e-9 && (one - 1.0).abs() < 1e-12);
        }
        assert!(expected.next().is_none());
    }
}
