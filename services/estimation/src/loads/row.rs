//! What the ledger reads: one estimate of any machine.

use crate::math::sqrt;
use crate::{CommonError, Quantity};

/// Source of the payload.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Witness {
    /// How the machine accelerates.
    #[default]
    Motion,
    /// Cylinder pressures.
    Pressure,
    /// Both, in one state.
    Both,
    /// A scale on the machine: its mass is measured.
    Scale,
    /// Nothing: it was seen to leave, and is what a load may be.
    Nothing,
}

impl Witness {
    /// All of them, in the order of their codes.
    pub const ALL: [Self; 5] = [
        Self::Motion,
        Self::Pressure,
        Self::Both,
        Self::Scale,
        Self::Nothing,
    ];

    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Pressure => "pressure",
            Self::Both => "motion and pressure",
            Self::Scale => "scale",
            Self::Nothing => "nothing",
        }
    }

    /// Code in messages.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// Shortest way from a truck to the pile, in the unit of [`Row::speed`]: an excavator swings it, a loader drives it, and pushes
    /// its bucket in for less \[rad, m\].
    pub(super) const fn trip(self) -> f64 {
        match self {
            Self::Motion | Self::Both | Self::Nothing => 0.35,
            Self::Pressure | Self::Scale => 3.0,
        }
    }
}

/// One estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Time of the measurement \[s\]; rows must increase.
    pub time: f64,
    /// Payload with its standard deviation; `None` where nothing is estimated \[kg\].
    pub payload: Option<Quantity>,
    /// Standard deviation of those errors of the payload that all loads share (span, zero, gain, description); `None`
    /// where the estimator does not tell them apart \[kg\].
    pub common_std: Option<f64>,
    /// Swing rate [rad/s] or driving speed [m/s], of any sign.
    pub speed: f64,
    /// The content is changing.
    pub changing: bool,
    /// The load hangs and swings: it is a pendulum, which no bucket drops.
    pub hangs: bool,
    /// The estimate may be believed.
    pub trusted: bool,
    /// Why not, in a code of whoever hands the row in; carried along.
    pub why: u32,
    /// Its source.
    pub witness: Witness,
    /// Which truck is loaded: another value begins another truck.
    pub truck: Option<f64>,
}

/// Beyond this a payload is no payload [kg].
const LIMIT: f64 = 1e7;
/// At least this share of a payload's variance is its own: pressures weigh without the scale of the swings.
const LEAST_OWN: f64 = 0.25;

/// Speed of a machine that moves [rad/s, m/s].
const MOVING: f64 = 0.05;

impl Row {
    /// The machine swings or drives.
    pub(super) fn moves(&self) -> bool {
        self.speed.abs() > MOVING
    }

    /// The payload, where it is a number with a standard deviation.
    pub(super) fn weighed(&self) -> Option<Quantity> {
        self.payload
            .filter(|p| p.value.abs() < LIMIT && p.std > 0.0 && p.std < LIMIT)
    }

    /// The payload without what all are off together.
    pub(super) fn own(&self, common: &CommonError) -> Option<Quantity> {
        let Quantity { value, std } = self.weighed()?;
        let variance = std * std;
        let own = (variance - common.variance(value)).max(LEAST_OWN * variance);
        Some(Quantity {
            value,
            std: sqrt(own),
        })
    }
}
