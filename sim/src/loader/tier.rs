//! Knowledge of the machine: exact in tier A, as of a real machine in tier B.

use super::plant::Machine;
use super::sensors::Grade;
use crate::noise::Noise;

/// Knowledge of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// The nominal machine, which the filter knows exactly.
    A,
    /// A production machine with its own tyres, radii, torque gains and slope bias. The filter has nominal values, a mass that is
    /// 2 % off and no horizontal spading force.
    B,
}

impl Tier {
    /// `A` or `B`, in upper or lower case.
    pub fn parse(text: &str) -> Option<Self> {
        match text {
            "A" | "a" => Some(Self::A),
            "B" | "b" => Some(Self::B),
            _ => None,
        }
    }
}

/// Sizes of wheel loaders, by their mass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Size {
    /// 4.7 t, the reference machine.
    #[default]
    Reference,
    /// 5 t.
    Small,
    /// 12 t.
    Middle,
    /// 20 t.
    Large,
}

impl Size {
    /// All sizes except the reference machine.
    pub const REAL: [Self; 3] = [Self::Small, Self::Middle, Self::Large];

    /// The machine from its data sheet.
    pub fn machine(self) -> Machine {
        let (mass, radius, inertia, wheelbase, reach, height, ratio) = match self {
            Self::Reference => return Machine::NOMINAL,
            Self::Small => (5200.0, 0.56, 24.0, 2.15, 1.6, 0.92, 0.45),
            Self::Middle => (12_500.0, 0.70, 120.0, 3.0, 2.2, 1.15, 0.45),
            Self::Large => (19_800.0, 0.82, 320.0, 3.3, 2.6, 1.30, 0.46),
        };
        let typical = Machine::NOMINAL;
        let heavy = mass / typical.mass;
        let long = wheelbase / typical.wheelbase;
        Machine {
            mass,
            wheel_radius: radius,
            axle_inertia: inertia,
            wheelbase,
            bucket_reach: reach,
            cg_height: height,
            cg_ratio: ratio,
            tyre_stiffness: heavy * typical.tyre_stiffness,
            tyre_damping: heavy * typical.tyre_damping,
            pitch_inertia: heavy * long * long * typical.pitch_inertia,
            ..typical
        }
    }
}

/// The estimator's knowledge of the machine, and its initial values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nominal {
    /// Mass without payload \[kg\].
    pub mass: f64,
    /// Rolling radius \[m\].
    pub wheel_radius: f64,
    /// Moment of inertia of one axle [kg m^2].
    pub axle_inertia: f64,
    /// Wheelbase \[m\].
    pub wheelbase: f64,
    /// From the front axle to the bucket tip \[m\].
    pub bucket_reach: f64,
    /// Rolling resistance f.
    pub rolling_resistance: f64,
    /// Friction coefficient mu.
    pub friction: f64,
    /// Load sensitivity rho of the rolling radius.
    pub radius_load_sensitivity: f64,
    /// Initial slip stiffness.
    pub slip_stiffness: f64,
    /// Initial height of the centre of gravity \[m\].
    pub cg_height: f64,
    /// Initial share of the front axle.
    pub cg_ratio: f64,
    /// Calibrated relative error of the front rolling radius, itself uncertain by 5e-4 (for a warm start).
    pub front_radius_error: f64,
    /// The same at the rear.
    pub rear_radius_error: f64,
    /// Grade of the sensors.
    pub grade: Grade,
}

/// Constant errors of the sensors in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Calibration {
    pub front_torque_gain: f64,
    pub rear_torque_gain: f64,
    /// Bias of the slope sensor [rad].
    pub slope_bias: f64,
    pub spade_force_z_gain: f64,
    /// Whether the horizontal spading force is measured.
    pub spade_force_x_known: bool,
    /// Stated mass over true mass.
    pub mass_gain: f64,
    pub payload_gain: f64,
    pub payload_height_error: f64,
    pub payload_reach_error: f64,
}

/// Draws a machine, its sensors and the filter's knowledge of them.
pub(super) fn draw(
    size: Size,
    tier: Tier,
    grade: Grade,
    noise: &mut Noise,
) -> (Machine, Calibration, Nominal) {
    let typical = size.machine();
    let machine = match tier {
        Tier::A => typical,
        Tier::B => draw_machine(&typical, noise),
    };
    let mut calibration = draw_calibration(noise);
    let mut rho = 0.01 * (1.0 + 0.1 * noise.normal());
    let tall = typical.cg_height / Machine::NOMINAL.cg_height;
    let mut centre = (typical.cg_height, typical.cg_ratio);
    if tier == Tier::A {
        calibration = Calibration {
            front_torque_gain: 1.0,
            rear_torque_gain: 1.0,
            slope_bias: 0.0,
            spade_force_z_gain: 1.0,
            spade_force_x_known: true,
            mass_gain: 1.0,
            ..calibration
        };
        rho = 0.0;
        centre = (machine.cg_height, machine.cg_ratio);
    }
    let nominal = Nominal {
        mass: machine.mass * calibration.mass_gain,
        wheel_radius: typical.wheel_radius,
        axle_inertia: typical.axle_inertia,
        wheelbase: typical.wheelbase,
        bucket_reach: typical.bucket_reach,
        rolling_resistance: typical.rolling_resistance,
        friction: typical.friction,
        radius_load_sensitivity: rho,
        slip_stiffness: 19.0 + 2.0 * noise.normal(),
        cg_height: centre.0 + 0.10 * tall * noise.normal(),
        cg_ratio: centre.1 + 0.05 * noise.normal(),
        front_radius_error: machine.front_radius_error + 5e-4 * noise.normal(),
        rear_radius_error: machine.rear_radius_error + 5e-4 * noise.normal(),
        grade,
    };
    (machine, calibration, nominal)
}

fn draw_machine(typical: &Machine, noise: &mut Noise) -> Machine {
    let tall = typical.cg_height / Machine::NOMINAL.cg_height;
    let mut normal = |mean: f64, deviation: f64| mean + deviation * noise.normal();
    let slip_stiffness = normal(19.0, 1.5).clamp(14.0, 24.0);
    let cg_height = tall * normal(0.9, 0.08).clamp(0.7, 1.15);
    let cg_ratio = normal(typical.cg_ratio, 0.03).clamp(0.36, 0.54);
    let front_radius_error = normal(0.0, 0.003);
    let rear_radius_error = normal(0.0, 0.003);
    Machine {
        slip_stiffness,
        cg_height,
        cg_ratio,
        front_radius_error,
        rear_radius_error,
        rolling_resistance: 0.02 * noise.uniform(0.9, 1.1),
        friction: noise.uniform(0.6, 0.9),
        relaxation_length: noise.uniform(0.08, 0.2),
        radius_load_sensitivity: 0.01,
        ..*typical
    }
}

fn draw_calibration(noise: &mut Noise) -> Calibration {
    Calibration {
        front_torque_gain: 1.0 + 0.005 * noise.normal(),
        rear_torque_gain: 1.0 + 0.005 * noise.normal(),
        slope_bias: 0.3f64.to_radians() * noise.normal(),
        spade_force_z_gain: 1.0 + 0.1 * noise.normal(),
        spade_force_x_known: false,
        mass_gain: 1.0 + 0.02 * noise.normal(),
        payload_gain: 1.0 + 0.05 * noise.normal(),
        payload_height_error: 0.10 * noise.normal(),
        payload_reach_error: 0.05 * noise.normal(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tier_a_is_given_everything_but_where_to_start() {
        let (machine, _, nominal) = draw(
            Size::Reference,
            Tier::A,
            Grade::Resolver,
            &mut Noise::new(1),
        );
        assert_eq!(machine, Machine::NOMINAL);
        assert_eq!(
            (nominal.mass, nominal.radius_load_sensitivity),
            (4700.0, 0.0)
        );
        assert_ne!(nominal.cg_height, machine.cg_height);
    }

    #[test]
    fn machines_of_tier_b_spread_as_specified() {
        let draws: Vec<_> = (0..4000)
            .map(|s| {
                let noise = &mut Noise::new(s);
                draw(Size::Reference, Tier::B, Grade::Resolver, noise)
            })
            .collect();
        let spread = |value: &dyn Fn(&(Machine, Calibration, Nominal)) -> f64| {
            let mean = draws.iter().map(value).sum::<f64>() / draws.len() as f64;
            (draws.iter().map(|d| (value(d) - mean).powi(2)).sum::<f64>() / draws.len() as f64)
                .sqrt()
        };
        // The deviation of 4000 draws is known to 1.1 %; clipping reduces it slightly.
        let near = |value: f64, expected: f64| {
            assert!((value / expected - 1.0).abs() < 0.06, "{value} {expected}")
        };
        near(spread(&|d| d.0.cg_ratio), 0.03);
        near(spread(&|d| d.0.front_radius_error), 0.003);
        near(spread(&|d| d.1.slope_bias), 0.3f64.to_radians());
        near(spread(&|d| d.2.mass), 94.0);
        near(spread(&|d| d.2.cg_ratio), 0.05);
    }
}
