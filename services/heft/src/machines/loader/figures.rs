//! The figures of the loader's paper, drawn from our runs.

use messages::LoaderEstimate;
use runtime::{Source, answer};
use sensor::loader::Simulator;
use steps::loader::EstimatorStep;
use view::figures::Curve;
use view::loader::figures as loader;

use crate::failure::Failure;
use crate::machines::{Figure, SEED};

/// Every figure of the paper.
pub fn all() -> Result<Vec<Figure>, Failure> {
    use sim::loader::Scenario;
    [
        ("fig04", "4", Scenario::Bumpy, "driving on a bumpy road"),
        ("fig05", "5", Scenario::Spading, "spading on a bumpy road"),
        ("fig07", "7", Scenario::ConstantTorque, "constant torque"),
        (
            "fig08",
            "8",
            Scenario::AccelDecel,
            "acceleration and deceleration",
        ),
    ]
    .into_iter()
    .map(|(file, number, scenario, condition)| {
        Ok((file.to_owned(), figure(number, scenario, condition)?))
    })
    .collect()
}

/// One condition of the loader paper, by its filter and by the EKF of the same model.
fn figure(
    number: &str,
    scenario: sim::loader::Scenario,
    condition: &str,
) -> Result<String, Failure> {
    let run = sim::loader::Run {
        seed: SEED,
        ..sim::loader::Run::new(scenario)
    };
    let mut source = Simulator::new(&run).map_err(Failure::internal)?;
    let rows: Vec<_> = std::iter::from_fn(|| source.next()).collect();
    // The machine of these runs is exactly known: rigid tyres.
    let mut description = config::Loader::default();
    description.machine.radius_load_sensitivity = 0.0;
    let estimates = |method| -> Result<Vec<LoaderEstimate>, Failure> {
        let mut step = EstimatorStep::new(&description, method).map_err(Failure::internal)?;
        Ok(rows.iter().map(|(s, _)| answer(&mut step, s)).collect())
    };
    let (ukf, ekf) = (estimates("isr-ukf")?, estimates("ekf")?);

    let wheelbase = description.machine.wheelbase;
    let column = |f: fn(&LoaderEstimate) -> f64, of: &[LoaderEstimate]| {
        of.iter().map(f).collect::<Vec<f64>>()
    };
    let t: Vec<f64> = rows.iter().map(|(s, _)| s.stamp.time).collect();
    let torque: Vec<f64> = rows.iter().map(|(s, _)| s.front_torque).collect();
    let speed = column(|e| e.speed, &ukf);
    let true_speed: Vec<f64> = rows.iter().map(|(_, t)| t.speed).collect();
    let true_distance: Vec<f64> = rows
        .iter()
        .map(|(_, t)| (1.0 - t.cg_ratio) * wheelbase)
        .collect();
    let true_height: Vec<f64> = rows.iter().map(|(_, t)| t.cg_height).collect();
    let estimates = [("ISR-UKF", &ukf), ("EKF", &ekf)];
    let distances = estimates.map(|(label, of)| (label, column(|e| e.cg_distance, of)));
    let heights = estimates.map(|(label, of)| (label, column(|e| e.cg_height, of)));
    let distance: [Curve<'_>; 2] = distances
        .each_ref()
        .map(|(name, of)| (*name, of.as_slice()));
    let height: [Curve<'_>; 2] = heights.each_ref().map(|(name, of)| (*name, of.as_slice()));
    let series = loader::Series {
        t: &t,
        front_torque: &torque,
        speed: &speed,
        reference_speed: Some(&true_speed),
        reference_distance: &true_distance,
        distance: &distance,
        reference_height: &true_height,
        height: &height,
    };
    Ok(if number == "4" || number == "5" {
        loader::driving(number, condition, &series)
    } else {
        loader::experiment(number, condition, &series)
    })
}
