//! The estimators for C: the implementation of `heft.h`.
//!
//! The caller provides the memory, and then one row after the other. No function here allocates, opens a
//! file, reads a clock or panics on data; every output number is finite. Structures are passed
//! as plain numbers in the order of one table per machine ([`Machine`]). The
//! header and the model descriptions of the FMUs are generated from it.
//!
//! | file | idea |
//! |---|---|
//! | `table` | the interface of a machine for other languages |
//! | `settings` | a description as doubles |
//! | `excavator`, `loader` | the tables |
//! | `loads` | loads from estimates |
//! | `abi` | a checksum of the header |
//! | `border` | memory and pointers of the caller: all the unsafe code |
#![cfg_attr(not(any(feature = "std", test)), no_std)]

pub mod abi;
mod border;
mod excavator;
mod loader;
mod loads;
pub mod settings;
mod table;

pub use border::{Code, SIZE_MAX};
pub use excavator::Excavator;
pub use loader::Loader;
pub use loads::LoadsRow;
pub use table::{Answer, Bit, Machine, Signal, Value, answer, bits, sample};

/// Without an operating system a panic has no output: the program stops.
#[cfg(not(any(feature = "std", test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// `core` of a target with an operating system is compiled for unwinding and refers to this function; nothing here unwinds.
#[cfg(all(target_os = "linux", not(any(feature = "std", test))))]
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}
