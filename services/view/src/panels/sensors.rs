//! What the sensors measured, as it came: a panel for each unit.

use super::{Panel, TIME};
use crate::number::unit;
use crate::plot::{Plot, Style};
use crate::run::Input;

/// A panel for each unit, with a line for each signal that has a value.
#[must_use]
pub fn panels(inputs: &[Input]) -> Vec<Panel> {
    let mut units: Vec<&str> = Vec::new();
    for input in inputs {
        if !units.contains(&input.unit) {
            units.push(input.unit);
        }
    }
    units.into_iter().map(|unit| panel(inputs, unit)).collect()
}

fn panel(inputs: &[Input], of: &str) -> Panel {
    let same: Vec<&Input> = inputs.iter().filter(|input| input.unit == of).collect();
    let names: Vec<String> = same
        .iter()
        .map(|input| input.name.replace('_', " "))
        .collect();
    let title = match names.as_slice() {
        [one] => format!("Measured {one} [{}]", unit(of)),
        _ => format!("Measured [{}]", unit(of)),
    };
    let mut plot = Plot::new(title, TIME);
    for (i, (input, name)) in same.iter().zip(&names).enumerate() {
        plot.line(name.as_str(), Style::Series(i), &input.points);
    }
    Panel::half(plot, "")
}
