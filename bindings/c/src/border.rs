//! Memory and pointers of the caller: all the unsafe code of the library.
//!
//! Every function checks pointers for null, size and alignment, and whether `init` has initialised the memory
//! for this machine. The header states the other requirements.
#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_void};
use core::fmt::Write;
use core::mem::{align_of, size_of};
use core::ptr::addr_of_mut;

use crate::settings::{Unfit, can_take, completed, position, read, write};
use crate::table::{Answer, Machine, answer, sample};
use crate::{Excavator, Loader, abi};

mod loads;
mod state;

use state::{restore, save, state_size};

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
    /// A setting, the method or the columns cannot be used; `error` names it.
    Refused = -3,
    /// The memory holds no estimator of this machine.
    NotInitialised = -4,
    /// No key has this name.
    NoSuchKey = -5,
    /// An error of the library; the memory must be initialised again. Without an operating system the program stops instead.
    Internal = -6,
    /// The program was compiled with the header of another library.
    OtherHeader = -7,
}

impl Code {
    /// All codes, with their names in the header and their meanings.
    pub const ALL: [(Self, &'static str, &'static str); 8] = [
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
            "a mistake of the library, told on standard error; initialise the memory anew. Without an operating system it stops instead",
        ),
        (
            Self::OtherHeader,
            "HEFT_OTHER_HEADER",
            "the program was compiled with the header of another library: take both from one",
        ),
    ];
}

/// Enough memory for either machine on every platform, for arrays of a fixed size \[byte\].
pub const SIZE_MAX: usize = 34 * 1024;

/// Contents of the caller's memory.
#[repr(C)]
struct Block<M> {
    /// [`mark`] of the machine if `machine` is valid; any other value if not.
    mark: u64,
    text: Text,
    machine: M,
}

/// A text terminated by 0.
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
    /// Text beyond the capacity is dropped.
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

/// Marks initialised memory of this machine.
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
    abi: u32,
) -> Code {
    let block = memory.cast::<Block<M>>();
    if memory.is_null() {
        return Code::Null;
    }
    if abi != abi::sum() {
        return Code::OtherHeader;
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
            _ if columns >> (M::SIGNALS.len() - 1) != 0 => {
                write!(text, "columns have a bit that is no signal's")
            }
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
    // SAFETY: the mark shows that the machine is initialised; the row has as many doubles as signals.
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
/// As [`defaults`].
unsafe fn complete<M: Machine>(numbers: *mut f64) -> Code {
    if numbers.is_null() {
        return Code::Null;
    }
    // SAFETY: the caller's promise.
    match unsafe { settings::<M>(numbers) } {
        Ok(stated) => {
            // SAFETY: the caller's promise.
            write(&completed(stated), |i, number| unsafe {
                numbers.add(i).write(number);
            });
            Code::Ok
        }
        Err(_) => Code::Refused,
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

/// None if `body` panicked: a panic must not leave the library, where the profile unwinds (`bindings` does).
/// Without an operating system (`controller`) a panic ends in the panic handler.
#[cfg(any(feature = "std", test))]
fn guarded<T>(body: impl FnOnce() -> T) -> Option<T> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(body)).ok()
}

#[cfg(not(any(feature = "std", test)))]
fn guarded<T>(body: impl FnOnce() -> T) -> Option<T> {
    Some(body())
}

/// # Safety
/// `numbers` is null or points to as many doubles as the machine has signals.
unsafe fn clear<M: Machine>(numbers: *mut f64) -> Code {
    if numbers.is_null() {
        return Code::Null;
    }
    for i in 0..M::SIGNALS.len() {
        // SAFETY: the caller's promise.
        unsafe { numbers.add(i).write(f64::NAN) };
    }
    Code::Ok
}

#[unsafe(no_mangle)]
extern "C" fn heft_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn heft_abi() -> u32 {
    abi::sum()
}

/// The functions of one machine; `heft.h` describes them.
macro_rules! export {
    (
        $machine:ty, $size:ident, $init:ident, $step:ident, $error:ident, $defaults:ident, $set:ident, $clear:ident,
        $complete:ident, $state_size:ident, $save:ident, $restore:ident, $loads_init:ident
    ) => {
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
            abi: u32,
        ) -> Code {
            // SAFETY: the promise of the header.
            unsafe { init::<$machine>(memory, bytes, settings, method, columns, abi) }
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

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $clear(sample: *mut f64) -> Code {
            // SAFETY: the promise of the header.
            unsafe { clear::<$machine>(sample) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $complete(settings: *mut f64) -> Code {
            // SAFETY: the promise of the header.
            unsafe { complete::<$machine>(settings) }
        }

        #[unsafe(no_mangle)]
        extern "C" fn $state_size() -> usize {
            state_size::<$machine>()
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $save(
            memory: *const c_void,
            state: *mut c_void,
            bytes: usize,
        ) -> Code {
            // SAFETY: the promise of the header.
            unsafe { save::<$machine>(memory, state, bytes) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $restore(
            memory: *mut c_void,
            bytes: usize,
            state: *const c_void,
            state_bytes: usize,
        ) -> Code {
            // SAFETY: the promise of the header.
            unsafe { restore::<$machine>(memory, bytes, state, state_bytes) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $loads_init(
            memory: *mut c_void,
            bytes: usize,
            settings: *const f64,
            target: f64,
            pause: f64,
            abi: u32,
        ) -> Code {
            // SAFETY: the promise of the header.
            unsafe { loads::init_for::<$machine>(memory, bytes, settings, target, pause, abi) }
        }
    };
}

export!(
    Excavator,
    heft_excavator_size,
    heft_excavator_init_as,
    heft_excavator_step,
    heft_excavator_error,
    heft_excavator_defaults,
    heft_excavator_set,
    heft_excavator_clear,
    heft_excavator_complete,
    heft_excavator_state_size,
    heft_excavator_save,
    heft_excavator_restore,
    heft_excavator_loads_init_as
);
export!(
    Loader,
    heft_loader_size,
    heft_loader_init_as,
    heft_loader_step,
    heft_loader_error,
    heft_loader_defaults,
    heft_loader_set,
    heft_loader_clear,
    heft_loader_complete,
    heft_loader_state_size,
    heft_loader_save,
    heft_loader_restore,
    heft_loader_loads_init_as
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_at_the_border() {
        assert_eq!(guarded(|| 7), Some(7));
        assert_eq!(guarded(|| -> u32 { panic!("a mistake") }), None);
        // The library for other programs needs unwinding: its profile must not set `panic`.
        let profiles = include_str!("../../../Cargo.toml");
        let of = |name| {
            profiles
                .split_once(name)
                .and_then(|(_, rest)| rest.split_once("\n\n"))
        };
        let (bindings, _) = of("[profile.bindings]").expect("a profile");
        assert!(!bindings.contains("panic"), "{bindings}");
    }
}
