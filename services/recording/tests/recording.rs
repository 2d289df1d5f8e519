//! Contents of a recording, and what remains of one that is cut off, damaged or refused.

use std::io::Write as _;
use std::path::Path;

use messages::channels::{self, EXCAVATOR_SENSORS, EXCAVATOR_TRUTH, HEALTH, Visitor};
use messages::{ExcavatorSensors, ExcavatorTruth, Health, Machine, Message, NumberType, Value};
use recording::{Metadata, Reader, Writer, recover};

fn sample(n: u64) -> ExcavatorSensors {
    let mut sensors = ExcavatorSensors::default();
    sensors.stamp.sequence = n;
    sensors.stamp.time = n as f64 * 0.01;
    sensors.stamp.measured_ns = 1_000_000 * n + 7;
    sensors.swing_velocity = (n as f64 * 0.1).sin();
    sensors.valid = (n % 64) as u32;
    sensors
}

fn metadata() -> Metadata {
    let pairs = [
        ("seed", "7"),
        ("configuration", "[machine]\nkind = \"excavator\"\n"),
    ];
    pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).into()
}

/// A recording of `n` samples, flushed after every tenth.
fn write(path: &Path, n: u64) {
    let _ = std::fs::remove_file(path);
    let mut writer = Writer::create(path, &metadata()).expect("a writable folder");
    for i in 0..n {
        writer
            .write(&EXCAVATOR_SENSORS, &sample(i))
            .expect("room on the disk");
        let truth = ExcavatorTruth {
            inertia: i as f64,
            ..Default::default()
        };
        writer
            .write(&EXCAVATOR_TRUTH, &truth)
            .expect("room on the disk");
        if i % 10 == 9 {
            writer.flush().expect("room on the disk");
        }
    }
    writer.finish().expect("room on the disk");
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for temporary files")
}

#[test]
fn a_recording_that_is_joined_to_another_is_named() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    write(&path, 25);
    let one = std::fs::read(&path).expect("a recording");
    std::fs::write(&path, [&one[..], &one[..]].concat()).expect("room on the disk");
    let reader = Reader::open(&path).expect("a recording");
    let samples = reader.messages::<ExcavatorSensors>("excavator/sensors");
    assert_eq!(samples.map(|s| s.len()).ok(), Some(25));
    assert_eq!(reader.lacks().cut_off, None);
    let (damage, at) = (reader.damage().concat(), one.len());
    let words = format!("another recording, joined to this one and not read, begins at byte {at}");
    assert!(damage.contains(&words), "{damage}");
}

#[test]
fn a_recording_reads_back_as_written() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    write(&path, 25);
    let reader = Reader::open(&path).expect("a recording");
    assert!(reader.is_complete() && !reader.is_being_written());
    assert_eq!(reader.metadata(), &metadata());
    assert_eq!(reader.channels(), ["excavator/sensors", "excavator/truth"]);
    let read: Vec<ExcavatorSensors> = reader.messages("excavator/sensors").expect("sensors");
    assert_eq!(read, (0..25).map(sample).collect::<Vec<_>>());
    assert!(
        reader
            .messages::<Health>("health")
            .expect("not recorded is empty")
            .is_empty()
    );
    assert!(
        reader.messages::<Health>("excavator/sensors").is_err(),
        "another type"
    );
}

#[test]
fn every_payload_survives_bit_for_bit_with_extreme_values() {
    struct RoundTrip<'a>(&'a Path, &'a channels::Channel);
    impl Visitor for RoundTrip<'_> {
        type Output = ();
        fn visit<M: Message>(self) {
            let doubles = [
                f64::NAN,
                -0.0,
                f64::MIN_POSITIVE,
                f64::NEG_INFINITY,
                0.1 + 0.2,
            ];
            let counts = [u64::MAX, 0, 1, 1 << 63, 300];
            let mut written = M::default();
            for (i, field) in M::FIELDS.iter().enumerate() {
                let value = match field.kind {
                    NumberType::F64 => Value::F64(doubles[i % 5]),
                    NumberType::U32 => Value::U32(counts[i % 5] as u32),
                    NumberType::U64 => Value::U64(counts[i % 5]),
                };
                assert!(written.set(i, value));
            }
            let _ = std::fs::remove_file(self.0);
            let mut writer = Writer::create(self.0, &metadata()).expect("a writable folder");
            writer.write(self.1, &written).expect("room on the disk");
            writer
                .write(self.1, &M::default())
                .expect("room on the disk");
            writer.finish().expect("room on the disk");
            let reader = Reader::open(self.0).expect("a recording");
            let read: Vec<M> = reader.messages(self.1.name).expect("the channel");
            assert_eq!(read.len(), 2);
            assert_eq!(read[1], M::default());
            for i in 0..M::FIELDS.len() {
                let (a, b) = (
                    written.get(i).expect("field"),
                    read[0].get(i).expect("field"),
                );
                assert!(a.same_bits(b), "{} {a:?} {b:?}", M::FIELDS[i].name);
            }
        }
    }
    let dir = folder();
    for channel in channels::all() {
        channel
            .payload
            .visit(RoundTrip(&dir.path().join("run.mcap"), channel));
    }
}

#[test]
fn what_bears_the_name_of_a_part_and_is_none_is_left_out_and_reported() {
    let dir = folder();
    let first = dir.path().join("run.mcap");
    let part = |file: &Path, run: &str, number: u32, samples: std::ops::Range<u64>| {
        let says = [("run", run.to_owned()), ("part", number.to_string())];
        let says = says.map(|(k, v)| (k.to_owned(), v)).into();
        let mut writer = Writer::create(file, &says).expect("a writable folder");
        for i in samples {
            writer
                .write(&EXCAVATOR_SENSORS, &sample(i))
                .expect("room on the disk");
        }
        writer.finish().expect("room on the disk");
    };
    let named = |n| recording::part(&first, n);
    part(&first, "1", 1, 0..10);
    part(&named(2), "1", 2, 10..20);
    part(&named(3), "2", 3, 20..30);
    std::fs::copy(named(2), named(4)).expect("a copy");
    std::fs::write(named(5), "t,swing_velocity\n").expect("writable");
    // Reserved by a logger that died before it wrote.
    std::fs::write(named(6), "").expect("writable");
    part(&named(9), "1", 9, 40..50);
    let reader = Reader::open(&first).expect("a recording");
    let samples: Vec<ExcavatorSensors> = reader.messages("excavator/sensors").expect("samples");
    let numbers: Vec<u64> = samples.iter().map(|s| s.stamp.sequence).collect();
    assert_eq!(numbers, (0..20).chain(40..50).collect::<Vec<_>>());
    let told = reader.damage();
    let said = [
        "run.part5.mcap: it is no MCAP file, and is left out",
        "run.mcap: parts 7 to 8 are missing",
        "run.part3.mcap: it is of another run, and is left out",
        "run.part4.mcap: it holds a part once more, and is left out",
    ];
    assert_eq!(told.len(), said.len(), "{told:?}");
    for (told, said) in told.iter().zip(said) {
        assert!(told.ends_with(said), "{told}");
    }
}

/// Reading a pipe without a writer would block.
#[test]
fn a_pipe_is_no_recording() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let made = std::process::Command::new("mkfifo").arg(&path).status();
    assert!(made.expect("mkfifo").success());
    let error = Reader::open(&path).expect_err("refused");
    assert!(error.what.contains("a pipe or a device"), "{error}");
}

#[test]
fn values_come_with_the_names_and_units_of_the_file() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    write(&path, 3);
    let reader = Reader::open(&path).expect("a recording");
    let fields = reader.fields("excavator/sensors");
    let at = fields
        .iter()
        .position(|f| f.name == "swing_velocity")
        .expect("the field");
    assert_eq!(fields[at].unit, "rad/s");
    let mut seen = Vec::new();
    reader
        .for_each_value("excavator/sensors", |time, values| {
            seen.push((time, values[at]))
        })
        .expect("the channel");
    assert_eq!(seen[2], (2_000_007, Value::F64(sample(2).swing_velocity)));
}

/// Cuts at every record boundary and one byte to either side, and at a sample of other places.
#[test]
fn a_recording_cut_anywhere_keeps_every_whole_chunk() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let mended = dir.path().join("mended.mcap");
    write(&path, 50);
    let whole = std::fs::read(&path).expect("readable");
    let boundaries = boundaries(&whole);
    let mut cuts: Vec<usize> = boundaries.iter().flat_map(|b| [b - 1, *b, b + 1]).collect();
    cuts.extend((0..whole.len()).step_by(499));
    cuts.retain(|cut| *cut < whole.len());
    let mut most = 0;
    for (i, cut) in cuts.into_iter().enumerate() {
        std::fs::write(&path, &whole[..cut]).expect("writable");
        let Ok(reader) = Reader::open(&path) else {
            assert!(
                cut < 8,
                "only without the first eight bytes it is no recording: {cut}"
            );
            assert!(recover(&path, None).is_err());
            continue;
        };
        assert!(!reader.is_complete(), "cut at {cut}");
        let read: Vec<ExcavatorSensors> = reader.messages("excavator/sensors").expect("sensors");
        assert_eq!(read.len() % 10, 0, "whole chunks only, cut at {cut}");
        assert_eq!(read, (0..read.len() as u64).map(sample).collect::<Vec<_>>());
        assert_eq!(
            reader.damage(),
            Vec::<String>::new(),
            "cut, not damaged: {cut}"
        );
        most = most.max(read.len());
        if i % 4 != 0 {
            continue; // mending waits for the disk each time
        }
        if read.is_empty() {
            let refused = recover(&path, Some(&mended)).expect_err("an empty copy helps nobody");
            assert!(refused.what.contains("would be empty"), "{refused}");
            assert!(!mended.exists(), "cut at {cut}");
            continue;
        }
        let recovered = recover(&path, Some(&mended)).expect("recoverable");
        assert_eq!(recovered.messages, 2 * read.len() as u64, "cut at {cut}");
        assert_eq!(recovered.written.as_deref(), Some(mended.as_path()));
        let unchanged = std::fs::read(&path).expect("readable");
        assert!(unchanged == whole[..cut], "the original stays as it is");
        let copy = Reader::open(&mended).expect("a recording");
        assert!(copy.is_complete());
        assert_eq!(
            copy.messages::<ExcavatorSensors>("excavator/sensors"),
            Ok(read)
        );
        let again = recover(&mended, None).expect("readable");
        assert!(again.was_complete, "once is enough: {again}");
        std::fs::remove_file(&mended).expect("removable");
    }
    assert_eq!(most, 50, "a cut in the index loses nothing");
    assert_eq!(
        std::fs::read_dir(dir.path()).expect("readable").count(),
        1,
        "nothing left beside"
    );
}

/// Ends of the records of a file, including that of the leading magic.
fn boundaries(bytes: &[u8]) -> Vec<usize> {
    let mut found = vec![8];
    let mut at = 8;
    while at + 9 < bytes.len() {
        let length = bytes[at + 1..at + 9].try_into().expect("eight bytes");
        at += 9 + u64::from_le_bytes(length) as usize;
        found.push(at);
    }
    found
}

/// For every kind of record and every length field: one flipped bit adds no sample, hides at most the contents of
/// its own chunk, and the loss is reported, by readers and by `recover`.
#[test]
fn a_flipped_bit_costs_one_block_at_most_and_is_reported() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let copy = dir.path().join("copy.mcap");
    write(&path, 50);
    let whole = std::fs::read(&path).expect("readable");
    let good: Vec<_> = (0..50).map(sample).collect();
    // Every bit of the opcode of every record, a bit of every byte of its head, and a selection of all bytes.
    let kinds = boundaries(&whole).into_iter();
    let kinds = kinds.flat_map(|at| (0..8).map(move |bit| (at, bit)));
    let heads = boundaries(&whole).into_iter().flat_map(|b| b..b + 48);
    let bytes = heads.chain((0..whole.len()).step_by(53)).enumerate();
    let mut places: Vec<(usize, usize)> = kinds.chain(bytes.map(|(i, at)| (at, i % 8))).collect();
    places.retain(|(at, _)| *at < whole.len());
    for (i, (at, bit)) in places.into_iter().enumerate() {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << bit;
        std::fs::write(&path, &bytes).expect("writable");
        let Ok(reader) = Reader::open(&path) else {
            assert!(
                at < 8,
                "only the first eight bytes make it a recording: {at}"
            );
            continue;
        };
        let read: Vec<ExcavatorSensors> = reader.messages("excavator/sensors").expect("sensors");
        let reported = !reader.damage().is_empty() || !reader.is_complete();
        assert!(
            read.len() >= 40,
            "flipped at {at}: {} of 50 are left",
            read.len()
        );
        assert!(read == good || reported, "flipped at {at}: lost in silence");
        assert!(
            read.iter().all(|m| good.contains(m)),
            "flipped at {at}: invented"
        );
        assert!(
            reader.metadata() == &metadata() || reported,
            "flipped at {at}: metadata"
        );
        if i % 16 != 0 {
            continue; // mending waits for the disk each time
        }
        let recovered = recover(&path, Some(&copy)).expect("recoverable");
        assert_eq!(
            recovered.was_complete, !reported,
            "flipped at {at}: {recovered}"
        );
        let mended = Reader::open(&copy).expect("a recording");
        let kept = mended.messages::<ExcavatorSensors>("excavator/sensors");
        assert_eq!(kept, Ok(read), "flipped at {at}");
        assert!(mended.is_complete() && mended.damage().is_empty());
        std::fs::remove_file(&copy).expect("removable");
    }
}

#[test]
fn a_live_recording_can_be_read_up_to_its_last_flush() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let mut writer = Writer::create(&path, &metadata()).expect("a writable folder");
    let reader = Reader::open(&path).expect("metadata are there at once");
    assert_eq!(reader.metadata(), &metadata());
    for i in 0..100 {
        writer
            .write(&EXCAVATOR_SENSORS, &sample(i))
            .expect("room on the disk");
    }
    writer.flush().expect("room on the disk");
    writer
        .write(&EXCAVATOR_SENSORS, &sample(100))
        .expect("room on the disk");
    let before = std::fs::read(&path).expect("readable");
    let reader = Reader::open(&path).expect("a recording");
    assert!(!reader.is_complete() && reader.is_being_written());
    assert!(recover(&path, None).is_err_and(|e| e.what.contains("being written")));
    assert_eq!(
        std::fs::read(&path).expect("readable"),
        before,
        "readers never write"
    );
    let second = Writer::create(&path, &metadata()).err().expect("locked");
    assert!(second.what.contains("not overwritten"), "{second}");
    let read = reader.messages::<ExcavatorSensors>("excavator/sensors");
    assert_eq!(read.map(|r| r.len()), Ok(100));
}

#[test]
fn a_full_disk_is_an_error_that_names_itself() {
    let Ok(mut writer) = Writer::create("/dev/full", &Metadata::new()) else {
        return; // refused at once: that is an answer too
    };
    let error = (0..1_000_000u64)
        .find_map(|i| {
            writer
                .write(
                    &HEALTH,
                    &Health {
                        steps: i,
                        ..Default::default()
                    },
                )
                .err()
        })
        .or_else(|| writer.flush().err())
        .expect("the disk is full");
    assert!(error.remedy.contains("make room"), "{error}");
    assert!(
        writer.write(&HEALTH, &Health::default()).is_err(),
        "and stays an error"
    );
    assert!(writer.finish().is_err());
}

#[test]
fn what_cannot_be_opened_is_reported_in_three_lines() {
    let dir = folder();
    let missing = Reader::open(dir.path().join("none.mcap")).expect_err("not there");
    assert_eq!(missing.to_string().lines().count(), 3);
    let text = dir.path().join("text.mcap");
    std::fs::write(&text, "t,swing_velocity\n0,1\n").expect("writable");
    let error = Reader::open(&text).expect_err("not a recording");
    assert_eq!(error.what, "this is no MCAP recording");
    for (bytes, what) in [
        (&b""[..], "the file is empty"),
        (b"\x1f\x8b\x08\x00", "this is a packed file"),
    ] {
        std::fs::write(&text, bytes).expect("writable");
        assert_eq!(Reader::open(&text).expect_err("none").what, what);
    }
    assert!(
        Writer::create(dir.path(), &Metadata::new()).is_err(),
        "a folder"
    );
    assert!(Writer::create(dir.path().join("none/run.mcap"), &Metadata::new()).is_err());
}

/// In a mount namespace of its own, this test runs again on a disk of 128 KiB.
const SMALL_DISK: &str = "HEFT_TEST_SMALL_DISK";

#[test]
fn a_disk_that_fills_up_leaves_a_recording_that_can_be_read_and_mended() {
    if let Some(disk) = std::env::var_os(SMALL_DISK) {
        return fill_up(Path::new(&disk));
    }
    let dir = folder();
    let mount = "mount -t tmpfs -o size=128k tmpfs \"$0\"";
    let unshare = |script: &str| {
        let mut command = std::process::Command::new("unshare");
        command.args(["-rm", "sh", "-c", script]).arg(dir.path());
        command.arg(std::env::current_exe().expect("this program"));
        command.env(SMALL_DISK, dir.path()).output()
    };
    if !unshare(mount).is_ok_and(|o| o.status.success()) {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: a small disk cannot be mounted here"
        );
        return;
    }
    let name = "a_disk_that_fills_up_leaves_a_recording_that_can_be_read_and_mended";
    let output = unshare(&format!("{mount} && \"$1\" --exact {name}")).expect("unshare runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
}

fn fill_up(disk: &Path) {
    let path = disk.join("run.mcap");
    let ballast = disk.join("ballast");
    std::fs::write(&ballast, vec![1; 64 << 10]).expect("half of the disk");
    let mut writer = Writer::create(&path, &metadata()).expect("room");
    let mut flushed = 0;
    let error = (0..100_000).find_map(|i| {
        writer
            .write(&EXCAVATOR_SENSORS, &sample(i))
            .err()
            .or_else(|| {
                let flush = (i % 10 == 9).then(|| writer.flush().err());
                flushed = if matches!(flush, Some(None)) {
                    i as usize + 1
                } else {
                    flushed
                };
                flush.flatten()
            })
    });
    let error = error.expect("the disk is full");
    assert!(error.remedy.contains("make room"), "{error}");
    drop(writer);
    let count = |path: &Path| {
        let reader = Reader::open(path).expect("a recording");
        reader
            .messages::<ExcavatorSensors>("excavator/sensors")
            .map(|r| r.len())
    };
    let kept = count(&path).expect("the channel");
    assert!(kept >= flushed, "nothing that was flushed is lost");
    let copy = disk.join("copy.mcap");
    assert!(
        recover(&path, Some(&copy)).is_err_and(|e| e.remedy.contains("make room")),
        "mending needs room"
    );
    assert!(!copy.exists(), "and leaves nothing without");
    assert_eq!(count(&path), Ok(kept), "reading needs none");
    std::fs::remove_file(&ballast).expect("removable");
    assert_eq!(
        recover(&path, Some(&copy)).map(|r| r.messages),
        Ok(kept as u64)
    );
    assert_eq!(count(&copy), Ok(kept));
    assert!(flushed > 100);
}

#[test]
fn a_damaged_length_in_the_metadata_hides_nothing_behind_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/recordings");
    let reader = Reader::open(folder.join("damaged-metadata-length.mcap")).expect("a recording");
    let counts = reader.counts();
    assert!(counts.values().sum::<u64>() > 50, "{counts:?}");
    let damage = reader.damage();
    assert!(
        damage.len() == 1 && damage[0].contains("a damaged record at byte 33"),
        "{damage:?}"
    );
    // Nor is it of the first machine, for the channels that all machines have.
    assert_eq!(reader.machine(), Some(Machine::Loader));
}

/// Readers of samples get to know what is missing: a damaged chunk is an error of `load`, a cut end is reported.
#[test]
fn samples_of_a_recording_say_what_it_lacks() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    write(&path, 500);
    let whole = std::fs::read(&path).expect("readable");
    let rows = recording::load::<ExcavatorSensors>(&path, None).expect("samples");
    let count = |path: &Path| {
        let samples = recording::open::<ExcavatorSensors>(path, None).expect("samples");
        let count = samples.rows().expect("rows").count();
        (count, samples.lacks())
    };
    assert_eq!(count(&path), (rows.len(), recording::Lacks::default()));

    let mut flipped = whole.clone();
    // Within the content of a chunk in the middle; a chunk's record begins with its kind, 6.
    let chunks: Vec<usize> = boundaries(&whole)
        .into_iter()
        .filter(|at| whole[*at] == 6)
        .collect();
    flipped[chunks[chunks.len() / 2] + 150] ^= 0x40;
    std::fs::write(&path, &flipped).expect("writable");
    let (fewer, lacks) = count(&path);
    assert!(fewer < rows.len(), "{fewer} of {}", rows.len());
    assert_eq!((lacks.damage.len(), lacks.cut_off), (1, None));
    let refused = recording::load::<ExcavatorSensors>(&path, None).expect_err("damaged");
    assert!(refused.to_string().contains("damaged block"), "{refused}");

    std::fs::write(&path, &whole[..whole.len() / 2]).expect("writable");
    let (fewer, lacks) = count(&path);
    assert!(fewer < rows.len() && lacks.cut_off.is_some(), "{lacks:?}");
    let loaded = recording::load::<ExcavatorSensors>(&path, None).expect("what is there");
    assert_eq!(loaded.len(), fewer);
}

#[test]
fn a_whole_recording_is_copied_where_a_copy_was_asked_for() {
    let dir = folder();
    let (path, copy) = (dir.path().join("run.mcap"), dir.path().join("x.mcap"));
    write(&path, 50);
    let recovered = recover(&path, None).expect("readable");
    assert!(
        recovered.was_complete && recovered.written.is_none(),
        "{recovered}"
    );
    let recovered = recover(&path, Some(&copy)).expect("readable");
    assert!(
        recovered
            .to_string()
            .contains("nothing was damaged; a copy is in"),
        "{recovered}"
    );
    let read = |path: &Path| std::fs::read(path).expect("readable");
    assert!(read(&copy) == read(&path), "bit for bit");
    assert!(
        recover(&path, Some(&copy)).is_err(),
        "nothing is overwritten"
    );
    let device = dir.path().join("device");
    std::os::unix::fs::symlink("/dev/full", &device).expect("a link");
    assert!(recover(&path, Some(&device)).is_err());
    assert!(device.is_symlink(), "and no device is removed");
}
