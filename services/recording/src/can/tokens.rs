//! The words of a DBC file.

/// A word, a text in quotes, or a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Letters, digits and the characters of numbers.
    Word,
    /// The text between quotes, without them.
    Text,
    /// One of `: ; , | @ ( ) [ ]`.
    Sign,
}

/// A token and its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Token<'a> {
    pub kind: Kind,
    pub text: &'a str,
    /// Line, counted from 1.
    pub line: usize,
    /// Whether it is the first of its line.
    pub first: bool,
}

/// The tokens of `text`.
pub(super) fn tokens(text: &str) -> impl Iterator<Item = Token<'_>> {
    Tokens {
        rest: text,
        line: 1,
        first: true,
    }
}

struct Tokens<'a> {
    rest: &'a str,
    line: usize,
    first: bool,
}

const SIGNS: &[char] = &[':', ';', ',', '|', '@', '(', ')', '[', ']'];

impl<'a> Iterator for Tokens<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        let start = self.rest.find(|c: char| !c.is_whitespace())?;
        self.advance(start);
        let (line, first) = (self.line, self.first);
        self.first = false;
        let (kind, text) = if self.rest.starts_with('"') {
            let end = end_of_text(self.rest);
            let text = self.rest.get(1..end).unwrap_or_default();
            self.advance((end + 1).min(self.rest.len()));
            (Kind::Text, text)
        } else if self.rest.starts_with(SIGNS) {
            (Kind::Sign, self.advance(1))
        } else {
            let word = |c: char| c.is_whitespace() || c == '"' || SIGNS.contains(&c);
            let end = self.rest.find(word).unwrap_or(self.rest.len());
            (Kind::Word, self.advance(end))
        };
        self.first &= self.line != line;
        Some(Token {
            kind,
            text,
            line,
            first,
        })
    }
}

impl<'a> Tokens<'a> {
    /// Advances by `bytes`, and counts the lines.
    fn advance(&mut self, bytes: usize) -> &'a str {
        let (passed, rest) = self.rest.split_at(bytes);
        let lines = passed.matches('\n').count();
        self.line += lines;
        self.first |= lines > 0;
        self.rest = rest;
        passed
    }
}

/// Position of the closing quote; a quote after a backslash does not close. The end of the file
/// closes too.
fn end_of_text(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = 1;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'"' => return at,
            b'\\' if bytes.get(at + 1) == Some(&b'"') => at += 2,
            _ => at += 1,
        }
    }
    text.len()
}
