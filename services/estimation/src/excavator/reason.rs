//! Why an estimate is not trusted, or what the machine does beside its description.

/// A cause, by its code in the messages. The codes never change their meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// Nothing speaks against the description.
    #[default]
    None,
    /// The ground is inclined.
    Slope,
    /// The drive loses torque.
    Loss,
    /// The Coulomb friction is not the described one.
    Friction,
    /// The torque's gain is not 1.
    Gain,
    /// Velocity and torque do not come together.
    Delay,
    /// The torque has an offset.
    Offset,
    /// The damping is not the described one.
    Damping,
    /// The motion does not follow the model, whatever its constants are.
    Unexplained,
    /// Manoeuvres disagree by more than they claim.
    Disagreement,
    /// The estimate is at the end of its range.
    Limit,
    /// The bucket may hold something else than before.
    Content,
    /// A sensor repeats one value.
    Frozen,
    /// A sensor seems to have the other sign.
    Sign,
    /// The method cannot tell the inertia of a machine that is not calibrated.
    Method,
    /// The process was started again: said by those who start it, not by an estimator.
    Restarted,
    /// A joint angle has jumped further than a joint moves.
    Jump,
    /// Damping, friction or an emptied bucket speak of another torque, velocity or posture than is measured.
    Contradiction,
    /// The moment of the boom wavers while it stands: the load hangs on a rope, or sloshes.
    Hanging,
    /// The bucket weighs more, or less, than the described one.
    Attachment,
}

impl Reason {
    /// All, in the order of their codes.
    pub const ALL: [Self; 20] = [
        Self::None,
        Self::Slope,
        Self::Loss,
        Self::Friction,
        Self::Gain,
        Self::Delay,
        Self::Offset,
        Self::Damping,
        Self::Unexplained,
        Self::Disagreement,
        Self::Limit,
        Self::Content,
        Self::Frozen,
        Self::Sign,
        Self::Method,
        Self::Restarted,
        Self::Jump,
        Self::Contradiction,
        Self::Hanging,
        Self::Attachment,
    ];

    /// Code in the messages.
    pub fn code(self) -> u32 {
        self as u32
    }

    /// The reason of a code; `None` for one that is not known.
    pub fn of(code: u32) -> Self {
        Self::ALL.get(code as usize).copied().unwrap_or_default()
    }

    /// Name in every output; empty where there is no reason.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Slope => "slope",
            Self::Loss => "losses",
            Self::Friction => "friction",
            Self::Gain => "gain",
            Self::Delay => "delay",
            Self::Offset => "offset",
            Self::Damping => "damping",
            Self::Unexplained => "unexplained",
            Self::Disagreement => "disagreement",
            Self::Limit => "limit",
            Self::Content => "content",
            Self::Frozen => "frozen",
            Self::Sign => "sign",
            Self::Method => "method",
            Self::Restarted => "restarted",
            Self::Jump => "jump",
            Self::Contradiction => "contradiction",
            Self::Hanging => "hanging",
            Self::Attachment => "attachment",
        }
    }

    /// The cause in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Slope => "the ground seems inclined",
            Self::Loss => "the swing drive seems to lose torque",
            Self::Friction => "the friction differs from the described one",
            Self::Gain => "the torque's gain seems not to be 1",
            Self::Delay => "velocity and torque do not come together",
            Self::Offset => "the torque seems to have an offset",
            Self::Damping => "the damping differs from the described one",
            Self::Unexplained => "the motion does not follow the model",
            Self::Disagreement => "swings disagree by more than they claim",
            Self::Limit => "the estimate is at the end of its range",
            Self::Content => "the bucket's content may have changed",
            Self::Frozen => "a sensor repeats one value",
            Self::Sign => "a sensor seems to have the other sign",
            Self::Method => {
                "this method cannot tell the inertia of a machine that is not calibrated"
            }
            Self::Restarted => "the service was started again",
            Self::Jump => "a joint angle has jumped further than a joint moves",
            Self::Contradiction => {
                "an emptied bucket or the friction contradicts what a sensor says"
            }
            Self::Hanging => "the load hangs or swings",
            Self::Attachment => "the bucket weighs otherwise than described",
        }
    }
}
