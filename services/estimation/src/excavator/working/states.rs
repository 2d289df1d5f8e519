//! Indices of the states of the default estimator.

/// Number of states.
pub(super) const N: usize = 18;
/// Swing velocity [rad/s].
pub(super) const W: usize = 0;
/// Payload over 1 plus the gain error [kg].
pub(super) const M: usize = 1;
/// Offset of the measured torque [N m].
pub(super) const OFFSET: usize = 2;
/// Viscous damping [N m s/rad].
pub(super) const DAMPING: usize = 3;
/// Gain error of the torque: true over measured, minus 1.
pub(super) const GAIN: usize = 4;
/// Share of the torque that the drive loses.
pub(super) const LOSS: usize = 5;
/// Coulomb friction [N m].
pub(super) const FRICTION: usize = 6;
/// Slope of the ground, two states.
pub(super) const SLOPE: usize = 7;
/// First moment of the upper body [kg m].
pub(super) const MOMENT: usize = 9;
/// Inertia of the upper body beyond the described one [kg m^2].
pub(super) const UPPER: usize = 10;
/// Mass of the bucket beyond the described one [kg].
pub(super) const BUCKET: usize = 11;
/// Masses of boom and arm over the described ones, minus 1.
pub(super) const LINKS: usize = 12;
/// States before this index act on the motion; later ones appear in measurements only.
pub(super) const ACTING: usize = 13;

/// Delay of the velocity behind the torque [s].
pub(super) const DELAY: usize = 13;
/// States before this index appear in the velocity; later ones in the boom's moment only.
pub(super) const SEEN: usize = 14;

/// Span of the boom's moment over the described one, minus 1.
pub(super) const SPAN: usize = 14;
/// Zero of the force of the boom cylinders [N].
pub(super) const ZERO: usize = 15;
/// Rest of their friction, and of the drawing's moment [N].
pub(super) const REST: usize = 16;
/// Friction of their seals after a stop, beyond the described share of it [N].
pub(super) const HELD: usize = 17;

/// Vector of states.
pub(super) type Vector = [f64; N];
