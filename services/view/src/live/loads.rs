//! Loads on the live page: content of the bucket, load of the truck, missing mass; a button for the next truck.
//!
//! One panel that needs only `/loads.json`; `/loads` shows it alone.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use steps::loads::LoadCounter;

use super::page::closed;

/// The counter of a run, shared by its writer and its viewers.
#[derive(Debug, Clone)]
pub struct SharedLoads(Arc<Mutex<LoadCounter>>);

impl SharedLoads {
    /// Shares a counter.
    pub fn new(counter: LoadCounter) -> Self {
        Self(Arc::new(Mutex::new(counter)))
    }

    /// The counter.
    pub fn lock(&self) -> MutexGuard<'_, LoadCounter> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Header of a request that changes the state: a page of another site cannot send it.
const ASKED: &str = "x-heft";

/// The present counts.
pub(super) fn state(loads: Option<&SharedLoads>) -> Response {
    let Some(loads) = loads else {
        return (StatusCode::NOT_FOUND, "this run counts no loads").into_response();
    };
    let text = crate::loads::live_json(&loads.lock()).to_string();
    let kind = [
        (header::CONTENT_TYPE, "application/json"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    (kind, text).into_response()
}

/// Starts another truck.
pub(super) fn next_truck(loads: Option<&SharedLoads>, headers: &HeaderMap) -> Response {
    if !headers.contains_key(ASKED) {
        return (StatusCode::FORBIDDEN, "the header x-heft is missing").into_response();
    }
    if let Some(loads) = loads {
        loads.lock().next_truck();
    }
    state(loads)
}

/// The panel by itself.
pub(super) fn panel() -> Response {
    closed(PANEL.to_owned())
}

const PANEL: &str = include_str!("../../assets/loads.html");
