//! Combines signals that never come in the same row: merged tables, topics and frames with their own times.

use messages::Value;

use crate::Sensors;

/// Time for which a value is held beside those of later rows [s]: comparisons of units and signs tolerate the delay.
const HELD: f64 = 0.2;

/// The latest value of each signal.
#[derive(Debug)]
pub struct Together<S> {
    /// Field and bit of each, its latest value and the time of it.
    signals: Vec<(usize, u32, f64, f64)>,
    sample: S,
}

impl<S: Sensors> Default for Together<S> {
    fn default() -> Self {
        let never = |(index, bit)| (index, bit, 0.0, f64::NEG_INFINITY);
        Self {
            signals: crate::measured::<S>().map(never).collect(),
            sample: S::default(),
        }
    }
}

impl<S: Sensors> Together<S> {
    /// A sample completed by values measured shortly before it.
    pub fn with(&mut self, sample: &S) -> &S {
        self.sample = *sample;
        let (now, mut valid) = (sample.stamp().time, sample.bits_of("valid"));
        for (index, bit, value, time) in &mut self.signals {
            if valid & *bit != 0 {
                *value = sample.get(*index).map_or(f64::NAN, Value::as_f64);
                *time = now;
            } else if (0.0..HELD).contains(&(now - *time)) {
                self.sample.set(*index, Value::F64(*value));
                valid |= *bit;
            }
        }
        if let Some(index) = S::index("valid") {
            self.sample.set(index, Value::U32(valid));
        }
        &self.sample
    }
}

#[cfg(test)]
mod tests {
    use messages::{LoaderSensors, loader_bits as bits};

    use super::*;

    #[test]
    fn a_value_stands_beside_those_of_the_next_rows_and_not_for_long() {
        let mut together = Together::<LoaderSensors>::default();
        let row = |time, speed: Option<f64>, wheel: Option<f64>| {
            let mut row = LoaderSensors {
                speed: speed.unwrap_or_default(),
                front_wheel_speed: wheel.unwrap_or_default(),
                ..LoaderSensors::default()
            };
            row.stamp.time = time;
            let has = |there: bool, bit| if there { bit } else { 0 };
            row.valid =
                has(speed.is_some(), bits::SPEED) | has(wheel.is_some(), bits::FRONT_WHEEL_SPEED);
            row
        };
        let mut seen = |time, speed, wheel| {
            let seen = together.with(&row(time, speed, wheel));
            (seen.speed, seen.front_wheel_speed, seen.valid)
        };
        let both = bits::SPEED | bits::FRONT_WHEEL_SPEED;
        assert_eq!(seen(1.0, Some(2.0), None), (2.0, 0.0, bits::SPEED));
        assert_eq!(seen(1.1, None, Some(3.0)), (2.0, 3.0, both));
        assert_eq!(seen(1.15, Some(4.0), None), (4.0, 3.0, both));
        assert_eq!(
            seen(1.05, None, None),
            (0.0, 0.0, 0),
            "a clock that is set back"
        );
        assert_eq!(seen(1.34, None, None), (4.0, 0.0, bits::SPEED));
        assert_eq!(seen(1.36, None, None), (0.0, 0.0, 0));
    }
}
