//! Errors and remedies for a text that is not TOML.

use core::ops::Range as Span;

use toml_edit::TomlError;

/// Remedy for a text that is not TOML, where the mistake is unknown.
const TOML_REMEDY: &str =
    "correct the TOML there (table in [brackets], key = value, words in quotes, numbers like 0.5)";

/// Typographic characters that resemble a quote, a blank or a minus of TOML.
const TYPESET: [char; 8] = [
    '\u{2018}', '\u{2019}', '\u{201c}', '\u{201d}', '\u{201e}', '\u{a0}', '\u{2212}', '\u{2013}',
];

/// Remedy for a text that is not TOML, whose error is in this line, counted from 1.
pub fn toml_remedy(text: &str, line: Option<usize>) -> String {
    let written = line.and_then(|line| text.lines().nth(line.saturating_sub(1)));
    let remedy = written.and_then(|line| remedy_of(line.trim()));
    remedy.unwrap_or_else(|| TOML_REMEDY.into())
}

/// Remedy for a line with a common mistake.
fn remedy_of(line: &str) -> Option<String> {
    if line.starts_with([';', '%']) || line.starts_with("//") {
        return Some("a comment begins with #".into());
    }
    if line.contains(TYPESET) {
        return Some(
            "type its quotes, blanks and minus signs anew: some are a typesetter's, which only look alike".into(),
        );
    }
    let Some((key, value)) = line.split_once('=') else {
        let (key, _) = line.split_once(':')?;
        let is_key = !key.is_empty() && !key.contains([' ', '"', '{']);
        return is_key.then(|| {
            format!("write {key} = VALUE: = stands between a key and its value, and a table is named in [brackets]")
        });
    };
    let value = value.split('#').next().unwrap_or_default().trim();
    let is_number = |c: char| c.is_ascii_digit() || "+-.,_'".contains(c);
    let number = value.split(|c| !is_number(c)).next().unwrap_or_default();
    let (key, rest) = (key.trim(), value[number.len()..].trim());
    match (number.contains(|c: char| c.is_ascii_digit()), rest) {
        (false, _) => None,
        (true, "") => number.contains([',', '\'']).then(|| {
            format!("write {key} with a decimal point and without marks between thousands, such as 17000 or 5.2")
        }),
        (true, unit) => unit.starts_with(|c: char| c.is_alphabetic() || "°%".contains(c)).then(|| {
            format!("write the number alone, in the unit that {key} has: a unit is no part of TOML")
        }),
    }
}

/// Line of an error, counted from 1, and its description; of a duplicate key, which one.
pub fn toml_error(text: &str, error: &TomlError) -> (Option<usize>, String) {
    let what = error.message().trim().replace('\n', "; ");
    let named = error.span().and_then(|span| text.get(span));
    let what = match named.filter(|key| what == "duplicate key" && !key.is_empty()) {
        Some(key) => format!("{key} stands twice"),
        None => what,
    };
    (error.span().map(|span| line_of(text, &span)), what)
}

/// The line on which a span begins, counted from 1.
pub(crate) fn line_of(text: &str, span: &Span<usize>) -> usize {
    let before = text.get(..span.start).unwrap_or(text);
    before.matches('\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_forms_of_a_number_get_a_remedy() {
        for (line, remedy) in [
            (
                "mass = 17000 kg",
                "the number alone, in the unit that mass has",
            ),
            ("angle = 74.5°", "the number alone"),
            ("efficiency = 95 %", "the number alone"),
            ("length = 5,2", "write length with a decimal point"),
            ("mass = 17,000", "without marks between thousands"),
            ("mass = \u{201c}none\u{201d}", "typesetter's"),
            ("mass\u{a0}= 17000", "typesetter's"),
            ("zero = \u{2212}0.1", "typesetter's"),
            ("mass: 17000", "write mass = VALUE"),
            ("; of a site", "begins with #"),
            ("// of a site", "begins with #"),
            ("mass = = 3", "correct the TOML"),
            ("mass = ", "correct the TOML"),
            ("{\"mass\": 3}", "correct the TOML"),
        ] {
            let text = format!("[machine]\n{line}\n");
            let error = toml_edit::Document::parse(text.clone()).expect_err(line);
            let (at, _) = toml_error(&text, &error);
            let said = toml_remedy(&text, at);
            assert!(said.contains(remedy), "{line}: {said}");
        }
    }

    #[test]
    fn a_key_that_stands_twice_is_named() {
        let said = |text: &str| {
            let error = toml_edit::Document::parse(text.to_owned()).expect_err("no TOML");
            toml_error(text, &error)
        };
        assert_eq!(
            said("[a]\nx = 1\ny = 2\nx = 3\n"),
            (Some(4), "x stands twice".to_owned())
        );
        assert_eq!(said("[a]\nx = \n").0, Some(2));
    }
}
