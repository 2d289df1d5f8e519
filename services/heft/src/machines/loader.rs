//! The wheel loader on the command line.

mod calibrate;
mod figures;

use config::Description;
use messages::{LoaderSensors, LoaderTruth};
use runtime::Source;
use sim::cylinder::Gauges;
use sim::loader::{CASES, Run, Scenario, Tier};
use sim::named;
use steps::described;

use super::{Figure, MachineKind, all_scenarios, bad_run, no_scenario};
use crate::commands::calibrate::args::CalibrateArgs;
use crate::failure::Failure;
use crate::plan::Plan;

pub(super) struct Loader;

impl MachineKind for Loader {
    type Sensors = LoaderSensors;
    type Estimate = messages::LoaderEstimate;
    type Look = checks::loader::Fits;
    const USUAL: &'static str = "work-cycle";
    const SHOWN: &'static str = "loading";
    // The empty machine stood on axle scales once, to 1 % of its weight; its height is stated to 5 %. Of seed 1 they are 0.472 and 0.964 m.
    const SHOWN_SETTINGS: &'static [&'static str] = &[
        "machine.lift_arm.empty_ratio=0.467",
        "machine.lift_arm.empty_ratio_std=0.01",
        "machine.lift_arm.empty_height=0.94",
        "machine.lift_arm.empty_height_std=0.045",
    ];

    const SIMULATED_MASS: (&'static str, f64) =
        ("machine.mass", sim::loader::Machine::NOMINAL.mass);
    const SIMULATED_CYLINDERS: fn() -> Vec<String> = sensor::loader::drawing;
    const EVALUATE: fn(&evaluate::Options) -> Result<evaluate::Report, evaluate::Error> =
        evaluate::loader::evaluate;
    const FIGURES: fn() -> Result<Vec<Figure>, Failure> = figures::all;

    fn scenarios() -> Vec<(String, String)> {
        let work = "drive, load, reverse, dump, return";
        all_scenarios(work, Scenario::ALL, CASES.iter().map(|c| (c.0, c.1)))
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
        calibrate::calibrate(args, described(description)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_demonstration_states_of_its_loader_what_scales_would_say() {
        let run = Run {
            seed: 1,
            tier: Tier::B,
            ..Run::new(Scenario::parse(Loader::SHOWN).expect("a scenario"))
        };
        let simulation = sim::loader::Simulation::new(&run).expect("a run");
        let machine = simulation.machine();
        let stated = |key: &str| -> f64 {
            let key = format!("machine.lift_arm.{key}=");
            let setting = Loader::SHOWN_SETTINGS
                .iter()
                .find_map(|s| s.strip_prefix(key.as_str()));
            setting.expect("a key").parse().expect("a number")
        };
        for (key, truth) in [
            ("empty_ratio", machine.cg_ratio),
            ("empty_height", machine.cg_height),
        ] {
            let error = (stated(key) - truth) / stated(&format!("{key}_std"));
            assert!((0.1..1.5).contains(&error.abs()), "{key}: {truth}, {error}");
        }
    }

    #[test]
    fn an_empty_machine_that_always_weighs_the_same_is_no_mark_of_missing_samples() {
        let said = |often: f64| {
            let loader = Description::default_of(messages::Machine::Loader);
            let mut doubts = crate::doubts::Doubts::<checks::loader::Fits>::of(&loader);
            for k in 0..1000 {
                let loaded = 21_000.0 + f64::from(k);
                let sample = LoaderSensors {
                    mass: if k % 3 == 0 { loaded } else { often },
                    valid: messages::loader_bits::MASS,
                    ..LoaderSensors::default()
                };
                doubts.add(&sample, false);
            }
            let words = doubts.words().join("\n");
            words.contains("mass is").then_some(words)
        };
        let stated = config::Loader::default().machine.mass;
        assert_eq!([stated, 1.1 * stated].map(said), [None, None]);
        for often in [0.0, 17_760.0] {
            let words = said(often).expect("a remark");
            assert!(
                words.contains(&format!("mass is {often} kg in 666 rows")),
                "{words}"
            );
            assert!(words.contains("state machine.mass"), "{words}");
        }
    }
}
