//! What is fuzzed: a parser each, and from a recording to its report.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use config::Description;
use messages::channels::{self, Channel, Visitor};
use messages::{Machine, Message, NumberType, Value};
use recording::{LineDecoder, Map, Metadata, Reader, Writer};

use crate::attack::Rng;

/// Where the input of the moment is, in the folder of the process.
pub const INPUT: &str = "input";

/// A parser and what it is given.
pub struct Target {
    /// On the command line, and its folder in `tests/fuzz`.
    pub name: &'static str,
    /// Files of the project to begin with.
    pub seeds: &'static [&'static str],
    /// One more that is made.
    pub made: Option<fn() -> Vec<u8>>,
    /// Only so much of a file: short inputs are quick.
    pub longest: usize,
    /// Must return, whatever the input is.
    pub run: fn(&[u8]),
}

const KB: usize = 1 << 10;

/// All of them.
pub const TARGETS: &[Target] = &[
    Target {
        name: "csv",
        seeds: &[
            "tests/golden/excavator_input_bad.csv",
            "tests/golden/excavator_input_drop.csv",
        ],
        made: None,
        longest: 4 * KB,
        run: csv,
    },
    Target {
        name: "dbc",
        seeds: &[
            "tests/maps/truck.dbc",
            "services/recording/tests/can/made_up.dbc",
            "services/recording/tests/can/canmod-gps.dbc",
            "services/recording/tests/can/cantools_j1939.dbc",
        ],
        made: None,
        longest: 16 * KB,
        run: dbc,
    },
    Target {
        name: "map",
        seeds: &[
            "tests/maps/truck.toml",
            "tests/maps/emps.toml",
            "tests/maps/hsm150.toml",
        ],
        made: None,
        longest: 4 * KB,
        run: map,
    },
    Target {
        name: "description",
        seeds: &[
            "tests/descriptions/emps.toml",
            "tests/descriptions/hsm150.toml",
            "tests/descriptions/paper.toml",
        ],
        made: Some(whole_description),
        longest: 16 * KB,
        run: description,
    },
    Target {
        name: "candump",
        seeds: &[],
        made: Some(log),
        longest: 16 * KB,
        run: candump,
    },
    Target {
        name: "lines",
        seeds: &["tests/golden/excavator_input_bad.csv"],
        made: Some(log),
        longest: 4 * KB,
        run: lines,
    },
    Target {
        name: "mcap",
        seeds: &[],
        made: Some(short_recording),
        longest: 256 * KB,
        run: mcap,
    },
    Target {
        name: "report",
        seeds: &[],
        made: Some(|| vec![7; 64]),
        longest: KB,
        run: report,
    },
    Target {
        name: "http",
        seeds: &[],
        made: Some(requests),
        longest: 16 * KB,
        run: http,
    },
];

/// The live page over a real socket: whatever comes, it answers the next one, and who went leaves no seat taken.
fn http(input: &[u8]) {
    const LOOK: Duration = Duration::from_millis(100);
    const PATIENCE: Duration = Duration::from_secs(10);
    static SERVER: OnceLock<view::live::Server> = OnceLock::new();
    let server = SERVER.get_or_init(|| {
        let feed = view::live::Feed::new(Vec::new());
        let any = ([127, 0, 0, 1], 0).into();
        view::live::serve(any, feed).expect("a port")
    });
    let ask = |request: &[u8], limit: Duration, patience: Duration| {
        let mut stream = TcpStream::connect(server.address()).expect("it listens");
        stream.set_read_timeout(Some(patience)).expect("a limit");
        // It may close before everything was said.
        let _ = stream.write_all(request);
        let (begun, mut answer) = (Instant::now(), [0; 4096]);
        let head = stream.read(&mut answer).map_or(0, |n| n);
        let mut rest = [0; 4096];
        while begun.elapsed() < limit && stream.read(&mut rest).is_ok_and(|n| n > 0) {}
        answer[..head].to_vec()
    };
    // What was not finished is left after a moment, what is streamed after a look.
    ask(input, LOOK, LOOK / 5);
    let request = b"GET /nothing HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    let answer = ask(request, PATIENCE, PATIENCE);
    assert!(answer.starts_with(b"HTTP/1.1 404"), "it does not answer");
    let begun = Instant::now();
    while server.viewers() > view::live::MAX_VIEWERS / 2 {
        assert!(begun.elapsed() < PATIENCE, "seats stay taken");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// What browsers ask, and what they do not, one after the other on a connection.
fn requests() -> Vec<u8> {
    b"GET / HTTP/1.1\r\nHost: localhost\r\nAccept: */*\r\n\r\n\
      POST / HTTP/1.1\r\nHost: 127.0.0.1:8440\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n\
      PUT /events HTTP/1.1\r\nHost: [::1]\r\nContent-Length: 12\r\nExpect: 100-continue\r\n\r\nhello, world\
      GET /events HTTP/1.0\r\nHost: elsewhere\r\nConnection: keep-alive\r\n\r\n\
      OPTIONS * HTTP/1.1\r\nHost: localhost\r\nConnection: upgrade, http2-settings\r\nUpgrade: h2c\r\n\r\n\
      GET /events HTTP/1.1\r\nHost: localhost\r\nLast-Event-ID: 7\r\n\r\n"
        .to_vec()
}

fn csv(input: &[u8]) {
    write("x.csv", input);
    let _ = recording::load::<messages::ExcavatorSensors>("x.csv", None);
    let _ = recording::load::<messages::LoaderSensors>("x.csv", None);
}

fn dbc(input: &[u8]) {
    write("truck.dbc", input);
    write("truck.toml", TRUCK_MAP.as_bytes());
    write("x.log", &log());
    if let Ok(map) = Map::read(Path::new("truck.toml")) {
        let _ = recording::load::<messages::LoaderSensors>("x.log", Some(&map));
    }
}

fn map(input: &[u8]) {
    write("truck.dbc", TRUCK_DBC.as_bytes());
    write("x.log", &log());
    write(
        "x.csv",
        b"time,v,t,a,b,c\n0,1,2,3,4,5\n0.01,1,2,3,4,5\n0.03,1,,3,4,5\n",
    );
    let text = String::from_utf8_lossy(input);
    if let Ok(map) = Map::parse(&text, "truck.toml") {
        let _ = recording::load::<messages::LoaderSensors>("x.log", Some(&map));
        let _ = recording::load::<messages::ExcavatorSensors>("x.csv", Some(&map));
        let _ = recording::load::<messages::LoaderSensors>("x.csv", Some(&map));
    }
}

fn description(input: &[u8]) {
    let text = String::from_utf8_lossy(input);
    for machine in [None, Some(Machine::Excavator), Some(Machine::Loader)] {
        let Ok(read) = Description::parse(&text, "input", machine) else {
            continue;
        };
        let printed = read.to_toml();
        let again =
            Description::parse(&printed, "printed", None).expect("what it prints, it reads");
        assert_eq!(again.to_toml(), printed, "printing is a fixed point");
    }
}

fn candump(input: &[u8]) {
    write("truck.dbc", TRUCK_DBC.as_bytes());
    write("x.log", input);
    let at_a_rate = TRUCK_MAP.replace("master = \"front_wheel_speed\"", "rate = 100");
    for text in [TRUCK_MAP, &at_a_rate] {
        let map = Map::parse(text, "truck.toml").expect("the map of the tests");
        let _ = recording::load::<messages::LoaderSensors>("x.log", Some(&map));
    }
}

fn lines(input: &[u8]) {
    write("truck.dbc", TRUCK_DBC.as_bytes());
    let map = Map::parse(TRUCK_MAP, "truck.toml").expect("the map of the tests");
    for map in [None, Some(map)] {
        let Ok(mut decoder) = LineDecoder::<messages::LoaderSensors>::new(map) else {
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

fn mcap(input: &[u8]) {
    write("x.mcap", input);
    let _ = fs::remove_file("x.recovered.mcap");
    read_all("x.mcap");
    let copy = Path::new("x.recovered.mcap");
    if recording::recover("x.mcap", Some(copy)).is_ok() && copy.exists() {
        read_all("x.recovered.mcap");
    }
}

/// A whole recording of wild numbers; the input is the chance.
fn report(input: &[u8]) {
    let seed = input
        .iter()
        .fold(1_u64, |a, b| a.wrapping_mul(31).wrapping_add(u64::from(*b)));
    let mut rng = Rng::new(seed);
    let machine = rng.one(&["excavator", "loader"]);
    let _ = fs::remove_file("x.mcap");
    let mut writer = Writer::create("x.mcap", &metadata(machine)).expect("room for a recording");
    for _ in 0..rng.between(0, 40) {
        for channel in channels::all().filter(|c| c.name.starts_with(machine) || c.name == "health")
        {
            channel.payload.visit(Wild {
                channel,
                writer: &mut writer,
                rng: &mut rng,
            });
        }
    }
    writer.finish().expect("room for a recording");
    read_all("x.mcap");
}

struct Wild<'a> {
    channel: &'a Channel,
    writer: &'a mut Writer,
    rng: &'a mut Rng,
}

impl Visitor for Wild<'_> {
    type Output = ();

    fn visit<M: Message>(self) {
        let mut message = M::default();
        for (index, field) in M::FIELDS.iter().enumerate() {
            let bits = match self.rng.between(0, 4) {
                0 => self.rng.between(0, u64::MAX),
                1 => (self.rng.between(0, 2000) as f64 - 1000.0).to_bits(),
                2 => self.rng.one(&[
                    0,
                    1,
                    u64::MAX,
                    f64::NAN.to_bits(),
                    f64::MAX.to_bits(),
                    1 << 63,
                ]),
                _ => self.rng.between(0, 1000),
            };
            let value = match field.kind {
                NumberType::U32 => Value::U32(bits as u32),
                NumberType::U64 => Value::U64(bits),
                NumberType::F64 => Value::F64(f64::from_bits(bits)),
            };
            message.set(index, value);
        }
        self.writer
            .write(self.channel, &message)
            .expect("room for a message");
    }
}

fn read_all(file: &str) {
    let Ok(reader) = Reader::open(file) else {
        return;
    };
    for channel in reader.channels() {
        let _ = reader.for_each_value(channel, |_, _| ());
    }
    let _ = reader.counts();
    if let Ok(run) = view::Run::from_recording(&reader) {
        let page = view::report(&run);
        assert!(!page.contains("NaN"), "a number that is none in the report");
    }
}

fn metadata(machine: &str) -> Metadata {
    let pairs = [
        ("machine", machine),
        ("processes", "sensor,kalman,rls,ukf,logger"),
    ];
    pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).into()
}

/// A valid recording of both machines.
fn short_recording() -> Vec<u8> {
    let file = std::env::temp_dir().join(format!("battery-{}.mcap", std::process::id()));
    let _ = fs::remove_file(&file);
    let mut writer = Writer::create(&file, &metadata("excavator")).expect("room for a recording");
    let mut rng = Rng::new(1);
    for n in 0..60 {
        for channel in channels::all() {
            channel.payload.visit(Wild {
                channel,
                writer: &mut writer,
                rng: &mut rng,
            });
        }
        if n % 20 == 19 {
            writer.flush().expect("room for a recording");
        }
    }
    writer.finish().expect("room for a recording");
    let bytes = fs::read(&file).expect("just written");
    let _ = fs::remove_file(&file);
    bytes
}

fn whole_description() -> Vec<u8> {
    Description::default_of(Machine::Loader)
        .to_toml()
        .into_bytes()
}

/// Frames of the truck in the common forms.
fn log() -> Vec<u8> {
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

const TRUCK_MAP: &str = include_str!("../../../../../tests/maps/truck.toml");
const TRUCK_DBC: &str = include_str!("../../../../../tests/maps/truck.dbc");

fn write(name: &str, bytes: &[u8]) {
    fs::write(name, bytes).expect("room for an input");
}
