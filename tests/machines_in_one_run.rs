//! `heft run M --machines N`: each machine gives the same estimates as in a run of its own.

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use common::table::{Row, Table};
use common::{both, golden, heft, kill, path_in, processes, run, run_ok, says, wait_until, words};
use messages::{ExcavatorEstimate, LoaderEstimate, Message};
use recording::Reader;
use rustix::process::Signal;

/// The rows of a table of many machines, by machine.
fn by_machine(table: &Table) -> BTreeMap<&str, Vec<Row<'_>>> {
    let mut found = BTreeMap::<_, Vec<_>>::new();
    for row in table.rows() {
        found.entry(row.cell("machine")).or_default().push(row);
    }
    found
}

/// Runs one machine and three, and compares the estimates of the second of the three with the recording of the single one.
fn the_second_is_the_one<E: Message>(
    machine: &str,
    scenario: &str,
    channel: &str,
    fields: &[&str],
) {
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| {
        folder
            .path()
            .join(name)
            .to_str()
            .expect("a path")
            .to_owned()
    };
    let common = [
        "run",
        machine,
        "--scenario",
        scenario,
        "--duration",
        "12",
        "--pace",
        "max",
        "--quiet",
        "--out",
    ];
    let alone = out("alone");
    run_ok(&[&common[..], &[&alone, "--no-report", "--seed", "6"]].concat());
    let three = out("three");
    let said = run_ok(&[&common[..], &[&three, "--machines", "3", "--seed", "5"]].concat());
    assert!(said.contains("3 machines by"), "{said}");
    assert!(
        said.contains(" 0 refused, 0 not answered, 0 sent later"),
        "{said}"
    );
    let table = Table::read(Path::new(&three).join("estimates.csv"));
    let found = by_machine(&table);
    let names: Vec<&str> = found.keys().copied().collect();
    assert_eq!(names, ["5", "6", "7"], "machines are called by their seeds");
    let reader = Reader::open(Path::new(&alone).join("run.mcap")).expect("a recording");
    let alone: Vec<E> = reader.messages(channel).expect("estimates");
    assert_eq!(found["6"].len(), alone.len());
    for (row, estimate) in found["6"].iter().zip(&alone) {
        for name in fields {
            let number = row.number(name);
            let its = estimate.number(name).expect("a field");
            assert_eq!(
                number.to_bits(),
                its.to_bits(),
                "{name} at {}",
                row.cell("t")
            );
        }
    }
    let last = |machine: &str| found[machine].last().expect("rows").cell(fields[0]);
    assert_ne!(last("5"), last("6"), "seeds tell machines apart");
}

#[test]
fn a_simulated_excavator_gets_what_a_run_of_its_seed_gives() {
    let fields = ["inertia", "inertia_std", "velocity"];
    the_second_is_the_one::<ExcavatorEstimate>(
        "excavator",
        "cycle",
        "excavator/inertia_ukf",
        &fields,
    );
}

#[test]
fn a_simulated_loader_gets_what_a_run_of_its_seed_gives() {
    let fields = [
        "cg_ratio",
        "cg_ratio_std",
        "cg_height",
        "cg_height_std",
        "speed",
    ];
    the_second_is_the_one::<LoaderEstimate>("loader", "work-cycle", "loader/cg_ukf", &fields);
}

/// Each simulated machine is prepared, which takes minutes for many.
#[test]
fn many_machines_are_refused_or_ended_while_they_are_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let simulated = |count: &str| {
        let mut heft = heft();
        heft.args(["run", "excavator", "--quiet", "--machines", count]);
        heft.arg("--out").arg(folder.path());
        heft
    };
    let refused = simulated("1000000").output().expect("heft starts");
    assert_eq!(refused.status.code(), Some(2), "{}", both(&refused));
    says(&refused, "1..=100000");
    let shards = run(&["serve", "excavator", "--shards", "1000000"]);
    assert_eq!(shards.status.code(), Some(2), "{}", both(&shards));
    let mut child = simulated("100000")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("heft starts");
    let shard = || {
        processes().into_iter().any(|(_, line)| {
            line.contains(&"--shard".to_owned()) && line.contains(&"excavator".to_owned())
        })
    };
    wait_until("its shards to start", Duration::from_secs(20), shard);
    kill(child.id(), Signal::TERM);
    wait_until("it to end", Duration::from_secs(20), || {
        child.try_wait().expect("a child").is_some()
    });
}

#[test]
fn recordings_are_a_machine_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| path_in(folder.path(), name);
    let names = ["drop", "two_swings"];
    for name in names {
        let input = golden(&format!("excavator_input_{name}.csv"));
        std::fs::create_dir_all(path("in")).expect("a folder");
        std::fs::copy(input, path(&format!("in/{name}.csv"))).expect("a copy");
    }
    let input = path("in");
    let run_them = [
        "run",
        "excavator",
        "--input",
        &input,
        "--pace",
        "max",
        "--quiet",
    ];
    run_ok(&[&run_them[..], &["--machines", "2", "--out", &path("out")]].concat());
    let together = Table::read(folder.path().join("out/estimates.csv"));
    let found = by_machine(&together);
    for name in names {
        let (recording, alone) = (
            path(&format!("in/{name}.csv")),
            path(&format!("{name}.csv")),
        );
        run_ok(&[
            "estimate",
            &recording,
            "--machine",
            "excavator",
            "-o",
            &alone,
        ]);
        let alone = Table::read(alone);
        let its = &found[recording.as_str()];
        assert_eq!(its.len(), alone.rows().len(), "{name}");
        for (row, alone_row) in its.iter().zip(alone.rows()) {
            for column in alone.names() {
                assert_eq!(row.cell(column), alone_row.cell(column), "{name}");
            }
        }
    }
    let output = run(&[&run_them[..], &["--machines", "3"]].concat());
    assert_eq!(output.status.code(), Some(2));
    says(&output, "holds 2 recordings, not 3");
}

/// Number of rows of the machine with the fewest, in the unfinished table of a run with this number of machines.
fn fewest(folder: &Path, machines: usize) -> usize {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let texts = files.filter_map(|f| std::fs::read_to_string(f.path()).ok());
    let text = texts.collect::<String>();
    let mut rows = BTreeMap::<&str, usize>::new();
    for line in text.lines().skip(1) {
        let name = line.split(',').next().unwrap_or_default();
        *rows.entry(name).or_default() += 1;
    }
    let fewest = rows.values().min().filter(|_| rows.len() >= machines);
    fewest.copied().unwrap_or(0)
}

#[test]
fn in_real_time_with_a_death_and_an_early_end_nothing_is_lost() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| path_in(folder.path(), name);
    let args = words("run excavator --scenario cycle --machines 4 --quiet --out");
    let mut child = heft();
    child.args(&args).args([&path("live"), "--duration", "600"]);
    let child = child
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("heft starts");
    let shards = || -> Vec<u32> {
        let of_ours = |pid: &u32| {
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            let parent = stat
                .rsplit_once(") ")
                .and_then(|(_, rest)| rest.split(' ').nth(1)?.parse().ok());
            parent == Some(child.id())
        };
        processes()
            .into_iter()
            .map(|(pid, _)| pid)
            .filter(of_ours)
            .collect()
    };
    wait_until("shards", Duration::from_secs(30), || !shards().is_empty());
    let some = |count: usize| {
        wait_until(
            "estimates of every machine",
            Duration::from_secs(60),
            || fewest(&folder.path().join("live"), 4) > count,
        );
    };
    some(100);
    let old = shards();
    kill(old[0], Signal::KILL);
    wait_until("a successor", Duration::from_secs(30), || {
        shards().iter().any(|pid| !old.contains(pid))
    });
    let before = fewest(&folder.path().join("live"), 4);
    some(before + 50);
    kill(child.id(), Signal::INT);
    let output = child.wait_with_output().expect("the end");
    let said = both(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("0 not answered") && said.contains("1 process replaced"),
        "{said}"
    );
    run_ok(
        &[
            &args[..],
            &[&path("quick"), "--duration", "60", "--pace", "max"],
        ]
        .concat(),
    );
    let [live, quick] = ["live", "quick"].map(|name| Table::read(path(name) + "/estimates.csv"));
    let (live, quick) = (by_machine(&live), by_machine(&quick));
    assert_eq!(live.len(), 4);
    for (machine, rows) in live {
        assert!(rows.len() > before + 50, "{}", rows.len());
        assert_eq!(rows[..], quick[machine][..rows.len()]);
    }
}

#[test]
fn what_makes_no_sense_for_many_machines_is_refused() {
    for words in [
        &["--rt"][..],
        &["--view"],
        &["--state", "s.toml"],
        &["--require-trust"],
        &["--split", "1h"],
        &["--output", "can:can0"],
    ] {
        let output = run(&[&["run", "excavator", "--machines", "2"], words].concat());
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        let said = both(&output);
        assert!(
            said.contains("cannot be used with") && said.contains("--machines"),
            "{said}"
        );
    }
    for live in ["can:can0", "-"] {
        let output = run(&["run", "excavator", "--machines", "2", "--input", live]);
        assert_eq!(output.status.code(), Some(2), "{live}");
        says(&output, "is one machine, not 2");
    }
}
