//! Interface of an attack, and the random numbers of its attempts.

use crate::ground::Ground;

/// An attack on a pipeline or on its files.
pub trait Attack {
    /// Name in the table.
    fn name(&self) -> String;
    /// Attempts it once; `Err` describes the damage.
    fn attempt(&mut self, rng: &mut Rng, ground: &Ground) -> Result<Outcome, String>;
    /// A note on all attempts, for the table.
    fn note(&self) -> Option<String> {
        None
    }
}

/// Outcome of an attempt without damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The pipeline survived.
    Survived {
        /// Longest run of unanswered samples in the recorded data.
        gap: u64,
    },
    /// The attack is not possible on this host.
    Skipped,
}

/// Reproducible random numbers: xorshift64*.
pub struct Rng(u64);

impl Rng {
    /// The same seed gives the same attacks.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number in `from..to`.
    pub fn between(&mut self, from: u64, to: u64) -> u64 {
        from + self.next() % (to - from).max(1)
    }

    /// One of `items`.
    pub fn one<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.between(0, items.len() as u64) as usize]
    }

    /// `n` distinct ones of `items`.
    pub fn some<T: Copy>(&mut self, items: &[T], n: usize) -> Vec<T> {
        let mut left = items.to_vec();
        let mut taken = Vec::new();
        while taken.len() < n && !left.is_empty() {
            taken.push(left.remove(self.between(0, left.len() as u64) as usize));
        }
        taken
    }
}
