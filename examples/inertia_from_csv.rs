//! The swing inertia from a table, without a process: `cargo run --example inertia_from_csv data.csv`.

use estimation::excavator::keys::Description;
use estimation::excavator::{Columns, Method, Settings, SwingEstimator};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let default = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/golden/excavator_input_base_case2.csv"
    );
    let file = std::env::args().nth(1).unwrap_or_else(|| default.into());
    let rows = recording::load::<messages::ExcavatorSensors>(&file, None)?;
    let columns = rows.first().map_or(Columns::default(), |(first, _)| {
        steps::excavator::columns(first)
    });
    let settings = Settings::of(&Description::default());
    let mut estimator = SwingEstimator::new(&settings, Method::Auto, columns)?;
    for (sensors, _) in &rows {
        let answer = estimator.step(&steps::excavator::sample(sensors));
        let word = if answer.flags.trusted() {
            "trusted"
        } else {
            "not trusted"
        };
        let (time, inertia, std) = (sensors.stamp.time, answer.inertia, answer.inertia_std);
        println!("{time:7.2} s  {inertia:7.0} ± {std:5.0} kg m²  {word}");
    }
    Ok(())
}
