//! Elements of HTML for the report.

use sha2::{Digest, Sha256};

pub(super) use crate::plot::escape as text;
use crate::plot::{self, Plot};

const STYLE: &str = include_str!("../../assets/report.css");
const UPLOT_STYLE: &str = include_str!("../../assets/uPlot.min.css");
/// uPlot as on the live page, and the script that makes plots of the numbers in the page.
const SCRIPT: &str = concat!(
    include_str!("../../assets/uPlot.iife.min.js"),
    include_str!("../../assets/common.js"),
    include_str!("../../assets/report.js")
);

/// A page that loads and runs nothing: the policy forbids it even to an injected value.
pub(super) fn page(title: &str, body: &str) -> String {
    whole(title, &[plot::STYLE, STYLE], "'none'", body, "")
}

/// A page whose `plots` can be zoomed. The policy allows only the script of the report, identified by its hash.
pub(super) fn page_of_plots(title: &str, body: &str, plots: &[Plot]) -> String {
    if plots.is_empty() {
        return page(title, body);
    }
    let data: Vec<_> = plots.iter().map(Plot::data).collect();
    // Escaped, so that no text closes the element.
    let data = serde_json::Value::from(data)
        .to_string()
        .replace('<', "\\u003c");
    let script = format!(
        "<script type=\"application/json\" id=\"plots\">{data}</script><script>{SCRIPT}</script>"
    );
    let styles = [plot::STYLE, UPLOT_STYLE, STYLE];
    let allowed = hash(SCRIPT);
    whole(title, &styles, &allowed, body, &script)
}

fn whole(title: &str, styles: &[&str], allowed: &str, body: &str, script: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src {allowed}\">\
         <title>{}</title><style>{}</style></head><body><main>{body}</main>{script}</body></html>\n",
        text(title),
        styles.join("\n"),
    )
}

/// A script's hash in the form of a policy.
pub(crate) fn hash(script: &str) -> String {
    format!("'sha256-{}'", base64(&Sha256::digest(script)))
}

fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for part in bytes.chunks(3) {
        let word = part
            .iter()
            .fold(0, |word, byte| (word << 8) | usize::from(*byte))
            << (8 * (3 - part.len()));
        for i in 0..4 {
            let letter = char::from(ALPHABET[(word >> (18 - 6 * i)) & 63]);
            out.push(if i <= part.len() { letter } else { '=' });
        }
    }
    out
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        let cases = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn a_label_cannot_end_the_numbers() {
        let mut plot = Plot::new("</script><script>alert(1)</script>", "t");
        plot.line("<!--", crate::plot::Style::Truth, &[(0.0, 1.0)]);
        let page = page_of_plots("t", "", &[plot]);
        assert_eq!(
            page.matches("<script").count(),
            2 + SCRIPT.matches("<script").count()
        );
        assert!(!page.contains("alert(1)</script>"));
    }
}
