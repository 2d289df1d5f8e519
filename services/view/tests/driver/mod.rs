//! Control of a browser: Debian's chromium by the WebDriver protocol of its
//! chromedriver.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Options for a headless chromium without dialogs and without network access of its own.
const OPTIONS: [&str; 11] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-quic",
    "--no-first-run",
    "--hide-scrollbars",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1000,2300",
];

/// A running browser.
pub struct Driver {
    process: Child,
    address: String,
    session: String,
    profile: tempfile::TempDir,
}

impl Driver {
    /// Starts the browser. Prints a line and returns `None` if it is not installed.
    pub fn start() -> Option<Self> {
        let installed = ["/usr/bin/chromium", "/usr/bin/chromedriver"]
            .iter()
            .all(|p| Path::new(p).exists());
        if !installed {
            let _ = writeln!(
                std::io::stderr(),
                "skipped: no chromium and chromedriver here"
            );
            return None;
        }
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let port = listener.local_addr().expect("bound").port();
        drop(listener);
        let process = Command::new("/usr/bin/chromedriver")
            .args([format!("--port={port}"), "--log-level=OFF".into()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver starts");
        let profile = tempfile::tempdir().expect("a folder for the profile");
        let address = format!("127.0.0.1:{port}");
        let mut driver = Self {
            process,
            address,
            session: String::new(),
            profile,
        };
        driver.session = driver.open();
        assert!(!driver.session.is_empty(), "no browser within a minute");
        Some(driver)
    }

    fn open(&self) -> String {
        let mut arguments = OPTIONS.map(str::to_owned).to_vec();
        arguments.push(format!("--user-data-dir={}", self.profile.path().display()));
        let options = json!({"binary": "/usr/bin/chromium", "args": arguments});
        let wish = json!({"capabilities": {"alwaysMatch": {"goog:chromeOptions": options}}});
        let end = Instant::now() + Duration::from_secs(60);
        while Instant::now() < end {
            std::thread::sleep(Duration::from_millis(200));
            let answer = self.ask("POST", "/session", Some(&wish));
            if let Some(session) = answer["value"]["sessionId"].as_str() {
                return session.to_owned();
            }
        }
        String::new()
    }

    /// Sends a request and waits for the answer; null if there is none.
    fn ask(&self, method: &str, path: &str, body: Option<&Value>) -> Value {
        self.exchange(method, path, body).unwrap_or(Value::Null)
    }

    fn exchange(&self, method: &str, path: &str, body: Option<&Value>) -> Option<Value> {
        let mut stream = TcpStream::connect(&self.address).ok()?;
        stream
            .set_read_timeout(Some(Duration::from_secs(30)))
            .ok()?;
        let body = body.map_or_else(String::new, Value::to_string);
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
            self.address,
            body.len()
        )
        .ok()?;
        let (mut answer, mut part) = (Vec::new(), [0; 65536]);
        loop {
            let text = String::from_utf8_lossy(&answer).into_owned();
            let parsed = text
                .split_once("\r\n\r\n")
                .and_then(|(_, body)| serde_json::from_str(body).ok());
            if parsed.is_some() {
                return parsed;
            }
            let n = stream.read(&mut part).ok().filter(|n| *n > 0)?;
            answer.extend_from_slice(&part[..n]);
        }
    }

    /// Opens a page.
    pub fn go(&self, url: &str) {
        self.ask(
            "POST",
            &format!("/session/{}/url", self.session),
            Some(&json!({"url": url})),
        );
    }

    /// Runs a script in the page and returns what it returns.
    pub fn run(&self, script: &str) -> Value {
        let path = format!("/session/{}/execute/sync", self.session);
        self.ask("POST", &path, Some(&json!({"script": script, "args": []})))["value"].clone()
    }

    /// The present document of the page.
    pub fn page(&self) -> String {
        let page = self.run("return document.documentElement.outerHTML");
        page.as_str().unwrap_or_default().to_owned()
    }

    /// A picture of the window, PNG.
    pub fn picture(&self) -> Vec<u8> {
        let answer = self.ask(
            "GET",
            &format!("/session/{}/screenshot", self.session),
            None,
        );
        base64(answer["value"].as_str().unwrap_or_default())
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        self.ask("DELETE", &format!("/session/{}", self.session), None);
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Decodes base64.
fn base64(text: &str) -> Vec<u8> {
    const ALPHABET: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let sextets = text
        .bytes()
        .filter_map(|b| ALPHABET.iter().position(|a| *a == b));
    let (mut out, mut bits, mut count) = (Vec::new(), 0usize, 0);
    for sextet in sextets {
        (bits, count) = (((bits << 6) | sextet) & 0xffff, count + 6);
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    out
}
