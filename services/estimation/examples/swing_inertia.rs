//! Swing inertia of an excavator that swings to and fro: `cargo run -p estimation --example swing_inertia`.
//!
//! The simulated machine is the described one, and its load is stated. A real one is read from its sensors, one row each.

use std::error::Error;
use std::f64::consts::TAU;

use estimation::excavator::keys::Description;
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};

/// Time between two rows [s].
const PERIOD: f64 = 0.01;
/// Angles of boom, arm and bucket [rad].
const POSTURE: [f64; 3] = [0.9, -1.6, -1.0];
/// Load in the bucket [kg].
const PAYLOAD: f64 = 300.0;
/// Load that a scale shows, and its standard deviation [kg].
const STATED: (f64, f64) = (290.0, 20.0);

fn main() -> Result<(), Box<dyn Error>> {
    let mut description = Description::default();
    (description.prior.payload, description.prior.payload_std) = STATED;
    let settings = Settings::of(&description);
    let columns = Columns {
        velocity: true,
        torque: true,
        posture: true,
        ..Columns::default()
    };
    let mut estimator = SwingEstimator::new(&settings, Method::Auto, columns)?;
    let inertia = settings.geometry.inertia(POSTURE).with_payload(PAYLOAD);
    let damping = description.machine.nominal_damping;
    let friction = description.machine.coulomb_friction;
    let mut velocity: f64 = 0.0;
    for row in 0..6000_u32 {
        let time = f64::from(row) * PERIOD;
        let answer = estimator.step(&Sample {
            time,
            velocity: Some(velocity),
            torque: Some(torque(time)),
            posture: POSTURE.map(Some),
            ..Sample::default()
        });
        // At the largest velocity of a swing.
        if row % 600 == 150 {
            let half = estimation::HALF_WIDTH_95 * answer.inertia_std;
            let word = match answer.flags.trusted() {
                true => "trusted",
                false => "not trusted",
            };
            println!(
                "{time:5.1} s  {:6.0} ± {half:4.0} kg m²  {word}",
                answer.inertia
            );
        }
        // J w' = T - b w - T_f sgn(w), solved exactly for the mean torque of two rows.
        let mean = 0.5 * (torque(time) + torque(time + PERIOD));
        let direction = if velocity == 0.0 { mean } else { velocity }.signum();
        let remaining = (-damping * PERIOD / inertia).exp();
        let steady = (mean - friction * direction) / damping;
        velocity = steady + (velocity - steady) * remaining;
    }
    println!("the truth is {inertia:.0} kg m²");
    Ok(())
}

/// Swing torque: three seconds in each direction [N m].
fn torque(time: f64) -> f64 {
    6000.0 * (TAU * time / 6.0).cos()
}
