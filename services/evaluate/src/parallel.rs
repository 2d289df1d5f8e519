//! Runs of many seeds in parallel, with a line that counts them.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use calibrate::parallel;

use crate::{Error, Options};

/// The results of `run` for the seeds 1 to `options.seeds`, in order. The line on stderr is shown only on a terminal.
///
/// # Errors
/// The first error of a run; [`Error::NoSeeds`] if no seed was run.
pub fn seeds<T: Send>(
    options: &Options,
    label: &str,
    run: impl Fn(u64) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let (count, failed) = (Count::new(options.seeds, label), AtomicBool::new(false));
    let results = parallel::map(options.seeds, |at| {
        // After an error, no further seed is started.
        let runs = !failed.load(Ordering::Relaxed);
        runs.then(|| {
            let result = run(at as u64 + 1);
            failed.fetch_or(result.is_err(), Ordering::Relaxed);
            count.one();
            result
        })
    });
    count.clear();
    let results: Vec<T> = results.into_iter().flatten().collect::<Result<_, _>>()?;
    if results.is_empty() {
        Err(Error::NoSeeds)
    } else {
        Ok(results)
    }
}

/// Number of finished seeds.
struct Count<'a> {
    label: &'a str,
    all: usize,
    done: AtomicUsize,
    start: Instant,
    is_shown: bool,
}

impl<'a> Count<'a> {
    fn new(all: usize, label: &'a str) -> Self {
        Self {
            label,
            all,
            done: AtomicUsize::new(0),
            start: Instant::now(),
            is_shown: std::io::stderr().is_terminal(),
        }
    }

    fn one(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.is_shown {
            let each = self.start.elapsed().as_secs_f64() / done as f64;
            let left = each * (self.all - done) as f64;
            eprint!(
                "\r{:40} {done}/{} seeds, {left:.0} s left\x1b[K",
                self.label, self.all
            );
        }
    }

    fn clear(&self) {
        if self.is_shown {
            eprint!("\r\x1b[K");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(seeds: usize) -> Options {
        Options {
            seeds,
            ..Options::default()
        }
    }

    #[test]
    fn results_keep_the_order_of_the_seeds() {
        assert_eq!(seeds(&of(50), "order", Ok), Ok((1..=50).collect()));
    }

    #[test]
    fn an_error_and_no_seeds_are_reported() {
        let fails = |_| Err::<u64, _>(Error::refused("no"));
        assert_eq!(seeds(&of(3), "error", fails), Err(Error::refused("no")));
        assert_eq!(seeds(&of(0), "none", Ok), Err(Error::NoSeeds));
    }
}
