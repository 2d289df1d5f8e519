//! One pass: speeds under the loads and grips of the stage before, with their derivatives.

use super::axle::Axle;
use super::stage::Stage;
use super::{K, Step, V, W, at};
use crate::ekf::add;
use crate::loader::layout::Layout;

impl Step<'_> {
    /// Returns the speeds under the loads and grips of the stage before; the `FIRST` pass starts from unit rows.
    #[inline(always)]
    pub(super) fn pass<const N: usize, const FIRST: bool>(&self, from: &Stage<N>) -> Stage<N> {
        let (m, dt, layout) = (self.machine, self.dt, Layout::of(N));
        let (per_mass, per_inertia) = (dt / m.mass, dt / m.axle_inertia);
        let stiffness = self.p.slip_stiffness;
        let radius_by_load = self.radius_by_load();
        let loads = self.loads(from.acceleration);
        let axle = |i: usize| self.axle(i, loads[i], from.acceleration, &from.motion);
        let axles = [axle(0), axle(1)];
        let [front, rear] = &axles;
        let free = [front.radius * front.spun, rear.radius * rear.spun];
        let push = front.grip * free[0] + rear.grip * free[1] - self.drag.value;
        let resistance = (front.grip + rear.grip) * per_mass + 1.0;
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
        let (mut by_acceleration, mut by_motion) = (0.0, [0.0; 3]);
        for (i, axle) in axles.iter().enumerate() {
            let Axle { load, radius, .. } = *axle;
            let per = axle.per_denominator;
            // Derivatives of the speed by the conductance, by the free rim speed.
            let alpha = per_mass * (free[i] - speed) * per_resistance * per * per;
            let beta = per_mass * axle.grip * per_resistance;
            let bend = 2.0 * per_inertia * radius * axle.conductance * axle.conductance;
            let by_load =
                alpha * (axle.by_load - bend * radius_by_load) + beta * axle.spun * radius_by_load;
            let by_radius = alpha * (axle.by_radius - bend) + beta * axle.spun;
            speed_by[W[i]] += beta * radius;
            speed_by[K] += alpha * axle.conductance / stiffness;
            axle.put(&mut speed_by, i, [by_load, by_radius], m);
            by_acceleration += alpha * axle.by_acceleration + by_load * load.by_acceleration;
            by_motion[V] += alpha * axle.by_speed;
            by_motion[W[i]] = alpha * axle.by_wheel;
        }
        from.chain::<FIRST>(&mut speed_by, by_acceleration, by_motion, dt);

        let mut by = [speed_by, [0.0; N], [0.0; N]];
        let mut motion = [speed, 0.0, 0.0];
        for (i, axle) in axles.iter().enumerate() {
            (motion[W[i]], by[W[i]]) = self.wheel::<N, FIRST>(i, axle, speed, &speed_by, from);
        }
        Stage {
            acceleration: (speed - self.old[V]) / dt,
            motion,
            by,
        }
    }

    /// Returns the speed of wheel `i` at a speed of the machine, and its derivatives.
    #[inline(always)]
    fn wheel<const N: usize, const FIRST: bool>(
        &self,
        i: usize,
        axle: &Axle,
        speed: f64,
        speed_by: &[f64; N],
        from: &Stage<N>,
    ) -> (f64, [f64; N]) {
        let (m, dt) = (self.machine, self.dt);
        let (per_inertia, stiffness) = (dt / m.axle_inertia, self.p.slip_stiffness);
        let radius_by_load = self.radius_by_load();
        let torque = [self.u.front_torque, self.u.rear_torque][i];
        let (radius, conductance, per) = (axle.radius, axle.conductance, axle.per_denominator);
        let wheel = (self.old[W[i]] + (radius * conductance * speed + torque) * per_inertia) * per;
        let by_conductance = per_inertia * radius * (speed - radius * wheel) * per;
        let by_radius_alone = per_inertia * conductance * (speed - 2.0 * radius * wheel) * per;
        let by_radius = by_radius_alone + by_conductance * axle.by_radius;
        let by_load = by_conductance * axle.by_load + by_radius_alone * radius_by_load;
        let mut row = [0.0; N];
        row[W[i]] = per;
        row[K] = by_conductance * conductance / stiffness;
        axle.put(&mut row, i, [by_load, by_radius], m);
        let pull = per_inertia * radius * axle.grip;
        let by_acceleration =
            by_conductance * axle.by_acceleration + by_load * axle.load.by_acceleration;
        add(&mut row, pull, speed_by);
        let mut by_motion = [by_conductance * axle.by_speed, 0.0, 0.0];
        by_motion[W[i]] = by_conductance * axle.by_wheel;
        from.chain::<FIRST>(&mut row, by_acceleration, by_motion, dt);
        (wheel, row)
    }
}
