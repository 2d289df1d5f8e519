//! `--spin`: processes that poll for messages continuously, each on a core of its own, so that no system call delays
//! an answer.

use std::collections::BTreeMap;

use runtime::realtime;
use steps::stages::{Pipeline, Role, Stage};

use crate::failure::Failure;

/// Stands for every step, and for the probe where there is one.
pub const ALL: &str = "all";

/// Processes that spin, with the core of each.
pub type Spinners = BTreeMap<String, usize>;

/// The named processes, each with a core of its own.
///
/// # Errors
/// A name is not that of a process that can spin, or no core would be left for the run.
pub fn spinners(pipeline: &Pipeline, wanted: &str, has_probe: bool) -> Result<Spinners, Failure> {
    let names = names(pipeline, wanted, has_probe)?;
    let places = places(names.len(), &realtime::cores(), &realtime::isolated_cores());
    let places = places.map_err(|cores| {
        Failure::input(
            format!(
                "{} processes that spin ({}) and the rest of the run need {} cores, and there are {cores}",
                names.len(),
                names.join(", "),
                names.len() + 1
            ),
            "--spin",
            "name fewer of them (--spin=PROCESS), or none: without --spin each sleeps until it is woken",
        )
    })?;
    Ok(names.into_iter().map(str::to_owned).zip(places).collect())
}

/// Excludes this thread, and the processes that it starts, from those cores.
pub fn keep_off(spinners: &Spinners) {
    let mut rest = realtime::cores();
    rest.retain(|core| !spinners.values().any(|taken| taken == core));
    if let Err(error) = realtime::keep_to(&rest) {
        tracing::warn!("the cores of the processes that spin are not theirs alone: {error}");
    }
}

fn names(pipeline: &Pipeline, wanted: &str, has_probe: bool) -> Result<Vec<&'static str>, Failure> {
    let can_spin = |stage: &&Stage| match stage.role {
        Role::Step(_) => true,
        Role::Probe(_) => has_probe,
        Role::Source { .. } | Role::Sink | Role::Sender => false,
    };
    let known = pipeline.stages.iter().filter(can_spin).map(|s| s.name);
    let known: Vec<&str> = known.collect();
    if wanted == ALL {
        return Ok(known);
    }
    let find = |name: &str| {
        let found = known.iter().find(|k| **k == name).copied();
        found.ok_or_else(|| {
            Failure::input(
                format!("no process `{name}` waits for messages"),
                "--spin",
                format!("name some of {}", known.join(", ")),
            )
        })
    };
    let mut names: Vec<&str> = wanted.split(',').map(find).collect::<Result<_, _>>()?;
    names.sort_unstable();
    names.dedup();
    Ok(names)
}

/// Cores for `count` processes: isolated ones first, then the last of the others, never all. `Err` with the number available if there
/// are too few.
fn places(count: usize, cores: &[usize], isolated: &[usize]) -> Result<Vec<usize>, usize> {
    let others = cores.iter().rev().filter(|c| !isolated.contains(c));
    let all: Vec<usize> = isolated.iter().chain(others).copied().collect();
    if count < all.len() {
        Ok(all[..count].to_vec())
    } else {
        Err(all.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Machine;

    #[test]
    fn the_rest_of_the_run_keeps_a_core() {
        assert_eq!(places(1, &[0, 1], &[]), Ok(vec![1]));
        assert_eq!(places(2, &[0, 1], &[]), Err(2));
        assert_eq!(places(3, &[0, 1, 2, 3], &[]), Ok(vec![3, 2, 1]));
        assert_eq!(places(0, &[0], &[]), Ok(vec![]));
        // The kernel keeps programs off isolated cores until they are placed there.
        assert_eq!(places(2, &[0, 1], &[2, 3]), Ok(vec![2, 3]));
        assert_eq!(places(3, &[0, 1], &[2, 3]), Ok(vec![2, 3, 1]));
        assert_eq!(places(4, &[0, 1], &[2, 3]), Err(4));
    }

    #[test]
    fn who_waits_for_messages_can_spin() {
        let pipeline = Pipeline::of(Machine::Excavator);
        let of = |wanted, probe| names(pipeline, wanted, probe);
        assert_eq!(of(ALL, false).unwrap(), ["kalman", "rls", "ukf"]);
        assert_eq!(of("ukf,kalman,ukf", false).unwrap(), ["kalman", "ukf"]);
        assert_eq!(of("probe", true).unwrap(), ["probe"]);
        for wrong in ["sensor", "probe", "logger", ""] {
            let said = of(wrong, false).unwrap_err().to_string();
            assert!(said.contains("name some of kalman, rls, ukf"), "{said}");
        }
    }
}
