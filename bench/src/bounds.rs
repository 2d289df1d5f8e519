//! Two lower bounds of a step, in nanoseconds of this machine.
//!
//! | bound | definition |
//! |---|---|
//! | flops | all operations at the highest rate this build reaches on independent numbers |
//! | chain | the operations that depend on each other from one step to the next, sums taken as trees |
//!
//! Operations are counted by hand from the formulas; their times are measured here, in the same run as everything else. A filter
//! at the chain bound does not become faster by saving other operations, only by running several machines at once.

use std::hint::black_box;
use std::time::Instant;

/// Operations of one step.
#[derive(Debug, Clone, Copy)]
pub struct Operations {
    /// All floating-point operations.
    pub flops: f64,
    /// Additions and multiplications on the longest chain.
    pub chain: f64,
    /// Divisions on it.
    pub divisions: f64,
    /// Square roots on it.
    pub roots: f64,
}

/// Kalman 2/1: the chain runs from P12 over P11 and S back to P12.
pub const KALMAN: Operations = Operations {
    flops: 24.0,
    chain: 6.0,
    divisions: 1.0,
    roots: 0.0,
};
/// Multiple-forgetting RLS, closed form: from the parameters over the innovation back to them.
pub const REGRESSION: Operations = Operations {
    flops: 43.0,
    chain: 6.0,
    divisions: 1.0,
    roots: 0.0,
};
/// Square-root UKF 6/3: the model, six reflections (9 operations, a root and a division each), three measurements.
pub const UNSCENTED: Operations = Operations {
    flops: 1900.0,
    chain: 92.0,
    divisions: 11.0,
    roots: 9.0,
};
/// EKF 6/3: as the UKF, with rows of half the length.
pub const EXTENDED: Operations = Operations {
    flops: 1100.0,
    chain: 84.0,
    divisions: 11.0,
    roots: 9.0,
};

/// Nanoseconds of single operations on this machine.
#[derive(Debug, Clone, Copy)]
pub struct Host {
    /// One operation among many independent ones.
    pub throughput: f64,
    /// An addition or multiplication that depends on the one before.
    pub arithmetic: f64,
    /// A division that depends on the operation before.
    pub division: f64,
    /// A square root that depends on the operation before.
    pub root: f64,
}

impl Host {
    /// Measures this machine; takes some 20 ms.
    pub fn measure() -> Self {
        let pair = quickest(|x| x * 0.999_999 + 1e-6);
        Self {
            throughput: throughput(),
            arithmetic: pair / 2.0,
            division: quickest(|x| 1.5 / x),
            root: quickest(|x| (x + 0.5).sqrt()) - pair / 2.0,
        }
    }

    /// Time of a step by the number of operations only \[ns\].
    pub fn flop_bound(&self, operations: &Operations) -> f64 {
        operations.flops * self.throughput
    }

    /// Time of a step by its longest chain only \[ns\].
    pub fn chain_bound(&self, operations: &Operations) -> f64 {
        operations.chain * self.arithmetic
            + operations.divisions * self.division
            + operations.roots * self.root
    }
}

const TURNS: usize = 4000;

/// Nanoseconds of `f` applied to its own result, the least of several blocks.
fn quickest(f: impl Fn(f64) -> f64) -> f64 {
    (0..200)
        .map(|_| {
            let mut x = black_box(1.2);
            let start = Instant::now();
            for _ in 0..TURNS {
                x = f(x);
            }
            black_box(x);
            start.elapsed().as_nanos() as f64 / TURNS as f64
        })
        .fold(f64::INFINITY, f64::min)
}

/// Nanoseconds of one operation among 32 independent chains, with the vectors of this build.
fn throughput() -> f64 {
    const LANES: usize = 32;
    (0..200)
        .map(|_| {
            let mut x = black_box([1.2; LANES]);
            let start = Instant::now();
            for _ in 0..TURNS / 8 {
                for lane in &mut x {
                    *lane = *lane * 0.999_999 + 1e-6;
                }
            }
            black_box(x);
            start.elapsed().as_nanos() as f64 / (TURNS / 8 * LANES * 2) as f64
        })
        .fold(f64::INFINITY, f64::min)
}
