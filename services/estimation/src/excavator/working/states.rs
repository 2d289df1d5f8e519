//! The states of the default estimator, by their places.

/// Number of states.
pub(super) const N: usize = 18;
/// Swing velocity.
pub(super) const W: usize = 0;
/// Payload.
pub(super) const M: usize = 1;
/// Torque offset.
pub(super) const OFFSET: usize = 2;
/// Viscous damping.
pub(super) const DAMPING: usize = 3;
/// Gain of the torque.
pub(super) const GAIN: usize = 4;
/// Loss of the drive.
pub(super) const LOSS: usize = 5;
/// Coulomb friction.
pub(super) const FRICTION: usize = 6;
/// Slope, two states.
pub(super) const SLOPE: usize = 7;
/// First moment of the upper body.
pub(super) const MOMENT: usize = 9;
/// Inertia of the upper body beyond the described one [kg m^2].
pub(super) const UPPER: usize = 10;
/// Mass of the bucket beyond the described one [kg].
pub(super) const BUCKET: usize = 11;
/// Masses of boom and arm over the described ones, minus 1.
pub(super) const LINKS: usize = 12;
/// The states before this one act on the motion; those that follow show in what is measured.
pub(super) const ACTING: usize = 13;

/// Delay of the velocity.
pub(super) const DELAY: usize = 13;
/// The states before this one show in the velocity; those that follow in the boom's moment alone.
pub(super) const SEEN: usize = 14;

/// Span of the boom's moment over the described one, minus 1.
pub(super) const SPAN: usize = 14;
/// Zero of the force of the boom's cylinders [N].
pub(super) const ZERO: usize = 15;
/// What is left of their friction, and of the drawing's moment [N].
pub(super) const REST: usize = 16;
/// What a stop leaves of the friction of their seals, beyond the described part of it [N].
pub(super) const HELD: usize = 17;

/// A vector of states.
pub(super) type Vector = [f64; N];
