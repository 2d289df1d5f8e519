//! The page itself, self-contained.

use axum::http::header;
use axum::response::{Html, IntoResponse, Response};
use messages::Machine;
use serde_json::{Value, json};

use crate::estimate::Estimate;
use crate::monitor::{Each, MachineState, Machines};
use crate::plot;
use crate::posture::{self, Posture};
use crate::report::hash;
use statistics::mean_chi_square_95;

const PAGE: &str = include_str!("../../assets/live.html");
const STYLE: &str = include_str!("../../assets/live.css");
const REPORT_STYLE: &str = include_str!("../../assets/report.css");
const COMMON: &str = include_str!("../../assets/common.js");
const SCRIPT: &str = include_str!("../../assets/live.js");
const UPLOT: &str = include_str!("../../assets/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../assets/uPlot.min.css");

/// A page with its policy: a browser may run the scripts that the page contains now, each identified by its hash, and read the
/// page's own events. Injected scripts do not run.
pub(super) fn closed(page: String) -> Response {
    let policy = policy(&page);
    let headers = [
        (header::CONTENT_SECURITY_POLICY, policy.as_str()),
        (header::CACHE_CONTROL, "no-store"),
    ];
    (headers, Html(page)).into_response()
}

fn policy(page: &str) -> String {
    let scripts = page.split("<script").skip(1).filter_map(|rest| {
        let (attributes, rest) = rest.split_once('>')?;
        let content = rest.split_once("</script>")?.0;
        // JSON data are not executed.
        (!attributes.contains("application/json")).then_some(content)
    });
    let hashes: Vec<String> = scripts.map(hash).collect();
    format!(
        "default-src 'none'; script-src {}; style-src 'unsafe-inline'; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        hashes.join(" ")
    )
}

/// The page with the present status as JSON, so that the verdict is shown before the first event.
pub(super) fn with(status: &str) -> String {
    // Escaped, so that no text closes the element.
    page().replace("<!--FIRST-->", &status.replace('<', "\\u003c"))
}

/// The page with scripts, styles and the tables of parameters inserted.
pub(super) fn page() -> String {
    let none = Machines::default();
    let definitions = Value::Object(none.each(Definition).into_iter().collect());
    let drawing = |machine| {
        let svg = posture::svg(machine, &Posture::default());
        format!(
            "<figure class=\"machine\" id=\"posture-{machine}\" hidden>{svg}<figcaption></figcaption></figure>"
        )
    };
    let postures: String = Machine::ALL.into_iter().map(drawing).collect();
    PAGE.replace(
        "/*STYLE*/",
        &[plot::STYLE, UPLOT_STYLE, REPORT_STYLE, STYLE].concat(),
    )
    .replace("<!--POSTURES-->", &postures)
    .replace("/*UPLOT*/", UPLOT)
    .replace("/*DEFINITIONS*/", &definitions.to_string())
    .replace("/*SCRIPT*/", &[COMMON, SCRIPT].concat())
}

/// Name of a machine, and definitions of its numbers.
struct Definition;

impl Each for Definition {
    type Output = (String, Value);

    fn of<E: Estimate>(&mut self, _: &MachineState<E>) -> (String, Value) {
        let rule = E::INNOVATION;
        let (low, high) = mean_chi_square_95(rule.window as f64 * rule.measurements);
        let parameters = E::PARAMETERS
            .iter()
            .map(|p| json!({"title": p.title(), "headline": p.headline()}));
        let definition = json!({
            "parameters": parameters.collect::<Vec<_>>(),
            "nis": {"limit": rule.limit, "low": low, "high": high},
        });
        (E::MACHINE.name().to_owned(), definition)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_runs_the_scripts_of_the_page_and_no_other() {
        let whole = page();
        let policy = policy(&whole);
        let (scripts, _) = policy.split_once("; style-src").expect("scripts");
        assert_eq!(scripts.matches("'sha256-").count(), 2, "{scripts}");
        assert!(!scripts.contains("unsafe-inline"));
        let injected = whole.replace("<main>", "<main><script>alert(1)</script>");
        assert_ne!(super::policy(&injected), policy, "each by its own hash");
    }

    #[test]
    fn the_page_names_no_address_but_in_the_licence_line_of_uplot() {
        let page = page();
        let addresses: Vec<_> = page
            .match_indices("://")
            .map(|(at, _)| &page[at - 5..at + 25])
            .collect();
        assert_eq!(addresses.len(), 1, "{addresses:?}");
        assert!(page.contains("/*! https://github.com/leeoniya/uPlot (v"));
        for loader in [
            "<link",
            "<img",
            "<iframe",
            "@import",
            "url(",
            "fetch(",
            "XMLHttpRequest",
            "WebSocket",
            "src=",
        ] {
            assert!(!page.contains(loader), "{loader}");
        }
        assert!(!page.contains("/*SCRIPT*/") && page.contains("Swing inertia [kg"));
    }
}
