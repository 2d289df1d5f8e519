//! The pipeline as processes: completeness, order, end, deaths, isolation.

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use common::{
    Running, both, heft, kill, run, says, sequences, shared_memory, survivors, wait_until,
};
use messages::{ExcavatorEstimate, ExcavatorSensors, Health, LoaderEstimate, SwingMotion};
use rustix::process::Signal;

#[test]
fn what_is_logged_as_json_names_its_process() {
    let mut heft = heft();
    heft.env("HEFT_LOG", "info,iceoryx2=off,iceoryx2_log=off");
    heft.env("HEFT_LOG_FORMAT", "json");
    let running = Running::start_with(heft, "log", "excavator --duration 2".split(' '));
    let (output, _folder) = running.wait();
    let text = String::from_utf8_lossy(&output.stderr);
    let lines = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    let lines: Vec<serde_json::Value> = lines.collect();
    let ready = lines.iter().filter(|l| l["message"] == "ready");
    assert_eq!(ready.count(), 5, "a line for each service: {text}");
    for line in &lines {
        let span = &line["span"];
        assert!(
            span["pid"].is_u64() && span["machine"] == "excavator",
            "{line}"
        );
    }
    let part = lines.iter().find(|l| l["span"]["process"] == "logger");
    assert_eq!(
        part.expect("a part of the recording begins")["part"],
        1,
        "{text}"
    );
}

#[test]
fn in_the_journal_each_line_has_its_priority_and_elsewhere_none() {
    use std::os::unix::fs::MetadataExt;
    let folder = tempfile::tempdir().expect("a folder");
    let lines = |name: &str, inode_off: u64| {
        let path = folder.path().join(name);
        let file = std::fs::File::create(&path).expect("writable");
        let about = file.metadata().expect("a file");
        let stream = format!("{}:{}", about.dev(), about.ino() + inode_off);
        let mut heft = heft();
        heft.env("HEFT_LOG", "info,iceoryx2=off,iceoryx2_log=off");
        heft.env("JOURNAL_STREAM", stream)
            .stdout(std::process::Stdio::null())
            .stderr(file);
        heft.args("run excavator --duration 1 --quiet --no-report --domain".split(' '));
        heft.arg(common::domain(name))
            .arg("--out")
            .arg(folder.path().join(format!("{name}-out")));
        heft.status().expect("heft starts");
        let text = std::fs::read_to_string(path).expect("what it said");
        let ready = text.lines().filter(|line| line.contains(" ready"));
        ready.map(str::to_owned).collect::<Vec<_>>()
    };
    let (in_journal, elsewhere) = (lines("journal", 0), lines("elsewhere", 1));
    assert_eq!(
        (in_journal.len(), elsewhere.len()),
        (5, 5),
        "{in_journal:?}"
    );
    assert!(in_journal.iter().all(|line| line.starts_with("<6>")));
    assert!(elsewhere.iter().all(|line| !line.contains("<6>")));
}

fn complete(numbers: &[u64], first: u64) {
    for (i, number) in numbers.iter().enumerate() {
        assert_eq!(*number, first + i as u64, "sample {i} of {}", numbers.len());
    }
}

#[test]
fn thirty_seconds_at_1_khz_arrive_complete_and_in_order() {
    let running = Running::start(
        "khz",
        "excavator --scenario cycle --rate 1000 --duration 30".split(' '),
    );
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let recording = folder.path().join("run.mcap");
    for (name, numbers) in [
        (
            "sensors",
            sequences::<ExcavatorSensors>(&recording, "excavator/sensors"),
        ),
        (
            "motion",
            sequences::<SwingMotion>(&recording, "excavator/motion"),
        ),
        (
            "rls",
            sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_rls"),
        ),
        (
            "ukf",
            sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_ukf"),
        ),
    ] {
        assert!(
            (30_000..=30_001).contains(&numbers.len()),
            "{name}: {}",
            numbers.len()
        );
        complete(&numbers, 0);
    }
}

#[test]
fn sigterm_ends_a_run_with_everything_drained_and_nothing_left() {
    let running = Running::start(
        "term",
        "excavator --scenario cycle --duration 60".split(' '),
    );
    running.wait_for_services();
    // About two seconds of samples, however slow the host: 20 kB of schemas, then 90 kB a second.
    wait_until("samples are recorded", Duration::from_secs(20), || {
        std::fs::metadata(running.recording()).is_ok_and(|file| file.len() > 200_000)
    });
    let domain = running.domain.clone();
    running.signal(Signal::TERM);
    let (output, folder) = running.wait();
    assert!(output.status.success(), "{}", both(&output));
    let recording = folder.path().join("run.mcap");
    let sensors = sequences::<ExcavatorSensors>(&recording, "excavator/sensors");
    assert!(sensors.len() > 50, "{} samples", sensors.len());
    complete(&sensors, 0);
    assert_eq!(
        sensors,
        sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_ukf")
    );
    assert_eq!(
        sensors,
        sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_rls")
    );
    assert_eq!(survivors(&domain), Vec::<u32>::new());
    assert_eq!(shared_memory(&domain), Vec::<String>::new());
    assert!(
        recording::Reader::open(&recording)
            .expect("a recording")
            .is_complete()
    );
}

#[test]
fn a_killed_service_is_back_within_half_a_second_and_the_run_goes_on() {
    let running = Running::start(
        "kill",
        "excavator --scenario cycle --rate 1000 --duration 120".split(' '),
    );
    running.wait_for_services();
    // A fixed order of victims and pauses: 20 deaths, each service several times.
    let services = ["kalman", "rls", "ukf", "logger", "sensor"];
    for round in 0..20u64 {
        let name = services[(round as usize * 3) % services.len()];
        std::thread::sleep(Duration::from_millis(350 + (round * 137) % 300));
        let Some(victim) = running.service(name) else {
            panic!("{name} is not there in round {round}");
        };
        kill(victim, Signal::KILL);
        let begun = Instant::now();
        wait_until("the service is back", Duration::from_secs(5), || {
            running.service(name).is_some_and(|pid| pid != victim)
        });
        let absent = begun.elapsed();
        assert!(
            absent < Duration::from_millis(500),
            "{name} was away for {absent:?}"
        );
    }
    std::thread::sleep(Duration::from_secs(1));
    let domain = running.domain.clone();
    running.signal(Signal::INT);
    let (output, folder) = running.wait();
    let text = both(&output);
    assert_eq!(output.status.code(), Some(1), "samples were lost: {text}");
    assert!(text.contains("started again"), "{text}");
    assert!(text.contains("were not answered by"), "{text}");
    assert_eq!(shared_memory(&domain), Vec::<String>::new());
    assert_eq!(survivors(&domain), Vec::<u32>::new());
    let recording = folder.path().join("run.mcap");
    let estimates = sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_ukf");
    assert!(
        estimates.is_sorted_by(|a, b| a < b),
        "the recording is intact and in order"
    );
    let last = sequences::<ExcavatorSensors>(&recording, "excavator/sensors").pop();
    assert!(
        estimates.last() >= last.map(|n| n - 1).as_ref(),
        "estimates reach the end"
    );
    let output = run(&["replay", recording.to_str().expect("a path"), "--verify"]);
    let text = both(&output);
    assert!(
        text.contains("bit-identical") && !text.contains("differ"),
        "{text}"
    );
    // Answers between a death and the next state are not verified, and the status shows that.
    let unchecked = text.contains("cannot be checked");
    assert_eq!(output.status.code(), Some(i32::from(unchecked)), "{text}");
}

#[test]
fn a_service_that_cannot_live_ends_the_run_with_its_reason() {
    let running = Running::start(
        "dying",
        "excavator --scenario cycle --duration 60".split(' '),
    );
    running.wait_for_services();
    let begun = Instant::now();
    let mut child_ended = false;
    while begun.elapsed() < Duration::from_secs(20) && !child_ended {
        if let Some(pid) = running.service("kalman") {
            kill(pid, Signal::KILL);
        }
        std::thread::sleep(Duration::from_millis(2));
        child_ended = survivors(&running.domain).is_empty();
    }
    let domain = running.domain.clone();
    let (output, _folder) = running.wait();
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    says(&output, "kalman");
    assert_eq!(shared_memory(&domain), Vec::<String>::new());
}

#[test]
fn workers_end_by_themselves_when_the_supervisor_is_killed_and_the_next_start_is_clean() {
    let running = Running::start(
        "orphans",
        "excavator --scenario cycle --duration 60".split(' '),
    );
    running.wait_for_services();
    wait_until("it records", Duration::from_secs(30), || {
        let about = running.recording().metadata();
        about.is_ok_and(|file| file.len() > 200_000)
    });
    let domain = running.domain.clone();
    running.signal(Signal::KILL);
    let (_, folder) = running.wait();
    wait_until("the workers end", Duration::from_secs(10), || {
        survivors(&domain).is_empty()
    });
    assert!(
        !shared_memory(&domain).is_empty(),
        "a killed supervisor cannot clean up"
    );
    let estimates =
        sequences::<ExcavatorEstimate>(&folder.path().join("run.mcap"), "excavator/inertia_ukf");
    assert!(
        estimates.len() > 20,
        "the recording is readable: {} estimates",
        estimates.len()
    );

    let next = tempfile::tempdir().expect("a folder");
    let text = common::heft()
        .args("run excavator --duration 0.5 --quiet --no-report --out".split(' '))
        .arg(next.path())
        .output()
        .expect("heft starts");
    assert!(text.status.success(), "{}", both(&text));
    assert!(
        both(&text).contains(&domain),
        "the leftovers are named: {}",
        both(&text)
    );
    assert_eq!(shared_memory(&domain), Vec::<String>::new());
}

#[test]
fn two_pipelines_run_side_by_side_in_their_own_domains() {
    let one = Running::start("one", "excavator --scenario cycle --duration 3".split(' '));
    let two = Running::start("two", "loader --duration 3".split(' '));
    let (first, folder_one) = one.wait();
    let (second, folder_two) = two.wait();
    assert!(first.status.success(), "{}", both(&first));
    assert!(second.status.success(), "{}", both(&second));
    let excavator = sequences::<ExcavatorEstimate>(
        &folder_one.path().join("run.mcap"),
        "excavator/inertia_ukf",
    );
    let loader = sequences::<LoaderEstimate>(&folder_two.path().join("run.mcap"), "loader/cg_ukf");
    complete(&excavator, 0);
    complete(&loader, 0);
    assert!(
        (300..=301).contains(&excavator.len()),
        "{}",
        excavator.len()
    );
    assert!((300..=301).contains(&loader.len()), "{}", loader.len());
}

#[test]
fn a_domain_in_use_is_refused() {
    let running = Running::start(
        "taken",
        "excavator --scenario cycle --duration 30".split(' '),
    );
    running.wait_for_services();
    let folder = tempfile::tempdir().expect("a folder");
    let output = common::heft()
        .args([
            "run",
            "excavator",
            "--duration",
            "1",
            "--quiet",
            "--domain",
            &running.domain,
        ])
        .arg("--out")
        .arg(folder.path())
        .output()
        .expect("heft starts");
    assert_eq!(output.status.code(), Some(2));
    says(&output, "in use by another run");
    running.signal(Signal::TERM);
    let (output, _folder) = running.wait();
    assert!(
        output.status.success(),
        "the first run is not disturbed: {}",
        both(&output)
    );
}

#[test]
fn start_up_in_any_order_loses_nothing() {
    // Services wait for those that start later: each one is held up in turn while it starts.
    for slow in ["sensor", "kalman", "rls", "ukf", "logger"] {
        let running = Running::start(
            &format!("slow-{slow}"),
            "excavator --duration 1 --rate 500".split(' '),
        );
        let mut held = None;
        wait_until("the service appears", Duration::from_secs(10), || {
            held = running.service(slow);
            held.is_some()
        });
        let held = held.expect("a process");
        kill(held, Signal::STOP);
        std::thread::sleep(Duration::from_millis(300));
        kill(held, Signal::CONT);
        let (output, folder) = running.wait();
        assert!(output.status.success(), "{slow}: {}", both(&output));
        let recording = folder.path().join("run.mcap");
        let sensors = sequences::<ExcavatorSensors>(&recording, "excavator/sensors");
        assert_eq!(sensors.len(), 501, "{slow}");
        complete(&sensors, 0);
        assert_eq!(
            sensors,
            sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_rls"),
            "{slow}"
        );
        assert_eq!(
            sensors,
            sequences::<ExcavatorEstimate>(&recording, "excavator/inertia_ukf"),
            "{slow}"
        );
        let reports = reports_of_health(&recording);
        assert_eq!(reports.len(), 5, "{slow}: {reports:?}");
        reports.values().for_each(|numbers| complete(numbers, 0));
    }
}

/// The sequence numbers of the health reports, by process.
fn reports_of_health(recording: &Path) -> BTreeMap<u32, Vec<u64>> {
    let reader = recording::Reader::open(recording).expect("a recording");
    let mut reports = BTreeMap::<u32, Vec<u64>>::new();
    for health in reader.stream::<Health>("health").expect("reports") {
        let numbers = reports.entry(health.process).or_default();
        numbers.push(health.stamp.sequence);
    }
    reports
}
