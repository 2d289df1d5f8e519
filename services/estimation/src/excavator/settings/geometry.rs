//! Swing inertia as a function of posture and payload.
//!
//! With the absolute link angles `a1 = q_b`, `a2 = a1 + q_a`, `a3 = a2 + q_k`:
//!
//! ```text
//! r1 = x0 + c1 cos a1 - n1 sin a1;  rA = x0 + L1 cos a1;  r2 = rA + c2 cos a2;  rB = rA + L2 cos a2
//! r3 = rB + c3 cos a3 - n3 sin a3;  rp = rB + cp cos a3 - np sin a3
//! J_e = J_u + sum [ m_i r_i^2 + I_i cos^2 a_i + Ir_i sin^2 a_i ];   g = rp^2 + kp^2;   J = J_e + m g
//! ```

use crate::excavator::keys::Description;
use crate::math::sin_cos;

/// Lengths, masses and inertias of the machine above the swing bearing. The default is a 5.5 t excavator.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Geometry {
    /// Inertia of the upper body without boom, arm and bucket, about the swing axis (J_u) [kg m^2].
    pub upper_inertia: f64,
    /// Swing axis to boom pin (x0) \[m\].
    pub boom_pin: f64,
    /// Boom pin to arm pin, arm pin to bucket pin (L1, L2) \[m\].
    pub lengths: [f64; 2],
    /// Pin to centre of mass of boom, arm, bucket (c1, c2, c3) \[m\].
    pub centres: [f64; 3],
    /// Bucket pin to the payload's centre of mass (cp) \[m\].
    pub payload_centre: f64,
    /// Distances of the centres of boom, bucket and payload from the lines of the pins, positive on the side to which the link turns up (n1,
    /// n3, np) \[m\].
    pub rises: [f64; 3],
    /// Radius of gyration of the payload (kp) \[m\].
    pub payload_gyration: f64,
    /// Masses of boom, arm, bucket \[kg\].
    pub masses: [f64; 3],
    /// Inertias across the length, at the centre of mass (I1, I2, I3) [kg m^2].
    pub inertias: [f64; 3],
    /// Inertias about the length (Ir1, Ir2, Ir3) [kg m^2].
    pub axial_inertias: [f64; 3],
}

impl Default for Geometry {
    fn default() -> Self {
        Self::of(&Description::default())
    }
}

/// Inertia at one posture, linear in the payload.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inertia {
    /// Without payload (J_e) [kg m^2].
    pub empty: f64,
    /// Inertia per kilogram of payload (g) [m^2].
    pub per_payload: f64,
    /// First moment of boom, arm and bucket about the swing axis [kg m].
    pub moment: f64,
    /// First moment per kilogram of payload, which is its radius \[m\].
    pub radius: f64,
    /// Part of boom and arm in the inertia [kg m^2].
    pub links: f64,
    /// Part of boom and arm in the first moment [kg m].
    pub links_moment: f64,
    /// Inertia per kilogram of the bucket [m^2].
    pub per_bucket: f64,
    /// Radius of the bucket's centre of mass \[m\].
    pub bucket_radius: f64,
}

impl Inertia {
    /// Inertia with a payload of `mass` kilograms [kg m^2].
    pub fn with_payload(&self, mass: f64) -> f64 {
        self.empty + mass * self.per_payload
    }

    /// Combines two inertias by `f`, part by part.
    #[must_use]
    pub fn with(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let sum = |of: fn(&Self) -> f64| f(of(self), of(other));
        Self {
            empty: sum(|i| i.empty),
            per_payload: sum(|i| i.per_payload),
            moment: sum(|i| i.moment),
            radius: sum(|i| i.radius),
            links: sum(|i| i.links),
            links_moment: sum(|i| i.links_moment),
            per_bucket: sum(|i| i.per_bucket),
            bucket_radius: sum(|i| i.bucket_radius),
        }
    }
}

/// Sines and cosines of the angles of boom, arm and bucket to the horizontal.
pub(in crate::excavator) type Turns = [(f64, f64); 3];

/// Sines and cosines at these joint angles \[rad\].
pub(in crate::excavator) fn turns([boom, arm, bucket]: [f64; 3]) -> Turns {
    [boom, boom + arm, boom + arm + bucket].map(sin_cos)
}

/// Folded posture for comparisons of machines [rad].
const FOLDED: [f64; 3] = [0.96, -2.55, -1.48];

impl Geometry {
    /// Inertia of the machine over the reference machine's, both empty and folded. Torques have the same ratio, since
    /// machines are designed for similar accelerations.
    pub(in crate::excavator) fn scale(&self) -> f64 {
        self.inertia(FOLDED).empty / Self::default().inertia(FOLDED).empty
    }

    /// Payload on this machine that corresponds to a kilogram on the reference machine: its share of the machine's
    /// inertia is equal.
    pub(in crate::excavator) fn payload_scale(&self) -> f64 {
        let leverage = |geometry: &Self| geometry.inertia(FOLDED).per_payload;
        self.scale() * leverage(&Self::default()) / leverage(self)
    }

    /// Inertia of the empty machine in the folded posture [kg m^2].
    pub(in crate::excavator) fn folded_inertia(&self) -> f64 {
        self.inertia(FOLDED).empty
    }

    /// First moment of the empty attachment in the folded posture [kg m].
    pub(in crate::excavator) fn folded_moment(&self) -> f64 {
        self.inertia(FOLDED).moment
    }

    /// Inertia at the joint angles boom (to the horizontal, up positive), arm (relative to the
    /// boom), bucket (relative to the arm) \[rad\].
    pub fn inertia(&self, posture: [f64; 3]) -> Inertia {
        self.inertia_turned(&turns(posture))
    }

    /// The same from sines and cosines of the angles of boom, arm and bucket to the horizontal.
    pub(in crate::excavator) fn inertia_turned(&self, turns: &Turns) -> Inertia {
        let [cos1, cos2, cos3] = turns.map(|(_, cos)| cos);
        let beside = |i: usize, link: usize| self.rises[i] * turns[link].0;
        let arm_pin = self.boom_pin + self.lengths[0] * cos1;
        let bucket_pin = arm_pin + self.lengths[1] * cos2;
        let radii = [
            self.boom_pin + self.centres[0] * cos1 - beside(0, 0),
            arm_pin + self.centres[1] * cos2,
            bucket_pin + self.centres[2] * cos3 - beside(1, 2),
        ];
        let turned = |i: usize| {
            let (sin, cos) = turns[i];
            self.inertias[i] * cos * cos + self.axial_inertias[i] * sin * sin
        };
        let of = |i: usize| self.masses[i] * radii[i] * radii[i] + turned(i);
        let own = turned(2) / self.masses[2].max(f64::MIN_POSITIVE);
        let links = of(0) + of(1);
        let payload = bucket_pin + self.payload_centre * cos3 - beside(2, 2);
        Inertia {
            empty: self.upper_inertia + (links + of(2)),
            per_payload: payload * payload + self.payload_gyration * self.payload_gyration,
            moment: (0..3).map(|i| self.masses[i] * radii[i]).sum(),
            radius: payload,
            links,
            links_moment: self.masses[0] * radii[0] + self.masses[1] * radii[1],
            per_bucket: radii[2] * radii[2] + if own.is_finite() { own } else { 0.0 },
            bucket_radius: radii[2],
        }
    }
}
