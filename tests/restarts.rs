//! A killed service continues from its last state: its intervals hold at once, it reports the restart, and a
//! replay follows it.

mod common;

use std::process::Command;
use std::time::Duration;

use common::{Running, both, kill, run, wait_until, words};
use messages::keyframe::Collector;
use messages::{
    ExcavatorEstimate, ExcavatorTruth, Keyframe, LoaderEstimate, LoaderTruth, Message,
    excavator_bits, loader_bits,
};
use recording::Reader;
use rustix::process::Signal;

fn kill_and_wait(running: &Running, name: &str) {
    let victim = running.service(name).expect("it runs");
    kill(victim, Signal::KILL);
    wait_until("another is there", Duration::from_secs(10), || {
        running.service(name).is_some_and(|pid| pid != victim)
    });
}

fn read<M: Message>(running: &std::path::Path, channel: &str) -> Vec<M> {
    let reader = Reader::open(running).expect("a recording");
    reader.messages(channel).expect("its messages")
}

/// From `replay --verify`: number of answers, and of those that cannot be checked.
fn replayed(recording: &std::path::Path) -> (u64, u64) {
    let output = run(&["replay", recording.to_str().expect("a path"), "--verify"]);
    let text = both(&output);
    assert!(!text.contains("differ"), "no wolf: {text}");
    let number = |before: &str, words: &str| -> Option<u64> {
        let line = text.lines().find(|l| l.contains(words))?;
        let line = line.split(before).last()?;
        line.split_whitespace().find_map(|w| w.parse().ok())
    };
    let all = number(" of ", "estimates are bit-identical").expect("a count");
    let unknown = number("", "cannot be checked").unwrap_or(0);
    // Unchecked answers are not verified.
    let status = output.status.code();
    assert_eq!(status, Some(i32::from(unknown > 0)), "{text}");
    (all, unknown)
}

/// Indices of the first answers of every later life.
fn first_answers(restarts: impl Iterator<Item = u32>) -> Vec<usize> {
    let all: Vec<u32> = restarts.collect();
    let pairs = all.windows(2).enumerate();
    pairs
        .filter(|(_, w)| w[1] != w[0])
        .map(|(i, _)| i + 1)
        .collect()
}

#[test]
fn killed_excavator_services_go_on_from_their_states() {
    let args = ["excavator", "--scenario", "cycle", "--duration", "60"];
    let running = Running::start("keep", &args);
    running.wait_for_services();
    std::thread::sleep(Duration::from_secs(6));
    for name in ["ukf", "rls", "kalman", "ukf", "rls"] {
        kill_and_wait(&running, name);
        std::thread::sleep(Duration::from_millis(1200));
    }
    running.signal(Signal::TERM);
    let (output, folder) = running.wait();
    let text = both(&output);
    let recording = folder.path().join("run.mcap");
    let truth: Vec<ExcavatorTruth> = read(&recording, "excavator/truth");
    for channel in ["excavator/inertia_ukf", "excavator/inertia_rls"] {
        let answers: Vec<ExcavatorEstimate> = read(&recording, channel);
        let first = first_answers(answers.iter().map(|a| a.hops.estimate_restarts));
        assert_eq!(first.len(), 2, "{channel}: {text}");
        for at in first {
            let mut compared = 0;
            let life = answers[at].hops.estimate_restarts;
            let life = answers[at..]
                .iter()
                .take_while(|a| a.hops.estimate_restarts == life);
            let life: Vec<_> = life.collect();
            for answer in life.iter().take(20) {
                let said = answer.flags & excavator_bits::RESTARTED != 0;
                assert!(said, "{channel} {}", answer.stamp.sequence);
                let number = answer.stamp.sequence;
                let there = truth.binary_search_by_key(&number, |t| t.stamp.sequence);
                // A truth may be lost with the process that is killed.
                let Ok(there) = there else { continue };
                compared += 1;
                let away = (answer.inertia - truth[there].inertia).abs();
                assert!(
                    away <= 3.0 * answer.inertia_std,
                    "{channel} {number}: {away} with {}",
                    answer.inertia_std
                );
            }
            assert!(compared > 0, "{channel}: no truth of this life");
            // Restarted until it is trusted; after that the flag is not set any more.
            for answer in &life {
                let said = answer.flags & excavator_bits::RESTARTED != 0;
                assert!(!(said && answer.flags & excavator_bits::TRUSTED != 0));
            }
        }
    }
    let (all, unknown) = replayed(&recording);
    // Answers lost with a death, and those up to the next state of stages that read from the dead one.
    assert!(unknown * 10 < all, "{unknown} of {all}");
}

/// `XDG_RUNTIME_DIR` may be another file system than `/dev/shm`, as in the unit. It is filled while a service is killed.
#[test]
fn a_service_waits_for_room_in_a_runtime_folder_that_others_fill() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path().display();
    let script = format!(
        "mount -t tmpfs -o size=4m,mode=700 tmpfs {at} && export XDG_RUNTIME_DIR={at} && exec \"$@\""
    );
    let behind = |program: &str| {
        let mut command = Command::new("unshare");
        command.args(["--mount", "sh", "-c", &script, "sh", program]);
        command
    };
    if !behind("true").status().is_ok_and(|s| s.success()) {
        eprintln!("skipped: this user may not mount");
        return;
    }
    let heft = behind(env!("CARGO_BIN_EXE_heft"));
    let running = Running::start_with(heft, "filled", ["excavator", "--duration", "12"]);
    running.wait_for_services();
    std::thread::sleep(Duration::from_secs(1));
    let filler = format!("/proc/{}/root{at}/of-others", running.child.id());
    std::fs::write(&filler, vec![1; 8 << 20]).expect_err("it is full");
    let victim = running.service("ukf").expect("it runs");
    kill(victim, Signal::KILL);
    std::thread::sleep(Duration::from_secs(2));
    std::fs::remove_file(&filler).expect("it can be freed");
    let (output, _folder) = running.wait();
    let said = both(&output);
    assert!(said.contains("the folder of the domains has"), "{said}");
    assert!(!said.contains("ended early"), "{said}");
    assert!(said.contains("ukf died"), "{said}");
}

#[test]
fn a_killed_loader_service_keeps_what_took_it_long_to_learn() {
    // With known tyres a drive in one direction suffices: the slips determine the ratio, which takes long.
    let tyres = "machine.radius_load_sensitivity_std=0.001";
    let slips = ["loader", "--without", "pressure", "--duration", "60"];
    let running = Running::start("learnt", &[&slips[..], &["--set", tyres]].concat());
    wait_until("it runs", Duration::from_secs(20), || {
        running.service("ukf").is_some() && running.service("kalman").is_some()
    });
    std::thread::sleep(Duration::from_secs(16));
    for name in ["ukf", "kalman", "ukf"] {
        kill_and_wait(&running, name);
        std::thread::sleep(Duration::from_millis(1500));
    }
    running.signal(Signal::TERM);
    let (output, folder) = running.wait();
    let text = both(&output);
    let recording = folder.path().join("run.mcap");
    let truth: Vec<LoaderTruth> = read(&recording, "loader/truth");
    let answers: Vec<LoaderEstimate> = read(&recording, "loader/cg_ukf");
    let first = first_answers(answers.iter().map(|a| a.hops.estimate_restarts));
    assert_eq!(first.len(), 2, "{text}");
    let fresh = &answers[0];
    for at in first {
        let (before, after) = (&answers[at - 1], &answers[at]);
        assert!(after.flags & loader_bits::RESTARTED != 0);
        assert!(after.flags & loader_bits::TRUSTED_RATIO == 0, "not at once");
        // At most a second of information is lost, of sixteen.
        assert!(
            before.cg_ratio_std < 0.5 * fresh.cg_ratio_std,
            "it had learnt"
        );
        let share = after.cg_ratio_std / before.cg_ratio_std;
        assert!(share < 1.5, "{share} of {}", before.cg_ratio_std);
        let number = after.stamp.sequence;
        let there = truth.binary_search_by_key(&number, |t| t.stamp.sequence);
        let truth = &truth[there.expect("the truth of each sample is recorded")];
        let ratio = (after.cg_ratio - truth.cg_ratio).abs();
        let height = (after.cg_height - truth.cg_height).abs();
        assert!(ratio <= 3.0 * after.cg_ratio_std, "{ratio}");
        assert!(height <= 3.0 * after.cg_height_std, "{height}");
    }
    let (all, unknown) = replayed(&recording);
    assert!(unknown * 10 < all, "{unknown} of {all}");
}

#[test]
fn every_step_publishes_its_whole_state_at_least_once_a_second() {
    for (machine, steps) in [("excavator", 3), ("loader", 2)] {
        let running = Running::start(&format!("states-{machine}"), &[machine, "--duration", "4"]);
        let (output, folder) = running.wait();
        assert!(output.status.success(), "{}", both(&output));
        let pieces: Vec<Keyframe> = read(&folder.path().join("run.mcap"), "keyframe");
        let mut processes: Vec<u32> = pieces.iter().map(|p| p.process).collect();
        processes.sort_unstable();
        processes.dedup();
        assert_eq!(processes.len(), steps, "{machine}");
        for process in processes {
            let mut collector = Collector::default();
            let own = pieces.iter().filter(|p| p.process == process);
            let states = own.filter_map(|p| collector.take(p));
            let times: Vec<f64> = states.map(|s| s.stamp.time).collect();
            let longest = times.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
            assert!(
                longest < 1.0 && times[times.len() - 1] > times[0] + 3.0,
                "{times:?}"
            );
        }
    }
}

#[test]
fn what_was_trusted_is_the_prior_of_the_next_run_and_its_replay_knows() {
    let folder = tempfile::tempdir().expect("a folder");
    let state = folder.path().join("state.json");
    let state = state.to_str().expect("a path");
    let run_once = |n: u32| {
        let (out, domain) = (
            folder.path().join(n.to_string()),
            common::domain(&format!("state-{n}")),
        );
        let out = out.to_str().expect("a path").to_owned();
        let args =
            words("run loader --without pressure --pace max --duration 60 --quiet --no-report");
        let more = ["--state", state, "--domain", &domain, "--out", &out];
        // With known tyres a drive in one direction is trusted.
        let tyres = words(
            "--set machine.radius_load_sensitivity=0.01 --set machine.radius_load_sensitivity_std=0.001",
        );
        let output = run(&[&args[..], &more, &tyres].concat());
        assert!(output.status.success(), "{}", both(&output));
        let recording = std::path::Path::new(&out).join("run.mcap");
        (
            both(&output),
            read::<LoaderEstimate>(&recording, "loader/cg_ukf"),
            recording,
        )
    };
    let (text, first, _) = run_once(1);
    assert!(text.contains("nothing to remember yet"), "{text}");
    let learnt = first
        .iter()
        .rfind(|e| e.flags & loader_bits::TRUSTED_RATIO != 0);
    let learnt = learnt.expect("it trusts the ratio once in a minute");
    let (text, second, recording) = run_once(2);
    assert!(text.contains("restored"), "{text}");
    let begin = &second[0];
    let stated = first[0].cg_ratio;
    let recalled = stated + config::CORRELATION * (learnt.cg_ratio - stated);
    assert!((begin.cg_ratio - recalled).abs() < 1e-7, "{text}");
    assert!(
        begin.cg_ratio_std < first[0].cg_ratio_std && begin.flags & loader_bits::TRUSTED_RATIO == 0
    );
    let (all, unknown) = replayed(&recording);
    assert!(all > 10_000 && unknown == 0, "{unknown} of {all}");
}

#[test]
fn a_service_that_dies_after_an_upgrade_is_the_old_one_again() {
    let place = tempfile::tempdir().expect("a folder");
    let copy = place.path().join("heft");
    std::fs::copy(env!("CARGO_BIN_EXE_heft"), &copy).expect("a copy");
    let mut heft = std::process::Command::new(&copy);
    heft.stdin(std::process::Stdio::null());
    let args = ["excavator", "--scenario", "cycle", "--duration", "60"];
    let running = Running::start_with(heft, "upgrade", &args);
    running.wait_for_services();
    std::thread::sleep(Duration::from_secs(2));
    // As package managers replace a file: another one under the same name, which would end at once.
    let other = place.path().join("heft.new");
    std::fs::copy("/bin/false", &other).expect("another program");
    std::fs::rename(&other, &copy).expect("in its place");
    kill_and_wait(&running, "kalman");
    std::thread::sleep(Duration::from_secs(1));
    std::fs::remove_file(&copy).expect("it is there");
    kill_and_wait(&running, "ukf");
    std::thread::sleep(Duration::from_secs(2));
    running.signal(Signal::TERM);
    let (output, folder) = running.wait();
    let text = both(&output);
    for name in ["kalman", "ukf"] {
        assert_eq!(text.matches(&format!("{name} died")).count(), 1, "{text}");
    }
    let answers: Vec<ExcavatorEstimate> =
        read(&folder.path().join("run.mcap"), "excavator/inertia_ukf");
    // A state of another build would have been refused, and the estimator would have restarted without it.
    let first = first_answers(answers.iter().map(|a| a.hops.estimate_restarts));
    assert_eq!(first.len(), 1, "{text}");
    assert!(
        answers[first[0]].flags & excavator_bits::RESTARTED != 0,
        "it goes on"
    );
    assert!(answers.len() > first[0] + 100, "it works again: {text}");
}
