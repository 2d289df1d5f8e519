//! Detects columns that stay constant while the machine moves: no sensor measures them.

use recording::Finding;

/// Fewest moving rows for a verdict: some ten seconds.
const FEWEST: u32 = 1000;

/// Signals of which at least one must change in a machine that moves.
pub(super) struct Still<const N: usize> {
    names: [&'static str; N],
    unit: &'static str,
    /// The first values, and whether a later row differs.
    first: Option<[f64; N]>,
    changes: bool,
    rows: u32,
}

impl<const N: usize> Still<N> {
    pub(super) fn new(names: [&'static str; N], unit: &'static str) -> Self {
        Self {
            names,
            unit,
            first: None,
            changes: false,
            rows: 0,
        }
    }

    /// Takes a row in which the machine moves.
    pub(super) fn see(&mut self, values: [Option<f64>; N]) {
        if values.iter().all(Option::is_some) {
            let values = values.map(Option::unwrap_or_default);
            self.changes |= *self.first.get_or_insert(values) != values;
            self.rows += 1;
        }
    }

    /// The fault and its remedy, if no signal changes.
    pub(super) fn fault(&self) -> Option<Finding> {
        let first = self.first.filter(|_| !self.changes)?;
        let said = self.names.iter().zip(first);
        let said: Vec<_> = said
            .map(|(name, value)| format!("{name} is exactly {value} {}", self.unit))
            .collect();
        let none = self.names.map(|name| format!("`{name} = \"none\"`"));
        (self.rows >= FEWEST).then(|| {
            Finding::new(
                format!(
                    "{} in all {} rows in which the machine moves: nothing seems to measure it",
                    said.join(" and "),
                    self.rows,
                ),
                format!(
                    "check the sensor and its line of the signal map; where there is no such sensor, write {} there",
                    none.join(" and "),
                ),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    fn said(rows: u32, torques: fn(u32) -> [Option<f64>; 2]) -> Option<Finding> {
        let mut still = Still::new(["front_torque", "rear_torque"], "N m");
        (0..rows).for_each(|k| still.see(torques(k)));
        still.fault()
    }

    #[test]
    fn torques_that_never_change_are_named_and_one_axle_alone_may_be_idle() {
        let words = text(said(FEWEST, |_| [Some(0.0), Some(-1.5)]));
        assert!(
            words.contains("front_torque is exactly 0 N m and rear_torque is exactly -1.5 N m")
                && words.contains("`rear_torque = \"none\"`"),
            "{words}"
        );
        assert_eq!(said(FEWEST, |k| [Some(f64::from(k)), Some(0.0)]), None);
        assert_eq!(said(FEWEST, |_| [Some(0.0), None]), None);
        assert_eq!(said(FEWEST - 1, |_| [Some(0.0), Some(0.0)]), None);
    }
}
