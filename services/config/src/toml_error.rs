//! What is said of a text that is no TOML.

use core::ops::Range as Span;

use toml_edit::TomlError;

/// What to do about a text that is no TOML.
pub const TOML_REMEDY: &str =
    "correct the TOML there (table in [brackets], key = value, words in quotes, numbers like 0.5)";

/// The line of an error, counted from 1, and what is wrong there: of a key that stands twice, which one.
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
