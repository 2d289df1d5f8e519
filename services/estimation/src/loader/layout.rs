//! Position of each quantity in the state of a filter and among its measurements.
//!
//! | states | x |
//! |---|---|
//! | all | v, w_f, w_r, K, h, lam |
//! | 8 | .., d_f, d_r |
//! | 10 | .., F_x, d_f, d_r, b |
//! | 9 | those of 8, tau |
//! | 12 | those of 10, e, tau |
//!
//! The measurements are v, w_f, w_r and the specific force. The first three have the positions of their states.

use core::ops::Range;

/// Speed v [m/s].
pub(super) const SPEED: usize = 0;
/// Front wheel speed w_f [rad/s].
pub(super) const FRONT_WHEEL: usize = 1;
/// Rear wheel speed w_r [rad/s].
pub(super) const REAR_WHEEL: usize = 2;
/// Slip stiffness K.
pub(super) const SLIP_STIFFNESS: usize = 3;
/// Height h of the centre of gravity [m].
pub(super) const CG_HEIGHT: usize = 4;
/// Share lam of the weight in front.
pub(super) const CG_RATIO: usize = 5;
/// Height and ratio, as a [`Centre`](super::load::mass_step::Centre) has them.
pub(super) const CENTRE: [usize; 2] = [CG_HEIGHT, CG_RATIO];

/// The states that not every filter has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Spade force F_x beside the measured one [N].
    pub spade_force: Option<usize>,
    /// Relative errors d_f, d_r of the rolling radii.
    pub radii: Option<[usize; 2]>,
    /// Slope bias b [rad].
    pub slope_bias: Option<usize>,
    /// Delay tau of the speed [s].
    pub speed_delay: Option<usize>,
    /// Error e of the load sensitivity of the rolling radii.
    pub load_sensitivity: Option<usize>,
}

impl Layout {
    /// Layout of a filter with this number of states.
    pub const fn of(states: usize) -> Self {
        let (spade_force, radii, slope_bias) = match states {
            10..=12 => (Some(6), Some([7, 8]), Some(9)),
            8 | 9 => (None, Some([6, 7]), None),
            _ => (None, None, None),
        };
        Self {
            spade_force,
            radii,
            slope_bias,
            speed_delay: match states {
                9 => Some(8),
                12 => Some(11),
                _ => None,
            },
            load_sensitivity: if states == 12 { Some(10) } else { None },
        }
    }

    /// The measurements that are states themselves: the wheel speeds, and the speed unless it is late.
    pub const fn direct(self) -> Range<usize> {
        if self.speed_delay.is_some() {
            FRONT_WHEEL..REAR_WHEEL + 1
        } else {
            SPEED..REAR_WHEEL + 1
        }
    }
}

/// A value for each of the two quantities that have a verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Each<T> {
    /// Of the share of the weight in front.
    pub ratio: T,
    /// Of the height of the centre of gravity.
    pub height: T,
}

impl<T> Each<T> {
    /// From the values at their positions in the state.
    pub fn of(place: impl Fn(usize) -> T) -> Self {
        Self {
            ratio: place(CG_RATIO),
            height: place(CG_HEIGHT),
        }
    }
}

/// One value for each state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ByState {
    /// Of v, w_f, w_r.
    pub motion: [f64; 3],
    /// Of K, h, lam.
    pub parameters: [f64; 3],
    pub spade_force: f64,
    /// Of both radii.
    pub radius: f64,
    pub slope_bias: f64,
    pub speed_delay: f64,
    pub load_sensitivity: f64,
}

impl ByState {
    /// Returns the values at the positions of their states, without states that the filter does not have.
    #[inline(always)]
    pub fn state<const N: usize>(self) -> [f64; N] {
        let layout = const { Layout::of(N) };
        let mut state = [self.radius; N];
        state[..SLIP_STIFFNESS].copy_from_slice(&self.motion);
        state[SLIP_STIFFNESS..=CG_RATIO].copy_from_slice(&self.parameters);
        for (place, value) in [
            (layout.spade_force, self.spade_force),
            (layout.slope_bias, self.slope_bias),
            (layout.speed_delay, self.speed_delay),
            (layout.load_sensitivity, self.load_sensitivity),
        ] {
            if let Some(i) = place {
                state[i] = value;
            }
        }
        state
    }
}
