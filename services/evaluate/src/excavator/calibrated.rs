//! A simulated machine at work as `heft calibrate` finds it: by two recordings of swings and slow lifts, one of them with a weighed load.

use calibrate::excavator::{self as calibration, Input, Options};
use estimation::Quantity;
use estimation::excavator::keys::{Attachment, Description, Variant};
use estimation::excavator::{Method, Settings};
use sim::excavator::{Effects, Size, Work};
use sim::noise::Noise;

use super::estimators::Setup;
use crate::Error;

/// Length of a recording: 150 s at 100 Hz.
const ROWS: usize = 15_000;
/// The weighed load, in rated payloads, and how well it is weighed.
const LOAD: f64 = 0.7;
const SCALE: f64 = 0.01;
/// Stream of the scale's error.
const STREAM: u64 = 340;

/// The settings of the calibrated machine; none where the calibration is refused. `before` is what a user states.
pub fn settings(
    (size, effects, seed): (Size, Effects, u64),
    before: &Description,
) -> Result<Option<Settings>, Error> {
    // Who calibrates looks for level ground.
    let level = Effects {
        slope: 0.0,
        ..effects
    };
    let load = LOAD * size.rated;
    let weighed = load * (1.0 + SCALE * Noise::channel(seed, STREAM).normal());
    let settings = Settings::of(before);
    let setup = Setup::working("to calibrate", Method::PostureTorque, settings);
    let inputs = [(0.0, 0.0), (load, weighed)].map(|(load, weighed)| Input {
        name: format!("{load:.0} kg"),
        samples: Work::trial(size, level, seed, load)
            .with_gauges(seed)
            .take(ROWS)
            .map(|row| setup.sample(&row))
            .collect(),
        payload: Some(Quantity {
            value: weighed,
            std: SCALE * weighed,
        }),
    });
    let outcome = calibration::calibrate(&inputs, &Options::of(before)).map_err(Error::refused)?;
    if !outcome.faults.is_empty() {
        eprintln!("seed {seed}: {}", outcome.faults.join("; "));
        return Ok(None);
    }
    let found = outcome.description(before, &[]);
    Ok(found.map(|(description, _)| Settings::of(&description)))
}

/// The description that means these settings.
pub fn description(s: &Settings) -> Description {
    let g = &s.geometry;
    let mut d = Description {
        geometry: Attachment {
            boom_pin: g.boom_pin,
            boom_length: g.lengths[0],
            arm_length: g.lengths[1],
            boom_centre: g.centres[0],
            arm_centre: g.centres[1],
            bucket_centre: g.centres[2],
            payload_centre: g.payload_centre,
            payload_gyration: g.payload_gyration,
            boom_mass: g.masses[0],
            arm_mass: g.masses[1],
            bucket_mass: g.masses[2],
            boom_inertia: g.inertias[0],
            arm_inertia: g.inertias[1],
            bucket_inertia: g.inertias[2],
            boom_axial_inertia: g.axial_inertias[0],
            arm_axial_inertia: g.axial_inertias[1],
            bucket_axial_inertia: g.axial_inertias[2],
            ..Attachment::default()
        },
        prior: s.prior,
        estimator: s.estimator,
        ..Description::default()
    };
    d.estimator.variant = Variant::Auto;
    d.machine.upper_inertia = g.upper_inertia;
    d.machine.nominal_damping = s.nominal_damping;
    d.machine.coulomb_friction = s.coulomb_friction;
    (d.machine.inertia_min, d.machine.inertia_max) = (s.inertia_min, s.inertia_max);
    d.sensors.swing_velocity_std = s.sensors.swing_velocity_std;
    d.sensors.swing_torque_std = s.sensors.swing_torque_std;
    d
}

#[cfg(test)]
mod tests {
    use super::super::honesty_lines::described;
    use super::*;
    use estimation::excavator::Doubts;

    #[test]
    fn a_description_means_the_settings_that_it_was_made_of() {
        let stated = described(&Work::new(Size::t22(), Effects::good(), 3));
        let meant = Settings::of(&description(&stated));
        assert_eq!(meant.geometry, stated.geometry);
        assert_eq!(meant.prior, stated.prior);
        assert_eq!(
            [meant.nominal_damping, meant.coulomb_friction],
            [stated.nominal_damping, stated.coulomb_friction]
        );
        // What all loads share hangs on the payload that is stated.
        let loads = stated.doubts.map_or_else(Default::default, |d| d.loads);
        let doubts = meant.doubts.map(|d| Doubts { loads, ..d });
        assert_eq!(doubts, stated.doubts);
    }
}
