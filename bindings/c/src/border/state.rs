//! A state as bytes: saved before the power goes, restored by the same library.
//!
//! The memory of an estimator has no pointers, so its bytes are its state. They are valid only for the build that wrote
//! them; a head with its mark and a checksum precedes them.

use core::ffi::c_void;
use core::mem::size_of;
use core::ptr::{addr_of, addr_of_mut};

use super::{Block, Code, mark};
use crate::table::Machine;

/// Head of a state, before the bytes of the memory.
#[repr(C)]
struct Head {
    /// Which machine.
    mark: u64,
    /// Which build of the library.
    build: u64,
    /// Sum of the bytes that follow.
    sum: u64,
}

/// Sum of the sources, the compiler, the target and the profile: by `build.rs`.
const BUILD: u64 = match u64::from_str_radix(env!("HEFT_BUILD"), 16) {
    Ok(build) => build,
    Err(_) => panic!("build.rs writes 16 digits"),
};

pub(super) fn state_size<M>() -> usize {
    size_of::<Head>() + size_of::<Block<M>>()
}

/// FNV-1a of `length` bytes.
///
/// # Safety
/// `bytes` points to them.
unsafe fn sum(bytes: *const u8, length: usize) -> u64 {
    (0..length).fold(0xcbf2_9ce4_8422_2325, |sum: u64, i| {
        // SAFETY: the caller's promise. Volatile: some bytes lie between fields and were never written.
        let byte = unsafe { bytes.add(i).read_volatile() };
        (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// # Safety
/// `memory` is null or was given to `init`; `state` is null or points to `bytes` bytes. Nobody else uses them meanwhile.
pub(super) unsafe fn save<M: Machine>(
    memory: *const c_void,
    state: *mut c_void,
    bytes: usize,
) -> Code {
    let block = memory.cast::<Block<M>>();
    if memory.is_null() || state.is_null() {
        return Code::Null;
    }
    if !block.is_aligned() || bytes < state_size::<M>() {
        return Code::Memory;
    }
    // SAFETY: `init` wrote the mark, whatever the outcome.
    if unsafe { addr_of!((*block).mark).read() } != mark::<M>() {
        return Code::NotInitialised;
    }
    let length = size_of::<Block<M>>();
    // SAFETY: the state has room for the head and the block, which do not overlap with the memory.
    unsafe {
        let body = state.cast::<u8>().add(size_of::<Head>());
        body.copy_from_nonoverlapping(memory.cast(), length);
        state.cast::<Head>().write_unaligned(Head {
            mark: mark::<M>(),
            build: BUILD,
            sum: sum(body, length),
        });
    }
    Code::Ok
}

/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `state` is null or points to `state_bytes` bytes.
pub(super) unsafe fn restore<M: Machine>(
    memory: *mut c_void,
    bytes: usize,
    state: *const c_void,
    state_bytes: usize,
) -> Code {
    let block = memory.cast::<Block<M>>();
    let length = size_of::<Block<M>>();
    if memory.is_null() || state.is_null() {
        return Code::Null;
    }
    if !block.is_aligned() || bytes < length {
        return Code::Memory;
    }
    if state_bytes < state_size::<M>() {
        return Code::Refused;
    }
    // SAFETY: the state has a head and a block; the memory has room for it.
    unsafe {
        let head = state.cast::<Head>().read_unaligned();
        let body = state.cast::<u8>().add(size_of::<Head>());
        if head.mark != mark::<M>() || head.build != BUILD || head.sum != sum(body, length) {
            return Code::Refused;
        }
        memory.cast::<u8>().copy_from_nonoverlapping(body, length);
        // The text of an earlier refusal is no part of the state.
        addr_of_mut!((*block).text).write(super::Text::EMPTY);
    }
    Code::Ok
}
