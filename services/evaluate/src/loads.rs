//! Comparison of the ledger's loads with the true ones.

use std::collections::BTreeSet;

use estimation::HALF_WIDTH_95;
use estimation::loads::{Ledger, Load, Row, Settings};

/// Least load, as a share of a full bucket.
pub const LOAD: f64 = 0.3;

/// Sums over loads.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// True loads.
    pub all: usize,
    /// Number of them that the ledger found.
    pub found: usize,
    /// Further loads that left the bucket by the ledger only.
    invented: usize,
    trusted: usize,
    covered: usize,
    /// Sum of squared errors [full buckets^2].
    squares: f64,
}

impl Tally {
    /// Adds the counts of another tally.
    pub fn add(&mut self, other: &Self) {
        self.all += other.all;
        self.found += other.found;
        self.invented += other.invented;
        self.trusted += other.trusted;
        self.covered += other.covered;
        self.squares += other.squares;
    }

    fn load(&mut self, truth: f64, load: Option<&Load>, rated: f64) {
        self.all += 1;
        let Some(load) = load else { return };
        let error = (load.weight.kg - truth).abs();
        self.found += 1;
        self.trusted += usize::from(load.trusted);
        self.covered += usize::from(error <= HALF_WIDTH_95 * load.weight.std);
        self.squares += (error / rated).powi(2);
    }

    /// Share of the true loads that the ledger found.
    pub fn found(&self) -> Option<f64> {
        share(self.found, self.all)
    }

    /// Invented loads of the ledger, as a share of the true ones.
    pub fn invented(&self) -> Option<f64> {
        share(self.invented, self.all)
    }

    /// Share of the true loads that are trusted.
    pub fn trusted(&self) -> Option<f64> {
        share(self.trusted, self.all)
    }

    /// Share of the found loads whose 95 % interval holds the truth.
    pub fn covered(&self) -> Option<f64> {
        share(self.covered, self.found)
    }

    /// Root mean square of the errors of the found loads [full buckets].
    pub fn rms(&self) -> Option<f64> {
        rms(self.squares, self.found)
    }
}

/// A share, `None` of nothing.
pub fn share(part: usize, of: usize) -> Option<f64> {
    (of > 0).then(|| part as f64 / of as f64)
}

/// Root of a mean square, `None` of nothing.
pub fn rms(squares: f64, count: usize) -> Option<f64> {
    (count > 0).then(|| (squares / count as f64).sqrt())
}

/// A true load: its time in the bucket \[s\], and its largest content \[kg\].
#[derive(Debug, PartialEq)]
struct True {
    from: f64,
    to: f64,
    kg: f64,
}

/// A ledger and the true loads.
pub struct Book {
    ledger: Ledger,
    /// The ledger's latest state of each load.
    loads: Vec<Load>,
    truths: Vec<True>,
    /// The load that is in the bucket now.
    open: Option<True>,
    rated: f64,
}

impl Book {
    /// A book for a machine with this rated payload \[kg\].
    pub fn new(rated: f64) -> Self {
        Self {
            ledger: Ledger::new(Settings::with_rated(rated)),
            loads: Vec::new(),
            truths: Vec::new(),
            open: None,
            rated,
        }
    }

    /// Takes a row of estimates with the true payload \[kg\].
    pub fn row(&mut self, row: &Row, payload: f64) {
        let load = self.ledger.step(row).load;
        self.note(load);
        if payload > LOAD * self.rated {
            let load = self.open.get_or_insert(True {
                from: row.time,
                to: row.time,
                kg: payload,
            });
            load.kg = load.kg.max(payload);
        } else if let Some(load) = self.open.take() {
            self.truths.push(True {
                to: row.time,
                ..load
            });
        }
    }

    fn note(&mut self, load: Option<Load>) {
        let Some(load) = load else { return };
        self.loads.retain(|known| known.number != load.number);
        self.loads.push(load);
    }

    /// Compares each true load that left the bucket with the load of the ledger at that time.
    pub fn judge(mut self) -> Tally {
        let last = self.ledger.finish().load;
        self.note(last);
        let mut tally = Tally::default();
        let mut taken = BTreeSet::new();
        for truth in &self.truths {
            let during =
                |l: &&Load| l.filled < truth.to && l.dumped.is_some_and(|t| t > truth.from);
            // Of several candidates, the one whose time of dumping is closest to the true one.
            let apart = |l: &Load| l.dumped.map_or(f64::INFINITY, |t| (t - truth.to).abs());
            let candidates = self.loads.iter().filter(during);
            // A load of the ledger matches one true load only, however long it lasts.
            let candidates = candidates.filter(|l| !taken.contains(&l.number));
            let load = candidates.min_by(|a, b| apart(a).total_cmp(&apart(b)));
            taken.extend(load.map(|l| l.number));
            tally.load(truth.kg, load, self.rated);
        }
        let dumped = self.loads.iter().filter(|l| l.dumped.is_some());
        tally.invented = dumped.filter(|l| !taken.contains(&l.number)).count();
        tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimation::Quantity;

    #[test]
    fn true_loads_are_those_that_leave_the_bucket() {
        let mut book = Book::new(1000.0);
        let payloads = [0.0, 500.0, 900.0, 880.0, 20.0, 0.0, 700.0];
        for (i, payload) in (0..).zip(payloads) {
            let row = Row {
                time: f64::from(i),
                ..Row::default()
            };
            book.row(&row, payload);
        }
        let (from, to, kg) = (1.0, 4.0, 900.0);
        assert_eq!(book.truths, [True { from, to, kg }]);
        let tally = book.judge();
        assert_eq!((tally.all, tally.found), (1, 0), "nothing was weighed");
        assert_eq!((tally.found(), tally.rms()), (Some(0.0), None));
    }

    /// The tally of phases with true content, estimated content and duration \[kg, kg, s\].
    fn judged(phases: &[(f64, f64, u32)]) -> Tally {
        let mut book = Book::new(1000.0);
        let mut time = 0.0;
        for &(truth, shown, seconds) in phases {
            for _ in 0..100 * seconds {
                time += 0.01;
                let row = Row {
                    time,
                    payload: Some(Quantity {
                        value: shown,
                        std: 15.0,
                    }),
                    trusted: true,
                    ..Row::default()
                };
                book.row(&row, truth);
            }
        }
        book.judge()
    }

    #[test]
    fn a_load_of_the_ledger_that_is_two_is_found_once() {
        let tally = judged(&[
            (0.0, 0.0, 2),
            (900.0, 900.0, 4),
            (0.0, 900.0, 1),
            (880.0, 890.0, 4),
            (0.0, 0.0, 4),
        ]);
        assert_eq!((tally.all, tally.found, tally.invented), (2, 1, 0));
    }

    #[test]
    fn a_load_that_the_ledger_has_twice_is_invented_once() {
        let tally = judged(&[
            (0.0, 0.0, 2),
            (900.0, 900.0, 2),
            (900.0, 0.0, 2),
            (900.0, 880.0, 2),
            (0.0, 0.0, 2),
        ]);
        assert_eq!((tally.all, tally.found, tally.invented), (1, 1, 1));
        assert_eq!((tally.invented(), tally.covered()), (Some(1.0), Some(1.0)));
    }
}
