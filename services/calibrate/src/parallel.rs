//! Runs the same work for many items on all cores.

use std::cell::Cell;
use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

thread_local! {
    /// Whether this thread already runs such work: work within it runs sequentially.
    static AT_WORK: Cell<bool> = const { Cell::new(false) };
}

/// Results of `make` for 0 to `count`, in that order.
pub fn map<T: Send>(count: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    map_on(None, count, make)
}

/// Like [`map`], on this many threads; `None` for one on each core.
pub fn map_on<T: Send>(
    workers: Option<NonZeroUsize>,
    count: usize,
    make: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let cores = || thread::available_parallelism().ok();
    let workers = workers.or_else(cores).map_or(1, usize::from).min(count);
    if workers < 2 || AT_WORK.get() {
        return (0..count).map(make).collect();
    }
    let next = AtomicUsize::new(0);
    let work = || {
        AT_WORK.set(true);
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let numbers = numbers.take_while(|at| *at < count);
        let made: Vec<(usize, T)> = numbers.map(|at| (at, make(at))).collect();
        AT_WORK.set(false);
        made
    };
    let mut all = thread::scope(|scope| {
        // If the system grants fewer threads, the others do all the work.
        let other = |_| thread::Builder::new().spawn_scoped(scope, work).ok();
        let others: Vec<_> = (1..workers).filter_map(other).collect();
        let mut all = work();
        for other in others {
            all.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        all
    });
    all.sort_by_key(|(at, _)| *at);
    all.into_iter().map(|(_, made)| made).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_their_order_in_work_within_work_too() {
        let squares = |count: usize| (0..count).map(|at| at * at).collect::<Vec<_>>();
        assert_eq!(map(100, |at| at * at), squares(100));
        assert_eq!(map(0, |at| at), []);
        let nested = map(20, |count| map(count, |at| at * at));
        assert_eq!(nested, (0..20).map(squares).collect::<Vec<_>>());
    }

    #[test]
    fn nothing_is_made_twice() {
        let made = AtomicUsize::new(0);
        map(1000, |_| made.fetch_add(1, Ordering::Relaxed));
        assert_eq!(made.into_inner(), 1000);
    }

    #[test]
    #[should_panic = "the seventh"]
    fn a_panic_is_propagated() {
        map(20, |at| assert!(at != 7, "the seventh"));
    }
}
