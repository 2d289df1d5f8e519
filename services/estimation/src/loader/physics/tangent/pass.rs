//! One pass: speeds under the loads and grips of the stage before, with their derivatives.

use super::axle::Axles;
use super::stage::Stage;
use super::{K, Step, V, W, at, wheels};
use crate::ekf::add;
use crate::loader::layout::Layout;
use crate::pair::Pair;

impl Step<'_> {
    /// Returns the speeds under the loads and grips of the stage before; the `FIRST` pass starts from unit rows.
    #[inline(always)]
    pub(super) fn pass<const N: usize, const FIRST: bool>(&self, from: &Stage<N>) -> Stage<N> {
        let (m, dt, layout) = (self.machine, self.dt, Layout::of(N));
        let (per_mass, per_inertia) = (dt / m.mass, dt / m.axle_inertia);
        let radius_by_load = self.radius_by_load();
        let axles = self.axles(from.acceleration, &from.motion);
        let Axles { load, radius, .. } = axles;
        let free = radius * axles.spun;
        let ([front, rear], [grip_front, grip_rear]) = ((axles.grip * free).0, axles.grip.0);
        let push = front + rear - self.drag.value;
        let resistance = (grip_front + grip_rear) * per_mass + 1.0;
        let speed = (self.old[V] + push * per_mass) / resistance;
        let per_resistance = 1.0 / resistance;

        let mut speed_by = [0.0; N];
        speed_by[V] = per_resistance * (1.0 - per_mass * self.drag.by_speed);
        at(
            &mut speed_by,
            layout.spade_force,
            -per_mass * per_resistance,
        );
        let by_bias = -per_mass * per_resistance * self.drag.by_bias;
        at(&mut speed_by, layout.slope_bias, by_bias);
        let per = axles.per_denominator;
        // Derivatives of the speed by the conductances, by the free rim speeds.
        let alpha = (free - speed) * per_mass * per_resistance * per * per;
        let beta = axles.grip * per_mass * per_resistance;
        let bend = radius * (2.0 * per_inertia) * axles.conductance * axles.conductance;
        let by_load =
            alpha * (axles.by_load - bend * radius_by_load) + beta * axles.spun * radius_by_load;
        let by_radius = alpha * (axles.by_radius - bend) + beta * axles.spun;
        let (by_wheel, by_stiffness) = (
            beta * radius,
            alpha * axles.conductance / self.p.slip_stiffness,
        );
        let by_parameter = axles.parameters(by_load, by_radius, m);
        let along = alpha * axles.by_acceleration + by_load * load.by_acceleration;
        let (of_speed, of_wheel) = (alpha * axles.by_speed, alpha * axles.by_wheel);
        let (mut by_acceleration, mut by_motion) = (0.0, [0.0; 3]);
        for i in 0..2 {
            speed_by[W[i]] += by_wheel.0[i];
            speed_by[K] += by_stiffness.0[i];
            by_parameter.put(&mut speed_by, i);
            by_acceleration += along.0[i];
            by_motion[V] += of_speed.0[i];
            by_motion[W[i]] = of_wheel.0[i];
        }
        from.chain::<FIRST>(&mut speed_by, by_acceleration, by_motion, dt);

        let (Pair([front, rear]), [by_front, by_rear]) =
            self.wheel_speeds::<N, FIRST>(&axles, speed, &speed_by, from);
        Stage {
            acceleration: (speed - self.old[V]) / dt,
            motion: [speed, front, rear],
            by: [speed_by, by_front, by_rear],
        }
    }

    /// Returns the wheel speeds at a speed of the machine, and their derivatives.
    #[inline(always)]
    fn wheel_speeds<const N: usize, const FIRST: bool>(
        &self,
        axles: &Axles,
        speed: f64,
        speed_by: &[f64; N],
        from: &Stage<N>,
    ) -> (Pair, [[f64; N]; 2]) {
        let (m, dt) = (self.machine, self.dt);
        let per_inertia = dt / m.axle_inertia;
        let radius_by_load = self.radius_by_load();
        let (radius, conductance, per) = (axles.radius, axles.conductance, axles.per_denominator);
        let pushed = (radius * conductance * speed + self.torques) * per_inertia;
        let wheel = (wheels(&self.old) + pushed) * per;
        let by_conductance = radius * per_inertia * (-(radius * wheel) + speed) * per;
        let by_radius_alone = conductance * per_inertia * (-(radius * 2.0 * wheel) + speed) * per;
        let by_radius = by_radius_alone + by_conductance * axles.by_radius;
        let by_load = by_conductance * axles.by_load + by_radius_alone * radius_by_load;
        let by_parameter = axles.parameters(by_load, by_radius, m);
        let by_stiffness = by_conductance * conductance / self.p.slip_stiffness;
        let pull = radius * per_inertia * axles.grip;
        let by_acceleration =
            by_conductance * axles.by_acceleration + by_load * axles.load.by_acceleration;
        let (by_speed, by_wheel) = (
            by_conductance * axles.by_speed,
            by_conductance * axles.by_wheel,
        );
        let mut rows = [[0.0; N]; 2];
        for (i, row) in rows.iter_mut().enumerate() {
            row[W[i]] = per.0[i];
            row[K] = by_stiffness.0[i];
            by_parameter.put(row, i);
            add(row, pull.0[i], speed_by);
            let mut by_motion = [by_speed.0[i], 0.0, 0.0];
            by_motion[W[i]] = by_wheel.0[i];
            from.chain::<FIRST>(row, by_acceleration.0[i], by_motion, dt);
        }
        (wheel, rows)
    }
}
