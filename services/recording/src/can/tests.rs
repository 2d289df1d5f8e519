//! Compares the database with cantools, and tests every reader with malformed input.

use std::path::Path;
use std::time::{Duration, Instant};

use super::dbc::{Dbc, Reading};
use super::{Decoder, Line, parse};
use crate::{Map, csv, load, time};
use messages::{ExcavatorSensors, LoaderSensors};

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/can"))
}

#[test]
fn random_frames_are_read_as_cantools_reads_them() {
    let text = std::fs::read_to_string(folder().join("golden.csv")).expect("golden frames");
    let mut compared = 0;
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [file, message, data, signal, wanted] = cells[..] else {
            panic!("{line}");
        };
        let dbc = Dbc::open(&folder().join(file)).expect("a DBC");
        let mut message = dbc.find(message).expect("a message").clone();
        // cantools does not decode "not available".
        message.j1939 = false;
        let signal = message.find(signal).expect("a signal");
        let log = format!("(0.0) x 1##0{data}");
        let Some(Line::Frame { frame, .. }) = parse(&log) else {
            panic!("{log}");
        };
        let wanted: f64 = wanted.parse().expect("a number");
        let place = message.place(signal).expect("a place");
        let Reading::Value(found) = place.read(frame.data()) else {
            panic!("{line}");
        };
        let scale = wanted.abs().max(signal.layout.offset.abs()).max(1e-300);
        assert!((found - wanted).abs() <= 1e-14 * scale, "{line}: {found}");
        compared += 1;
    }
    assert!(compared > 500, "{compared}");
}

/// A generator without a dependency (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }

    /// `text` with a few pieces removed, doubled, swapped or replaced.
    fn damage(&mut self, text: &[u8]) -> Vec<u8> {
        const PIECES: &[&[u8]] = &[
            b"",
            b"\"",
            b"\n",
            b";",
            b"(",
            b"#",
            b"99999999999999999999",
            b"-1",
            b"1e308",
            b"nan",
            b"\xff\xfe",
            b"\xc3",
            b"m0",
            b"[64]",
            b"e",
            b".",
            b"=",
            b"[",
            b"}",
        ];
        let mut text = text.to_vec();
        for _ in 0..=self.below(4) {
            let start = self.below(text.len() + 1);
            let end = (start + self.below(9)).min(text.len());
            let piece = PIECES[self.below(PIECES.len())];
            match self.below(3) {
                0 => drop(text.splice(start..end, piece.iter().copied())),
                1 => text.truncate(start.max(1)),
                _ => {
                    let copy = text[start..end].to_vec();
                    drop(text.splice(start..start, copy));
                }
            }
        }
        text
    }
}

const LOG: &str = "(1397165409.000000) can0 0CF00400#FFFFD82003FFFFFF\n (000.005001)  can0  RX - -  18FEDF00   [8]  8A A0 28 7D 7D FF FF F5\n(2014-04-10 21:30:09.5) can1 123##1AABB\n";
const MAP: &str = "[can]\ndbc = \"d.dbc\"\nrate = 1000\n[can.signals]\nswing_velocity = { message = \"Extended\", signal = \"Deep\", unit = \"rad/s\", delay = 0.1, interpolate = true, max_age = 2 }\nswing_torque = { terms = [{ message = \"Floats\", signal = \"Single\" }, { constant = 1.0 }], scale = 2.0 }\n[columns]\nt = { column = \"Zeit\", unit = \"ms\" }\nswing_velocity = { column = \"n\", delay = 0.2 }\n";
const TABLE: &str = "sep=;\nt;swing_velocity;swing_torque\n2026-11-21T16:00:00,5;0,5;\n2026-11-21T16:00:00,6;\"1,5\";2000\n";

/// Any input gives an answer or an error, in bounded time, and never a panic.
#[test]
fn no_input_is_answered_by_a_panic() {
    let begun = Instant::now();
    let limit = Duration::from_secs(20);
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let dbc = std::fs::read(folder().join("made_up.dbc")).expect("a DBC");
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::write(dir.path().join("d.dbc"), &dbc).expect("writable");
    let map = Map::parse(MAP, dir.path().join("m.toml")).expect("a map");
    let table = dir.path().join("t.csv");
    for round in 0..1000 {
        let broken = String::from_utf8_lossy(&random.damage(&dbc)).into_owned();
        if let Ok(dbc) = Dbc::parse(&broken, Path::new("x.dbc")) {
            for message in &dbc.messages {
                for place in message.signals.iter().filter_map(|s| message.place(s)) {
                    let bytes: Vec<u8> = (0..random.below(65))
                        .map(|_| random.below(256) as u8)
                        .collect();
                    if let Reading::Value(value) = place.read(&bytes) {
                        assert!(value.is_finite());
                    }
                }
            }
        }
        let broken = String::from_utf8_lossy(&random.damage(MAP.as_bytes())).into_owned();
        if let Ok(map) = Map::parse(&broken, dir.path().join("m.toml")) {
            let _ = Decoder::<ExcavatorSensors>::new(&map);
            let _ = Decoder::<LoaderSensors>::new(&map);
        }
        let broken = String::from_utf8_lossy(&random.damage(LOG.as_bytes())).into_owned();
        let mut decoder = Decoder::<ExcavatorSensors>::new(&map).expect("a decoder");
        for line in broken.lines() {
            let _ = time::nanoseconds(line);
            if let Some(Line::Frame { frame, .. }) = parse(line) {
                decoder.take(&frame);
            }
        }
        decoder.finish();
        let rows = std::iter::from_fn(|| decoder.row()).count();
        assert!(rows < 100_000, "{rows} rows of three lines");
        if round % 4 == 0 {
            std::fs::write(&table, random.damage(TABLE.as_bytes())).expect("writable");
            let _ = csv::read::<ExcavatorSensors>(&table, None);
            let _ = csv::read::<ExcavatorSensors>(&table, Some(&map));
            let _ = csv::read_weighings(&table);
        }
        assert!(begun.elapsed() < limit, "{round} rounds took {limit:?}");
    }
}

#[test]
fn two_thousand_random_frames_make_no_row_that_cannot_be() {
    let mut random = Random(7);
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::copy(folder().join("made_up.dbc"), dir.path().join("d.dbc")).expect("a DBC");
    let map = Map::parse(MAP, dir.path().join("m.toml")).expect("a map");
    let mut decoder = Decoder::<ExcavatorSensors>::new(&map).expect("a decoder");
    let mut last = f64::NEG_INFINITY;
    for n in 0..2000 {
        let data: String = (0..random.below(9))
            .map(|_| format!("{:02X}", random.below(256)))
            .collect();
        let id = [101, 103, random.below(0x800)][random.below(3)];
        let line = format!(
            "({}.{:06}) can0 {id:03X}#{data}",
            n / 500,
            random.below(1_000_000)
        );
        if let Some(Line::Frame { frame, .. }) = parse(&line) {
            decoder.take(&frame);
        }
        while let Some((sensors, _)) = decoder.row() {
            assert!(sensors.stamp.time > last, "time goes forward");
            last = sensors.stamp.time;
            assert!(sensors.swing_velocity.is_finite() && sensors.swing_torque.is_finite());
        }
    }
    assert!(last > 1.0);
}

#[test]
fn a_file_that_says_it_is_a_log_and_is_not_is_an_error() {
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::copy(folder().join("made_up.dbc"), dir.path().join("d.dbc")).expect("a DBC");
    let map = Map::parse(MAP, dir.path().join("m.toml")).expect("a map");
    let path = dir.path().join("x.log");
    std::fs::write(&path, [0xff; 5000]).expect("writable");
    let error = load::<ExcavatorSensors>(&path, Some(&map)).expect_err("no log");
    assert!(error.to_string().len() < 1000, "{error}");
}

#[test]
fn a_frame_that_ends_before_a_signal_is_named_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "BO_ 256 SWING: 8 E\n SG_ Speed : 0|16@1- (0.001,0) [0|0] \"rad/s\" E\n \
                SG_ Torque : 32|32@1- (1,0) [0|0] \"Nm\" E\n";
    std::fs::write(folder.path().join("m.dbc"), text).expect("writable");
    let map = "[can]\ndbc = [\"m.dbc\"]\nrate = 100\n[can.signals]\n\
               swing_velocity = { message = \"SWING\", signal = \"Speed\" }\n\
               swing_torque = { message = \"SWING\", signal = \"Torque\" }\n";
    let map = Map::parse(map, folder.path().join("m.toml")).expect("a map");
    let mut decoder = Decoder::<ExcavatorSensors>::new(&map).expect("a decoder");
    for n in 0..100 {
        let data = if n % 10 == 5 {
            "0100"
        } else {
            "0100000000000000"
        };
        let line = format!("(0.{n:02}) can0 100#{data}");
        let Some(Line::Frame { frame, .. }) = parse(&line) else {
            panic!("a frame: {line}");
        };
        decoder.take(&frame);
    }
    let remarks = decoder.take_remarks();
    assert!(
        remarks.len() == 1 && remarks[0].contains("SWING are too short for Torque"),
        "{remarks:?}"
    );
}

/// A DBC of J1939 need not say that it is one.
#[test]
fn a_message_of_the_transport_protocol_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writable");
        path
    };
    file(
        "m.dbc",
        "BO_ 2566869249 SWING: 8 E\n SG_ Speed : 0|16@1- (0.001,0) [0|0] \"rad/s\" E\n\
         BO_ 2566869761 BIG: 12 E\n SG_ Head : 0|32@1- (1,0) [0|0] \"Pa\" E\n",
    );
    let map = file(
        "map.toml",
        "[can]\ndbc = [\"m.dbc\"]\nrate = 100\n[can.signals]\n\
         swing_velocity = { message = \"SWING\", signal = \"Speed\" }\n\
         boom_head_pressure = { message = \"BIG\", signal = \"Head\" }\n",
    );
    let rows = (0..200).map(|i| {
        format!(
            "({}.{:02}) c 18FF5101#0{}00000000000000\n",
            i / 100,
            i % 100,
            i % 9
        )
    });
    let log = file("day.log", &rows.collect::<String>());
    let map = Map::read(&map).expect("a map");
    let error = load::<ExcavatorSensors>(&log, Some(&map))
        .map(drop)
        .expect_err("no pressure");
    assert!(
        error.to_string().contains("transport protocol of J1939"),
        "{error}"
    );
}
