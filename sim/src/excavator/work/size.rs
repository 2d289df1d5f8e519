//! Machines of real sizes.

use super::super::geometry::{Attachment, Geometry, Link};

/// A machine by its data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Name.
    pub name: &'static str,
    /// Dimensions and masses.
    pub geometry: Geometry,
    /// First moment of the upper body without boom, arm and bucket, forward positive [kg m].
    pub upper_first_moment: f64,
    /// Viscous damping of the swing [N m s/rad].
    pub damping: f64,
    /// Coulomb friction of the swing [N m].
    pub friction: f64,
    /// Payload of a full bucket \[kg\].
    pub rated: f64,
    /// Largest swing torque [N m].
    pub torque: f64,
    /// Noise of the torque sensor [N m].
    pub torque_noise: f64,
    /// Noise of the gyro [rad/s].
    pub gyro_noise: f64,
}

fn link(mass: f64, centre: f64, flat_inertia: f64, upright_inertia: f64) -> Link {
    Link {
        mass,
        centre,
        flat_inertia,
        upright_inertia,
    }
}

impl Size {
    /// The sizes by name.
    pub const NAMES: [&str; 4] = ["5t", "13t", "22t", "36t"];

    /// The machine of a name.
    pub fn parse(name: &str) -> Option<Self> {
        let all = [Self::reference(), Self::t13(), Self::t22(), Self::t36()];
        all.into_iter().find(|size| size.name == name)
    }

    /// The reference machine of 5.5 t.
    pub fn reference() -> Self {
        Self {
            name: "5t",
            geometry: Geometry::with(Attachment::bucket()),
            upper_first_moment: -1500.0,
            damping: 1500.0,
            friction: 250.0,
            rated: 423.0,
            torque: 5500.0,
            torque_noise: 100.0,
            gyro_noise: 0.005,
        }
    }

    /// 13 t.
    pub fn t13() -> Self {
        Self {
            name: "13t",
            geometry: Geometry {
                boom_pin: 0.15,
                boom_length: 4.6,
                arm_length: 2.5,
                boom: link(1150.0, 2.2, 2030.0, 60.0),
                arm: link(620.0, 0.9, 390.0, 25.0),
                attachment: Attachment {
                    link: link(480.0, 0.6, 60.0, 45.0),
                    payload_centre: 0.7,
                    payload_gyration: 0.35,
                },
                upper_inertia: 13_500.0,
            },
            upper_first_moment: -6460.0,
            damping: 2900.0,
            friction: 1300.0,
            rated: 1000.0,
            torque: 33_000.0,
            torque_noise: 220.0,
            gyro_noise: 0.003,
        }
    }

    /// 22 t.
    pub fn t22() -> Self {
        Self {
            name: "22t",
            geometry: Geometry {
                boom_pin: 0.2,
                boom_length: 5.7,
                arm_length: 2.9,
                boom: link(1950.0, 2.75, 5300.0, 110.0),
                arm: link(1050.0, 1.05, 880.0, 50.0),
                attachment: Attachment {
                    link: link(900.0, 0.75, 170.0, 110.0),
                    payload_centre: 0.85,
                    payload_gyration: 0.45,
                },
                upper_inertia: 35_600.0,
            },
            upper_first_moment: -14_100.0,
            damping: 7100.0,
            friction: 3300.0,
            rated: 2000.0,
            torque: 82_000.0,
            torque_noise: 550.0,
            gyro_noise: 0.003,
        }
    }

    /// 36 t.
    pub fn t36() -> Self {
        Self {
            name: "36t",
            geometry: Geometry {
                boom_pin: 0.25,
                boom_length: 6.5,
                arm_length: 3.2,
                boom: link(3300.0, 3.1, 11_600.0, 220.0),
                arm: link(1750.0, 1.2, 1800.0, 90.0),
                attachment: Attachment {
                    link: link(1900.0, 0.95, 450.0, 300.0),
                    payload_centre: 1.05,
                    payload_gyration: 0.6,
                },
                upper_inertia: 74_400.0,
            },
            upper_first_moment: -25_900.0,
            damping: 13_700.0,
            friction: 5200.0,
            rated: 3600.0,
            torque: 130_000.0,
            torque_noise: 900.0,
            gyro_noise: 0.003,
        }
    }
}
