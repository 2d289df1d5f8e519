//! The report: one HTML file that opens from disk, without network. Its texts and plots are complete without its script, which
//! only zooms.

mod compared;
mod header;
mod html;
mod loads;
pub(crate) use html::hash;
mod one_by_one;
mod part;
mod tables;
mod verdicts;

use std::fmt::Write;

use crate::estimate::Estimate;
use crate::panels::{self, Panel};
use crate::plot::Plot;
use crate::run::{MachineRun, Run};

pub use compared::compared;
pub use header::NOT_WHOLE;
pub use loads::loads_page;
pub(crate) use tables::state_name;

/// Width and height of a plot over the whole page, over half of it, and of a wide one on a phone.
const WIDE: (u32, u32) = (900, 290);
const HALF: (u32, u32) = (445, 250);
const PHONE: (u32, u32) = (400, 270);

/// A page under construction: its text, and the plots that its script redraws.
#[derive(Debug, Default)]
struct Page {
    body: String,
    plots: Vec<Plot>,
}

/// The report on `run`.
pub fn report(run: &Run) -> String {
    let mut page = Page::default();
    header::write(&mut page.body, run);
    for part in part::all(run) {
        part.sections(&mut page, run);
    }
    let measured = panels::sensors::panels(&run.inputs);
    page.section("What the sensors measured", measured);
    tables::processes(&mut page.body, run);
    tables::configuration(&mut page.body, run);
    html::page_of_plots(&header::title(run), &page.body, &page.plots)
}

/// The headline estimate over time, with its interval, the truth if known, and the trusted stretches: one SVG file that follows
/// the reader's light or dark setting.
pub fn picture(run: &Run) -> String {
    let panels = part::all(run).into_iter().flat_map(|part| part.history());
    let plots: Vec<Plot> = panels.filter(|p| p.wide).map(|p| p.plot).collect();
    crate::plot::file(
        &header::title(run).replacen("report", "estimates", 1),
        "band: 95 % interval; shaded: heft trusts its estimate; dashed: the truth",
        &plots,
        WIDE.0,
        WIDE.1,
    )
}

/// A page in the style of the report around a `body` that is HTML already.
pub fn page(title: &str, body: &str) -> String {
    html::page(title, body)
}

/// All sections of one machine; nothing if the run has no data of it.
fn machine<E: Estimate>(page: &mut Page, run: &Run, part: &MachineRun<E>) {
    if part.estimators.is_empty() {
        return;
    }
    let history = panels::history::panels(part);
    page.section(&format!("What the {} did", E::MACHINE), history);
    // Pauses are detected between neighbouring samples, which a thinned run lacks.
    if run.thinned.is_empty() {
        one_by_one::write(&mut page.body, part);
    }
    page.section("Why heft trusts it, or not", panels::rules::panels(part));
    tables::comparison(&mut page.body, run, part);
    page.section("Errors against the truth", panels::error::panels(part));
    // Whiteness needs neighbouring samples too.
    if run.thinned.is_empty() {
        page.section("Innovations", panels::innovation::panels(part, &run.motion));
    }
    latency(page, run, part);
}

fn latency<E: Estimate>(page: &mut Page, run: &Run, part: &MachineRun<E>) {
    let mut panels = Vec::new();
    let mut rows = String::new();
    for estimator in &part.estimators {
        let hops = panels::latency::hops(estimator);
        tables::hop_rows(&mut rows, &estimator.channel, &hops);
        panels.extend(panels::latency::panel(
            &format!("Share of samples slower: {}", estimator.channel),
            &hops,
        ));
    }
    if panels.is_empty() {
        page.body.push_str("<section><h2>Latency and loss</h2><p>This run was computed in one process: no sample travelled.</p></section>");
        return;
    }
    page.section("Latency and loss", panels);
    tables::latency(&mut page.body, run, &rows, part);
}

impl Page {
    fn section(&mut self, title: &str, panels: Vec<Panel>) {
        if panels.is_empty() {
            return;
        }
        let title = html::text(title);
        let _ = write!(self.body, "<section><h2>{title}</h2><div class=\"panels\">");
        for panel in panels {
            self.panel(panel);
        }
        self.body.push_str("</div></section>");
    }

    /// A plot as SVG; one over time is also passed to the script.
    fn panel(&mut self, panel: Panel) {
        let note = if panel.note.is_empty() {
            String::new()
        } else {
            format!("<figcaption>{}</figcaption>", html::text(&panel.note))
        };
        let svg = |(width, height)| panel.plot.svg(width, height);
        let place = if panel.plot.x_label() == panels::TIME {
            format!(" data-plot=\"{}\"", self.plots.len())
        } else {
            String::new()
        };
        let _ = if panel.wide {
            write!(
                self.body,
                "<figure class=\"wide\"{place}><div class=\"large\">{}</div><div class=\"small\">{}</div>{note}</figure>",
                svg(WIDE),
                svg(PHONE)
            )
        } else {
            write!(self.body, "<figure{place}>{}{note}</figure>", svg(HALF))
        };
        if !place.is_empty() {
            self.plots.push(panel.plot);
        }
    }
}
