//! The table of processes is consistent with itself, the channels and the methods.

use config::Description;
use messages::{EXCAVATOR_METHODS, Hop, LOADER_METHODS, Machine, channels};
use steps::Error;
use steps::stages::{Pipeline, Stage};

fn pipelines() -> [&'static Pipeline; 2] {
    Machine::ALL.map(Pipeline::of)
}

#[test]
fn each_machine_has_its_own_pipeline() {
    for machine in Machine::ALL {
        assert_eq!(Pipeline::of(machine).machine, machine);
    }
}

#[test]
fn whoever_reads_a_channel_is_woken_by_its_writer() {
    for pipeline in pipelines() {
        for reader in pipeline.stages {
            let Some(input) = reader.input() else {
                continue;
            };
            let writer = pipeline.writer(input);
            assert!(
                writer.is_some_and(|w| w.wakes.contains(&reader.name)),
                "{}",
                reader.name
            );
        }
    }
}

#[test]
fn only_processes_that_exist_are_woken() {
    for pipeline in pipelines() {
        for stage in pipeline.stages {
            assert!(stage.wakes.iter().all(|w| pipeline.stage(w).is_some()));
        }
        assert!(pipeline.main_output().is_some(), "{}", pipeline.main);
    }
}

#[test]
fn neighbours_of_the_chain_lie_one_hop_apart() {
    let hops = |machine| -> Vec<usize> {
        let pipeline = Pipeline::of(machine);
        let of = |s: &Stage| pipeline.hops_before(s);
        pipeline.stages.iter().map(of).collect()
    };
    // sensor, kalman, rls, ukf, logger, probe, sender
    assert_eq!(hops(Machine::Excavator), [0, 1, 2, 1, 0, 3, 0]);
    // sensor, kalman, ukf, logger, probe, sender
    assert_eq!(hops(Machine::Loader), [0, 1, 1, 0, 2, 0]);
}

#[test]
fn the_channels_of_a_machine_are_those_of_its_stages() {
    for pipeline in pipelines() {
        let of_machine: Vec<&str> = channels::of_machine(pipeline.machine)
            .map(|c| c.name)
            .filter(|name| name.starts_with(pipeline.machine.name()) && !name.ends_with("/truth"))
            .collect();
        let outputs = pipeline
            .stages
            .iter()
            .filter_map(|s| Some(s.output()?.name));
        // The supervisor publishes the loads.
        let loads = steps::loads::channel(pipeline.machine).name;
        assert_eq!(outputs.chain([loads]).collect::<Vec<_>>(), of_machine);
    }
}

#[test]
fn every_method_of_the_messages_runs_in_one_process() {
    for (machine, names) in [
        (Machine::Excavator, EXCAVATOR_METHODS),
        (Machine::Loader, LOADER_METHODS),
    ] {
        let pipeline = Pipeline::of(machine);
        let mut offered: Vec<&str> = pipeline
            .stages
            .iter()
            .flat_map(|s| s.methods())
            .copied()
            .collect();
        let mut known = names.to_vec();
        offered.sort_unstable();
        known.sort_unstable();
        assert_eq!(offered, known);
    }
}

#[test]
fn every_method_of_the_table_can_be_made_and_every_other_is_refused() {
    for pipeline in pipelines() {
        let description = Description::default_of(pipeline.machine);
        for (stage, row) in pipeline.rows() {
            let default: &[&str] = &[""];
            let methods = if row.methods().is_empty() {
                default
            } else {
                row.methods()
            };
            for method in methods {
                assert!(
                    row.start(&description, method).is_ok(),
                    "{} {method}",
                    stage.name
                );
            }
            if !row.methods().is_empty() {
                assert!(row.start(&description, "no-such").is_err());
            }
        }
    }
}

#[test]
fn a_description_of_another_machine_is_refused() {
    let loader = Description::default_of(Machine::Loader);
    for (_, row) in Pipeline::of(Machine::Excavator).rows() {
        let refused = row.start(&loader, "auto").err();
        assert_eq!(refused, Some(Error::OtherMachine(Machine::Loader)));
    }
}

#[test]
fn a_method_goes_to_the_process_that_offers_it_and_the_others_keep_their_own() {
    let methods = |machine, asked| {
        Pipeline::of(machine).methods(asked).map(|m| {
            m.into_iter()
                .map(|(p, m)| format!("{p}={m}"))
                .collect::<Vec<_>>()
                .join(" ")
        })
    };
    let excavator = |asked| methods(Machine::Excavator, asked);
    assert_eq!(excavator(None).as_deref(), Ok("rls=svf-rls ukf=auto"));
    assert_eq!(
        excavator(Some("torque")).as_deref(),
        Ok("rls=svf-rls ukf=torque")
    );
    assert_eq!(
        excavator(Some("multi-forgetting-rls")).as_deref(),
        Ok("rls=multi-forgetting-rls ukf=auto")
    );
    assert_eq!(
        methods(Machine::Loader, Some("isr-ukf")).as_deref(),
        Ok("kalman=full-ekf ukf=isr-ukf")
    );
    assert!(excavator(Some("full")).is_err());
}

#[test]
fn a_sample_passes_the_filter_on_its_path_to_the_regression_only() {
    let pipeline = Pipeline::of(Machine::Excavator);
    let hops = |process| -> Vec<Hop> {
        let stage = pipeline.stage(process).expect("a process");
        pipeline
            .path_to(stage)
            .iter()
            .map(|row| row.hop())
            .collect()
    };
    assert_eq!(hops("rls"), [Hop::Filter, Hop::Estimate]);
    assert_eq!(hops("ukf"), [Hop::Estimate]);
}
