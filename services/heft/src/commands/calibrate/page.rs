//! The page of a calibration: values with intervals, residuals, slices of the likelihood, correlations,
//! and the contribution of each recording.

use std::fmt::Write;

use calibrate::honesty::Agreement;
use calibrate::{FitResult, Summary};
use estimation::Quantity;
use view::number;
use view::plot::{Plot, Style, escape};

/// Bars of the histogram of residuals.
const BARS: usize = 40;

/// A value with its standard deviation.
pub fn figure(q: Quantity, unit: &str) -> String {
    number::with_std(q.value, q.std, &number::unit(unit))
}

/// Recognizes such a page by its first bytes.
pub fn is_ours(head: &[u8]) -> bool {
    String::from_utf8_lossy(head).contains("<title>heft calibration")
}

/// The page of a calibration.
pub fn page(summary: &Summary<'_>) -> String {
    let mut body = format!("<h1>Calibration of the {}</h1>", summary.machine);
    verdict(&mut body, summary);
    if let Some(found) = summary.found {
        values(&mut body, summary, found);
        unseen(&mut body, summary, found);
        residuals(&mut body, summary, found);
        slices(&mut body, summary, found);
        correlations(&mut body, summary, found);
        contributions(&mut body, summary, found);
    }
    view::page(&format!("heft calibration: {}", summary.machine), &body)
}

fn verdict(body: &mut String, summary: &Summary<'_>) {
    let (class, word) = if summary.faults.is_empty() {
        ("verdict trusted", "calibrated")
    } else {
        ("verdict", "not calibrated")
    };
    let _ = write!(
        body,
        "<div class=\"{class}\"><p><span class=\"badge\">{word}</span></p>"
    );
    if let Some(found) = summary.found {
        let [before, after] = &found.unseen;
        let _ = write!(
            body,
            "<p class=\"number\">{:.1}\u{a0}%</p><p>of the measurements left out of the fit lie inside their 95\u{a0}% interval; \
             {:.1}\u{a0}% with the machine file as it was.</p>",
            100.0 * after.covered,
            100.0 * before.covered
        );
    }
    for line in summary.faults.iter().chain(summary.remarks) {
        let _ = write!(body, "<p>{}</p>", escape(line));
    }
    if summary.faults.is_empty() {
        body.push_str(
            "<p class=\"when\">Next: estimate another recording with the new machine file (--config), and compare its loads.</p>",
        );
    }
    body.push_str("</div>");
}

fn table(body: &mut String, title: &str, note: &str, head: &[&str], rows: &[Vec<String>]) {
    const WIDE: usize = 12;
    // A narrow screen must not cut the found values.
    let class = match head {
        ["", "before", ..] => "found",
        head if head.len() > WIDE => "dense",
        _ => "",
    };
    let _ = write!(
        body,
        "<section class=\"{class}\"><h2>{}</h2>",
        escape(title)
    );
    if !note.is_empty() {
        let _ = write!(body, "<p class=\"note\">{}</p>", escape(note));
    }
    body.push_str("<div class=\"scroll\"><table><thead><tr>");
    for cell in head {
        let _ = write!(body, "<th>{}</th>", escape(cell));
    }
    body.push_str("</tr></thead><tbody>");
    for row in rows {
        body.push_str("<tr>");
        for cell in row {
            let _ = write!(body, "<td>{}</td>", escape(cell));
        }
        body.push_str("</tr>");
    }
    body.push_str("</tbody></table></div></section>");
}

fn panels(body: &mut String, title: &str, note: &str, plots: &[Plot]) {
    let _ = write!(
        body,
        "<section><h2>{}</h2><p class=\"note\">{}</p><div class=\"panels\">",
        escape(title),
        escape(note)
    );
    for plot in plots {
        let _ = write!(body, "<figure>{}</figure>", plot.svg(445, 250));
    }
    body.push_str("</div></section>");
}

fn values(body: &mut String, summary: &Summary<'_>, found: &FitResult) {
    let parameters = summary.model.parameters().iter().enumerate();
    let rows: Vec<Vec<String>> = parameters
        .filter_map(|(i, p)| {
            let before = Quantity {
                value: p.mean,
                std: p.value_std(0.0, 1.0),
            };
            let noise = p.value_std(found.fit.place[i], found.uncertainty.noise[i]);
            let held = if summary.fixed[i] {
                " (of the machine file)"
            } else {
                ""
            };
            Some(vec![
                format!("{}{held}", p.words),
                figure(before, p.unit),
                figure(summary.quantity(i)?, p.unit),
                number::significant(noise, 2),
                p.key.clone(),
            ])
        })
        .collect();
    table(
        body,
        "What was found",
        &format!(
            "± is one standard deviation; the noise alone would give a smaller one, the scatter from {} to {} widened it {:.2} times.",
            summary.block, summary.block, found.uncertainty.widened
        ),
        &["", "before", "found", "noise alone", "key"],
        &rows,
    );
}

fn unseen(body: &mut String, summary: &Summary<'_>, found: &FitResult) {
    let row = |name: &str, a: &Agreement| {
        vec![
            name.to_owned(),
            a.count.to_string(),
            format!("{:.3}", a.nis),
            format!("{:+.3}", a.correlation),
            format!("{:.1}", 100.0 * a.covered),
        ]
    };
    let [before, after] = &found.unseen;
    table(
        body,
        "Check on data left out of the fit",
        &format!(
            "Every fourth {} was left out, and predicted by a fit to the others. A right model has 1, 0 and 95.",
            summary.block
        ),
        &[
            "",
            "innovations",
            "squares over predicted",
            "correlation with the next",
            "inside 95 %, %",
        ],
        &[row("machine file", before), row("calibrated", after)],
    );
}

/// Normalised innovations of a recording at the found values, over all blocks.
fn normalised(summary: &Summary<'_>, found: &FitResult, recording: usize) -> Vec<f64> {
    let values = calibrate::fit::values(summary.model, &found.fit.place);
    let mut innovations = Vec::new();
    for block in summary.blocks_of(recording) {
        summary.model.innovations(block, &values, &mut innovations);
    }
    innovations
        .iter()
        .map(|i| i.value / i.variance.sqrt())
        .collect()
}

fn residuals(body: &mut String, summary: &Summary<'_>, found: &FitResult) {
    let mut plots = Vec::new();
    for (r, name) in summary.recordings.iter().enumerate() {
        let residuals = normalised(summary, found, r);
        let points: Vec<(f64, f64)> = residuals
            .iter()
            .enumerate()
            .map(|(i, z)| (i as f64, *z))
            .collect();
        let mut course = Plot::new(format!("residual, {name}"), "measurement");
        course.line("innovation / predicted", Style::Series(0), &points);
        course.level("95 %", Style::Limit, estimation::HALF_WIDTH_95);
        course.level("", Style::Limit, -estimation::HALF_WIDTH_95);
        plots.push(course);
        plots.push(histogram(&residuals, name));
    }
    panels(
        body,
        "Residuals",
        "Innovations over their predicted size. They are white and of size one if the model holds.",
        &plots,
    );
}

fn histogram(residuals: &[f64], name: &str) -> Plot {
    let edges: Vec<f64> = (0..=BARS)
        .map(|i| -5.0 + 10.0 * i as f64 / BARS as f64)
        .collect();
    let mut heights = vec![0.0; BARS];
    for z in residuals {
        let bar = ((z + 5.0) / 10.0 * BARS as f64).floor();
        if (0.0..BARS as f64).contains(&bar) {
            heights[bar as usize] += BARS as f64 / (10.0 * residuals.len().max(1) as f64);
        }
    }
    let normal: Vec<(f64, f64)> = edges
        .iter()
        .map(|x| {
            (
                *x,
                (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt(),
            )
        })
        .collect();
    let mut plot = Plot::new(format!("density, {name}"), "innovation / predicted");
    plot.bars("innovations", Style::Series(0), &edges, &heights);
    plot.line("normal", Style::Limit, &normal);
    plot
}

fn slices(body: &mut String, summary: &Summary<'_>, found: &FitResult) {
    let plots: Vec<Plot> = found
        .profiles
        .iter()
        .map(|profile| {
            let p = &summary.model.parameters()[profile.parameter];
            let best = found.fit.place[profile.parameter];
            let std = found.uncertainty.std(profile.parameter);
            let points: Vec<(f64, f64)> = profile
                .points
                .iter()
                .map(|(x, c)| (p.value(*x), *c))
                .collect();
            let parabola: Vec<(f64, f64)> = (-20..=20)
                .map(|k| f64::from(k) / 10.0)
                .map(|k| (p.value(best + k * std), 0.5 * k * k))
                .collect();
            let mut plot = Plot::new(
                "−ln likelihood above its minimum",
                format!("{} {}", p.words, p.unit),
            );
            plot.line("all others fitted again", Style::Series(0), &points);
            plot.line("the stated interval", Style::Limit, &parabola);
            plot
        })
        .collect();
    panels(
        body,
        "Slices of the likelihood",
        "The two parameters that the recordings determine least. Where the first curve is above the second, the stated interval is wide enough.",
        &plots,
    );
}

fn correlations(body: &mut String, summary: &Summary<'_>, found: &FitResult) {
    let free: Vec<usize> = (0..summary.fixed.len())
        .filter(|&i| !summary.fixed[i])
        .collect();
    let head: Vec<String> = std::iter::once(String::new())
        .chain((1..=free.len()).map(|k| k.to_string()))
        .collect();
    let rows: Vec<Vec<String>> = free
        .iter()
        .enumerate()
        .map(|(k, &i)| {
            let cells = free[..k]
                .iter()
                .map(|&j| found.uncertainty.correlation(i, j));
            std::iter::once(format!("{} {}", k + 1, summary.model.parameters()[i].words))
                .chain(cells.map(|c| format!("{c:+.2}")))
                .chain(std::iter::once("1".into()))
                .collect()
        })
        .collect();
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    table(body, "Correlations of the errors", "", &head, &rows);
}

/// Share of each recording in the information on a parameter.
fn contributions(body: &mut String, summary: &Summary<'_>, found: &FitResult) {
    let mut head = vec!["".to_owned()];
    head.extend(summary.recordings.iter().map(|name| format!("{name}, %")));
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (i, parameter) in summary.model.parameters().iter().enumerate() {
        if summary.fixed[i] || summary.loads[i] {
            continue;
        }
        let mut shares = vec![0.0; summary.recordings.len()];
        for (block, information) in found.fit.information.iter().enumerate() {
            let column = (0..information.nrows()).map(|k| information[(k, i)].powi(2));
            shares[summary.model.recording(block)] += column.sum::<f64>();
        }
        let whole: f64 = shares.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let mut row = vec![parameter.words.clone()];
        row.extend(shares.iter().map(|s| format!("{:.0}", 100.0 * s / whole)));
        rows.push(row);
    }
    rows.push(
        std::iter::once("content".to_owned())
            .chain(summary.contents.iter().cloned())
            .collect(),
    );
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    table(
        body,
        "What each recording contributed",
        "Share of the information about each parameter, if all others were known.",
        &head,
        &rows,
    );
}
