//! Parts, free space and clock, of a single recorder.

use super::*;
use messages::ExcavatorSensors;
use messages::channels::EXCAVATOR_SENSORS;

fn mark(first: &Path) -> Mark {
    Mark::open(&first.with_extension("mark"), first)
}

fn begin(first: &Path, limits: Limits) -> Recorder {
    Recorder::create(first, &Metadata::new(), limits, mark(first)).expect("made")
}

fn record(recorder: &mut Recorder, numbers: std::ops::Range<u64>) {
    write(recorder, numbers);
    recorder.flush().expect("room");
}

fn write(recorder: &mut Recorder, numbers: std::ops::Range<u64>) {
    for number in numbers {
        let mut message = ExcavatorSensors::default();
        message.stamp.sequence = number;
        message.stamp.measured_ns = 1 + number;
        message.swing_velocity = (number as f64).sin();
        assert_eq!(
            recorder.write(&EXCAVATOR_SENSORS, &message.envelope()),
            Ok(true)
        );
    }
}

fn numbers(path: &Path) -> Vec<u64> {
    let reader = recording::Reader::open(path).expect("a recording");
    assert!(reader.is_complete(), "each part is whole");
    let messages = reader.stream::<ExcavatorSensors>("excavator/sensors");
    messages
        .expect("sensors")
        .map(|m| m.stamp.sequence)
        .collect()
}

/// Numbers of the messages that a recorder has kept, without a gap.
fn numbers_of(mut recorder: Recorder) -> std::ops::Range<u64> {
    recorder.finish().expect("room");
    let numbers = numbers(&recorder.first);
    assert!(numbers.windows(2).all(|w| w[0] + 1 == w[1]));
    numbers[0]..numbers[numbers.len() - 1] + 1
}

#[test]
fn a_split_recording_is_read_as_one_and_keeps_what_it_may() {
    let dir = tempfile::tempdir().expect("a folder");
    let first = dir.path().join("run.mcap");
    let mut limits = Limits {
        split_bytes: Some(20_000),
        ..Limits::default()
    };
    let mut recorder = begin(&first, limits);
    for i in 0..10 {
        record(&mut recorder, i * 500..(i + 1) * 500);
    }
    recorder.finish().expect("room");
    let files = recording::files_by_age(dir.path()).len();
    assert!(files > 3, "{files} parts");
    assert_eq!(numbers(dir.path()), (0..5000).collect::<Vec<_>>());

    // A second run into the folder, which may hold 100 kB.
    let second = dir.path().join("run-2.mcap");
    limits.keep_bytes = Some(100_000);
    std::fs::write(dir.path().join("notes.mcap.txt"), vec![0; 200_000]).expect("writable");
    let mut recorder = begin(&second, limits);
    for i in 0..20 {
        record(&mut recorder, i * 500..(i + 1) * 500);
    }
    recorder.finish().expect("room");
    let total: u64 = recording::files_by_age(dir.path())
        .iter()
        .map(|f| f.2)
        .sum();
    assert!((40_000..130_000).contains(&total), "{total} bytes are kept");
    assert!(!first.exists(), "the oldest go first");
    let kept = numbers(dir.path());
    assert_eq!(kept.last(), Some(&9999));
    assert!(kept.windows(2).all(|w| w[0] + 1 == w[1]), "without a gap");
    assert!(dir.path().join("notes.mcap.txt").exists());
}

/// Gives each file of a recording in `folder` another time of its last write.
fn written_at(folder: &Path, time: SystemTime, which: impl Fn(&Path) -> bool) {
    let files = recording::files_by_age(folder).into_iter();
    for (file, ..) in files.filter(|(file, ..)| which(file)) {
        let file = std::fs::File::options().append(true).open(file);
        file.and_then(|f| f.set_modified(time)).expect("set");
    }
}

#[test]
fn a_clock_that_is_set_during_a_run_makes_no_part_too_old_to_keep() {
    let dir = tempfile::tempdir().expect("a folder");
    let first = dir.path().join("run.mcap");
    let day = Duration::from_secs(86_400);
    let limits = Limits {
        split_bytes: Some(20_000),
        keep_for: Some(7 * day),
        ..Limits::default()
    };
    let mut recorder = begin(&first, limits);
    for i in 0..10 {
        record(&mut recorder, i * 500..(i + 1) * 500);
    }
    // What is there was written in the last hour, by a clock that was 30 days behind.
    let now = SystemTime::now();
    written_at(dir.path(), now - 30 * day - day / 24, |_| true);
    recorder.ages.set_forward(30 * day, now);
    for i in 10..20 {
        record(&mut recorder, i * 500..(i + 1) * 500);
    }
    assert_eq!(numbers_of(recorder), 0..10_000);

    // A run that begins after that cannot know: by its clock they are 30 days old.
    written_at(dir.path(), now - 30 * day, |_| true);
    let mut recorder = begin(&dir.path().join("run-2.mcap"), limits);
    for i in 0..10 {
        record(&mut recorder, i * 500..(i + 1) * 500);
    }
    recorder.finish().expect("room");
    assert!(!first.exists());
}

#[test]
fn the_parts_of_a_run_go_last_and_in_their_order_whatever_the_clock_says() {
    let dir = tempfile::tempdir().expect("a folder");
    let (older, first) = (dir.path().join("run.mcap"), dir.path().join("run-2.mcap"));
    let mut limits = Limits::default();
    let mut recorder = begin(&older, limits);
    record(&mut recorder, 0..1000);
    recorder.finish().expect("room");
    limits.split_bytes = Some(20_000);
    let mut recorder = begin(&first, limits);
    for i in 0..4 {
        record(&mut recorder, i * 500..(i + 1) * 500);
    }
    // The clock was set back by a day before this run, and again after its first part.
    let day = Duration::from_secs(86_400);
    let now = SystemTime::now();
    written_at(dir.path(), now + 2 * day, |file| file == older);
    written_at(dir.path(), now + day, |file| file == first);
    let sizes = recording::files_by_age(dir.path());
    let of_older = sizes.iter().find(|f| f.0 == older).expect("there").2;
    let all: u64 = sizes.iter().map(|f| f.2).sum();
    recorder.limits.keep_bytes = Some(all - of_older / 2);
    recorder.remove_old();
    assert!(!older.exists(), "the other run's");
    assert!(first.exists(), "its own");
    recorder.limits.keep_bytes = Some(all - of_older - 1000);
    recorder.remove_old();
    assert!(!first.exists(), "the first part of its own");
    let kept = numbers_of(recorder);
    assert!(kept.start > 0 && kept.end == 2000, "{kept:?}");
}

#[test]
fn a_disk_with_less_room_than_asked_for_stops_the_recording_with_a_whole_part() {
    let dir = tempfile::tempdir().expect("a folder");
    let first = dir.path().join("run.mcap");
    let limits = Limits {
        min_free: Some(u64::MAX),
        ..Limits::default()
    };
    let mut recorder = begin(&first, limits);
    let message = ExcavatorSensors::default();
    assert_eq!(
        recorder.write(&EXCAVATOR_SENSORS, &message.envelope()),
        Ok(true)
    );
    assert!(
        recorder
            .flush()
            .is_err_and(|e| e.what.contains("--min-free"))
    );
    assert_eq!(
        recorder.write(&EXCAVATOR_SENSORS, &message.envelope()),
        Ok(false)
    );
    assert_eq!(numbers(&first), [0]);
}

#[test]
fn a_part_that_somebody_deletes_is_reported_and_costs_no_more_than_itself() {
    let dir = tempfile::tempdir().expect("a folder");
    let first = dir.path().join("run.mcap");
    let mut recorder = begin(&first, Limits::default());
    record(&mut recorder, 0..10);
    std::fs::remove_file(&first).expect("it is there");
    write(&mut recorder, 10..20);
    let reported = recorder.flush();
    assert!(reported.is_err_and(|e| e.what.contains("deleted")));
    record(&mut recorder, 20..30);
    recorder.finish().expect("room");
    assert_eq!(numbers(dir.path()), (20..30).collect::<Vec<_>>());
}

#[test]
fn a_wall_clock_that_jumps_is_noted_in_the_recording_which_keeps_its_time() {
    let dir = tempfile::tempdir().expect("a folder");
    let first = dir.path().join("run.mcap");
    let mut recorder = begin(&first, Limits::default());
    record(&mut recorder, 0..10);
    let before = recorder.wall_offset_ns;
    // As if the clock had been an hour behind until now, then 0.4 s, which is no jump.
    recorder.wall_offset_ns -= 3_600_000_000_000;
    record(&mut recorder, 10..20);
    recorder.wall_offset_ns -= 400_000_000;
    record(&mut recorder, 20..30);
    assert!((recorder.wall_offset_ns - before).abs() < 500_000_000);
    recorder.finish().expect("room");
    assert_eq!(numbers(&first), (0..30).collect::<Vec<_>>());
    let reader = recording::Reader::open(&first).expect("a recording");
    let jumps = reader.metadata().get("wall_clock.jumps").expect("a value");
    assert!(jumps.starts_with("3600.0"), "{jumps}");
    assert!(!jumps.contains(';'), "one jump: {jumps}");
}

#[test]
fn a_successor_knows_what_is_recorded_at_whatever_byte_its_predecessor_died() {
    let dir = tempfile::tempdir().expect("a folder");
    let first = dir.path().join("run.mcap");
    let next = || mark(&first).recorded().get(EXCAVATOR_SENSORS.name).copied();
    let mut recorder = begin(&first, Limits::default());
    assert_eq!(next(), None);
    record(&mut recorder, 0..50);
    let before = recorder.writer.as_ref().map_or(0, Writer::size);
    assert_eq!(next(), Some(50));
    record(&mut recorder, 50..100);
    write(&mut recorder, 100..150);
    assert_eq!(next(), Some(100), "what is not flushed is lost with it");
    let file = std::fs::OpenOptions::new().write(true).open(&first);
    let file = file.expect("the recording");
    for cut in (before..file.metadata().expect("a length").len()).rev() {
        file.set_len(cut).expect("cut");
        let whole = recording::Reader::open(&first).expect("a recording");
        let whole: Vec<ExcavatorSensors> = whole.messages(EXCAVATOR_SENSORS.name).expect("some");
        assert_eq!(next(), Some(whole.len() as u64), "cut at {cut}");
    }
    // The next part continues from there.
    let mut recorder = begin(&first, Limits::default());
    record(&mut recorder, 50..60);
    assert_eq!(next(), Some(60));
}
