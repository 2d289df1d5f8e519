//! The pages in a real browser, where one is installed.

mod common;
mod driver;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use driver::Driver;
use messages::channels;
use serde_json::json;
use view::live::{Feed, serve};

/// Pushes both machines at 100 Hz until asked to stop.
fn feed_until(stop: &AtomicBool, feed: &Feed) {
    let mut noise = common::Noise(3);
    let mut n = 0;
    while !stop.load(Ordering::Relaxed) {
        feed.push(
            &channels::EXCAVATOR_TRUTH,
            &common::excavator_truth(n, 100.0),
        );
        let (paper, product) = (
            common::excavator_estimate(n, 100.0, &mut noise, true),
            common::excavator_estimate(n, 100.0, &mut noise, false),
        );
        feed.push(&channels::EXCAVATOR_INERTIA_RLS, &paper);
        feed.push(&channels::EXCAVATOR_INERTIA_UKF, &product);
        feed.push(&channels::LOADER_TRUTH, &common::loader_truth(n, 100.0));
        feed.push(
            &channels::LOADER_CG_UKF,
            &common::loader_estimate(n, 100.0, &mut noise, 0),
        );
        if n.is_multiple_of(10) {
            (0..5).for_each(|p| feed.push(&channels::HEALTH, &common::health(p, n as u64 / 10)));
        }
        n += 1;
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Waits until the page holds all of `wanted`.
fn wait_for(driver: &Driver, wanted: &[&str]) {
    let end = Instant::now() + Duration::from_secs(60);
    let mut page = driver.page();
    while let Some(part) = wanted.iter().find(|w| !page.contains(**w)) {
        assert!(
            Instant::now() < end,
            "{part} is not in {}",
            &page[page.len().saturating_sub(3000)..]
        );
        std::thread::sleep(Duration::from_millis(300));
        page = driver.page();
    }
}

#[test]
fn the_live_page_has_plots_and_texts_in_chromium() {
    let Some(driver) = Driver::start() else {
        return;
    };
    let feed = Feed::new(common::PROCESSES.map(str::to_owned).to_vec());
    let server = serve("127.0.0.1:0".parse().expect("a constant"), feed.clone()).expect("served");
    let stop = Arc::new(AtomicBool::new(false));
    let feeding = std::thread::spawn({
        let stop = Arc::clone(&stop);
        move || feed_until(&stop, &feed)
    });
    driver.go(&format!("http://{}/", server.address()));
    wait_for(
        &driver,
        &[
            "Swing inertia [kg",
            "The swing inertia is",
            "behind the front axle",
            "<canvas",
            "live · 1 viewer",
            "kalman (4001)",
            "excavator/inertia_ukf",
        ],
    );
    let legend = "return document.querySelector('.u-value').textContent";
    let before = driver.run(legend);
    std::thread::sleep(Duration::from_secs(6));
    assert_ne!(driver.run(legend), before, "the legend follows the run");
    let ink = "const c = document.querySelector('canvas'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
               let n = 0; for (let i = 3; i < d.length; i += 4) if (d[i] > 0) n++; return n";
    assert!(
        driver.run(ink).as_u64().is_some_and(|n| n > 1000),
        "the first plot has ink"
    );
    let loaded = driver.run("return performance.getEntriesByType('resource').map((e) => e.name)");
    let own = format!("http://{}/", server.address());
    let foreign = |e: &serde_json::Value| e.as_str().is_none_or(|name| !name.starts_with(&own));
    assert!(
        !loaded.as_array().is_none_or(|l| l.iter().any(foreign)),
        "foreign addresses in {loaded}"
    );
    let picture = driver.picture();
    assert!(picture.len() > 30_000, "{} bytes of picture", picture.len());
    std::fs::write(
        Path::new(env!("CARGO_TARGET_TMPDIR")).join("live.png"),
        picture,
    )
    .expect("written");
    stop.store(true, Ordering::Relaxed);
    feeding.join().expect("the feeder ends");
}

#[test]
fn the_report_opens_from_disk_in_chromium() {
    let Some(driver) = Driver::start() else {
        return;
    };
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser_report.html");
    std::fs::write(&file, view::report(&common::excavator(10.0, 100.0, true))).expect("written");
    driver.go(&format!("file://{}", file.display()));
    wait_for(&driver, &["The swing inertia is", "</svg>"]);
    let overflow = driver.run("return document.documentElement.scrollWidth - innerWidth");
    assert!(
        overflow.as_i64().is_some_and(|o| o <= 0),
        "nothing sticks out: {overflow}"
    );
    let loaded = driver.run("return performance.getEntriesByType('resource').length");
    assert_eq!(loaded, json!(0), "the report loads nothing");
    let count = |of: &str| driver.run(&format!("return document.querySelectorAll('{of}').length"));
    assert_ne!(count("figure[data-plot]"), json!(0));
    let canvases = count("figure.drawn canvas");
    assert_eq!(canvases, count("figure[data-plot]"), "its own script runs");
    let ends = "return charts.map((c) => [c.plot.scales.x.min, c.plot.scales.x.max])";
    driver.run("zoom(2, 3)");
    let all = driver.run(ends);
    let all = all.as_array().expect("a range for each plot");
    assert!(all.iter().all(|range| *range == json!([2, 3])), "{all:?}");
}
