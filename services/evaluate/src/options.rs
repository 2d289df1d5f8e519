//! Options and results of an evaluation.

/// Options of an evaluation.
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
    /// The same with the number of seeds divided by `many`, for long runs.
    pub(crate) fn one_of(&self, many: usize) -> Self {
        Self {
            seeds: self.seeds.div_ceil(many),
            ..self.clone()
        }
    }
}

/// Results of an evaluation.
#[derive(Clone, Debug)]
pub struct Report {
    /// The tables, to be printed.
    pub text: String,
    /// The same numbers; each table documents its keys.
    pub json: serde_json::Value,
    /// Whether every target is met.
    pub met: bool,
}
