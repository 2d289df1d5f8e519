//! Checks the stated masses against torques and motion.

use super::{Drives, Role};
use crate::fit::{Fit, GOOD, Task};
use crate::honesty;
use crate::parameter::Source;

/// Distance of a stated mass from the identified one above which it counts as wrong, in standard deviations.
const DOUBTFUL: f64 = 3.0;
/// Relative prior standard deviation of a mass that is checked.
const ANY_MASS: f64 = 0.5;

/// Stated masses that torques and motion contradict, each identified with the described torque gains.
pub fn doubts(drives: &Drives, task: &Task<'_, Drives>, fit: &Fit) -> Vec<String> {
    let mut sentences = Vec::new();
    for load in 1..drives.loads.len() {
        let Some(stated) = drives.loads[load].mass else {
            continue;
        };
        let Some(at) = drives.index(Role::Mass(load)) else {
            continue;
        };
        let mut open = drives.clone();
        open.parameters[at].std = ANY_MASS * stated.value;
        open.parameters[at].source = Source::Description;
        let mut place = fit.place.clone();
        place[at] = 0.0;
        let asked = Task {
            model: &open,
            least_gain: GOOD,
            progress: &|_| {},
            ..*task
        };
        let answer = asked.run(&place);
        let none = vec![0.0; place.len()];
        let uncertainty = honesty::uncertainty(&answer, &open.parameters, asked.fixed, &none);
        let Some(uncertainty) = uncertainty else {
            continue;
        };
        let found = open.parameters[at].value(answer.place[at]);
        let std = open.parameters[at].value_std(answer.place[at], uncertainty.std(at));
        if (found - stated.value).abs() > DOUBTFUL * (std.powi(2) + stated.std.powi(2)).sqrt() {
            let recordings = drives.drives.iter().zip(&drives.load_of);
            let names: Vec<&str> = recordings
                .filter(|(_, of)| **of == load)
                .map(|(drive, _)| drive.name.as_str())
                .collect();
            sentences.push(format!(
                "the mass in {} was stated as {:.0} kg, but with the torques of the machine file it is {found:.0} ± {std:.0} kg; weigh it again, or check which recording is which",
                names.join(", "),
                stated.value
            ));
        }
    }
    sentences
}
