//! Seeds in parallel, with a progress bar.

use crate::{Error, Options};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// The results of `run` for the seeds 1 to `options.seeds`, in their order. When `options.stop` is set the
/// seeds not yet begun are left out. The bar on stderr shows only on a terminal.
///
/// # Errors
/// The first error of a run; [`Error::NoSeeds`] if no seed was run.
pub fn seeds<T: Send>(
    options: &Options,
    label: &str,
    run: impl Fn(u64) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let bar = bar(options.seeds as u64, label);
    let work = || {
        (1..=options.seeds as u64)
            .into_par_iter()
            .filter(|_| !options.stop.load(Ordering::Relaxed))
            .map(|seed| run(seed).inspect(|_| bar.inc(1)))
            .collect::<Result<Vec<_>, _>>()
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build();
    let results = pool.map_err(Error::refused)?.install(work)?;
    bar.finish_and_clear();
    if results.is_empty() {
        Err(Error::NoSeeds)
    } else {
        Ok(results)
    }
}

fn bar(length: u64, label: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:40} {bar:30} {pos}/{len} seeds, {eta} left");
    ProgressBar::new(length)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(label.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_the_order_of_the_seeds() {
        let options = Options {
            seeds: 50,
            ..Options::default()
        };
        assert_eq!(seeds(&options, "order", Ok), Ok((1..=50).collect()));
    }

    #[test]
    fn an_interrupted_evaluation_keeps_what_is_done() {
        let options = Options {
            seeds: 1000,
            threads: 1,
            ..Options::default()
        };
        let done = seeds(&options, "stop", |seed| {
            options.stop.fetch_or(seed == 5, Ordering::Relaxed);
            Ok(seed)
        });
        assert!(done.is_ok_and(|done| (1..1000).contains(&done.len())));
    }

    #[test]
    fn an_error_and_no_seeds_are_reported() {
        let fails = |_| Err::<u64, _>(Error::refused("no"));
        let options = Options {
            seeds: 3,
            ..Options::default()
        };
        assert_eq!(seeds(&options, "error", fails), Err(Error::refused("no")));
        let none = Options {
            seeds: 0,
            ..Options::default()
        };
        assert_eq!(seeds(&none, "none", Ok), Err(Error::NoSeeds));
    }
}
