//! Nothing that runs: see `../../kernels.rs`.
#![no_std]

include!("../../kernels.rs");

kernels!(num_complex::Complex32, c32: c32x1 c32x2 avx);
