//! A limit of memory: what asks for more than an input may cost gets none, and ends.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// What one input may cost at most [bytes].
const LIMIT: usize = 256 << 20;
/// What it may leave behind [bytes]: names and tables that are made once.
const KEPT: usize = 1 << 20;
/// How long it may take to give back the rest.
const PATIENCE: Duration = Duration::from_secs(10);

static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(usize::MAX);

/// The system's allocator with a limit; a program that fuzzes makes it its own.
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

/// Runs one input under the limit, in a program whose allocator is [`Limited`]. Who asks for more aborts the process.
///
/// # Errors
/// More than 1 MB is not given back.
pub fn limited(work: impl FnOnce()) -> Result<(), String> {
    let before = USED.load(Relaxed);
    MOST.store(before.saturating_add(LIMIT), Relaxed);
    work();
    MOST.store(usize::MAX, Relaxed);
    // Another thread, of a server, may hold some of it for a moment.
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
