//! The wheel loader on the command line.

mod calibrate;
mod figures;

use config::Description;
use messages::{LoaderSensors, LoaderTruth};
use runtime::Source;
use sim::cylinder::Gauges;
use sim::loader::{CASES, LiftArm, Run, Scenario, Size, Tier};
use sim::named;

use super::{Figure, Typed, all_scenarios, bad_run, cylinder_settings, no_scenario};
use crate::commands::calibrate::args::CalibrateArgs;
use crate::failure::Failure;
use crate::plan::Plan;

pub(super) struct Loader;

impl Typed for Loader {
    type Sensors = LoaderSensors;
    type Estimate = messages::LoaderEstimate;
    type Look = ();
    const USUAL: &'static str = "work-cycle";
    const SHOWN: &'static str = "loading";
    // A maker's data.
    const SHOWN_SETTINGS: &'static [&'static str] = &[
        "machine.radius_load_sensitivity=0.01",
        "machine.radius_load_sensitivity_std=0.001",
    ];

    fn scenarios() -> Vec<(String, String)> {
        all_scenarios(Scenario::ALL, CASES.iter().map(|c| (c.0, c.1)))
    }

    fn simulated_cylinders() -> Vec<String> {
        let arm = LiftArm::of(&Size::Reference.machine());
        let mut settings: Vec<String> = [
            ("length", arm.length),
            ("pivot_x", arm.pivot_x),
            ("pivot_z", arm.pivot_z),
            ("mass", arm.mass),
            ("mass_distance", arm.mass_distance),
            ("bucket_mass", arm.bucket_mass),
            ("payload_distance", arm.payload_distance),
            ("reference_angle", arm.reference.lift),
            ("reference_tilt", arm.reference.bucket - arm.reference.lift),
        ]
        .map(|(key, value)| format!("machine.lift_arm.{key}={value:?}"))
        .into();
        settings.extend(cylinder_settings(
            "machine.lift_arm.cylinder",
            &arm.cylinder,
        ));
        settings.push("sensors.angle_offset_std=0.009".into());
        settings
    }

    fn simulator(
        plan: &Plan,
    ) -> Result<impl Source<Sensors = LoaderSensors, Truth = LoaderTruth> + 'static, Failure> {
        let mut at_work = CASES.iter();
        let mut run = match at_work.find(|c| named::scenario(c.0, c.1) == plan.scenario) {
            Some((_, _, effects)) => Run::at_work(*effects),
            None => Run::new(
                Scenario::parse(&plan.scenario)
                    .ok_or_else(|| no_scenario(&plan.scenario, &Self::scenarios()))?,
            ),
        };
        run.payload = plan.payload.or(run.payload);
        (run.rate, run.seed) = (plan.rate, plan.seed);
        (run.tier, run.duration) = (Tier::B, plan.duration);
        run.gauges = plan.pressures.then(Gauges::default);
        sensor::loader::Simulator::new(&run).map_err(bad_run)
    }

    fn calibrate(args: &CalibrateArgs, description: &Description) -> Result<(), Failure> {
        match description {
            Description::Loader(d) => calibrate::calibrate(args, d),
            other => Err(steps::Error::OtherMachine(other.machine()).into()),
        }
    }

    fn evaluate(options: &evaluate::Options) -> Result<evaluate::Report, evaluate::Error> {
        evaluate::loader::evaluate(options)
    }

    fn figures() -> Result<Vec<Figure>, Failure> {
        figures::all()
    }
}
