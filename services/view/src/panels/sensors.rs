//! The measurements as received: a panel for each unit.

use super::{Panel, TIME};
use crate::number::unit;
use crate::plot::{Plot, Style};
use crate::run::Input;

/// A panel for each unit, with a line for each signal that has a value.
pub fn panels(inputs: &[Input]) -> Vec<Panel> {
    let mut units: Vec<&str> = Vec::new();
    for input in inputs {
        if !units.contains(&input.unit) {
            units.push(input.unit);
        }
    }
    units.into_iter().map(|unit| panel(inputs, unit)).collect()
}

/// Name and shown unit of the signals of a unit, and their divisor: a pressure in Pa has too many digits.
fn kind(of: &str) -> (&'static str, String, f64) {
    let kind = match of {
        "rad" => "angles",
        "rad/s" => "angular velocities",
        "N m" => "torques",
        "N" => "forces",
        "m/s" => "speeds",
        "Pa" => return ("pressures", "bar".into(), 1e5),
        _ => "signals",
    };
    (kind, unit(of), 1.0)
}

fn panel(inputs: &[Input], of: &str) -> Panel {
    let same: Vec<&Input> = inputs.iter().filter(|input| input.unit == of).collect();
    let names: Vec<String> = same
        .iter()
        .map(|input| {
            input
                .name
                .replace("spade_force", "bucket_force")
                .replace('_', " ")
        })
        .collect();
    let (kind, unit, divisor) = kind(of);
    let title = match names.as_slice() {
        [one] => format!("Measured {one} [{unit}]"),
        _ => format!("Measured {kind} [{unit}]"),
    };
    let mut plot = Plot::new(title, TIME);
    for (i, (input, name)) in same.iter().zip(&names).enumerate() {
        let points: Vec<_> = input
            .points
            .iter()
            .map(|(t, v)| (*t, v / divisor))
            .collect();
        plot.line(name.as_str(), Style::Series(i), &points);
    }
    Panel::half(plot, "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_of_a_unit_share_a_panel_with_a_name_and_pressures_are_in_bar() {
        let input = |name, unit, value| Input {
            name,
            unit,
            points: vec![(0.0, value), (1.0, value)],
        };
        let panels = panels(&[
            input("boom_head_pressure", "Pa", 1.5e7),
            input("swing_torque", "N m", 4000.0),
            input("boom_rod_pressure", "Pa", 1e6),
        ]);
        let [pressures, torque] = panels.as_slice() else {
            panic!("{} panels", panels.len());
        };
        let svg = pressures.plot.svg(445, 250);
        assert!(
            svg.contains("Measured pressures [bar]") && svg.contains(">150<"),
            "{svg}"
        );
        assert!(
            torque
                .plot
                .svg(445, 250)
                .contains("Measured swing torque [")
        );
    }
}
