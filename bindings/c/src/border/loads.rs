//! Memory and pointers of a caller that counts loads.

use core::ffi::c_void;
use core::mem::{align_of, size_of};
use core::ptr::addr_of_mut;

use estimation::loads::{LoadReport, Settings};

use super::{Code, SIZE_MAX, guarded, settings};
use crate::abi;
use crate::loads::{Loads, LoadsRow, can_be_target};
use crate::table::{Machine, present};

/// Marks initialised memory of loads.
const LOADS_MARK: u64 = 0x6865_6674_6c6f_6164;

/// Contents of the caller's memory for loads.
#[repr(C)]
struct LoadsBlock {
    /// [`LOADS_MARK`] if `loads` is valid.
    mark: u64,
    loads: Loads,
}

/// # Safety
/// `memory` is null or was given to `heft_loads_init`; `out` is null or points to the report. Nobody else uses them
/// meanwhile.
unsafe fn with_loads(
    memory: *mut c_void,
    out: *mut LoadReport,
    body: impl FnOnce(&mut Loads) -> LoadReport,
) -> Code {
    let block = memory.cast::<LoadsBlock>();
    if memory.is_null() || out.is_null() {
        return Code::Null;
    }
    if !block.is_aligned() {
        return Code::Memory;
    }
    // SAFETY: `heft_loads_init` wrote the mark, whatever the outcome.
    if unsafe { addr_of_mut!((*block).mark).read() } != LOADS_MARK {
        return Code::NotInitialised;
    }
    // SAFETY: the mark shows that the loads are initialised.
    let loads = unsafe { &mut (*block).loads };
    match guarded(|| body(loads)) {
        Some(report) => {
            // SAFETY: the caller's promise.
            unsafe { out.write(report) };
            Code::Ok
        }
        None => {
            // SAFETY: the block is ours alone.
            unsafe { addr_of_mut!((*block).mark).write(0) };
            Code::Internal
        }
    }
}

#[unsafe(no_mangle)]
extern "C" fn heft_loads_size() -> usize {
    const { assert!(size_of::<LoadsBlock>() <= SIZE_MAX && align_of::<LoadsBlock>() <= 8) };
    size_of::<LoadsBlock>()
}

/// Makes an empty ledger with the values `usual` of the machine; none if they are unknown.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses.
unsafe fn init(
    memory: *mut c_void,
    bytes: usize,
    usual: Option<Settings>,
    target: f64,
    pause: f64,
    abi: u32,
) -> Code {
    let block = memory.cast::<LoadsBlock>();
    if memory.is_null() {
        return Code::Null;
    }
    if abi != abi::sum() {
        return Code::OtherHeader;
    }
    if bytes < size_of::<LoadsBlock>() || !block.is_aligned() {
        return Code::Memory;
    }
    // SAFETY: the block is large enough, aligned, and ours alone; a plain number may be written over anything.
    unsafe { addr_of_mut!((*block).mark).write(0) };
    let Some(loads) = usual.and_then(|usual| Loads::new(usual, target, pause)) else {
        return Code::Refused;
    };
    // SAFETY: as above; what was there before needs no destructor.
    unsafe {
        addr_of_mut!((*block).loads).write(loads);
        addr_of_mut!((*block).mark).write(LOADS_MARK);
    }
    Code::Ok
}

#[unsafe(no_mangle)]
unsafe extern "C" fn heft_loads_init_as(
    memory: *mut c_void,
    bytes: usize,
    rated: f64,
    target: f64,
    pause: f64,
    abi: u32,
) -> Code {
    let usual = Some(Settings::with_rated(rated));
    // SAFETY: the promise of the header.
    unsafe { init(memory, bytes, usual, target, pause, abi) }
}

/// The same for the machine of a description.
///
/// # Safety
/// As [`init`]; `numbers` is null or points to as many doubles as the machine has keys.
pub(super) unsafe fn init_for<M: Machine>(
    memory: *mut c_void,
    bytes: usize,
    numbers: *const f64,
    target: f64,
    pause: f64,
    abi: u32,
) -> Code {
    if abi != abi::sum() {
        return Code::OtherHeader;
    }
    // SAFETY: the caller's promise.
    let described = unsafe { settings::<M>(numbers) };
    let usual = guarded(|| described.ok().map(|d| M::loads(&d)));
    // SAFETY: the caller's promise.
    unsafe { init(memory, bytes, usual.flatten(), target, pause, abi) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn heft_loads_step(
    memory: *mut c_void,
    row: *const LoadsRow,
    out: *mut LoadReport,
) -> Code {
    if row.is_null() {
        return Code::Null;
    }
    // SAFETY: the promise of the header.
    unsafe { with_loads(memory, out, |loads| loads.step(&*row)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn heft_loads_next_truck(memory: *mut c_void, out: *mut LoadReport) -> Code {
    // SAFETY: the promise of the header.
    unsafe { with_loads(memory, out, Loads::next_truck) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn heft_loads_set_target(
    memory: *mut c_void,
    target: f64,
    out: *mut LoadReport,
) -> Code {
    let target = present(target);
    if !can_be_target(target) {
        return Code::Refused;
    }
    // SAFETY: the promise of the header.
    unsafe { with_loads(memory, out, |loads| loads.set_target(target)) }
}
