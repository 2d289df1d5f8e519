//! A user-defined step in the pipeline, after the filter of heft.
//!
//! It estimates the torque per acceleration of a swing from the filtered motion. The same step
//! could run as a process (`runtime::run_stage`); here it runs on a simulated excavator.

use std::error::Error;

use messages::{ExcavatorEstimate, SwingMotion};
use runtime::{Source, Step, answer};
use steps::excavator::FilterStep;

/// Torque over acceleration, averaged over the samples that accelerate.
#[derive(Default)]
struct Crude {
    torque: f64,
    acceleration: f64,
}

impl Step for Crude {
    type Input = SwingMotion;
    type Output = ExcavatorEstimate;

    fn step(&mut self, motion: &SwingMotion) -> ExcavatorEstimate {
        if motion.filtered_acceleration.abs() > 0.2 {
            self.torque += motion.filtered_torque * motion.filtered_acceleration.signum();
            self.acceleration += motion.filtered_acceleration.abs();
        }
        ExcavatorEstimate {
            inertia: self.torque / self.acceleration.max(1e-9),
            ..ExcavatorEstimate::default()
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let run = sim::excavator::Run::new(sim::excavator::Scenario::Base);
    let mut machine = sensor::excavator::Simulator::new(&run)?;
    let mut filter = FilterStep::new(&config::Excavator::default())?;
    let mut crude = Crude::default();
    let mut last = None;
    while let Some((sensors, truth)) = machine.next() {
        let motion = answer(&mut filter, &sensors);
        last = Some((answer(&mut crude, &motion), truth));
    }
    if let Some((estimate, truth)) = last {
        println!(
            "crude {:.0} kg m², truth {:.0} kg m²",
            estimate.inertia, truth.inertia
        );
    }
    Ok(())
}
