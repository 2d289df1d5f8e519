//! The few pieces of HTML that the report needs.

pub(super) use crate::plot::escape as text;

/// A page that loads nothing: the policy forbids it even if a value smuggled an address in.
pub(super) fn page(title: &str, styles: &[&str], body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\
         <title>{}</title><style>{}</style></head><body><main>{body}</main></body></html>\n",
        text(title),
        styles.join("\n"),
    )
}

/// A table row of cells that are already HTML.
pub(super) fn row(cells: &[String]) -> String {
    let cells: String = cells.iter().map(|c| format!("<td>{c}</td>")).collect();
    format!("<tr>{cells}</tr>")
}

/// A table in a frame that scrolls where the screen is narrow.
/// The first `names` columns hold names, the others numbers.
pub(super) fn table(names: usize, head: &[&str], rows: &str) -> String {
    let head: String = head.iter().map(|h| format!("<th>{h}</th>")).collect();
    format!(
        "<div class=\"scroll\"><table class=\"names{names}\"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
    )
}
