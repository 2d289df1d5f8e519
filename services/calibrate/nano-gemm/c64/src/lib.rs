//! Nothing that runs: see `../../kernels.rs`.
#![no_std]

include!("../../kernels.rs");

kernels!(num_complex::Complex64, c64: c64x1 avx);
