//! Numbers that repeat exactly in many rows: marks of missing samples, far from all others, or a limit of the range.

/// Fewest rows with a mark.
const LEAST_ROWS: usize = 10;

/// Least distance of a mark from the other values, as a share of their range.
const APART: f64 = 0.5;

/// Fewest rows at a limit of the range, and their least share.
const LEAST_AT_END: usize = 50;
const OFTEN_AT_END: f64 = 0.02;

/// Largest distance of a limit from the next value, as a share of the whole range: above it the signal has few distinct values.
const NEAR: f64 = 0.005;

/// The values of a signal at one of their ends.
#[derive(Debug, Clone, Copy)]
struct End {
    /// 1 for the least value, -1 for the largest.
    sign: f64,
    /// The outermost value, its number of rows, and the next value; the values times the sign.
    first: f64,
    count: usize,
    next: f64,
}

impl End {
    fn of(sign: f64) -> Self {
        Self {
            sign,
            first: f64::INFINITY,
            count: 0,
            next: f64::INFINITY,
        }
    }

    fn see(&mut self, value: f64) {
        let value = self.sign * value;
        if value < self.first {
            (self.next, self.first, self.count) = (self.first, value, 1);
        } else if value == self.first {
            self.count += 1;
        } else if value < self.next {
            self.next = value;
        }
    }
}

/// Both ends of the values of a signal.
#[derive(Debug, Clone, Copy)]
pub struct Ends {
    least: End,
    largest: End,
    rows: usize,
}

impl Default for Ends {
    fn default() -> Self {
        Self {
            least: End::of(1.0),
            largest: End::of(-1.0),
            rows: 0,
        }
    }
}

impl Ends {
    /// Takes a value.
    pub fn see(&mut self, value: f64) {
        self.least.see(value);
        self.largest.see(value);
        self.rows += 1;
    }

    /// How many values were taken.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Limit of a signal's range and its number of rows, if the signal is cut there. A real motion that turns does not repeat exactly
    /// one value.
    pub fn cut(&self) -> Option<(f64, usize)> {
        let width = -self.largest.first - self.least.first;
        let is_cut = |end: &End| {
            end.count >= LEAST_AT_END
                && end.count as f64 >= OFTEN_AT_END * self.rows as f64
                && end.next - end.first < NEAR * width
                && end.first != 0.0
        };
        let found = [self.least, self.largest].into_iter().find(is_cut);
        found.map(|end| (end.sign * end.first, end.count))
    }

    /// A mark of missing samples and its number of rows: a repeated value far from all others.
    pub fn mark(&self) -> Option<(f64, usize)> {
        let marks = [(self.least, self.largest), (self.largest, self.least)];
        let found = marks.into_iter().find(|(end, other)| {
            let width = -other.first - end.next;
            end.count >= LEAST_ROWS && width > 0.0 && end.next - end.first > APART * width
        });
        found.map(|(end, _)| (end.sign * end.first, end.count))
    }
}

/// Largest number of marks of one logger: one for each width of its numbers.
const MOST: usize = 4;

/// Marks found in any signal. The same number in another signal is a mark there too, even if it could be a measurement.
#[derive(Debug, Clone, Default)]
pub struct Shared {
    marks: Vec<f64>,
}

impl Shared {
    /// Takes a mark.
    pub fn learn(&mut self, value: f64) {
        if self.marks.len() < MOST && !self.is_mark(value) {
            self.marks.push(value);
        }
    }

    /// Whether a value is a mark.
    pub fn is_mark(&self, value: f64) -> bool {
        self.marks.contains(&value)
    }
}

/// Rows of a signal with a mark of another signal, and the mark.
#[derive(Debug, Clone, Copy, Default)]
pub struct Count {
    value: f64,
    rows: usize,
}

impl Count {
    /// Takes a value.
    pub fn see(&mut self, value: f64, shared: &Shared) {
        if shared.is_mark(value) {
            self.value = value;
            self.rows += 1;
        }
    }

    /// The mark, and its number of rows.
    pub fn mark(&self) -> Option<(f64, usize)> {
        (self.rows >= LEAST_ROWS).then_some((self.value, self.rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_that_ends_within_the_motion_is_distinguished_from_motions_and_from_coarse_signals() {
        let torque =
            |k: i32| 3e4 * (0.013 * f64::from(k)).sin() + 9e3 * (0.31 * f64::from(k)).sin();
        let cut = |change: fn(f64) -> f64| {
            let mut ends = Ends::default();
            (0..4000).for_each(|k| ends.see(change(torque(k))));
            ends.cut()
        };
        assert_eq!(cut(|x| x), None);
        assert_eq!(cut(|x| x.max(0.0)), None, "one way only");
        assert_eq!(cut(|x| (x / 2e3).round() * 2e3), None, "few values");
        let (value, rows) = cut(|x| x.min(2e4)).expect("an end");
        assert!((value - 2e4).abs() < 1e-9 && rows > 500, "{value} {rows}");
        assert_eq!(
            cut(|x| x.clamp(-2e4, 1e5)).map(|(value, _)| value),
            Some(-2e4)
        );
    }

    #[test]
    fn what_one_signal_cannot_be_is_a_mark_in_another() {
        let (mut shared, mut count) = (Shared::default(), Count::default());
        let torque = |k: i32| {
            if k % 5 == 0 {
                -9999.0
            } else {
                300.0 * f64::from(k - 50)
            }
        };
        (0..100).for_each(|k| count.see(torque(k), &shared));
        assert_eq!(count.mark(), None);
        shared.learn(-9999.0);
        (0..100).for_each(|k| count.see(torque(k), &shared));
        assert_eq!(count.mark(), Some((-9999.0, 20)));
        // More values than marks can be: the rest are not stored.
        (0..50).for_each(|k| shared.learn(f64::from(k)));
        assert!(!shared.is_mark(40.0));
    }

    fn mark(values: impl Iterator<Item = f64>) -> Option<(f64, usize)> {
        let mut ends = Ends::default();
        values.for_each(|value| ends.see(value));
        ends.mark()
    }

    #[test]
    fn a_value_far_from_all_others_in_many_rows_is_a_mark_and_states_and_ends_of_a_motion_are_none()
    {
        let motion = || (0..500).map(|i| 0.9 + 0.3 * (0.02 * f64::from(i)).sin());
        let with = |value: f64, every: usize| {
            motion()
                .enumerate()
                .map(move |(i, x)| if i % every == 0 { value } else { x })
        };
        assert_eq!(mark(with(-1.0, 10)), Some((-1.0, 50)));
        assert_eq!(mark(with(9999.0, 7)), Some((9999.0, 72)));
        assert_eq!(mark(with(0.4, 7)), None, "as near as a motion goes");
        assert_eq!(mark(with(9999.0, 100)), None, "five rows");
        assert_eq!(mark(motion()), None);
        assert_eq!(mark(motion().map(|x| x.clamp(0.8, 1.0))), None, "held");
        assert_eq!(
            mark((0..500).map(|i| f64::from(i / 100 % 2))),
            None,
            "states"
        );
        assert_eq!(mark([0.0; 500].into_iter()), None);
    }
}
