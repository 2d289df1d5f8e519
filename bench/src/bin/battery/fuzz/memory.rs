//! A limit of memory: what asks for more than an input may cost gets none, and ends.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// What one input may cost at most [bytes].
const LIMIT: usize = 256 << 20;

static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

/// The system's allocator with a limit.
struct Limited;

// SAFETY: every call that is not refused is passed on to the system's allocator unchanged; null is what a
// refused allocation returns. Counting touches atomics only, which do not allocate.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if USED
            .fetch_add(layout.size(), Relaxed)
            .saturating_add(layout.size())
            > MOST.load(Relaxed)
        {
            USED.fetch_sub(layout.size(), Relaxed);
            return std::ptr::null_mut();
        }
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: `pointer` came from `System.alloc` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Limited = Limited;

/// Runs one input under the limit. Who asks for more aborts the process; what is not given back is an error.
pub fn limited(work: impl FnOnce()) -> Result<(), String> {
    let before = USED.load(Relaxed);
    MOST.store(before.saturating_add(LIMIT), Relaxed);
    work();
    MOST.store(usize::MAX, Relaxed);
    let kept = USED.load(Relaxed).saturating_sub(before);
    // Names and tables that are made once may stay.
    if kept > 1 << 20 {
        return Err(format!("{kept} bytes are not given back"));
    }
    Ok(())
}
