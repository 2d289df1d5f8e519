//! The page itself: everything it needs is in it.

use serde_json::{Value, json};

use crate::estimate::Estimate;
use crate::monitor::Machines;
use crate::plot;
use statistics::mean_chi_square_95;

const PAGE: &str = include_str!("../../assets/live.html");
const STYLE: &str = include_str!("../../assets/live.css");
const REPORT_STYLE: &str = include_str!("../../assets/report.css");
const COMMON: &str = include_str!("../../assets/common.js");
const SCRIPT: &str = include_str!("../../assets/live.js");
const UPLOT: &str = include_str!("../../assets/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../assets/uPlot.min.css");

/// What a browser may do with the page: run what is in it and read its own events.
pub(super) const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; \
    style-src 'unsafe-inline'; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The page with scripts, styles and the tables of parameters put in.
pub(super) fn page() -> String {
    let none = Machines::default();
    let definitions = none
        .all()
        .map(|m| (m.machine().name().to_owned(), m.definition()));
    let definitions = Value::Object(definitions.into_iter().collect());
    PAGE.replace(
        "/*STYLE*/",
        &[plot::STYLE, UPLOT_STYLE, REPORT_STYLE, STYLE].concat(),
    )
    .replace("/*UPLOT*/", UPLOT)
    .replace("/*DEFINITIONS*/", &definitions.to_string())
    .replace("/*SCRIPT*/", &[COMMON, SCRIPT].concat())
}

pub(crate) fn definition<E: Estimate>() -> Value {
    let rule = E::INNOVATION;
    let (low, high) = mean_chi_square_95(rule.window as f64 * rule.measurements);
    let parameters = E::PARAMETERS
        .iter()
        .map(|p| json!({"title": p.title(), "headline": p.headline()}));
    json!({
        "parameters": parameters.collect::<Vec<_>>(),
        "nis": {"limit": rule.limit, "low": low, "high": high},
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
