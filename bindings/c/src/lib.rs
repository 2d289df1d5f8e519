//! The estimators for C: `heft.h` is the interface, this is what stands behind it.
//!
//! The caller gives the memory, and then one row after the other. Nothing here allocates, opens a
//! file, reads a clock or panics on data; every number that comes out is finite. Structures cross
//! the border as plain numbers in the order of one table per machine ([`Machine`]), from which the
//! header and the model descriptions of the FMUs are written.
//!
//! | file | idea |
//! |---|---|
//! | `table` | what a machine must tell to be offered outside |
//! | `settings` | a description as doubles |
//! | `excavator`, `loader` | the tables |
//! | `loads` | from estimates to loads |
//! | `abi` | one number for what the header promises |
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

/// Without an operating system there is nobody to tell: the step was wrong, not the data.
#[cfg(not(any(feature = "std", test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// `core` of a target with an operating system is made to unwind and names this function; nothing here ever unwinds.
#[cfg(all(target_os = "linux", not(any(feature = "std", test))))]
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}
