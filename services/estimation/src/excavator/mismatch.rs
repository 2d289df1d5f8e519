//! Mismatches between the data and the description of an excavator, in words.

/// A mismatch between data and description.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mismatch {
    /// The velocity is in degrees per second.
    Degrees,
    /// The velocity is in revolutions per minute.
    Revolutions,
    /// The joint angles are in degrees.
    AngleDegrees,
    /// Pitch and roll of the ground are in degrees.
    SlopeDegrees,
    /// Torque and acceleration have opposite signs.
    Sign,
    /// The torque is in kilonewton metres, or the machine has this many times the described inertia.
    Kilonewtons(f64),
    /// The torque is in meganewton metres.
    Meganewtons,
    /// Boom and arm are exchanged.
    Exchanged,
    /// Angles of arm or bucket lie outside the range of the joint.
    Beyond {
        /// The arm's do.
        arm: bool,
        /// The bucket's do.
        bucket: bool,
    },
    /// Angles of arm or bucket are measured against the horizontal.
    Absolute {
        /// The arm's are.
        arm: bool,
        /// The bucket's are.
        bucket: bool,
    },
    /// The machine has this many times the described inertia.
    Size(f64),
}

impl core::fmt::Display for Mismatch {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Size(ratio) => {
                f.write_str("data and machine file are of different machines: the torque moves ")?;
                return if *ratio < 0.1 {
                    write!(f, "1/{:.0} of the described inertia", ratio.recip())
                } else {
                    write!(f, "{ratio:.2} times the described inertia")
                };
            }
            Self::Degrees => "swing_velocity seems to be in degrees per second",
            Self::Revolutions => "swing_velocity seems to be in revolutions per minute",
            Self::AngleDegrees => "the joint angles seem to be in degrees",
            Self::SlopeDegrees => "pitch and roll of the ground seem to be in degrees",
            Self::Kilonewtons(_) => {
                "swing_torque seems to be in kN m: the machine accelerates a thousand times more than it"
            }
            Self::Meganewtons => {
                "swing_torque seems to be in MN m: the machine accelerates a million times more than it"
            }
            Self::Sign => "swing_torque and swing_velocity seem to have opposite signs",
            Self::Exchanged => {
                "boom_angle and arm_angle seem to be exchanged: the boom points down and the arm up in all swings"
            }
            Self::Beyond { arm: true, bucket: true } => {
                "arm_angle and bucket_angle seem to have the other sign, or another zero: both turn up beyond the line of the link before"
            }
            Self::Beyond { arm: true, .. } => {
                "arm_angle seems to have the other sign, or another zero: the arm turns up beyond the line of the boom"
            }
            Self::Beyond { .. } => {
                "bucket_angle seems to have the other sign, or another zero: the bucket turns up beyond the line of the arm"
            }
            Self::Absolute { arm: true, bucket: true } => {
                "arm_angle and bucket_angle seem absolute, to the horizontal: each moves along with the link before it"
            }
            Self::Absolute { arm: true, .. } => {
                "arm_angle seems absolute, to the horizontal: each moves along with the link before it"
            }
            Self::Absolute { .. } => {
                "bucket_angle seems absolute, to the horizontal: each moves along with the link before it"
            }
        })
    }
}
