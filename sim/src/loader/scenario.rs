//! The manoeuvres.
//!
//! | name | code | what | duration, evaluated from |
//! |---|---|---|---|
//! | `bumpy` | S1 | a rough field track under constant drive | 10 s, 4 s |
//! | `spading` | S2 | the same with 600 N at the bucket for 2 s | 10 s, 4 s |
//! | `digging` | S2d | the same with 11 kN, as digging really takes | 10 s, 4 s |
//! | `constant-torque` | S3 | asphalt, long stretches of constant torque | 20 s, 6 s |
//! | `accel-decel` | S4 | asphalt, hard acceleration and braking | 30 s, 8 s |
//! | `load-cycle` | S5 | drive, fill the bucket with 1500 kg, lift it, drive | 60 s, 20 s |
//! | `work-cycle` | S6 | random acceleration and braking | 300 s, 100 s |
//! | `dither` | S6x | the same with the torque shifted between the axles | 300 s, 100 s |
//! | `loading` | | fill, carry, dump into a truck, again and again | 260 s, 26 s |
//! | `lifts` | | stands, and lifts its arm slowly up and down, twice: to calibrate | 64 s, 10 s |
//! | `cruise` | | up to 2.5 m/s, then constant speed | 60 s, 20 s |
//!
//! In S5 the load rises straight up, as specified; with the sensors of an arm ([`Run::gauges`](super::Run::gauges)) it rises as the arm lifts it.

use super::road::Surface;
use super::{lifts, loading};

/// Payload of a load cycle if the run does not say otherwise [kg].
const LOAD_CYCLE_PAYLOAD: f64 = 1500.0;

/// What the machine does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenario {
    /// S1.
    Bumpy,
    /// S2.
    Spading,
    /// S2d.
    Digging,
    /// S3.
    ConstantTorque,
    /// S4.
    AccelDecel,
    /// S5.
    LoadCycle,
    /// S6.
    WorkCycle,
    /// S6x.
    Dither,
    /// Constant speed.
    Cruise,
    /// Loads, dumped into a truck.
    Loading,
    /// Slow lifts.
    Lifts,
}

impl Scenario {
    /// Every scenario's name and what it is, in one line.
    pub const ALL: &[(&str, &str)] = &[
        (
            "bumpy",
            "a rough field track under constant drive, 10 s (S1)",
        ),
        ("spading", "the same with 600 N at the bucket for 2 s (S2)"),
        (
            "digging",
            "the same with 11 kN at the bucket, real digging (S2d)",
        ),
        (
            "constant-torque",
            "asphalt, long stretches of constant torque, 20 s (S3)",
        ),
        (
            "accel-decel",
            "asphalt, hard acceleration and braking, 30 s (S4)",
        ),
        (
            "load-cycle",
            "drive, fill the bucket with 1500 kg, lift it, drive, 60 s (S5)",
        ),
        ("work-cycle", "random acceleration and braking, 300 s (S6)"),
        (
            "dither",
            "the work cycle with torque shifted between the axles, 300 s (S6x)",
        ),
        (
            "cruise",
            "constant speed, from which the height cannot be learnt, 60 s",
        ),
        (
            "loading",
            "fill, carry, dump into a truck, again and again, 26 s each",
        ),
        (
            "lifts",
            "stand and lift the arm slowly up and down, twice, to calibrate, 64 s",
        ),
    ];

    /// The scenario of a name or code, in upper or lower case.
    pub fn parse(text: &str) -> Option<Self> {
        Some(match text.to_ascii_lowercase().as_str() {
            "bumpy" | "s1" => Self::Bumpy,
            "spading" | "s2" => Self::Spading,
            "digging" | "s2d" => Self::Digging,
            "constant-torque" | "s3" => Self::ConstantTorque,
            "accel-decel" | "s4" => Self::AccelDecel,
            "load-cycle" | "s5" => Self::LoadCycle,
            "work-cycle" | "s6" => Self::WorkCycle,
            "dither" | "s6x" => Self::Dither,
            "cruise" => Self::Cruise,
            "loading" => Self::Loading,
            "lifts" => Self::Lifts,
            _ => return None,
        })
    }

    /// The name that [`Self::parse`] reads.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    /// How long it takes \[s\].
    pub fn duration(self) -> f64 {
        match self {
            Self::Bumpy | Self::Spading | Self::Digging => 10.0,
            Self::ConstantTorque => 20.0,
            Self::AccelDecel => 30.0,
            Self::LoadCycle | Self::Cruise => 60.0,
            Self::WorkCycle | Self::Dither => 300.0,
            Self::Loading => 10.0 * loading::PERIOD,
            Self::Lifts => lifts::DURATION,
        }
    }

    /// When the estimates should have settled: errors count from here on \[s\].
    pub fn evaluated_from(self) -> f64 {
        match self {
            Self::Bumpy | Self::Spading | Self::Digging => 4.0,
            Self::ConstantTorque => 6.0,
            Self::AccelDecel => 8.0,
            Self::Lifts => 10.0,
            Self::LoadCycle | Self::Cruise => 20.0,
            Self::WorkCycle | Self::Dither => 100.0,
            Self::Loading => loading::PERIOD,
        }
    }

    /// Speed at the start [m/s].
    pub fn start_speed(self) -> f64 {
        if matches!(self, Self::Bumpy | Self::Spading | Self::Digging) {
            1.0
        } else {
            0.0
        }
    }

    /// The road it is driven on.
    pub fn surface(self) -> Surface {
        let (slope_amplitude_deg, roughness, length) = match self {
            Self::Bumpy | Self::Spading | Self::Digging => (4.0, 128e-6, 260.0),
            Self::ConstantTorque | Self::AccelDecel | Self::Cruise => (0.3, 16e-6, 260.0),
            Self::LoadCycle | Self::Loading => (0.8, 32e-6, 260.0),
            Self::WorkCycle | Self::Dither => (1.0, 32e-6, 1400.0),
            Self::Lifts => (0.0, 16e-6, 260.0),
        };
        Surface {
            slope_amplitude_deg,
            roughness,
            length,
        }
    }

    /// The payload it picks up, or carries from the start [kg].
    pub(super) fn payload(self, asked: Option<f64>) -> f64 {
        asked.unwrap_or(if self == Self::LoadCycle {
            LOAD_CYCLE_PAYLOAD
        } else {
            0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_and_code_is_read_back() {
        for (name, _) in Scenario::ALL {
            assert_eq!(Scenario::parse(name).map(Scenario::name), Some(*name));
        }
        assert_eq!(Scenario::parse("S2d"), Some(Scenario::Digging));
        assert_eq!(Scenario::parse("s7"), None);
    }
}
