//! Unwraps times that count ticks in a register which overflows: milliseconds of 16 bits after 66 s, the
//! microseconds of a microcontroller's 32 bits after 72 min.

/// Widths of the registers \[bit\].
const WIDTHS: [i32; 2] = [16, 32];

/// Largest step over an overflow, as a multiple of the step before: rows may be lost there, and two
/// recordings in one table seldom end and begin so near to an overflow.
const STEPS: f64 = 10.0;

/// State of the counter.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    last: Option<f64>,
    step: f64,
    /// Ticks of all overflows.
    full: f64,
}

impl Counter {
    /// The ticks without overflows.
    pub(crate) fn count(&mut self, ticks: f64) -> f64 {
        if !ticks.is_finite() {
            return ticks;
        }
        let step = ticks - self.last.replace(ticks).unwrap_or(ticks);
        let is_count = |ticks: f64| ticks >= 0.0 && ticks.fract() == 0.0;
        let on = |full: &f64| (1.0..=STEPS * self.step).contains(&(step + full));
        let mut registers = WIDTHS.iter().map(|bits| 2_f64.powi(*bits));
        if step > 0.0 {
            self.step = step;
        } else if is_count(ticks) && is_count(ticks - step) {
            // The row before must be in the range of the register.
            let full = registers.find(on).filter(|full| ticks - step < *full);
            self.full += full.unwrap_or(0.0);
        }
        self.full + ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(ticks: &[f64]) -> Vec<f64> {
        let mut counter = Counter::default();
        ticks.iter().map(|ticks| counter.count(*ticks)).collect()
    }

    #[test]
    fn a_register_that_is_full_goes_on() {
        for full in [65_536.0, 4_294_967_296.0] {
            let ticks = [full - 25.0, full - 15.0, full - 5.0, 5.0, 15.0, 45.0];
            let on = [full + 5.0, full + 15.0, full + 45.0];
            assert_eq!(counted(&ticks)[3..], on);
            // Rows are lost at the overflow, and one has no time.
            let ticks = [full - 75.0, full - 65.0, f64::NAN, 15.0];
            assert_eq!(counted(&ticks)[3], full + 15.0);
        }
        let twice: Vec<f64> = (0..20_000).map(|k| f64::from(k * 10 % 65_536)).collect();
        assert_eq!(counted(&twice)[19_999], 199_990.0);
    }

    #[test]
    fn a_clock_that_is_set_back_and_another_recording_are_left_as_they_are() {
        for ticks in [
            [60_000.0, 60_010.0, 0.0, 10.0],
            [65_520.0, 65_530.0, 300.0, 310.0],
            [65_520.5, 65_530.5, 5.0, 15.0],
            [131_060.0, 131_066.0, 0.0, 10.0],
            [10.0, 20.0, 20.0, 10.0],
            [-20.0, -10.0, -65_540.0, 0.0],
        ] {
            assert_eq!(counted(&ticks), ticks);
        }
    }
}
