//! Why an estimate is not believed: the first cause that was found, by its code in messages and files.

/// A cause; the number is its code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// Nothing is wrong.
    #[default]
    None = 0,
    /// A required input is missing or too old.
    Missing = 1,
    /// The speed never changes.
    StuckSpeed = 2,
    /// The front wheel speed never changes.
    StuckFrontWheel = 3,
    /// The rear wheel speed never changes.
    StuckRearWheel = 4,
    /// The front torque never changes.
    StuckFrontTorque = 5,
    /// The rear torque never changes.
    StuckRearTorque = 6,
    /// The slope never changes.
    StuckSlope = 7,
    /// The specific force never changes.
    StuckAcceleration = 8,
    /// The innovations are larger than predicted, and no cause is known.
    Unexplained = 9,
    /// The speed comes later than a sensor may.
    Latency = 10,
    /// The slip stiffness is none that tyres have.
    Stiffness = 11,
    /// A deceleration that the torques do not explain: friction brakes, without a column that says so.
    Brakes = 12,
    /// The machine turns.
    Steering = 13,
    /// The slope does not fit the motion.
    Slope = 14,
    /// The torques do not fit the motion: gain, sign, or mass.
    Torque = 15,
    /// The load may have changed.
    Load = 16,
    /// Independent manoeuvres disagree by more than they claim.
    Disagreement = 17,
    /// An estimate is at its limit.
    AtLimit = 18,
    /// The process was started again: said by those who start it, not by an estimator.
    Restarted = 19,
    /// The axles turn alike: a locked centre drive, whose axle torques are not those that are told.
    Locked = 20,
}

impl Reason {
    /// Names by code.
    pub const NAMES: [&'static str; 21] = [
        "",
        "missing",
        "stuck speed",
        "stuck front wheel",
        "stuck rear wheel",
        "stuck front torque",
        "stuck rear torque",
        "stuck slope",
        "stuck acceleration",
        "unexplained",
        "latency",
        "stiffness",
        "brakes",
        "steering",
        "slope",
        "torque",
        "load",
        "disagreement",
        "limit",
        "restarted",
        "locked drive",
    ];

    /// The name in tables; empty for none.
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The cause of a stuck signal, in the order of the watched signals.
    pub(super) fn stuck(signal: usize) -> Self {
        [
            Self::StuckSpeed,
            Self::StuckFrontWheel,
            Self::StuckRearWheel,
            Self::StuckFrontTorque,
            Self::StuckRearTorque,
            Self::StuckSlope,
            Self::StuckAcceleration,
        ][signal.min(6)]
    }
}
