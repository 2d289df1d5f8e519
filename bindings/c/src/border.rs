//! Memory and pointers of the caller: all the unsafe code of the library.
//!
//! Every function checks what can be checked (null, size, alignment, whether the memory was made
//! by `init` for this machine) and says the rest in the header.
#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_void};
use core::fmt::Write;
use core::mem::{align_of, size_of};
use core::ptr::addr_of_mut;

use estimation::loads::LoadReport;

use crate::loads::{Loads, LoadsRow, can_be_target};
use crate::settings::{Unfit, can_take, position, read, write};
use crate::table::{Answer, Machine, answer, present, sample};
use crate::{Excavator, Loader};

/// What a function returns.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// Done.
    Ok = 0,
    /// A pointer is null.
    Null = -1,
    /// The memory is too small, or not aligned to 8 bytes.
    Memory = -2,
    /// A setting, the method or the columns cannot be used; `error` tells which.
    Refused = -3,
    /// The memory holds no estimator of this machine.
    NotInitialised = -4,
    /// No key has this name.
    NoSuchKey = -5,
    /// A mistake of the library; the memory must be initialised anew.
    Internal = -6,
}

impl Code {
    /// All codes, with their names in the header and what they say.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Ok, "HEFT_OK", "done"),
        (Self::Null, "HEFT_NULL", "a pointer is null"),
        (
            Self::Memory,
            "HEFT_MEMORY",
            "the memory is too small, or not aligned to 8 bytes",
        ),
        (
            Self::Refused,
            "HEFT_REFUSED",
            "a setting, the method or the columns cannot be used; the error text tells which",
        ),
        (
            Self::NotInitialised,
            "HEFT_NOT_INITIALISED",
            "the memory holds no estimator of this machine",
        ),
        (Self::NoSuchKey, "HEFT_NO_SUCH_KEY", "no key has this name"),
        (
            Self::Internal,
            "HEFT_INTERNAL",
            "a mistake of the library; initialise the memory anew",
        ),
    ];
}

/// Enough memory for either machine on every platform, for arrays of a fixed size \[byte\].
pub const SIZE_MAX: usize = 32 * 1024;

/// What the caller's memory holds.
#[repr(C)]
struct Block<M> {
    /// [`mark`] of the machine where `machine` is one; anything else where it is not.
    mark: u64,
    text: Text,
    machine: M,
}

/// Words with a 0 at the end.
#[repr(C)]
struct Text {
    bytes: [u8; 184],
    length: u64,
}

impl Text {
    const EMPTY: Self = Self {
        bytes: [0; 184],
        length: 0,
    };
}

impl Write for Text {
    /// What does not fit is left out.
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for byte in text.bytes() {
            let at = self.length as usize;
            if at + 1 < self.bytes.len() {
                self.bytes[at] = byte;
                self.length += 1;
            }
        }
        Ok(())
    }
}

/// Tells initialised memory of this machine from any other.
fn mark<M: Machine>() -> u64 {
    let name = M::NAME
        .bytes()
        .fold(0, |all: u64, byte| all * 31 + u64::from(byte));
    0x6865_6674_0000_0000 ^ name
}

fn size<M>() -> usize {
    const { assert!(size_of::<Block<M>>() <= SIZE_MAX && align_of::<Block<M>>() <= 8) };
    size_of::<Block<M>>()
}

/// The numbers behind a pointer, or the defaults of the machine.
///
/// # Safety
/// `numbers` is null or points to as many doubles as the machine has keys.
unsafe fn settings<M: Machine>(numbers: *const f64) -> Result<M::Settings, Unfit> {
    if numbers.is_null() {
        return Ok(M::Settings::default());
    }
    // SAFETY: the caller's promise.
    read(|i| unsafe { numbers.add(i).read() })
}

/// # Safety
/// `memory` is null or points to `size` bytes that nobody else uses; `numbers` as for [`settings`].
unsafe fn init<M: Machine>(
    memory: *mut c_void,
    bytes: usize,
    numbers: *const f64,
    method: u32,
    columns: u32,
) -> Code {
    let block = memory.cast::<Block<M>>();
    if memory.is_null() {
        return Code::Null;
    }
    if bytes < size::<M>() || !block.is_aligned() {
        return Code::Memory;
    }
    // SAFETY: the block is large enough, aligned, and ours alone.
    let (at_mark, at_text, at_machine) = unsafe {
        (
            addr_of_mut!((*block).mark),
            addr_of_mut!((*block).text),
            addr_of_mut!((*block).machine),
        )
    };
    // SAFETY: as above; a plain number and plain bytes may be written over anything.
    unsafe {
        at_mark.write(0);
        at_text.write(Text::EMPTY);
    }
    let mut text = Text::EMPTY;
    // SAFETY: the caller's promise.
    let settings = unsafe { settings::<M>(numbers) };
    let made = guarded(|| {
        let report = match (missing::<M>(columns), settings) {
            (Some(group), _) => write!(text, "columns lack {}", group[0]),
            (None, Err(unfit)) => write!(text, "{unfit}"),
            (None, Ok(settings)) => match M::new(&settings, method as usize, columns) {
                Ok(machine) => return Some(machine),
                Err(error) => write!(text, "{error}"),
            },
        };
        let _ = report;
        None
    });
    match made {
        Some(Some(machine)) => {
            // SAFETY: as above; what was there before needs no destructor.
            unsafe {
                at_machine.write(machine);
                at_mark.write(mark::<M>());
            }
            Code::Ok
        }
        Some(None) => {
            // SAFETY: as above.
            unsafe { at_text.write(text) };
            Code::Refused
        }
        None => Code::Internal,
    }
}

/// The first group of signals of which `columns` has none.
fn missing<M: Machine>(columns: u32) -> Option<&'static [&'static str]> {
    let there = |name: &&str| {
        let signals = M::SIGNALS.iter().skip(1);
        let found = signals.enumerate().find(|(_, signal)| signal.name == *name);
        found.is_some_and(|(i, _)| columns & (1 << i) != 0)
    };
    let mut groups = M::REQUIRED.iter().copied();
    groups.find(|group| !group.iter().any(there))
}

/// # Safety
/// `memory` is null or was given to `init`; `row` is null or points to as many doubles as the
/// machine has signals; `out` is null or points to an answer. Nobody else uses them meanwhile.
unsafe fn step<M: Machine, const N: usize>(
    memory: *mut c_void,
    row: *const f64,
    out: *mut Answer<N>,
) -> Code {
    const { assert!(N == M::VALUES.len()) };
    let block = memory.cast::<Block<M>>();
    if memory.is_null() || row.is_null() || out.is_null() {
        return Code::Null;
    }
    if !block.is_aligned() {
        return Code::Memory;
    }
    // SAFETY: `init` wrote the mark, whatever the outcome.
    if unsafe { addr_of_mut!((*block).mark).read() } != mark::<M>() {
        return Code::NotInitialised;
    }
    // SAFETY: the mark says that the machine is there; the row has as many doubles as signals.
    let (machine, row) = unsafe {
        (
            &mut (*block).machine,
            core::slice::from_raw_parts(row, M::SIGNALS.len()),
        )
    };
    match guarded(|| answer::<M, N>(&machine.step(&sample::<M>(row)))) {
        Some(answer) => {
            // SAFETY: the caller's promise.
            unsafe { out.write(answer) };
            Code::Ok
        }
        None => {
            // SAFETY: the block is ours alone.
            unsafe { addr_of_mut!((*block).mark).write(0) };
            Code::Internal
        }
    }
}

/// # Safety
/// `numbers` is null or points to as many doubles as the machine has keys.
unsafe fn defaults<M: Machine>(numbers: *mut f64) -> Code {
    if numbers.is_null() {
        return Code::Null;
    }
    // SAFETY: the caller's promise.
    write(&M::Settings::default(), |i, number| unsafe {
        numbers.add(i).write(number);
    });
    Code::Ok
}

/// # Safety
/// As [`defaults`]; `name` is null or a C string.
unsafe fn set<M: Machine>(numbers: *mut f64, name: *const c_char, number: f64) -> Code {
    if numbers.is_null() || name.is_null() {
        return Code::Null;
    }
    // SAFETY: the caller's promise.
    match position::<M::Settings>(unsafe { CStr::from_ptr(name) }.to_bytes()) {
        Some(i) if !can_take::<M::Settings>(i, number) => Code::Refused,
        Some(i) => {
            // SAFETY: the caller's promise.
            unsafe { numbers.add(i).write(number) };
            Code::Ok
        }
        None => Code::NoSuchKey,
    }
}

/// # Safety
/// `memory` is null or was given to `init`.
unsafe fn error<M: Machine>(memory: *const c_void) -> *const c_char {
    let block = memory.cast::<Block<M>>();
    if memory.is_null() || !block.is_aligned() {
        return c"".as_ptr();
    }
    // SAFETY: `init` wrote the text, whatever the outcome.
    unsafe { core::ptr::addr_of!((*block).text.bytes).cast() }
}

/// Tells initialised memory of loads from any other.
const LOADS_MARK: u64 = 0x6865_6674_6c6f_6164;

/// What the caller's memory holds where it counts loads.
#[repr(C)]
struct LoadsBlock {
    /// [`LOADS_MARK`] where `loads` is there.
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
    // SAFETY: the mark says that the loads are there.
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

#[unsafe(no_mangle)]
unsafe extern "C" fn heft_loads_init(
    memory: *mut c_void,
    bytes: usize,
    rated: f64,
    target: f64,
    pause: f64,
) -> Code {
    let block = memory.cast::<LoadsBlock>();
    if memory.is_null() {
        return Code::Null;
    }
    if bytes < size_of::<LoadsBlock>() || !block.is_aligned() {
        return Code::Memory;
    }
    // SAFETY: the block is large enough, aligned, and ours alone; a plain number may be written over anything.
    unsafe { addr_of_mut!((*block).mark).write(0) };
    let Some(loads) = Loads::new(rated, target, pause) else {
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

/// Nothing if `body` panicked: a panic must not cross the border. Without an operating system a
/// panic ends in the panic handler.
#[cfg(any(feature = "std", test))]
fn guarded<T>(body: impl FnOnce() -> T) -> Option<T> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(body)).ok()
}

#[cfg(not(any(feature = "std", test)))]
fn guarded<T>(body: impl FnOnce() -> T) -> Option<T> {
    Some(body())
}

/// The functions of one machine; `heft.h` describes them.
macro_rules! export {
    ($machine:ty, $size:ident, $init:ident, $step:ident, $error:ident, $defaults:ident, $set:ident) => {
        #[unsafe(no_mangle)]
        extern "C" fn $size() -> usize {
            size::<$machine>()
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $init(
            memory: *mut c_void,
            bytes: usize,
            settings: *const f64,
            method: u32,
            columns: u32,
        ) -> Code {
            // SAFETY: the promise of the header.
            unsafe { init::<$machine>(memory, bytes, settings, method, columns) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $step(
            memory: *mut c_void,
            sample: *const f64,
            estimate: *mut Answer<{ <$machine as Machine>::VALUES.len() }>,
        ) -> Code {
            // SAFETY: the promise of the header.
            unsafe { step::<$machine, _>(memory, sample, estimate) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $error(memory: *const c_void) -> *const c_char {
            // SAFETY: the promise of the header.
            unsafe { error::<$machine>(memory) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $defaults(settings: *mut f64) -> Code {
            // SAFETY: the promise of the header.
            unsafe { defaults::<$machine>(settings) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $set(settings: *mut f64, key: *const c_char, value: f64) -> Code {
            // SAFETY: the promise of the header.
            unsafe { set::<$machine>(settings, key, value) }
        }
    };
}

export!(
    Excavator,
    heft_excavator_size,
    heft_excavator_init,
    heft_excavator_step,
    heft_excavator_error,
    heft_excavator_defaults,
    heft_excavator_set
);
export!(
    Loader,
    heft_loader_size,
    heft_loader_init,
    heft_loader_step,
    heft_loader_error,
    heft_loader_defaults,
    heft_loader_set
);
