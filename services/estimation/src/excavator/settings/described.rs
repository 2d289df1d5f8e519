//! Derives the settings of the estimators from the description of an excavator.

use crate::excavator::align;
use crate::excavator::cylinder::Cylinder;
use crate::excavator::doubts::{Correlations, Doubts, OfBucket};
use crate::excavator::geometry::Geometry;
use crate::excavator::keys::{Description, Machine, Paper, Variant};
use crate::excavator::settings::{Sensors, Settings};
use crate::math::sqrt;

impl Settings {
    /// Settings that follow from a description.
    #[must_use]
    pub fn of(d: &Description) -> Self {
        Self {
            geometry: Geometry::of(d),
            nominal_damping: d.machine.nominal_damping,
            coulomb_friction: d.machine.coulomb_friction,
            inertia_min: d.machine.inertia_min,
            inertia_max: d.machine.inertia_max,
            sensors: sensors(d),
            prior: d.prior,
            estimator: d.estimator,
            paper: paper(d),
            boom: Cylinder::of_boom(d),
            doubts: (d.estimator.variant == Variant::Auto)
                .then(|| Doubts::of(d))
                .filter(Doubts::are_any),
        }
    }
}

impl Geometry {
    /// Geometry that follows from a description.
    #[must_use]
    pub fn of(d: &Description) -> Self {
        let g = &d.geometry;
        Self {
            upper_inertia: d.machine.upper_inertia,
            boom_pin: g.boom_pin,
            lengths: [g.boom_length, g.arm_length],
            centres: [g.boom_centre, g.arm_centre, g.bucket_centre],
            payload_centre: g.payload_centre,
            rises: [g.boom_rise, g.bucket_rise, g.payload_rise],
            payload_gyration: g.payload_gyration,
            masses: [g.boom_mass, g.arm_mass, g.bucket_mass],
            inertias: [g.boom_inertia, g.arm_inertia, g.bucket_inertia],
            axial_inertias: [
                g.boom_axial_inertia,
                g.arm_axial_inertia,
                g.bucket_axial_inertia,
            ],
        }
    }
}

/// Standard deviation of the gain of a torque that was not compared with a reference: motors differ in displacement by 2 %, in mechanical
/// efficiency by 4 %, and pressures by 1 to 2 %. A stated 0 counts the same, except in the variant `Known`.
const GAIN_STD: f64 = 0.05;
/// The same where boom pressures weigh too. Pressures reveal large gain errors, which the parallel filter models for one machine in
/// four; the gains of the other machines differ less.
const WEIGHED_GAIN_STD: f64 = 0.03;

/// Standard deviation of the torque's gain; 0 only in the variant `Known`.
fn gain_std(d: &Description) -> f64 {
    let known = d.estimator.variant == Variant::Known;
    match d.sensors.swing_torque_gain_std {
        None if known => 0.0,
        None => GAIN_STD,
        Some(0.0) if !known => GAIN_STD,
        Some(stated) => stated,
    }
}

/// Relative standard deviations of upper inertia and bucket mass over that of boom and arm, where none is stated: counterweights, tanks
/// and options differ by 10 to 15 %, buckets by 20 %.
const UPPER: f64 = 7.0;
const BUCKET: f64 = 11.0;

impl Doubts {
    /// Uncertainty of the description of an uncalibrated machine.
    #[must_use]
    pub fn of(d: &Description) -> Self {
        let (m, s) = (&d.machine, &d.sensors);
        let both = |a: f64, b: f64| sqrt(a * a + b * b);
        Self {
            gain_std: gain_std(d),
            weighed_gain_std: d
                .sensors
                .swing_torque_gain_std
                .map_or(WEIGHED_GAIN_STD, |_| gain_std(d)),
            efficiency: m.drive_efficiency,
            efficiency_std: m.drive_efficiency_std,
            friction_std: m.coulomb_friction_std.unwrap_or(d.prior.friction_std),
            slope_std: m.slope_std,
            upper_first_moment: m.upper_first_moment,
            upper_first_moment_std: m.upper_first_moment_std,
            delay: align::rest([s.swing_velocity_delay, s.swing_torque_delay]),
            delay_std: both(s.swing_velocity_delay_std, s.swing_torque_delay_std),
            torque_share: d.estimator.torque_noise_share,
            // Masses that were calibrated by swinging include the effect of the lengths.
            links_share: match m.links_gain_correlation {
                Some(_) => m.mass_tolerance,
                None => both(m.mass_tolerance, 2.0 * m.geometry_tolerance),
            },
            upper_share: m.upper_tolerance.unwrap_or(UPPER * m.mass_tolerance),
            bucket_share: Self::bucket_share(m),
            form_share: 2.0 * m.geometry_tolerance,
            loads: d.loads_common(),
            found: m.links_gain_correlation.map(|links_gain| Correlations {
                links_gain,
                upper_gain: m.upper_gain_correlation,
                upper_links: m.upper_links_correlation,
                bucket: m.bucket_gain_correlation.map(|gain| OfBucket {
                    gain,
                    upper: m.upper_bucket_correlation,
                    links: m.links_bucket_correlation,
                }),
            }),
        }
    }
}

impl Doubts {
    /// Relative standard deviation of the bucket's mass.
    pub(in crate::excavator) fn bucket_share(m: &Machine) -> f64 {
        m.bucket_tolerance.unwrap_or(BUCKET * m.mass_tolerance)
    }

    /// Whether the description is uncertain at all; not where it states 0 for every tolerance.
    fn are_any(&self) -> bool {
        let stds = [
            self.efficiency_std,
            self.slope_std,
            self.delay_std,
            self.torque_share,
            self.links_share,
            self.upper_share,
            self.bucket_share,
            self.form_share,
        ];
        stds.iter().any(|std| *std > 0.0)
    }
}

fn sensors(d: &Description) -> Sensors {
    let s = &d.sensors;
    Sensors {
        rate: s.rate,
        swing_velocity_std: s.swing_velocity_std,
        swing_angle_std: s.swing_angle_std,
        swing_torque_std: s.swing_torque_std,
        swing_torque_gain_std: gain_std(d),
        angle_std: s.angle_std,
        swing_velocity_limit: s.swing_velocity_limit,
        angle_limit: s.angle_limit,
        swing_torque_gain: s.swing_torque_gain,
        swing_torque_offset: s.swing_torque_offset,
        angle_offsets: [
            s.boom_angle_offset,
            s.arm_angle_offset,
            s.bucket_angle_offset,
        ],
        delays: [s.swing_velocity_delay, s.swing_torque_delay],
    }
}

/// A stated `estimator.forgetting` applies both inside and outside the change windows.
fn paper(d: &Description) -> Paper {
    let common = match *d.estimator.forgetting {
        [all] => Some([all; 3]),
        [inertia, damping, torque, ..] => Some([inertia, damping, torque]),
        _ => None,
    };
    Paper {
        lambda_normal: common.unwrap_or(d.paper.lambda_normal),
        lambda_window: common.unwrap_or(d.paper.lambda_window),
        ..d.paper
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_that_nobody_states_is_less_known_than_a_stated_one_and_better_beside_pressures() {
        let stds = |stated: Option<f64>| {
            let mut d = Description::default();
            d.sensors.swing_torque_gain_std = stated;
            let doubts = Doubts::of(&d);
            [doubts.gain_std, doubts.weighed_gain_std]
        };
        assert_eq!(stds(None), [GAIN_STD, WEIGHED_GAIN_STD]);
        assert_eq!(stds(Some(0.0)), [GAIN_STD; 2], "nobody knows it exactly");
        assert_eq!(stds(Some(0.02)), [0.02; 2]);
    }
}
