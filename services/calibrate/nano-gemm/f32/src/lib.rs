//! Nothing that runs: see `../../kernels.rs`.
#![no_std]

include!("../../kernels.rs");

kernels!(f32, f32: f32x1 f32x2 f32x4 avx);
