//! Targets: parsers of text, which are tables, signal maps, CAN logs, DBC files, and lines of a live source.

use std::path::{Path, PathBuf};

use messages::{ExcavatorSensors, LoaderSensors};
use recording::{LineDecoder, Map, Sensors};

use crate::recorded::assert_finite;
use crate::write;

pub fn csv(input: &[u8]) {
    write("x.csv", input);
    load::<ExcavatorSensors>("x.csv", None);
    load::<LoaderSensors>("x.csv", None);
    suggest("x.csv", &[]);
}

pub fn dbc(input: &[u8]) {
    write("truck.dbc", input);
    write("truck.toml", TRUCK_MAP.as_bytes());
    write("x.log", &log());
    if let Ok(map) = Map::read(Path::new("truck.toml")) {
        load::<LoaderSensors>("x.log", Some(&map));
    }
    suggest("x.log", &["truck.dbc".into()]);
}

pub fn map(input: &[u8]) {
    write("truck.dbc", TRUCK_DBC.as_bytes());
    write("x.log", &log());
    write(
        "x.csv",
        b"time,v,t,a,b,c\n0,1,2,3,4,5\n0.01,1,2,3,4,5\n0.03,1,,3,4,5\n",
    );
    let text = String::from_utf8_lossy(input);
    if let Ok(map) = Map::parse(&text, "truck.toml") {
        load::<LoaderSensors>("x.log", Some(&map));
        load::<ExcavatorSensors>("x.csv", Some(&map));
        load::<LoaderSensors>("x.csv", Some(&map));
    }
}

pub fn candump(input: &[u8]) {
    write("truck.dbc", TRUCK_DBC.as_bytes());
    write("x.log", input);
    let at_a_rate = TRUCK_MAP.replace("master = \"front_wheel_speed\"", "rate = 100");
    for text in [TRUCK_MAP, &at_a_rate] {
        let map = Map::parse(text, "truck.toml").expect("the map of the tests");
        load::<LoaderSensors>("x.log", Some(&map));
    }
}

pub fn lines(input: &[u8]) {
    write("truck.dbc", TRUCK_DBC.as_bytes());
    let map = Map::parse(TRUCK_MAP, "truck.toml").expect("the map of the tests");
    for map in [None, Some(map)] {
        let Ok(mut decoder) = LineDecoder::<LoaderSensors>::new(map) else {
            continue;
        };
        for (n, line) in (0..).zip(input.split(|b| *b == b'\n')) {
            if decoder.take(line, n * 10_000_000).is_err() {
                break;
            }
            while decoder.row().is_some() {}
        }
        decoder.finish();
        while decoder.row().is_some() {}
        let _ = decoder.take_remarks();
    }
}

/// Asserts that a suggested map is valid, or empty.
fn suggest(file: &str, dbc: &[PathBuf]) {
    let Ok(recording::Suggestion { text, .. }) = recording::suggest(Path::new(file), dbc, None)
    else {
        return;
    };
    if let Err(error) = Map::parse(&text, "suggested.toml") {
        assert_eq!(error.what, "the map is empty", "{text}");
    }
}

/// Asserts that all numbers of loaded samples are finite.
fn load<S: Sensors>(file: &str, map: Option<&Map>) {
    for (sensors, truth) in recording::load::<S>(file, map).into_iter().flatten() {
        assert_finite(&sensors);
        assert_finite(&truth);
    }
}

/// Frames of the truck in the common forms.
pub fn log() -> Vec<u8> {
    let mut text = String::new();
    for n in 0..40 {
        let time = 1_700_000_000.0 + 0.01 * f64::from(n);
        text += &format!("({time:.6}) can0 18FEF100#FFFF{n:02X}1AFFFFFFFF\n");
        text += &format!("({time:.6}) can0 18FEBF0B#{n:02X}1AFFFFFFFFFFFF\n");
        text += &format!(" ({time:.6})  can0  0CF00203   [8]  FF {n:02X} 12 FF FF FF FF FF\n");
        text += &format!("  can0  0CF00400   [8]  F1 7D {n:02X} 68 13 00 F4 FF\n");
    }
    text.into_bytes()
}

const TRUCK_MAP: &str = include_str!("../../../tests/maps/truck.toml");
const TRUCK_DBC: &str = include_str!("../../../tests/maps/truck.dbc");
