//! Fuzz targets: every parser, the path from a recording to its report, and from samples to estimates.
//!
//! Two programs feed the same targets. `battery --fuzz` changes inputs at random, with a seed; it needs no tools and runs in every
//! `cargo test`. `bench/fuzz/guided` uses the coverage of each input, by libFuzzer.
//!
//! | file | targets |
//! |---|---|
//! | `text` | csv, dbc, map, candump, lines |
//! | `described` | description, estimate |
//! | `recorded` | mcap, report |
//! | `http` | http |

mod described;
mod http;
mod memory;
mod recorded;
mod text;

use std::fs;
use std::path::{Path, PathBuf};

pub use memory::{Limited, limited};

/// A parser and its inputs.
pub struct Target {
    /// Name on the command line, and of its folder in `tests/fuzz`.
    pub name: &'static str,
    /// Files of the project as initial inputs.
    pub seeds: &'static [&'static str],
    /// Further initial inputs, which are generated.
    pub made: fn() -> Vec<Vec<u8>>,
    /// Largest number of bytes of a file: short inputs run quickly.
    pub longest: usize,
    /// Must return, whatever the input is. Writes files into the working folder.
    pub run: fn(&[u8]),
}

const KB: usize = 1 << 10;

/// All targets.
pub const TARGETS: &[Target] = &[
    Target {
        name: "csv",
        seeds: &[
            "tests/golden/excavator_input_bad.csv",
            "tests/golden/excavator_input_drop.csv",
        ],
        made: Vec::new,
        longest: 4 * KB,
        run: text::csv,
    },
    Target {
        name: "dbc",
        seeds: &[
            "tests/maps/truck.dbc",
            "services/recording/tests/can/made_up.dbc",
            "services/recording/tests/can/canmod-gps.dbc",
            "services/recording/tests/can/cantools_j1939.dbc",
        ],
        made: Vec::new,
        longest: 16 * KB,
        run: text::dbc,
    },
    Target {
        name: "map",
        seeds: &[
            "tests/maps/truck.toml",
            "tests/maps/emps.toml",
            "tests/maps/hsm150.toml",
        ],
        made: Vec::new,
        longest: 4 * KB,
        run: text::map,
    },
    Target {
        name: "description",
        seeds: &[
            "tests/descriptions/emps.toml",
            "tests/descriptions/hsm150.toml",
            "tests/descriptions/paper.toml",
        ],
        made: described::whole_descriptions,
        longest: 16 * KB,
        run: described::description,
    },
    Target {
        name: "candump",
        seeds: &[],
        made: || vec![text::log()],
        longest: 16 * KB,
        run: text::candump,
    },
    Target {
        name: "lines",
        seeds: &["tests/golden/excavator_input_bad.csv"],
        made: || vec![text::log()],
        longest: 4 * KB,
        run: text::lines,
    },
    Target {
        name: "mcap",
        seeds: &[],
        made: recorded::recordings,
        longest: 256 * KB,
        run: recorded::mcap,
    },
    Target {
        name: "report",
        seeds: &[],
        made: || vec![vec![0, 39], vec![1, 39]],
        longest: KB,
        run: recorded::report,
    },
    Target {
        name: "estimate",
        seeds: &[],
        made: || vec![vec![0, 255], vec![1, 255]],
        longest: KB,
        run: described::estimate,
    },
    Target {
        name: "http",
        seeds: &[],
        made: || vec![http::requests()],
        longest: 16 * KB,
        run: http::http,
    },
];

/// The target of this name.
///
/// # Errors
/// The name is unknown; the error lists the known ones.
pub fn target(name: &str) -> Result<&'static Target, String> {
    let known = || TARGETS.iter().map(|t| t.name).collect::<Vec<_>>();
    let found = TARGETS.iter().find(|t| t.name == name);
    found.ok_or_else(|| format!("no target {name}; known: {}", known().join(", ")))
}

impl Target {
    /// Initial inputs: files of the project's tests, earlier findings, and generated ones.
    #[must_use]
    pub fn corpus(&self) -> Vec<Vec<u8>> {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        let found = fs::read_dir(root.join("tests/fuzz").join(self.name));
        let found = found.into_iter().flatten().flatten().map(|e| e.path());
        let named = self.seeds.iter().map(|file| {
            let file = root.join(file);
            assert!(file.exists(), "{} is no file to begin with", file.display());
            file
        });
        let mut files: Vec<PathBuf> = named.chain(found).collect();
        files.sort();
        let read = |file: PathBuf| {
            let mut bytes = fs::read(file).ok()?;
            bytes.truncate(self.longest);
            Some(bytes)
        };
        let found = files.into_iter().filter_map(read);
        found.chain((self.made)()).collect()
    }
}

fn write(name: impl AsRef<Path>, bytes: &[u8]) {
    fs::write(name, bytes).expect("room for an input");
}
