//! The report: one HTML file that opens from disk, without script or network.

mod header;
mod html;
mod tables;

use messages::{Health, Machine};

use crate::estimate::Estimate;
use crate::panels::{self, Panel};
use crate::run::{MachineRun, Run};

pub(crate) use tables::state_name;

/// Style of the page; the plots bring their own.
const STYLE: &str = include_str!("../assets/report.css");

/// Width and height of a plot over the whole page, of half of it, and of a wide one on a phone.
const WIDE: (u32, u32) = (900, 290);
const HALF: (u32, u32) = (445, 250);
const PHONE: (u32, u32) = (400, 270);

/// The report on `run`.
#[must_use]
pub fn report(run: &Run) -> String {
    let mut body = String::new();
    header::write(&mut body, run);
    machine(
        &mut body,
        run,
        &run.excavator,
        panels::rules::excavator(&run.excavator),
    );
    machine(
        &mut body,
        run,
        &run.loader,
        panels::rules::loader(&run.loader),
    );
    section(
        &mut body,
        "What the sensors measured",
        panels::sensors::panels(&run.inputs),
    );
    tables::processes(&mut body, run);
    tables::configuration(&mut body, run);
    html::page(&header::title(run), &[crate::plot::STYLE, STYLE], &body)
}

/// A page in the style of the report around a `body` that is HTML already.
#[must_use]
pub fn page(title: &str, body: &str) -> String {
    html::page(title, &[crate::plot::STYLE, STYLE], body)
}

/// All sections of one machine; nothing where the run has none of it.
fn machine<E: Estimate>(body: &mut String, run: &Run, part: &MachineRun<E>, rules: Vec<Panel>) {
    if part.estimators.is_empty() {
        return;
    }
    section(
        body,
        &format!("What the {} did", E::MACHINE),
        panels::history::panels(part),
    );
    tables::stretches(body, part);
    section(body, "Why heft trusts it, or not", rules);
    tables::comparison(body, run, part);
    section(
        body,
        "Errors against the truth",
        panels::error::panels(part),
    );
    let motion = if E::MACHINE == Machine::Excavator {
        run.motion.as_slice()
    } else {
        &[]
    };
    // They are judged by neighbours.
    if run.thinned.is_empty() {
        section(
            body,
            "Innovations",
            panels::innovation::panels(part, motion),
        );
    }
    latency(body, run, part);
}

fn latency<E: Estimate>(body: &mut String, run: &Run, part: &MachineRun<E>) {
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
        body.push_str("<section><h2>Latency and loss</h2><p>This run was computed in one process: no sample travelled.</p></section>");
        return;
    }
    section(body, "Latency and loss", panels);
    tables::latency(body, run, &rows, part);
}

fn section(body: &mut String, title: &str, panels: Vec<Panel>) {
    if panels.is_empty() {
        return;
    }
    body.push_str(&format!(
        "<section><h2>{}</h2><div class=\"panels\">",
        html::text(title)
    ));
    for panel in &panels {
        write_panel(body, panel);
    }
    body.push_str("</div></section>");
}

fn write_panel(body: &mut String, panel: &Panel) {
    let note = if panel.note.is_empty() {
        String::new()
    } else {
        format!("<figcaption>{}</figcaption>", html::text(&panel.note))
    };
    if panel.wide {
        let (wide, phone) = (
            panel.plot.svg(WIDE.0, WIDE.1),
            panel.plot.svg(PHONE.0, PHONE.1),
        );
        body.push_str(&format!(
            "<figure class=\"wide\"><div class=\"large\">{wide}</div><div class=\"small\">{phone}</div>{note}</figure>"
        ));
    } else {
        body.push_str(&format!(
            "<figure>{}{note}</figure>",
            panel.plot.svg(HALF.0, HALF.1)
        ));
    }
}

/// The last health message of each process, in the order of the table of processes.
fn last_health(run: &Run) -> Vec<&Health> {
    let mut last: std::collections::BTreeMap<u32, &Health> = std::collections::BTreeMap::new();
    for health in &run.health {
        last.insert(health.process, health);
    }
    last.into_values().collect()
}
