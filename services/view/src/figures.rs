//! The papers' figures, drawn from our runs: each function takes plain series and returns the text of an SVG file that states the
//! source of its data.

use crate::plot::{Plot, Style};

/// Size of one panel of a figure.
const WIDTH: u32 = 640;
const HEIGHT: u32 = 230;

/// A line of a panel: its name in the legend and its values, one for each time.
pub type Curve<'a> = (&'a str, &'a [f64]);

/// A figure with caption and panels; "heft" marks the data as those of this project.
pub(crate) fn figure(number: &str, paper: &str, what: &str, panels: &[Plot]) -> String {
    let caption = format!("Fig. {number}: {what}");
    crate::plot::file(
        &caption,
        &format!("Data of heft, {paper}"),
        panels,
        WIDTH,
        HEIGHT,
    )
}

pub(crate) fn points(t: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    t.iter().copied().zip(values.iter().copied()).collect()
}

/// Curves over time, the reference dashed and on top.
pub(crate) fn panel(
    title: &str,
    t: &[f64],
    reference: Option<&[f64]>,
    curves: &[Curve<'_>],
) -> Plot {
    let mut plot = Plot::new(title, "Time [s]");
    for (i, (label, values)) in curves.iter().enumerate() {
        plot.line(*label, Style::Series(i), &points(t, values));
    }
    if let Some(reference) = reference {
        plot.line("reference", Style::Truth, &points(t, reference));
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excavator::figures as excavator;
    use crate::loader::figures as loader;

    #[test]
    fn every_figure_stands_alone_and_says_whose_data_it_shows() {
        let t: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.02).collect();
        let wave: Vec<f64> = t.iter().map(|t| t.sin()).collect();
        let on: Vec<bool> = wave.iter().map(|w| *w > 0.0).collect();
        let curves: [Curve<'_>; 2] = [("isr-ukf", &wave), ("ekf", &wave)];
        let cg = loader::Series {
            t: &t,
            front_torque: &wave,
            speed: &wave,
            reference_speed: None,
            reference_distance: &wave,
            distance: &curves,
            reference_height: &wave,
            height: &curves,
        };
        let results = excavator::Results {
            t: &t,
            inertia: &wave,
            true_inertia: &wave,
            damping: &wave,
            true_damping: &wave,
            torque: &wave,
            true_torque: &wave,
        };
        let files = [
            excavator::attachments(&[("bucket, 0 kg", 1.0, 0.6), ("crusher, 423 kg", 1.4, 0.9)]),
            excavator::working_angles(&t, [&wave, &wave, &wave], &wave, &wave),
            excavator::analytic_inertia(&t, &[("288 kg", &wave)]),
            excavator::results("11", "no material", &results),
            excavator::updates("12", "no material", &t, &on, &on),
            excavator::error_distribution("13", "no material", &wave),
            loader::driving("4", "a bumpy road", &cg),
            loader::experiment("7", "constant torque", &cg),
        ];
        for file in files {
            assert!(
                file.starts_with("<svg xmlns=")
                    && file.contains("Data of heft")
                    && file.ends_with("</svg>\n")
            );
            assert!(!file.contains("NaN"));
        }
    }
}
