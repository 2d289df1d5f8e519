//! Figures of the wheel loader paper.

use crate::figures::{Curve, figure, panel};
use crate::plot::Plot;

/// The paper.
const PAPER: &str = "after Yang, Wang, Han 2021";

/// Data of the figures over time, SI units.
#[derive(Debug, Clone, Copy)]
pub struct Series<'a> {
    /// Time \[s\].
    pub t: &'a [f64],
    /// Torque of the front axle [N m].
    pub front_torque: &'a [f64],
    /// Speed [m/s], estimated or measured.
    pub speed: &'a [f64],
    /// True speed [m/s], where it is to be shown.
    pub reference_speed: Option<&'a [f64]>,
    /// True distance from the front axle to the centre of gravity \[m\].
    pub reference_distance: &'a [f64],
    /// Its estimates by method \[m\].
    pub distance: &'a [Curve<'a>],
    /// True height of the centre of gravity \[m\].
    pub reference_height: &'a [f64],
    /// Its estimates by method \[m\].
    pub height: &'a [Curve<'a>],
}

impl Series<'_> {
    fn speed_panel(&self) -> Plot {
        let label = if self.reference_speed.is_some() {
            "estimate"
        } else {
            "speed"
        };
        panel(
            "Speed [m/s]",
            self.t,
            self.reference_speed,
            &[(label, self.speed)],
        )
    }

    fn centre_of_gravity(&self) -> [Plot; 2] {
        [
            panel(
                "Centre of gravity behind the front axle [m]",
                self.t,
                Some(self.reference_distance),
                self.distance,
            ),
            panel(
                "Height of the centre of gravity [m]",
                self.t,
                Some(self.reference_height),
                self.height,
            ),
        ]
    }
}

/// Figs. 4 and 5: speed, position and height of the centre of gravity on a bumpy road, driving and spading. `number` is the
/// number of the figure, `condition` the condition.
pub fn driving(number: &str, condition: &str, series: &Series<'_>) -> String {
    let [distance, height] = series.centre_of_gravity();
    figure(
        number,
        PAPER,
        condition,
        &[series.speed_panel(), distance, height],
    )
}

/// Figs. 7 and 8: torque, speed, position and height in the two experiments, here simulated.
pub fn experiment(number: &str, condition: &str, series: &Series<'_>) -> String {
    let torque = [("front axle torque", series.front_torque)];
    let torque = panel("Front axle torque [N m]", series.t, None, &torque);
    let [distance, height] = series.centre_of_gravity();
    figure(
        number,
        PAPER,
        condition,
        &[torque, series.speed_panel(), distance, height],
    )
}
