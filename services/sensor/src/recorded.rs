//! Recorded samples as a source of messages.

use messages::{Message, Stamp};
use runtime::Source;

/// Plays rows once, in their order. Sequence numbers start at 0 as in any run; clock readings of an earlier run
/// are removed, the time of the data stays.
pub struct Recorded<S, T> {
    rows: Box<dyn Iterator<Item = (S, T)>>,
    sequence: u64,
}

impl<S, T> Recorded<S, T> {
    /// Plays `rows`.
    pub fn new(rows: impl Iterator<Item = (S, T)> + 'static) -> Self {
        Self {
            rows: Box::new(rows),
            sequence: 0,
        }
    }
}

impl<S: Message, T: Message> Source for Recorded<S, T> {
    type Sensors = S;
    type Truth = T;

    fn next(&mut self) -> Option<(S, T)> {
        let (mut sensors, mut truth) = self.rows.next()?;
        let stamp = Stamp {
            machine: sensors.stamp().machine,
            sequence: self.sequence,
            time: sensors.stamp().time,
            ..Stamp::default()
        };
        *sensors.stamp_mut() = stamp;
        *truth.stamp_mut() = stamp;
        *sensors.hops_mut() = Default::default();
        *truth.hops_mut() = Default::default();
        self.sequence += 1;
        Some((sensors, truth))
    }
}

#[cfg(test)]
mod tests {
    use messages::{ExcavatorSensors, ExcavatorTruth};

    use super::*;

    #[test]
    fn rows_come_in_order_with_numbers_from_0_and_without_old_clocks() {
        let row = |n: u64| {
            let mut sensors = ExcavatorSensors {
                swing_velocity: n as f64,
                ..Default::default()
            };
            sensors.stamp = Stamp {
                sequence: 7 * n,
                time: n as f64,
                measured_ns: 9,
                ..Default::default()
            };
            sensors.hops.sensor_ns = 5;
            (sensors, ExcavatorTruth::default())
        };
        let mut source = Recorded::new((0..3).map(row));
        for n in 0..3 {
            let (sensors, truth) = source.next().expect("three rows");
            assert_eq!(
                (sensors.stamp.sequence, sensors.swing_velocity),
                (n, n as f64)
            );
            assert_eq!(
                (sensors.stamp.time, sensors.stamp.measured_ns),
                (n as f64, 0)
            );
            assert_eq!((sensors.hops.sensor_ns, truth.stamp), (0, sensors.stamp));
        }
        assert!(source.next().is_none());
    }
}
