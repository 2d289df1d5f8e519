//! Interleaved blocks: every contender runs one block, then every one the next, so that a change of clock or load affects all
//! equally.

use crate::problem::Filter;
use std::hint::black_box;
use std::time::Instant;

/// A timed filter.
pub struct Contender {
    /// Name in the table.
    pub name: &'static str,
    /// Runs some steps and returns their number.
    block: Box<dyn FnMut() -> u64>,
    /// Runs one step.
    single: Box<dyn FnMut()>,
}

impl Contender {
    /// One pass over the data; returns the number of steps.
    pub fn pass(&mut self) -> u64 {
        (self.block)()
    }

    /// One step.
    pub fn step(&mut self) {
        (self.single)();
    }
}

/// Times of one step \[ns\].
#[derive(Debug, Clone, Copy)]
pub struct Timing {
    /// The fastest block: the cost of the code without disturbance.
    pub min: f64,
    /// The middle block.
    pub median: f64,
}

/// Quantiles of single, separately timed calls \[ns\], including the cost of the clock.
#[derive(Debug, Clone, Copy)]
pub struct Tail {
    /// Half of the calls are faster.
    pub p50: f64,
    /// 99 in 100 are faster.
    pub p99: f64,
    /// 999 in 1000 are faster.
    pub p999: f64,
    /// The slowest call.
    pub max: f64,
}

#[inline(never)]
fn run<Z, F: Filter<Z, N>, const N: usize>(filter: &mut F, data: &[Z]) {
    for sample in data {
        filter.step(sample);
    }
}

/// A filter as a contender, running over its data repeatedly.
pub fn contender<F, Z: 'static, const N: usize>(name: &'static str, data: Vec<Z>) -> Contender
where
    F: Filter<Z, N> + Default + 'static,
{
    let (mut blocks, mut singles, samples) = (F::default(), F::default(), data.len() as u64);
    let data = std::rc::Rc::new(data);
    let (all, one) = (data.clone(), data);
    let mut next = 0;
    Contender {
        name,
        block: Box::new(move || {
            run(black_box(&mut blocks), black_box(&all));
            black_box(blocks.state());
            samples
        }),
        single: Box::new(move || {
            run(black_box(&mut singles), black_box(&one[next..=next]));
            black_box(singles.state());
            next = (next + 1) % one.len();
        }),
    }
}

/// A batch as a contender: `block` runs some steps of some machines and returns the number of machine steps.
pub fn custom(
    name: &'static str,
    block: impl FnMut() -> u64 + 'static,
    single: impl FnMut() + 'static,
) -> Contender {
    Contender {
        name,
        block: Box::new(block),
        single: Box::new(single),
    }
}

/// Times all contenders, block by block in turn; `block_us` is the approximate duration of a block \[us\].
pub fn interleaved(contenders: &mut [Contender], blocks: usize, block_us: f64) -> Vec<Timing> {
    let repeats: Vec<usize> = contenders
        .iter_mut()
        .map(|contender| repeats_for(contender, block_us))
        .collect();
    let mut times = vec![Vec::with_capacity(blocks); contenders.len()];
    for _ in 0..blocks {
        for ((contender, times), repeats) in contenders.iter_mut().zip(&mut times).zip(&repeats) {
            times.push(time(contender, *repeats));
        }
    }
    times
        .into_iter()
        .map(|mut times| {
            times.sort_unstable_by(f64::total_cmp);
            Timing {
                min: times[0],
                median: times[times.len() / 2],
            }
        })
        .collect()
}

/// Number of passes in a block; also warms up.
fn repeats_for(contender: &mut Contender, block_us: f64) -> usize {
    let mut per_step = time(contender, 1);
    for _ in 0..2 {
        per_step = per_step.min(time(contender, 1));
    }
    let steps = (contender.block)() as f64;
    ((block_us * 1e3) / (per_step * steps)).clamp(1.0, 10_000.0) as usize
}

/// Nanoseconds per step.
fn time(contender: &mut Contender, repeats: usize) -> f64 {
    let start = Instant::now();
    let mut steps = 0;
    for _ in 0..repeats {
        steps += (contender.block)();
    }
    start.elapsed().as_nanos() as f64 / steps as f64
}

/// Times calls one by one.
pub fn tail(contender: &mut Contender, calls: usize) -> Tail {
    let mut times: Vec<u64> = (0..calls)
        .map(|_| {
            let start = Instant::now();
            (contender.single)();
            start.elapsed().as_nanos() as u64
        })
        .collect();
    times.sort_unstable();
    let at = |quantile: f64| times[((calls - 1) as f64 * quantile) as usize] as f64;
    Tail {
        p50: at(0.5),
        p99: at(0.99),
        p999: at(0.999),
        max: at(1.0),
    }
}

/// Undisturbed cost of the rows of a recording \[ns\].
#[derive(Debug, Clone, Copy)]
pub struct Rows {
    /// Mean over the rows.
    pub mean: f64,
    /// The slowest row.
    pub worst: f64,
}

/// Times every row separately in several laps; returns the least time of each, minus the cost of the clock.
///
/// A disturbance does not affect the same row in all laps, so the least time is the row's own.
pub fn rows(contender: &mut Contender, rows: usize, laps: usize) -> Rows {
    let mut quickest = vec![f64::INFINITY; rows];
    for _ in 0..laps {
        for time in &mut quickest {
            let start = Instant::now();
            (contender.single)();
            *time = time.min(start.elapsed().as_nanos() as f64);
        }
    }
    let clock = (0..1000)
        .map(|_| Instant::now().elapsed().as_nanos() as f64)
        .fold(f64::INFINITY, f64::min);
    Rows {
        mean: quickest.iter().sum::<f64>() / rows as f64 - clock,
        worst: quickest.iter().copied().fold(0.0, f64::max) - clock,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_longer_step_takes_longer() {
        let spin = |turns: u64| {
            move || {
                (0..turns).for_each(|i| {
                    black_box(i);
                });
                1
            }
        };
        let mut contenders = [
            custom("short", spin(1_000), || ()),
            custom("long", spin(10_000), || ()),
        ];
        let times = interleaved(&mut contenders, 5, 10.0);
        assert!(times[1].min > 2.0 * times[0].min, "{times:?}");
        assert!(times.iter().all(|time| time.min <= time.median));
    }
}
