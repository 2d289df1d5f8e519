//! The pages in a real browser: Debian's chromium, where it is installed.

mod common;

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use messages::channels;
use view::live::{Feed, serve};

fn chromium() -> Option<&'static str> {
    let found = [
        "/usr/bin/chromium",
        "/usr/bin/chromium-browser",
        "/usr/bin/google-chrome",
    ];
    let found = found.into_iter().find(|p| Path::new(p).exists());
    if found.is_none() {
        println!("skipped: no chromium here");
    }
    found
}

/// Runs the browser on `url` and returns what it prints.
fn browse(chromium: &str, url: &str, options: &[&str]) -> String {
    let profile = tempfile::tempdir().expect("a folder for the profile");
    let output = Command::new(chromium)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--hide-scrollbars",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--window-size=1000,1900",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(options)
        .arg(url)
        .stderr(Stdio::piped())
        .output()
        .expect("the browser starts");
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Pushes both machines at 100 Hz until told to stop.
fn feed_until(stop: &AtomicBool, feed: &Feed) {
    let mut noise = common::Noise(3);
    for n in 0.. {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        feed.push(
            &channels::EXCAVATOR_TRUTH,
            &common::excavator_truth(n, 100.0),
        );
        feed.push(
            &channels::EXCAVATOR_INERTIA_RLS,
            &common::excavator_estimate(n, 100.0, &mut noise, true),
        );
        feed.push(
            &channels::EXCAVATOR_INERTIA_UKF,
            &common::excavator_estimate(n, 100.0, &mut noise, false),
        );
        feed.push(&channels::LOADER_TRUTH, &common::loader_truth(n, 100.0));
        feed.push(
            &channels::LOADER_CG_UKF,
            &common::loader_estimate(n, 100.0, &mut noise, 0),
        );
        if n % 10 == 0 {
            (0..5).for_each(|p| feed.push(&channels::HEALTH, &common::health(p, n as u64 / 10)));
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn the_live_page_draws_and_tells_in_chromium() {
    let Some(chromium) = chromium() else { return };
    let feed = Feed::new(common::PROCESSES.map(str::to_owned).to_vec());
    let server = serve("127.0.0.1:0".parse().expect("a constant"), feed.clone()).expect("served");
    let url = format!("http://{}/", server.address());
    let stop = Arc::new(AtomicBool::new(false));
    let feeding = std::thread::spawn({
        let stop = Arc::clone(&stop);
        move || feed_until(&stop, &feed)
    });
    std::thread::sleep(Duration::from_secs(6));
    let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join("live.png");
    let dom = browse(
        chromium,
        &url,
        &["--virtual-time-budget=4000", "--dump-dom"],
    );
    let screenshot = format!("--screenshot={}", picture.display());
    browse(chromium, &url, &["--virtual-time-budget=4000", &screenshot]);
    stop.store(true, Ordering::Relaxed);
    feeding.join().expect("the feeder ends");
    for part in [
        "Swing inertia [kg",
        "The swing inertia is",
        "behind the front axle",
        "<canvas",
        "live · 1 viewer",
        "kalman (4001)",
        "excavator/inertia_ukf",
    ] {
        assert!(
            dom.contains(part),
            "{part} in {}",
            &dom[dom.len().saturating_sub(3000)..]
        );
    }
    assert!(
        std::fs::metadata(&picture).is_ok_and(|m| m.len() > 30_000),
        "a picture with plots"
    );
}

#[test]
fn the_report_opens_from_disk_in_chromium() {
    let Some(chromium) = chromium() else { return };
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser_report.html");
    std::fs::write(&file, view::report(&common::excavator(10.0, 100.0, true))).expect("written");
    let dom = browse(
        chromium,
        &format!("file://{}", file.display()),
        &["--dump-dom", "--enable-logging=stderr"],
    );
    assert!(dom.contains("The swing inertia is") && dom.contains("</svg>"));
    assert!(
        !dom.contains("Refused to"),
        "the policy forbids nothing that the page needs"
    );
}
