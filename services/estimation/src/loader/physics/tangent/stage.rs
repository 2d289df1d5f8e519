//! Intermediate result of the step with its derivatives, and its initial value, the rigid machine.

use super::{Step, V, W, at};
use crate::ekf::add;
use crate::loader::layout::Layout;

/// Intermediate result of the step: the acceleration at which the loads are taken, and the motion with its derivatives.
///
/// Before the first pass the motion is the old one, whose rows are unit rows; the first row is then that of the acceleration.
pub(super) struct Stage<const N: usize> {
    pub acceleration: f64,
    pub motion: [f64; 3],
    pub by: [[f64; N]; 3],
}

impl<const N: usize> Stage<N> {
    /// Adds to a row what depends on this stage's acceleration and motion; after a pass a = (v - v_old)/dt.
    #[inline(always)]
    pub fn chain<const FIRST: bool>(
        &self,
        row: &mut [f64; N],
        by_acceleration: f64,
        by_motion: [f64; 3],
        dt: f64,
    ) {
        if FIRST {
            add(row, by_acceleration, &self.by[0]);
            for j in 0..3 {
                row[j] += by_motion[j];
            }
            return;
        }
        let per_dt = by_acceleration / dt;
        row[V] -= per_dt;
        add(row, by_motion[V] + per_dt, &self.by[V]);
        for j in W {
            if by_motion[j] != 0.0 {
                add(row, by_motion[j], &self.by[j]);
            }
        }
    }
}

impl Step<'_> {
    /// Initial stage: the rigid machine.
    #[inline(always)]
    pub(super) fn start<const N: usize>(&self) -> Stage<N> {
        let (m, layout) = (self.machine, Layout::of(N));
        let errors = [self.p.front_radius_error, self.p.rear_radius_error];
        let torques = [self.u.front_torque, self.u.rear_torque];
        let radii = errors.map(|d| (d + 1.0) * m.wheel_radius);
        let acceleration = m.rigid_acceleration(radii[0], radii[1], self.u, self.drag.value);
        let per_radius = radii.map(|r| 1.0 / r);
        let spin = per_radius.map(|per| m.axle_inertia * per * per);
        let per_mass = 1.0 / (spin[0] + spin[1] + m.mass);
        let mut by = [0.0; N];
        by[V] = -self.drag.by_speed * per_mass;
        at(&mut by, layout.spade_force, -per_mass);
        at(&mut by, layout.slope_bias, -self.drag.by_bias * per_mass);
        for i in 0..2 {
            let along = 2.0 * acceleration * spin[i] - torques[i] * per_radius[i];
            let radius = m.wheel_radius * per_radius[i] * along * per_mass;
            at(&mut by, layout.radii.map(|place| place[i]), radius);
        }
        Stage {
            acceleration,
            motion: self.old,
            by: [by, [0.0; N], [0.0; N]],
        }
    }
}
