//! Common parts of the messages of all simulators.

use messages::Message;

/// Columns and valid signals of a simulated sample.
pub(crate) struct Columns {
    pub columns: u32,
    pub valid: u32,
}

impl Columns {
    /// Columns that always exist.
    pub(crate) fn of(columns: u32) -> Self {
        Self { columns, valid: 0 }
    }

    /// The value of a signal; 0, and not valid, where it is missing. `None`: the machine has no such sensor.
    pub(crate) fn take(&mut self, value: Option<f64>, bit: u32) -> f64 {
        self.columns |= if value.is_some() { bit } else { 0 };
        let value = value.filter(|v| v.is_finite());
        self.valid |= if value.is_some() { bit } else { 0 };
        value.unwrap_or(0.0)
    }

    /// Sets a signal that consists of a bit only.
    pub(crate) fn flag(&mut self, on: bool, bit: u32) {
        self.columns |= bit;
        self.valid |= if on { bit } else { 0 };
    }
}

/// Sets number and time of a sample and its truth, and marks them as simulated.
pub(crate) fn mark(
    measured: &mut impl Message,
    known: &mut impl Message,
    sequence: &mut u64,
    time: f64,
) {
    for stamp in [measured.stamp_mut(), known.stamp_mut()] {
        stamp.sequence = *sequence;
        stamp.time = time;
    }
    measured.mark_simulated();
    known.mark_simulated();
    *sequence += 1;
}

/// Data sheet of cylinders, as `--set` takes it.
pub(crate) fn cylinder(table: &str, c: &sim::cylinder::Cylinder) -> Vec<String> {
    [
        ("count", c.count),
        ("head_area", c.head_area),
        ("rod_area", c.rod_area),
        ("base_distance", c.base_distance),
        ("rod_distance", c.rod_distance),
        ("angle", c.angle),
        ("friction", c.friction),
        // The simulated seals differ by a third.
        ("friction_std", 0.5 * c.friction),
    ]
    .map(|(key, value)| format!("{table}.{key}={value:?}"))
    .into()
}
