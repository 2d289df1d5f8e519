//! Input of the ledger: one estimate of any machine.

use crate::math::sqrt;
use crate::{CommonError, Quantity};

/// Source of the payload.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Witness {
    /// Acceleration of the machine.
    #[default]
    Motion,
    /// Cylinder pressures.
    Pressure,
    /// Both, in one state.
    Both,
    /// A scale on the machine: its mass is measured.
    Scale,
    /// Nothing: the load was detected to leave; its weight is that of an average load.
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

    /// Shortest travel from a truck to the pile, in the unit of [`Row::speed`]: an excavator swings, a loader drives. A loader moves
    /// less to push its bucket in \[rad, m\].
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
    /// Those errors of the payload that are common to all loads (span, zero, gain, description); `None` where the estimator does not
    /// separate them.
    pub common: Option<CommonError>,
    /// Swing rate [rad/s] or driving speed [m/s], with any sign.
    pub speed: f64,
    /// Whether the content is changing.
    pub changing: bool,
    /// Whether the load is suspended and swings as a pendulum: no bucket drops it.
    pub hangs: bool,
    /// Whether the estimate is trusted.
    pub trusted: bool,
    /// Why it is not trusted, in a code of the caller; passed on.
    pub why: u32,
    /// Source of the payload.
    pub witness: Witness,
    /// Which truck is loaded: another value starts another truck.
    pub truck: Option<f64>,
}

/// Largest plausible payload and standard deviation [kg].
const LIMIT: f64 = 1e7;
/// Least share of a payload's variance that is independent: pressures do not depend on the gain of the swing motion.
const LEAST_OWN: f64 = 0.25;

/// Speed above which a machine moves [rad/s, m/s].
const MOVING: f64 = 0.05;

impl Row {
    /// Whether the machine swings or drives.
    pub fn moves(&self) -> bool {
        self.speed.abs() > MOVING
    }

    /// The row with the common errors of a lift arm that has weighed it, unless it states its own. A part of them may be known by now, so
    /// they are at most a share of the payload's variance.
    pub(super) fn with_common(&self, lift_arm: Option<CommonError>) -> Self {
        let weighed = self.weighed().filter(|_| self.witness == Witness::Pressure);
        let of_arm = lift_arm.zip(weighed).map(|(common, payload)| {
            common.at_most(sqrt(1.0 - LEAST_OWN) * payload.std, payload.value)
        });
        Self {
            common: self.common.or(of_arm),
            ..*self
        }
    }

    /// The payload, where it is a number with a standard deviation.
    pub(super) fn weighed(&self) -> Option<Quantity> {
        self.payload
            .filter(|p| p.value.abs() < LIMIT && p.std > 0.0 && p.std < LIMIT)
    }

    /// The payload without the variance of the common errors.
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
