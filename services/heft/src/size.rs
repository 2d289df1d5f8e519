//! Words on the size of a machine: another one is simulated than is described, or nobody says it.

use std::path::Path;

use config::Description;

use crate::args::{DescriptionArgs, is_of_heft};
use crate::machines;
use crate::plan::Plan;
use crate::sources::is_simulated;

/// A simulated machine that is described by more than this share too heavy or too light is another one.
const SAME_SIZE: f64 = 0.1;

/// Warns where a machine of another size is described than is simulated.
pub fn tell_other_size(plan: &Plan, description: &Description) {
    if !is_simulated(plan) {
        return;
    }
    let (key, simulated) = machines::entry(plan.machine).simulated_mass;
    let described = description.number(key);
    if let Some(kg) = described.filter(|kg| (kg / simulated - 1.0).abs() > SAME_SIZE) {
        let [simulated, described] = [simulated, kg].map(|kg| kg / 1000.0);
        eprintln!(
            "warning: the simulated {} has {simulated} t, and {described} t are described ({key}): the estimates are those of a wrong \
             machine file; leave out --class and --config, or give data of your machine (--input)",
            plan.machine
        );
    }
}

/// Notes that nobody says how large the machine of an input is.
pub fn tell_assumed_size(description: &Description, args: &DescriptionArgs, input: &Path) {
    let (machine, is_told) = (
        description.machine(),
        args.config.is_some() || args.class.is_some(),
    );
    let (key, kg) = machines::entry(machine).simulated_mass;
    let is_reference = description.number(key).is_none_or(|stated| stated == kg);
    if is_reference && !is_told && !is_of_heft(input) {
        eprintln!(
            "note: the {machine} is taken for the reference machine of {} t; say how large yours is (--class 21t), or give its machine file \
             (--config)",
            kg / 1000.0
        );
    }
}
