//! Machines of independent simulators: their recordings, the settings of a competent user, and the criteria for an estimator.

use estimation::loader::Sample;
use serde_json::{Map, Value};
use statistics::judge::Tally;

use super::golden;
use super::table::Row;

/// The machines of a file in `golden`, by the names of their recordings.
pub fn described(file: &str) -> Map<String, Value> {
    let text = std::fs::read_to_string(golden(file)).expect("the settings");
    serde_json::from_str(&text).expect("JSON")
}

/// The stated settings of a machine, `KEY=VALUE` each, as `--set` takes them.
pub fn sets(stated: &Value) -> Vec<String> {
    let stated = stated.as_object().expect("settings by key");
    stated
        .iter()
        .map(|(key, value)| format!("{key}={value}"))
        .collect()
}

/// The sample in a row of a loader's recording.
pub fn loader_sample(row: &Row) -> Sample {
    Sample {
        time: row.number("t"),
        speed: row.measured("speed"),
        front_wheel_speed: row.measured("front_wheel_speed"),
        rear_wheel_speed: row.measured("rear_wheel_speed"),
        front_torque: row.measured("front_torque"),
        rear_torque: row.measured("rear_torque"),
        slope: row.measured("slope"),
        acceleration: row.measured("acceleration"),
        mass: row.measured("mass"),
        spade_force_z: row.measured("spade_force_z"),
        articulation: row.measured("articulation"),
        yaw_rate: row.measured("yaw_rate"),
        brake: row.measured("brake") == Some(1.0),
        ..Sample::default()
    }
}

/// Shares of trusted and of wrong rows, and coverage over all time.
pub fn scores(tally: &Tally) -> String {
    format!(
        "trusted {:.2} wrong {:.3} rms {:.2} % covered {:.3}",
        tally.trusted(),
        tally.wrong(),
        tally.rms(),
        tally.covered()
    )
}

/// Requirements on an estimator for a machine, from 0 to 1.
pub struct Limits {
    /// Least trusted share of the time in motion.
    pub trusted: f64,
    /// Least share of all time in which the 95 % interval holds the truth.
    pub covered: f64,
}

impl Limits {
    /// Whether they hold, and at most one trusted row of twenty is wrong.
    pub fn hold(&self, tally: &Tally) -> bool {
        tally.trusted() >= self.trusted && tally.wrong() <= 0.05 && tally.covered() >= self.covered
    }
}
