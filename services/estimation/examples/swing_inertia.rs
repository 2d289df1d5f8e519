//! Swing inertia of an excavator that swings to and fro: `cargo run -p estimation --example swing_inertia`.
//!
//! The simulated machine is the described one with a load; a real one is read from its sensors, one row each.

use estimation::excavator::keys::Description;
use estimation::excavator::{Columns, Method, Sample, Settings, SwingEstimator};

/// Time between two rows [s].
const PERIOD: f64 = 0.01;
/// Angles of boom, arm and bucket [rad].
const POSTURE: [f64; 3] = [0.9, -1.6, -1.0];
/// Load in the bucket [kg].
const PAYLOAD: f64 = 300.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let description = Description::default();
    let settings = Settings::of(&description);
    let columns = Columns {
        velocity: true,
        torque: true,
        posture: true,
        ..Columns::default()
    };
    let mut estimator = SwingEstimator::new(&settings, Method::Auto, columns)?;
    let inertia = settings.geometry.inertia(POSTURE).with_payload(PAYLOAD);
    let (damping, friction) = (
        description.machine.nominal_damping,
        description.machine.coulomb_friction,
    );
    let mut velocity: f64 = 0.0;
    for row in 0..6000_u32 {
        let time = f64::from(row) * PERIOD;
        // Accelerates for a second, brakes for a second, rests for two; then in the opposite direction.
        let phase = time % 8.0;
        let torque = match phase {
            p if p < 1.0 => 6000.0,
            p if p < 2.0 => -6000.0 + 2.0 * (friction + damping * velocity),
            p if p < 4.0 => 0.0,
            p if p < 5.0 => -6000.0,
            p if p < 6.0 => 6000.0 - 2.0 * (friction - damping * velocity),
            _ => 0.0,
        };
        let answer = estimator.step(&Sample {
            time,
            velocity: Some(velocity),
            torque: Some(torque),
            posture: POSTURE.map(Some),
            ..Sample::default()
        });
        let moving = torque - damping * velocity - friction * velocity.signum();
        let next = velocity + PERIOD * moving / inertia;
        let rests = next * velocity < 0.0 || velocity == 0.0 && torque.abs() <= friction;
        velocity = if rests { 0.0 } else { next };
        // In the middle of braking.
        if row % 400 == 150 {
            let half = estimation::HALF_WIDTH_95 * answer.inertia_std;
            let word = if answer.flags.trusted() {
                "trusted"
            } else {
                "not trusted: the interval is wide"
            };
            println!(
                "{time:5.1} s  {:6.0} ± {half:4.0} kg m²  {word}",
                answer.inertia
            );
        }
    }
    println!("the truth is {inertia:.0} kg m²");
    Ok(())
}
