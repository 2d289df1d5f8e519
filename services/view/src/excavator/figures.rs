//! Figures of the excavator paper.

use crate::figures::{Curve, figure, panel, points};
use crate::panels::error::histogram;
use crate::plot::{Plot, Style};

/// The paper.
const PAPER: &str = "after Oh, Yi, Seo, Kim, Lee 2017";

/// Fig. 3: inertia by attachment and material in two working postures, normalised by the largest. Each condition is its name and
/// the inertia in posture 1 and 2 (any unit).
pub fn attachments(conditions: &[(&str, f64, f64)]) -> String {
    let largest = conditions
        .iter()
        .fold(f64::MIN_POSITIVE, |m, c| m.max(c.1).max(c.2));
    let names = conditions
        .iter()
        .enumerate()
        .map(|(i, c)| (i as f64, c.0.to_owned()));
    let mut plot = Plot::new("Swing inertia, normalised [–]", "Attachment and material")
        .x_names(names.collect())
        .x_range(-0.5, conditions.len() as f64 - 0.5)
        .y_range(0.0, 1.1);
    for (posture, from) in [(1, -0.3), (2, 0.0)] {
        let mut label = format!("posture {posture}");
        for (i, c) in conditions.iter().enumerate() {
            let (edge, value) = (i as f64 + from, if posture == 1 { c.1 } else { c.2 });
            let style = Style::Series(posture - 1);
            plot.bars(
                std::mem::take(&mut label),
                style,
                &[edge, edge + 0.3],
                &[value / largest],
            );
        }
    }
    figure(
        "3",
        PAPER,
        "inertia by posture, attachment and material",
        &[plot],
    )
}

/// Fig. 8: angles of boom, arm and bucket, and swing angle and velocity [rad, rad/s].
pub fn working_angles(
    t: &[f64],
    joints: [&[f64]; 3],
    swing_angle: &[f64],
    swing_velocity: &[f64],
) -> String {
    let degrees = |values: &[f64]| values.iter().map(|v| v.to_degrees()).collect::<Vec<_>>();
    let joints = joints.map(degrees);
    let [boom, arm, bucket] = &joints;
    let joints: [Curve<'_>; 3] = [("boom", boom), ("arm", arm), ("bucket", bucket)];
    let swing = degrees(swing_angle);
    let panels = [
        panel("Working angles [°]", t, None, &joints),
        panel("Swing angle [°]", t, None, &[("swing angle", &swing)]),
        panel(
            "Swing velocity [rad/s]",
            t,
            None,
            &[("swing velocity", swing_velocity)],
        ),
    ];
    figure("8", PAPER, "working scenario", &panels)
}

/// Fig. 9: the inertia from the geometry, for one or more payloads [kg m²].
pub fn analytic_inertia(t: &[f64], cases: &[Curve<'_>]) -> String {
    let plot = panel("Swing inertia [kg m²]", t, None, cases);
    figure(
        "9",
        PAPER,
        "analytic inertia in the working scenario",
        &[plot],
    )
}

/// Data of Figs. 11, 14 and 17: estimates and truth over time, SI units.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the names of the quantities")]
pub struct Results<'a> {
    pub t: &'a [f64],
    pub inertia: &'a [f64],
    pub true_inertia: &'a [f64],
    pub damping: &'a [f64],
    pub true_damping: &'a [f64],
    pub torque: &'a [f64],
    pub true_torque: &'a [f64],
}

/// Figs. 11, 14, 17: estimation results; `number` is the figure's, `case` its material.
pub fn results(number: &str, case: &str, r: &Results<'_>) -> String {
    let against =
        |title, truth, estimate| panel(title, r.t, Some(truth), &[("estimate", estimate)]);
    let panels = [
        against("Swing inertia [kg m²]", r.true_inertia, r.inertia),
        against("Damping [N m s/rad]", r.true_damping, r.damping),
        against("Torque [N m]", r.true_torque, r.torque),
    ];
    figure(
        number,
        PAPER,
        &format!("estimation results, {case}"),
        &panels,
    )
}

/// Figs. 12, 15, 18: activity of the rule of the nominal damping and of that of the forgetting factors.
pub fn updates(
    number: &str,
    case: &str,
    t: &[f64],
    nominal: &[bool],
    forgetting: &[bool],
) -> String {
    let step = |title: &str, acts: &[bool]| {
        let values: Vec<f64> = acts.iter().map(|a| f64::from(u8::from(*a))).collect();
        let mut plot = Plot::new(title, "Time [s]").y_range(-0.1, 1.1);
        plot.line("1 = updated", Style::Series(0), &points(t, &values));
        plot
    };
    let panels = [
        step("Damping coefficient", nominal),
        step("Forgetting factors", forgetting),
    ];
    figure(number, PAPER, &format!("updating rules, {case}"), &panels)
}

/// Figs. 13, 16, 19: distribution of the error of the inertia [%] with its normal fit.
pub fn error_distribution(number: &str, case: &str, errors: &[f64]) -> String {
    let title = "Error of the swing inertia, share of samples per 1 %";
    let plot = histogram(title, "error", errors, Style::Series(0));
    let plot = plot.unwrap_or_else(|| Plot::new(title, "Relative error [%]"));
    figure(
        number,
        PAPER,
        &format!("error distribution, {case}"),
        &[plot],
    )
}
