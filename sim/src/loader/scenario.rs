//! The manoeuvres.
//!
//! In S5 the load rises vertically, as specified; with the sensors of an arm ([`Run::gauges`](super::Run::gauges)) it rises as
//! the arm lifts it.

use super::road::Surface;
use super::{lifts, loading};
use crate::named::scenarios;

/// Default payload of a load cycle [kg].
const LOAD_CYCLE_PAYLOAD: f64 = 1500.0;

scenarios! {
    /// What the machine does.
    Bumpy "bumpy" "a rough field track under constant drive, 10 s (S1)";
    Spading "spading" "the same with 600 N at the bucket for 2 s (S2)";
    Digging "digging" "the same with 11 kN at the bucket, real digging (S2d)";
    ConstantTorque "constant-torque" "asphalt, long stretches of constant torque, 20 s (S3)";
    AccelDecel "accel-decel" "asphalt, hard acceleration and braking, 30 s (S4)";
    LoadCycle "load-cycle" "drive, fill the bucket with 1500 kg, lift it, drive, 60 s (S5)";
    WorkCycle "work-cycle" "random acceleration and braking, 300 s (S6)";
    Dither "dither" "the work cycle with torque shifted between the axles, 300 s (S6x)";
    Cruise "cruise" "constant speed, from which the height cannot be learnt, 60 s";
    Loading "loading" "fill, carry, dump into a truck, again and again, 26 s each";
    Lifts "lifts" "stand and lift the arm slowly up and down, twice, to calibrate, 64 s";
}

/// Codes of the first scenarios.
const CODES: [&str; 8] = ["s1", "s2", "s2d", "s3", "s4", "s5", "s6", "s6x"];

impl Scenario {
    /// The scenario of a name or code, in upper or lower case.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.to_ascii_lowercase();
        let named = Self::all().find(|scenario| scenario.name() == text);
        named.or_else(|| Self::all().nth(CODES.iter().position(|code| *code == text)?))
    }

    /// Duration \[s\].
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

    /// Time from which errors count, when the estimates should have settled \[s\].
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

    /// Its road.
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

    /// Payload that it picks up, or carries from the start [kg].
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
