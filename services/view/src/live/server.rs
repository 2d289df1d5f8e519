//! The server: one thread, one task a viewer, one task that takes the frames.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use axum::Router;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_util::stream::{self, Stream, StreamExt};
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::broadcast::{self, error::RecvError};
use tokio::sync::{Notify, oneshot};

use super::connections::Door;
use super::{Feed, frame, loads, metrics, page};

/// Most viewers at a time; the next one is rejected with a request to wait.
pub const MAX_VIEWERS: usize = 16;
/// Period of frames without viewers: they form the history for the next viewer.
const IDLE_PERIOD: Duration = Duration::from_millis(100);
/// Period of frames with viewers: at most 30 a second.
const PERIOD: Duration = Duration::from_millis(34);
/// Frames per status: words change slower than numbers, so they are sent 4 times a second.
const STATUS_EVERY: u64 = 8;
/// Frames by which a viewer may lag before it skips the oldest: 2 s.
const RING: usize = 64;
/// Bytes that the kernel buffers for a viewer.
const SEND_BUFFER: u32 = 64 * 1024;
/// Frames in the history of a new viewer: one minute.
const HISTORY: usize = 1800;

/// A running page; dropping it ends it, with all its viewers.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    shared: Arc<Shared>,
    _thread: ServerThread,
}

impl Server {
    /// Its address; with the chosen port where 0 was requested.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Viewers right now.
    pub fn viewers(&self) -> usize {
        self.shared.viewers.load(Ordering::Relaxed)
    }

    /// Frames that slow viewers skipped so far.
    pub fn skipped(&self) -> u64 {
        self.shared.skipped.load(Ordering::Relaxed)
    }
}

/// The thread of a server; dropping it ends the server and waits for it.
#[derive(Debug)]
pub struct ServerThread {
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl ServerThread {
    /// A thread that ends at a signal on `stop`.
    pub fn new(stop: oneshot::Sender<()>, thread: JoinHandle<()>) -> Self {
        Self {
            stop: Some(stop),
            thread: Some(thread),
        }
    }
}

impl Drop for ServerThread {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// State shared by the tasks.
#[derive(Debug)]
struct Shared {
    feed: Feed,
    /// Time of the last frame by the data [s].
    shown: Mutex<f64>,
    /// Notified when a viewer arrives.
    came: Notify,
    frames: broadcast::Sender<Frame>,
    history: Mutex<VecDeque<Arc<str>>>,
    viewers: AtomicUsize,
    skipped: AtomicU64,
    loopback: bool,
}

/// An event for all viewers.
#[derive(Debug, Clone)]
struct Frame {
    kind: &'static str,
    data: Arc<str>,
}

/// Shows `feed` at `address`.
///
/// # Errors
/// The address cannot be bound, or the thread not started.
pub fn serve(address: SocketAddr, feed: Feed) -> io::Result<Server> {
    serve_every(PERIOD, address, feed)
}

/// [`serve`] with a frame every `period`.
pub(super) fn serve_every(period: Duration, address: SocketAddr, feed: Feed) -> io::Result<Server> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_io()
        .enable_time()
        .build()?;
    let listener = {
        let _context = runtime.enter();
        listen(address)?
    };
    let address = listener.local_addr()?;
    let shared = Arc::new(Shared {
        feed,
        shown: Mutex::new(f64::NEG_INFINITY),
        came: Notify::new(),
        frames: broadcast::channel(RING).0,
        history: Mutex::new(VecDeque::with_capacity(HISTORY)),
        viewers: AtomicUsize::new(0),
        skipped: AtomicU64::new(0),
        loopback: address.ip().is_loopback(),
    });
    let (stop, stopped) = oneshot::channel();
    let for_thread = Arc::clone(&shared);
    let thread = std::thread::Builder::new()
        .name("live page".into())
        .spawn(move || {
            runtime.block_on(async move {
                tokio::spawn(take_frames(period, Arc::clone(&for_thread)));
                run(listener, for_thread, stopped).await;
            });
            // Dropping the runtime here closes every connection, including stalled ones.
        })?;
    Ok(Server {
        address,
        shared,
        _thread: ServerThread::new(stop, thread),
    })
}

/// A listening socket whose connections have small buffers, which bounds the kernel memory of a stalled viewer.
fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() {
        TcpSocket::new_v4()
    } else {
        TcpSocket::new_v6()
    }?;
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.bind(address)?;
    socket.listen(64)
}

async fn run(listener: TcpListener, shared: Arc<Shared>, stopped: oneshot::Receiver<()>) {
    let router = Router::new()
        .route("/", get(show))
        .route("/events", get(events))
        .route("/loads", get(show_loads))
        .route("/loads.json", get(state_of_loads))
        .route("/metrics", get(show_metrics))
        .route("/next-truck", post(next_truck))
        .with_state(shared);
    let serving = Box::pin(async move { axum::serve(Door::new(listener), router).await });
    futures_util::future::select(serving, stopped).await;
}

/// Takes a frame every `period` while there are viewers, and less often otherwise.
async fn take_frames(period: Duration, shared: Arc<Shared>) {
    let mut clock = tokio::time::interval(period);
    clock.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    for turn in 0u64.. {
        clock.tick().await;
        let viewers = shared.viewers.load(Ordering::Relaxed);
        if viewers == 0 {
            let _ = tokio::time::timeout(IDLE_PERIOD, shared.came.notified()).await;
        }
        shared.take_series();
        if viewers > 0 && turn.is_multiple_of(STATUS_EVERY) {
            shared.send("status", shared.status().into());
        }
    }
}

impl Shared {
    /// Takes a frame of the numbers if there are new ones.
    fn take_series(&self) {
        let series = {
            let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
            let monitor = self.feed.lock();
            if monitor.time == *shown || monitor.channels.is_empty() {
                return;
            }
            *shown = monitor.time;
            frame::series(&monitor)
        };
        let data: Arc<str> = series.into();
        self.remember(Arc::clone(&data));
        self.send("series", data);
    }

    /// The present status in words.
    fn status(&self) -> String {
        // The requester counts as a viewer.
        let viewers = self.viewers.load(Ordering::Relaxed).max(1);
        let skipped = self.skipped.load(Ordering::Relaxed);
        let loads = self.feed.loads.as_ref();
        let loads = loads.map(|loads| crate::loads::live_json(&loads.lock()));
        let monitor = self.feed.lock();
        frame::status(&monitor, loads, Instant::now(), viewers, skipped)
    }

    fn send(&self, kind: &'static str, data: Arc<str>) {
        // An error means that there are no viewers.
        let _ = self.frames.send(Frame { kind, data });
    }

    fn remember(&self, data: Arc<str>) {
        let mut history = self.history.lock().unwrap_or_else(PoisonError::into_inner);
        if history.len() == HISTORY {
            history.pop_front();
        }
        history.push_back(data);
    }

    /// The history as one JSON array.
    fn history(&self) -> String {
        let history = self.history.lock().unwrap_or_else(PoisonError::into_inner);
        let frames: Vec<&str> = history.iter().map(AsRef::as_ref).collect();
        format!("[{}]", frames.join(","))
    }
}

/// Whether a request names this host. Only such requests are answered: otherwise any site could read the page through a name that
/// it resolves to this host.
pub fn names_this_host(headers: &HeaderMap) -> bool {
    let host = headers
        .get(header::HOST)
        .and_then(|h| h.to_str().ok())
        .unwrap_or("");
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
        _ => host,
    };
    ["localhost", "127.0.0.1", "[::1]"].contains(&name)
}

/// The shared state, for a request that has passed the check.
struct Admitted(Arc<Shared>);

impl FromRequestParts<Arc<Shared>> for Admitted {
    type Rejection = StatusCode;

    async fn from_request_parts(
        parts: &mut Parts,
        shared: &Arc<Shared>,
    ) -> Result<Self, StatusCode> {
        if shared.loopback && !names_this_host(&parts.headers) {
            return Err(StatusCode::FORBIDDEN);
        }
        Ok(Self(Arc::clone(shared)))
    }
}

async fn show(Admitted(shared): Admitted) -> Response {
    page::closed(page::with(&shared.status()))
}

async fn show_loads(_: Admitted) -> Response {
    loads::panel()
}

async fn show_metrics(Admitted(shared): Admitted) -> Response {
    let text = metrics::text(&shared.feed.lock(), Instant::now());
    ([(header::CONTENT_TYPE, metrics::KIND)], text).into_response()
}

async fn state_of_loads(Admitted(shared): Admitted) -> Response {
    loads::state(shared.feed.loads.as_ref())
}

async fn next_truck(Admitted(shared): Admitted, headers: HeaderMap) -> Response {
    loads::next_truck(shared.feed.loads.as_ref(), &headers)
}

async fn events(Admitted(shared): Admitted) -> Response {
    let Some(viewer) = Viewer::admit(shared) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many viewers").into_response();
    };
    Sse::new(viewer.stream())
        .keep_alive(KeepAlive::default())
        .into_response()
}

/// A viewer's place, freed on drop.
struct Viewer {
    shared: Arc<Shared>,
    frames: broadcast::Receiver<Frame>,
}

impl Viewer {
    fn admit(shared: Arc<Shared>) -> Option<Self> {
        let seats = |n: usize| (n < MAX_VIEWERS).then_some(n + 1);
        shared
            .viewers
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, seats)
            .ok()?;
        shared.take_series();
        shared.came.notify_one();
        let frames = shared.frames.subscribe();
        Some(Self { shared, frames })
    }

    /// The history and the present status, then every frame that the viewer is fast enough for.
    fn stream(self) -> impl Stream<Item = Result<Event, Infallible>> {
        let history = Event::default()
            .event("history")
            .data(self.shared.history());
        let status = Event::default().event("status").data(self.shared.status());
        let live = stream::unfold(self, |mut viewer| async move {
            let frame = viewer.next().await?;
            Some((
                Ok(Event::default().event(frame.kind).data(&*frame.data)),
                viewer,
            ))
        });
        stream::iter([Ok(history), Ok(status)]).chain(live)
    }

    async fn next(&mut self) -> Option<Frame> {
        loop {
            match self.frames.recv().await {
                Ok(frame) => return Some(frame),
                Err(RecvError::Lagged(n)) => {
                    self.shared.skipped.fetch_add(n, Ordering::Relaxed);
                }
                Err(RecvError::Closed) => return None,
            }
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.shared.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}
