//! The page of the fleet, on this host only: a table of all machines, and a page for each machine in the style and words of the
//! live page. It has no script and no external resources.

use std::fmt::Write;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use axum::Router;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;
use tokio::sync::oneshot;
use view::live::{ServerThread, names_this_host};
use view::plot::escape;

use super::live::{Fleet, Machine};
use super::{machine_page, shown};
use crate::key::MachineId;
use crate::lock;

/// Refresh period of the page [s].
const REFRESH: &str = "2";
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Most machines in the table.
const ROWS: usize = 2000;

/// The server of the page; it runs until dropped.
pub struct Server {
    address: SocketAddr,
    _thread: ServerThread,
}

impl Server {
    /// Its address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

#[derive(Clone)]
struct Shared {
    fleet: Arc<Mutex<Fleet>>,
    db: PathBuf,
}

/// Shows the fleet.
///
/// # Errors
/// The address is taken.
pub fn serve(address: SocketAddr, fleet: Arc<Mutex<Fleet>>, db: PathBuf) -> Result<Server, String> {
    let failed = |e: io::Error| {
        let remedy = "choose another port: --page 8451";
        crate::error(
            format!("cannot show the page: {e}"),
            format!("--page {address}"),
            remedy,
        )
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_io()
        .enable_time()
        .build()
        .map_err(failed)?;
    let listener = runtime
        .block_on(tokio::net::TcpListener::bind(address))
        .map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let (stop, stopped) = oneshot::channel::<()>();
    let router = Router::new()
        .route("/", get(table))
        .route("/{site}/{machine}", get(machine))
        .with_state(Shared { fleet, db });
    let thread = std::thread::spawn(move || {
        runtime.block_on(async move {
            tokio::select! {
                _ = axum::serve(listener, router) => {}
                _ = stopped => {}
            }
        });
    });
    Ok(Server {
        address,
        _thread: ServerThread::new(stop, thread),
    })
}

fn answer(
    headers: &HeaderMap,
    refresh: &'static str,
    page: impl FnOnce() -> Option<String>,
) -> Response {
    if !names_this_host(headers) {
        return StatusCode::FORBIDDEN.into_response();
    }
    let Some(page) = page() else {
        return (StatusCode::NOT_FOUND, "there is no such machine").into_response();
    };
    let fields = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::CACHE_CONTROL, "no-store"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFRESH, refresh),
    ];
    (fields, Html(page)).into_response()
}

async fn table(State(shared): State<Shared>, headers: HeaderMap) -> Response {
    answer(&headers, REFRESH, || {
        let fleet = lock(&shared.fleet);
        Some(view::page("heft fleet", &body(&fleet)))
    })
}

async fn machine(
    State(shared): State<Shared>,
    Path((site, machine)): Path<(String, String)>,
    headers: HeaderMap,
) -> Response {
    answer(&headers, "10", || {
        let id = MachineId::new(&site, &machine)?;
        let head = {
            let fleet = lock(&shared.fleet);
            machine_page::Head::of(&id, fleet.machines.get(&id)?)
        };
        machine_page::page(&shared.db, &id, &head)
    })
}

/// Keeps the table readable on a narrow screen, and shows states by colour and by word.
const STYLE: &str = "<style>main{max-width:1300px}.bad{color:var(--bad);font-weight:600}.good{color:var(--good);font-weight:600}\
td.words{white-space:normal;text-align:left;min-width:12em}a{color:inherit}</style>";

fn body(fleet: &Fleet) -> String {
    let here = fleet.machines.values().filter(|m| m.is_here()).count();
    let alarms: usize = fleet.machines.values().map(|m| m.alarms.on.len()).sum();
    let mut out = format!(
        "{STYLE}<h1>Fleet</h1><p class=\"facts\">{} machines, {here} here; alarms: {alarms}</p>",
        fleet.machines.len()
    );
    if let Some((why, since)) = &fleet.unkept {
        let (why, seconds) = (escape(why), since.elapsed().as_secs());
        let _ = write!(
            out,
            "<p class=\"badge\">Nothing has been kept for {seconds} s: {why}</p>"
        );
    }
    if fleet.turned_away > 0 {
        let messages = fleet.turned_away;
        let _ = write!(
            out,
            "<p class=\"badge\">{messages} messages of machines for which there was no room were not taken</p>"
        );
    }
    let head = [
        "site",
        "machine",
        "kind",
        "verdict",
        "quantity",
        "95 % interval",
        "last load",
        "age",
        "alarms",
        "lost",
        "gaps",
        "runs not received",
        "refused",
        "version",
    ];
    let head: String = head.iter().map(|h| format!("<th>{h}</th>")).collect();
    let _ = write!(
        out,
        "<div class=\"scroll\"><table class=\"names2\"><thead><tr>{head}</tr></thead><tbody>"
    );
    for (id, machine) in fleet.machines.iter().take(ROWS) {
        row(&mut out, id, machine);
    }
    out.push_str("</tbody></table></div>");
    if fleet.machines.len() > ROWS {
        let _ = write!(
            out,
            "<p class=\"note\">The first {ROWS} machines; `heft fleet query` has all.</p>"
        );
    }
    out.push_str(
        "<p class=\"note\">age: since the machine last spoke. lost: messages that nobody has any more. gaps: streams of which something \
         is missing and is being asked for. runs not received: whole runs that the machine has counted and of which nothing came. refused: messages under the machine's keys that were not taken.</p>",
    );
    out
}

fn row(out: &mut String, id: &MachineId, machine: &Machine) {
    let quantity = machine.headline();
    let verdict = match &quantity {
        _ if machine.broke_off => "<span class=\"bad\">broke off</span>",
        _ if !machine.is_here() => "<span class=\"bad\">away</span>",
        Some(q) if q.trusted => "<span class=\"good\">trusted</span>",
        Some(_) => "not trusted",
        None => "no estimate",
    };
    let value = quantity
        .as_ref()
        .map_or(String::new(), |q| format!("{} {}", q.label, q.text()));
    let interval = quantity
        .as_ref()
        .map_or(String::new(), shown::Quantity::interval);
    let load = machine.main("loads").and_then(|(_, e)| shown::load(e));
    let load = load.map_or(String::new(), |q| {
        let doubt = if q.trusted { "" } else { " ?" };
        format!("{} {}{doubt}", q.label, q.text())
    });
    let age = machine.heard.map_or("–".into(), |h| {
        format!("{:.0} s", h.elapsed().as_secs_f64())
    });
    let alarms: Vec<&str> = machine.alarms.on.values().map(String::as_str).collect();
    let refused: u64 = machine.refused.values().sum();
    let name = format!(
        "<a href=\"/{0}/{1}\">{1}</a>",
        escape(&id.site),
        escape(&id.machine)
    );
    let cells = [
        escape(&id.site),
        name,
        escape(&machine.kind),
        verdict.to_owned(),
        escape(&value),
        escape(&interval),
        escape(&load),
        age,
        format!("<span class=\"bad\">{}</span>", escape(&alarms.join("; "))),
        machine.account.lost.to_string(),
        machine.account.gaps.to_string(),
        machine.account.unheard.to_string(),
        refused.to_string(),
        escape(&machine.version),
    ];
    out.push_str("<tr>");
    for cell in cells {
        let _ = write!(out, "<td>{cell}</td>");
    }
    out.push_str("</tr>");
}
