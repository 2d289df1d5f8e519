//! Foreign text made safe for display: names of columns, files and machines.

use std::fmt::{self, Display, Formatter, Write};

/// Whether a character is invisible but changes the display around it: control characters, marks of
/// direction, and characters without width.
pub fn steers(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{ad}'
                | '\u{61c}'
                | '\u{180e}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{e0000}'..='\u{e007f}'
        )
}

/// A text with such characters escaped (`\u{1b}`), except line breaks and tabs.
pub struct Plain<T>(pub T);

impl<T: Display> Display for Plain<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Writing(f).write_fmt(format_args!("{}", self.0))
    }
}

/// The same on one line: line breaks are escaped too (`\n`), which a file's name may contain.
pub struct OneLine<T>(pub T);

impl<T: Display> Display for OneLine<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Plain(self.0.to_string().replace('\n', "\\n")).fmt(f)
    }
}

/// A word of a shell command: in quotation marks if it contains characters that a shell would interpret.
pub struct Quoted<T>(pub T);

impl<T: Display> Display for Quoted<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let word = self.0.to_string();
        let is_plain = |c: char| c.is_alphanumeric() || "_-./,:=+@%".contains(c);
        match !word.is_empty() && word.chars().all(is_plain) {
            true => f.write_str(&word),
            false => write!(f, "'{}'", word.replace('\'', "'\\''")),
        }
    }
}

/// Writes with these characters escaped.
struct Writing<'a, 'b>(&'a mut Formatter<'b>);

impl Write for Writing<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut rest = text;
        while let Some(at) = rest.find(|c| steers(c) && !matches!(c, '\n' | '\t')) {
            let (before, from) = rest.split_at(at);
            self.0.write_str(before)?;
            let mut characters = from.chars();
            if let Some(c) = characters.next() {
                write!(self.0, "{}", c.escape_unicode())?;
            }
            rest = characters.as_str();
        }
        self.0.write_str(rest)
    }
}

#[cfg(test)]
mod tests {
    use super::{OneLine, Plain, Quoted};

    #[test]
    fn a_shell_takes_a_quoted_name_as_one_word() {
        for name in ["day.csv", "Tag 1 (Größe).csv", "it's $HOME", "", "a;b"] {
            let script = format!("printf %s {}", Quoted(name));
            let output = std::process::Command::new("sh")
                .args(["-c", &script])
                .output();
            let printed = String::from_utf8(output.expect("sh runs").stdout).expect("text");
            assert_eq!(printed, name);
        }
        assert_eq!(Quoted("a/b-1.csv").to_string(), "a/b-1.csv");
    }

    #[test]
    fn what_steers_a_terminal_or_turns_its_text_is_written_out() {
        let name = "a\x1b[31mred\x07.csv";
        let shown = Plain(format_args!("{name}\tok\n\u{9b}2J ± m²")).to_string();
        assert_eq!(shown, "a\\u{1b}[31mred\\u{7}.csv\tok\n\\u{9b}2J ± m²");
        let turned = Plain("swing\u{202e}vsc.\u{200b}x\u{feff}é").to_string();
        assert_eq!(turned, "swing\\u{202e}vsc.\\u{200b}x\\u{feff}é");
        assert_eq!(OneLine("a\nb\x1b").to_string(), "a\\nb\\u{1b}");
    }
}
