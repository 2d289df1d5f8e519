//! Seeds in parallel, with a progress bar.

use crate::{Error, Options};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

/// The results of `run` for the seeds 1 to `options.seeds`, in their order. The bar on stderr shows only on a terminal.
///
/// # Errors
/// The first error of a run; [`Error::NoSeeds`] if no seed was run.
pub fn seeds<T: Send>(
    options: &Options,
    label: &str,
    run: impl Fn(u64) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let bar = bar(options.seeds as u64, label);
    let results = (1..=options.seeds as u64)
        .into_par_iter()
        .map(|seed| run(seed).inspect(|_| bar.inc(1)))
        .collect::<Result<Vec<_>, _>>()?;
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
