//! Eight machines in the lanes of vector registers, and the selection of the registers at run time.
//!
//! The step is [`crate::batch`], compiled three times: for baseline x86-64 (or the target's own baseline), for AVX2, and for
//! AVX-512. The fastest one depends on the processor, so the comparison measures it. On a Cascade Lake AVX2 wins (0.2 of a single
//! step per machine), and AVX-512 loses (0.57), so the widest is not assumed to be best. None of them fuses a multiplication with
//! an addition, so all give the same bits; a test checks it.

use crate::batch::{BatchUkf, LaneModel};
use crate::problem::{ROVER, Rover, RoverProblem, RoverSample};
use core::ops::{Add, Div, Mul, Neg, Sub};
use estimation::scalar::Scalar;
use estimation::sigma_points::Spread;

/// Machines in a batch.
pub const LANES: usize = 8;

/// One number of each machine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = self;
        for i in 0..LANES {
            result.0[i] = f(self.0[i], other.0[i]);
        }
        result
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self;
        for i in 0..LANES {
            result.0[i] = f(self.0[i]);
        }
        result
    }
}

macro_rules! operator {
    ($operator:ident, $name:ident, $symbol:tt) => {
        impl $operator for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.zip(other, |a, b| a $symbol b)
            }
        }

        impl $operator<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                self.map(|a| a $symbol other)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Scalar for Lanes {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn above(self, limit: Self, yes: Self, no: Self) -> Self {
        let mut result = no;
        for i in 0..LANES {
            result.0[i] = if self.0[i] > limit.0[i] {
                yes.0[i]
            } else {
                no.0[i]
            };
        }
        result
    }
    /// Correctly rounded, as everywhere; the standard library's function becomes one instruction for all lanes.
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    fn sin(self) -> Self {
        self.map(Scalar::sin)
    }
    fn cos(self) -> Self {
        self.map(Scalar::cos)
    }
    fn exp(self) -> Self {
        self.map(Scalar::exp)
    }
    fn ln(self) -> Self {
        self.map(Scalar::ln)
    }
    fn tanh(self) -> Self {
        self.map(Scalar::tanh)
    }
    fn per_atanh(self) -> Self {
        self.map(Scalar::per_atanh)
    }
}

/// One sample of eight rovers.
#[derive(Clone, Copy, Debug)]
pub struct LaneSample {
    /// Front and rear torque.
    pub torque: [Lanes; 2],
    /// Measurements.
    pub measured: [Lanes; 3],
}

impl LaneSample {
    /// Samples side by side.
    pub fn of(samples: [RoverSample; LANES]) -> Self {
        Self {
            torque: std::array::from_fn(|i| Lanes(samples.map(|sample| sample.torque[i]))),
            measured: std::array::from_fn(|j| Lanes(samples.map(|sample| sample.measured[j]))),
        }
    }
}

struct LaneRover {
    rover: Rover,
    torque: [Lanes; 2],
}

impl LaneModel<Lanes, 6> for LaneRover {
    const DYNAMIC: usize = 3;

    #[inline(always)]
    fn predict(&self, state: &[Lanes; 6]) -> [Lanes; 6] {
        let [v, front, rear] = self.rover.advance_with(state, self.torque);
        [v, front, rear, state[3], state[4], state[5]]
    }
}

/// The registers in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    /// The baseline of the build.
    Portable,
    /// 256 bits.
    Avx2,
    /// 512 bits.
    Avx512,
}

impl Path {
    /// Every path of this machine, the widest last.
    pub fn available() -> Vec<Path> {
        let mut paths = vec![Path::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                paths.push(Path::Avx2);
            }
            if is_x86_feature_detected!("avx512f") {
                paths.push(Path::Avx512);
            }
        }
        paths
    }

    /// Name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Path::Portable => "batch of 8, portable",
            Path::Avx2 => "batch of 8, AVX2",
            Path::Avx512 => "batch of 8, AVX-512",
        }
    }
}

/// The filters of eight rovers.
#[derive(Clone, Debug)]
pub struct Batch {
    filter: BatchUkf<Lanes, 6, 3>,
    problem: RoverProblem,
    path: Path,
}

impl Batch {
    /// Filters at the start of the comparison's problem. The path is one of [`Path::available`]; another becomes portable.
    pub fn new(path: Path) -> Self {
        let path = if Path::available().contains(&path) {
            path
        } else {
            Path::Portable
        };
        let state = ROVER.state.map(Lanes::constant);
        let filter = BatchUkf::new(state, &ROVER.initial_std.map(Lanes::constant), Spread::UNIT);
        Self {
            filter,
            problem: ROVER,
            path,
        }
    }

    /// One step of each machine for each sample.
    pub fn run(&mut self, samples: &[LaneSample]) {
        match self.path {
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            Path::Avx2 => {
                // SAFETY: `new` stores this path only where the processor has been found to have AVX2.
                unsafe { run_avx2(&mut self.filter, &self.problem, samples) }
            }
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            Path::Avx512 => {
                // SAFETY: as above, for AVX-512F.
                unsafe { run_avx512(&mut self.filter, &self.problem, samples) }
            }
            _ => run_portable(&mut self.filter, &self.problem, samples),
        }
    }

    /// The states of machine `lane`.
    pub fn state(&self, lane: usize) -> [f64; 6] {
        self.filter.state.map(|lanes| lanes.0[lane])
    }
}

#[inline(always)]
fn steps(filter: &mut BatchUkf<Lanes, 6, 3>, problem: &RoverProblem, samples: &[LaneSample]) {
    let std = problem.measurement_std.map(Lanes::constant);
    for sample in samples {
        let model = LaneRover {
            rover: problem.rover,
            torque: sample.torque,
        };
        filter.step(&model, &problem.process_std, &sample.measured, &std);
    }
}

#[inline(never)]
fn run_portable(
    filter: &mut BatchUkf<Lanes, 6, 3>,
    problem: &RoverProblem,
    samples: &[LaneSample],
) {
    steps(filter, problem, samples);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2(filter: &mut BatchUkf<Lanes, 6, 3>, problem: &RoverProblem, samples: &[LaneSample]) {
    steps(filter, problem, samples);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn run_avx512(filter: &mut BatchUkf<Lanes, 6, 3>, problem: &RoverProblem, samples: &[LaneSample]) {
    steps(filter, problem, samples);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ours::Unscented;
    use crate::problem::{Filter, SAMPLES, rover_data};

    fn lanes() -> Vec<LaneSample> {
        let data = rover_data();
        (0..SAMPLES)
            .map(|k| LaneSample::of(std::array::from_fn(|lane| data[(k + 31 * lane) % SAMPLES])))
            .collect()
    }

    #[test]
    fn every_path_gives_the_same_bits() {
        let samples = lanes();
        let states: Vec<[[f64; 6]; LANES]> = Path::available()
            .into_iter()
            .map(|path| {
                let mut batch = Batch::new(path);
                batch.run(&samples);
                std::array::from_fn(|lane| batch.state(lane))
            })
            .collect();
        assert!(states.iter().all(|state| *state == states[0]), "{states:?}");
    }

    #[test]
    fn a_lane_computes_what_a_single_filter_computes() {
        let (samples, data) = (lanes(), rover_data());
        let mut batch = Batch::new(Path::Portable);
        batch.run(&samples);
        for lane in 0..LANES {
            let mut single = Unscented::default();
            (0..SAMPLES).for_each(|k| single.step(&data[(k + 31 * lane) % SAMPLES]));
            for (x, y) in batch.state(lane).into_iter().zip(single.state()) {
                // The same formulas with another order of sums: rounding, carried through 512 steps.
                assert!((x - y).abs() < 1e-11 * (1.0 + x.abs()), "{x} {y}");
            }
        }
    }
}
