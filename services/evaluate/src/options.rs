//! What to evaluate, and what came out.

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Options {
    /// The table; all if none.
    pub table: Option<String>,
    /// Seeds per case.
    pub seeds: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            table: None,
            seeds: 100,
        }
    }
}

impl Options {
    /// The same with one of so many seeds, for what takes long.
    pub(crate) fn one_of(&self, many: usize) -> Self {
        Self {
            seeds: self.seeds.div_ceil(many),
            ..self.clone()
        }
    }
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Report {
    /// The tables, to be printed.
    pub text: String,
    /// The same numbers; each table documents its keys.
    pub json: serde_json::Value,
    /// Whether every target is met.
    pub met: bool,
}
