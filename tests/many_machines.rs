//! `heft serve`: many machines in few processes give the same estimates as each machine alone, even if processes die.

mod common;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use common::{both, golden, heft, kill, run, run_ok, says, wait_until};
use messages::{ExcavatorEstimate, ExcavatorSensors};
use recording::csv::EstimateRows;
use recording::payload::{decode, encode, put_delimited, take_delimited};
use rustix::process::Signal;

const MACHINES: usize = 30;

fn name(machine: usize) -> String {
    // A name with a comma needs quotes.
    format!("site 7, no. {machine}")
}

/// The recording that a machine plays.
fn plays(machine: usize) -> &'static str {
    ["excavator_input_two_swings.csv", "excavator_input_drop.csv"][machine % 2]
}

/// The rows of all machines in turn.
fn table() -> Vec<String> {
    let read = |m| std::fs::read_to_string(golden(plays(m))).expect("a recording");
    let texts: Vec<String> = (0..MACHINES).map(read).collect();
    let mut rows: Vec<_> = texts.iter().map(|t| t.lines()).collect();
    let header = rows[0].next().expect("a header");
    for rows in &mut rows[1..] {
        rows.next();
    }
    let mut lines = vec![format!("machine,{header}")];
    loop {
        let before = lines.len();
        for (machine, rows) in rows.iter_mut().enumerate() {
            lines.extend(
                rows.next()
                    .map(|row| format!("\"{}\",{row}", name(machine))),
            );
        }
        if lines.len() == before {
            return lines;
        }
    }
}

/// The rows of each machine, in their order.
fn by_machine(text: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::<String, String>::new();
    for line in text.lines().skip(1) {
        let (name, row) = line[1..].split_once("\",").expect("a name in quotes");
        let _ = writeln!(found.entry(name.into()).or_default(), "{row}");
    }
    found
}

fn start() -> Child {
    let mut command = heft();
    command.args("serve excavator --shards 3 --set prior.inertia=6000".split(' '));
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command.spawn().expect("heft starts")
}

/// The shard processes of a router.
fn shards(router: &Child) -> Vec<u32> {
    let parent = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let (_, rest) = stat.rsplit_once(") ")?;
        rest.split(' ').nth(1)?.parse::<u32>().ok()
    };
    let all = common::processes().into_iter();
    let own = all.filter(|(pid, args)| {
        args.iter().any(|a| a == "--shard") && parent(*pid) == Some(router.id())
    });
    own.map(|(pid, _)| pid).collect()
}

/// Feeds a router, and kills every shard before the lines at `deaths`. Returns standard output and messages.
fn serve(lines: &[String], deaths: &[usize]) -> (String, String) {
    let mut router = start();
    let mut pipe = router.stdin.take().expect("a pipe");
    let out = router.stdout.take().expect("a pipe");
    let reader = std::thread::spawn(move || {
        let lines = BufReader::new(out).lines().map(|l| l.expect("text") + "\n");
        lines.collect::<String>()
    });
    for (number, line) in lines.iter().enumerate() {
        if deaths.contains(&number) {
            pipe.flush().expect("a router");
            wait_until("three shards", Duration::from_secs(60), || {
                shards(&router).len() == 3
            });
            let old = shards(&router);
            old.iter().for_each(|pid| kill(*pid, Signal::KILL));
            wait_until("their successors", Duration::from_secs(60), || {
                let new = shards(&router);
                new.len() == 3 && new.iter().all(|pid| !old.contains(pid))
            });
        }
        writeln!(pipe, "{line}").expect("a router");
    }
    drop(pipe);
    let text = reader.join().expect("rows");
    let output = router.wait_with_output().expect("the end");
    let said = both(&output);
    assert!(output.status.success(), "{said}");
    (text, said)
}

#[test]
fn comments_and_units_above_the_rows_change_nothing() {
    let lines: Vec<String> = table().into_iter().take(2000).collect();
    let units: Vec<&str> = lines[0]
        .split(',')
        .map(|name| match name {
            "t" => "s",
            "swing_velocity" => "rad/s",
            "swing_torque" => "N m",
            _ => "",
        })
        .collect();
    let above = [
        "# by a gateway".into(),
        "# of a site, v3".into(),
        lines[0].clone(),
        units.join(","),
    ];
    let with: Vec<String> = above.iter().chain(&lines[1..]).cloned().collect();
    let (plain, _) = serve(&lines, &[]);
    let (found, said) = serve(&with, &[]);
    assert!(said.contains("; 0 lines left out"), "{said}");
    assert_eq!(by_machine(&found), by_machine(&plain));
}

/// Checks that each machine has the rows that `heft estimate` gives for it alone, with these settings.
fn each_has_what_it_has_alone(text: &str, settings: &[&str]) {
    let found = by_machine(text);
    assert_eq!(found.len(), MACHINES);
    let header: Vec<&str> = text
        .lines()
        .next()
        .expect("a header")
        .split(',')
        .skip(1)
        .collect();
    let folder = tempfile::tempdir().expect("a folder");
    for machine in 0..2 {
        let out = folder.path().join(format!("{machine}.csv"));
        let input = golden(plays(machine));
        let path = |p: &Path| p.to_str().expect("a path").to_owned();
        let (input, to) = (path(&input), path(&out));
        let args = ["estimate", &input, "--machine", "excavator", "-o", &to];
        run_ok(&[&args[..], settings].concat());
        let alone = std::fs::read_to_string(out).expect("estimates");
        let own: Vec<&str> = alone.lines().next().expect("a header").split(',').collect();
        // The table of one machine lacks the columns of quantities that the method does not estimate.
        let place = own
            .iter()
            .map(|c| header.iter().position(|h| h == c).expect("a column"));
        let place: Vec<usize> = place.collect();
        let narrow = |row: &str| {
            let cells: Vec<&str> = row.split(',').collect();
            place
                .iter()
                .map(|at| cells[*at])
                .collect::<Vec<_>>()
                .join(",")
                + "\n"
        };
        let rows: String = alone.lines().skip(1).map(|l| l.to_owned() + "\n").collect();
        let same = (machine..MACHINES).step_by(2).map(name);
        for machine in same {
            let shared: String = found[&machine].lines().map(narrow).collect();
            assert_eq!(shared, rows, "{machine}");
        }
    }
}

#[test]
fn each_machine_gets_what_it_would_get_alone() {
    let lines = table();
    let (text, said) = serve(&lines, &[]);
    assert!(
        said.contains(&format!("{MACHINES} machines, {} samples", lines.len() - 1)),
        "{said}"
    );
    each_has_what_it_has_alone(&text, &["--set", "prior.inertia=6000"]);
}

#[test]
fn killed_processes_change_no_bit() {
    let lines = table();
    let (undisturbed, _) = serve(&lines, &[]);
    // Before the first state of a shard, after it, and near the end.
    let (disturbed, said) = serve(&lines, &[500, 16_000, lines.len() - 50]);
    assert!(said.contains("9 processes replaced"), "{said}");
    assert_eq!(by_machine(&disturbed), by_machine(&undisturbed));
}

/// Answers and messages of `heft serve --messages` to these records.
fn serve_messages(input: Vec<u8>) -> (Vec<u8>, String) {
    let mut command = heft();
    command.args(["serve", "excavator", "--messages", "--shards", "2"]);
    command.args(["--set", "prior.inertia=6000"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut router = command.stderr(Stdio::piped()).spawn().expect("heft starts");
    let mut pipe = router.stdin.take().expect("a pipe");
    let writer = std::thread::spawn(move || pipe.write_all(&input).expect("a router"));
    let output = router.wait_with_output().expect("the end");
    writer.join().expect("all is written");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    (output.stdout, said)
}

#[test]
fn messages_give_the_rows_of_a_table_and_a_removed_machine_restarts() {
    let record = |name: &str, message: &[u8], out: &mut Vec<u8>| {
        put_delimited(name.as_bytes(), out);
        put_delimited(message, out);
    };
    let mut input = Vec::new();
    for machine in 0..2 {
        let rows = recording::load::<ExcavatorSensors>(golden(plays(machine)), None);
        for (sample, _) in rows.expect("a recording") {
            let mut message = Vec::new();
            encode(&sample, &mut message);
            record(&name(machine), &message, &mut input);
        }
    }
    // The first machine leaves and returns; invalid messages change nothing.
    let (first, _) = recording::load::<ExcavatorSensors>(golden(plays(0)), None)
        .expect("a recording")
        .remove(0);
    record(&name(0), &[], &mut input);
    record(&name(0), &[0xff; 7], &mut input);
    record("", &[8, 1], &mut input);
    let mut nan = first;
    nan.swing_velocity = f64::NAN;
    for sample in [nan, first] {
        let mut message = Vec::new();
        encode(&sample, &mut message);
        record(&name(0), &message, &mut input);
    }
    let (answers, said) = serve_messages(input);
    assert!(said.contains("3 messages left out"), "{said}");

    let table = EstimateRows::<ExcavatorEstimate>::default();
    let (mut rest, mut found) = (answers.as_slice(), BTreeMap::<String, String>::new());
    while !rest.is_empty() {
        let name = take_delimited(&mut rest).expect("a name");
        let message = take_delimited(&mut rest).expect("an estimate");
        let estimate = decode(message).expect("an estimate");
        let row = found
            .entry(String::from_utf8_lossy(name).into_owned())
            .or_default();
        assert!(table.put(&estimate, row), "a refused one is left out");
        row.push('\n');
    }
    let (text, _) = serve(&self::table(), &[]);
    let expected = by_machine(&text);
    assert_eq!(found[&name(1)], expected[&name(1)]);
    let begin = expected[&name(0)].lines().next().expect("a row");
    assert_eq!(found[&name(0)], format!("{}{begin}\n", expected[&name(0)]));
}

/// The rows of the first recording with changed cells: `change` takes the index of the column and the number.
fn changed(name: &str, change: impl Fn(usize, f64) -> f64) -> String {
    let text = std::fs::read_to_string(golden(plays(0))).expect("a recording");
    let rows = text.lines().skip(1).map(|row| {
        let cells = row.split(',').enumerate().map(|(at, cell)| {
            let number = cell.parse::<f64>().map(|x| change(at, x).to_string());
            number.unwrap_or_else(|_| cell.to_owned())
        });
        format!("{name},{}\n", cells.collect::<Vec<_>>().join(","))
    });
    rows.collect()
}

/// The index of a column in the recording.
fn column(name: &str) -> usize {
    let text = std::fs::read_to_string(golden(plays(0))).expect("a recording");
    let header = text.lines().next().expect("a header");
    header.split(',').position(|c| c == name).expect("a column")
}

#[test]
fn data_that_cannot_be_right_are_named_of_each_machine() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("in.csv");
    let (boom, velocity) = (column("boom_angle"), column("swing_velocity"));
    let header = &table()[0];
    let parts = [
        changed("right", |_, x| x),
        changed(
            "degrees",
            |at, x| if at == boom { x.to_degrees() } else { x },
        ),
        changed("slow", |at, x| if at == 0 { 100.0 * x } else { x }),
        changed("fast", |at, x| if at == velocity { 1e3 * x } else { x }),
    ];
    std::fs::write(&path, format!("{header}\n{}", parts.concat())).expect("a file");
    let serve = |path: &Path| run(&["serve", "excavator", path.to_str().expect("a path")]);
    let output = serve(&path);
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    for words in [
        "machine degrees: boom_angle seems to be in degrees",
        "write `unit = \"deg\"` for boom_angle",
        "machine slow: the rows are 1 s apart",
        "machine fast: swing_velocity seems to be in mrad/s",
        "where: ",
    ] {
        says(&output, words);
    }
    assert!(
        !both(&output).contains("machine right:"),
        "{}",
        both(&output)
    );
    // The unchanged rows alone succeed.
    std::fs::write(&path, format!("{header}\n{}", parts[0])).expect("a file");
    let output = serve(&path);
    assert!(output.status.success(), "{}", both(&output));
}

#[test]
fn rows_come_no_more_often_than_asked() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("in.csv");
    std::fs::write(&input, table().join("\n")).expect("a file");
    let input = input.to_str().expect("a path");
    let text = run_ok(&["serve", "excavator", input, "--every", "1"]);
    let rows = by_machine(&text[..]);
    let times = |rows: &str| -> Vec<f64> {
        let time = |r: &str| r.split(',').next().and_then(|t| t.parse().ok());
        rows.lines().map(|r| time(r).expect("a time")).collect()
    };
    let reported = times(&rows[&name(0)]);
    assert_eq!(reported.len(), 12, "{reported:?}");
    assert!(
        reported.windows(2).all(|w| w[1] - w[0] >= 1.0),
        "{reported:?}"
    );
}

#[test]
fn the_size_of_the_machines_counts_as_for_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("in.csv");
    std::fs::write(&input, table().join("\n")).expect("a file");
    let input = input.to_str().expect("a path");
    let class = ["--class", "13.5t"];
    let text = run_ok(&[&["serve", "excavator", input], &class[..]].concat());
    each_has_what_it_has_alone(&text, &class);
}

#[test]
fn what_cannot_be_served_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("in.csv");
    let path = input.to_str().expect("a path");
    for (text, words) in [
        ("", "without a header"),
        ("t,swing_velocity\n0,1\n", "there is no column machine"),
        ("machine,t\na,1\n", "swing_velocity"),
        ("machine,t,swing_velocity\n", "ended without a sample"),
        (
            "machine,t,swing_velocity\n\u{1b}[31m,0,1\n",
            "line 2 of IN names no machine",
        ),
    ] {
        std::fs::write(&input, text).expect("a file");
        let output = run(&["serve", "excavator", path]);
        let said = both(&output).replace(path, "IN");
        assert_eq!(output.status.code(), Some(2), "{text:?}: {said}");
        assert!(said.contains(words), "{text:?}: {said}");
        assert!(said.contains("where: IN"), "{text:?}: {said}");
    }
    for (rows, words) in [
        ("a,0,0,0\na,0.01,x,0\na,0.02,x,0\n", "2 lines were left out"),
        ("a,3,0,0\na,2,0,0\na,1,0,0\n", "2 of 3 rows were refused"),
    ] {
        let text = format!("machine,t,swing_velocity,swing_torque\n{rows}");
        std::fs::write(&input, text).expect("a file");
        let output = run(&["serve", "excavator", path]);
        assert_eq!(output.status.code(), Some(2), "{}", both(&output));
        says(&output, words);
    }
    let rows = "machine,t,swing_velocity,swing_torque\na,0,0,0\n,0.01,0,0\nb,0,0,0\na,0.02,x,0\na,0.03,0,0\nb,0,0,0\n";
    std::fs::write(&input, rows).expect("a file");
    let output = run(&["serve", "excavator", path]);
    assert!(output.status.success(), "{}", both(&output));
    let said = both(&output).replace(path, "IN");
    for words in [
        "2 machines, 4 samples",
        "2 lines left out",
        "line 3 of IN names no machine",
        "line 5 of IN is no row",
        "1 samples were refused",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // Concatenated exports: rows below a header with other columns are left out, and a byte order mark is not part of a name.
    let header = "machine,t,swing_velocity,swing_torque";
    let joined = format!(
        "{header}\na,0,0,0\n{header}\n\u{feff}a,0.01,0,0\nmachine,t,swing_torque,swing_velocity\na,0.02,9,0\n{header}\na,0.03,0,0\n"
    );
    std::fs::write(&input, joined).expect("a file");
    let output = run(&["serve", "excavator", path]);
    let said = both(&output).replace(path, "IN");
    for words in [
        "1 machine, 3 samples",
        "line 3 of IN is the header once more",
        "line 5 of IN belongs to another table",
        "line 6 of IN belongs to another table",
        "4 lines left out",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // An endless input without a line.
    let zeros = run(&["serve", "excavator", "/dev/zero"]);
    assert_eq!(zeros.status.code(), Some(2));
    says(&zeros, "this is no table");
    let folder = run(&[
        "serve",
        "excavator",
        folder.path().to_str().expect("a path"),
    ]);
    says(&folder, "not a folder");
    let full = std::fs::File::options().write(true).open("/dev/full");
    let full = common::heft()
        .args(["serve", "excavator", path])
        .stdout(full.expect("a full disk"))
        .output()
        .expect("heft");
    assert_eq!(full.status.code(), Some(2));
    says(&full, "No space left");
}

/// `heft serve` on a pipe, one shard: its rows, of which as many as `wanted` have come when this returns.
fn serve_pipe(input: &str, wanted: usize) -> (Child, std::thread::JoinHandle<String>) {
    let mut command = heft();
    command.args(["serve", "excavator", "--set", "prior.inertia=6000"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut router = command.stderr(Stdio::piped()).spawn().expect("heft starts");
    let out = router.stdout.take().expect("a pipe");
    let (say, came) = std::sync::mpsc::channel();
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        let mut lines = BufReader::new(out);
        while lines.read_line(&mut text).expect("text") > 0 {
            let _ = say.send(());
        }
        text
    });
    let pipe = router.stdin.as_mut().expect("a pipe");
    pipe.write_all(input.as_bytes()).expect("a router");
    for _ in 0..wanted {
        came.recv_timeout(Duration::from_secs(20)).expect("a row");
    }
    (router, reader)
}

#[test]
fn a_signal_ends_serve_in_order_without_the_line_of_which_a_part_had_come() {
    let lines = table();
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        // A hundred rows of each: the first ones wait until their times are known.
        // The number in the last cell of a part would be another one.
        let count = 101 * MACHINES;
        let (rows, part) = (&lines[..=count], &lines[count + 1]);
        let input = format!("{}\n{}", rows.join("\n"), &part[..part.len() - 2]);
        let (mut router, reader) = serve_pipe(&input, rows.len());
        kill(router.id(), signal);
        let input = router.stdin.take();
        let output = router.wait_with_output().expect("the end");
        drop(input);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{signal:?}: {said}");
        let samples = format!("{MACHINES} machines, {count} samples");
        assert!(said.contains(&samples), "{samples}: {said}");
        assert!(said.contains("0 lines left out"), "{said}");
        let text = reader.join().expect("rows");
        assert_eq!(text.lines().count(), rows.len());
    }
}

#[test]
fn a_last_line_without_an_end_counts() {
    let lines = table();
    let (mut router, reader) = serve_pipe(&lines[..2].join("\n"), 1);
    drop(router.stdin.take());
    let output = router.wait_with_output().expect("the end");
    assert!(output.status.success(), "{output:?}");
    assert_eq!(reader.join().expect("rows").lines().count(), 2);
}

#[test]
fn serve_is_silent_where_its_reader_has_left() {
    let mut command = heft();
    command.args(["serve", "excavator", "--set", "prior.inertia=6000"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut router = command.stderr(Stdio::piped()).spawn().expect("heft starts");
    drop(router.stdout.take());
    let mut pipe = router.stdin.take().expect("a pipe");
    // Its end is the end of the pipe.
    let _ = pipe.write_all(table().join("\n").as_bytes());
    drop(pipe);
    let output = router.wait_with_output().expect("the end");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(141), "{said}");
    assert!(!said.contains("heft:"), "{said}");
}
