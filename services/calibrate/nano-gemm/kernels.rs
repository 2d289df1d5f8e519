// In place of the kernels of nano-gemm for a number that heft does not multiply: the names that nano-gemm reads, and one kernel
// that says where it is.

use nano_gemm_core::{MicroKernel, MicroKernelData};

fn unused<T>(_: &MicroKernelData<T>, _: *mut T, _: *const T, _: *const T) {
    unimplemented!("this build multiplies matrices of f64 alone (services/calibrate/nano-gemm)")
}

/// The sets of kernels of a number, each of one kernel for one row and one column.
macro_rules! kernels {
    ($number:ty, $module:ident: $($name:ident)*) => {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        pub mod x86 {
            pub mod $module { $( $crate::kernels!(@ $name, $number); )* }
        }
        #[cfg(target_arch = "aarch64")]
        pub mod aarch64 {
            pub mod $module { $crate::kernels!(@ neon, $number); }
        }
    };
    (@ $name:ident, $number:ty) => {
        pub mod $name {
            pub const MR_DIV_N: usize = 1;
            pub const NR: usize = 1;
            pub const N: usize = 1;
            pub static MICROKERNELS: [[[crate::MicroKernel<$number>; NR]; MR_DIV_N]; 17] =
                [[[crate::unused; NR]; MR_DIV_N]; 17];
            pub static MASKS: [(); N] = [(); N];
        }
    };
}
use kernels;
