//! Requests for messages that did not arrive, for both sides.
//!
//! A request goes to the key of the stream: `?run=R;after=A;upto=B` with the last number that the collector has (its
//! acknowledgement) and the last that it knows of. The replies are the messages as they were sent, then a summary. A machine
//! answers from its recording, a site from its stored estimates.

use serde::{Deserialize, Serialize};
use zenoh::Wait;
use zenoh::query::Query;

/// Most messages in reply to one request; the rest is requested again.
pub const MOST: u64 = 5000;
/// Requests that may wait at the answering side.
pub const WAITING: usize = 64;
/// Attachment of the reply that is the summary.
pub const END: &[u8] = b"end";
/// Error reply of a side that has nothing more of the run.
pub const OVER: &str = "that was another run";

/// Summary of the replies to a request.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnswerSummary {
    /// Everything available up to this number was sent, -1 for nothing.
    pub upto: i64,
    /// Messages sent.
    pub messages: u64,
    /// Messages that are lost for good.
    pub lost: u64,
}

/// Contents of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asked {
    /// Id of the run.
    pub run: i64,
    /// The last number that the collector has.
    pub after: i64,
    /// The last number that it knows of.
    pub upto: i64,
}

impl Asked {
    /// Parses a request; replies with an error if it is malformed.
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

/// Sends the summary. The querier may be gone.
pub fn end(query: &Query, summary: &AnswerSummary) {
    let key = query.key_expr().clone();
    let summary = serde_json::to_vec(summary).unwrap_or_default();
    let _ = query.reply(key, summary).attachment(END).wait();
}
