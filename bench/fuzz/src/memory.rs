//! A limit of memory: an allocation beyond the limit of one input fails, and the process aborts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Largest memory for one input [bytes].
const LIMIT: usize = 256 << 20;
/// Largest memory that remains allocated after it [bytes]: names and tables that are created once.
const KEPT: usize = 1 << 20;
/// Longest time until the rest is freed.
const PATIENCE: Duration = Duration::from_secs(10);

static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

/// The system's allocator with a limit; a program that fuzzes uses it as its global allocator.
pub struct Limited;

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
            // This write does not allocate. The caller reports the size that it requested.
            let _ = std::io::stderr()
                .write_all(b"an input costs more than 256 MB, all threads together\n");
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

/// Runs one input under the limit, in a program whose allocator is [`Limited`]. A larger allocation aborts the process.
///
/// # Errors
/// More than 1 MB is not freed.
pub fn limited(work: impl FnOnce()) -> Result<(), String> {
    let before = USED.load(Relaxed);
    MOST.store(before.saturating_add(LIMIT), Relaxed);
    work();
    MOST.store(usize::MAX, Relaxed);
    // Another thread of a server may still hold some memory.
    let begun = Instant::now();
    while kept_since(before) > KEPT && begun.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(1));
    }
    match kept_since(before) {
        kept if kept > KEPT => Err(format!(
            "{kept} bytes are not given back after {PATIENCE:?}"
        )),
        _ => Ok(()),
    }
}

fn kept_since(before: usize) -> usize {
    USED.load(Relaxed).saturating_sub(before)
}
