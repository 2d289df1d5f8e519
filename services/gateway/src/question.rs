//! Questions for what did not arrive, as who asks and who answers have them.
//!
//! A question goes to the key of the stream: `?run=R;after=A;upto=B` with the last number that the collector has (its
//! acknowledgement) and the last that it knows of. The answers are the messages as they were sent, then one that says how
//! far they go. A machine answers from its recording, a site from what it has kept of its own estimates.

use serde::{Deserialize, Serialize};
use zenoh::Wait;
use zenoh::query::Query;

/// Answers to one question; the rest is asked for again.
pub const MOST: u64 = 5000;
/// Questions that may wait at whoever answers.
pub const WAITING: usize = 64;
/// The attachment of the answer that says how far the others go.
pub const END: &[u8] = b"end";
/// The error of whoever has nothing more of the run.
pub const OVER: &str = "that was another run";

/// How far the answers to a question go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnswerSummary {
    /// Everything up to this number that can be had was sent, -1 for nothing.
    pub upto: i64,
    /// Messages sent.
    pub messages: u64,
    /// Messages that nobody holds any more.
    pub lost: u64,
}

/// What a question asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asked {
    /// Id of the run.
    pub run: i64,
    /// The last number that is there.
    pub after: i64,
    /// The last number that is known of.
    pub upto: i64,
}

impl Asked {
    /// Reads a question; one that cannot be read is told so.
    pub fn of(query: &Query) -> Option<Self> {
        let parameters = query.parameters();
        let number = |name: &str| parameters.get(name)?.parse::<i64>().ok();
        let asked = (|| {
            Some(Self {
                run: number("run")?,
                after: number("after")?,
                upto: number("upto")?,
            })
        })();
        if asked.is_none() {
            let _ = query.reply_err("run, after and upto are numbers").wait();
        }
        asked
    }
}

/// Says how far the answers went. Whoever asked may be gone.
pub fn end(query: &Query, summary: &AnswerSummary) {
    let key = query.key_expr().clone();
    let summary = serde_json::to_vec(summary).unwrap_or_default();
    let _ = query.reply(key, summary).attachment(END).wait();
}
