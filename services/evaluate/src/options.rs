//! What to evaluate, and what came out.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Options {
    /// The table; all if none.
    pub table: Option<String>,
    /// Seeds per case.
    pub seeds: usize,
    /// Threads; 0 for one per core.
    pub threads: usize,
    /// Set it to stop early: what is done by then is reported.
    pub stop: Arc<AtomicBool>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            table: None,
            seeds: 100,
            threads: 0,
            stop: Arc::default(),
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
