//! What kind of file it is: by its first bytes, else by its name.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::Error;
use crate::can::parse;
use crate::packed::GZIP;

/// What samples are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A table with a header, as it is or packed by gzip.
    Table,
    /// Lines of candump, as they are or packed by gzip.
    Log,
    /// An MCAP file, of heft or of others, or the folder of a run.
    Recording,
}

/// Endings of tables and CAN logs.
const TABLES: [&str; 5] = ["csv", "txt", "tsv", "tab", "dat"];
const LOG: &str = "log";
const RECORDING: &str = "mcap";
const PACKED: &str = "gz";

/// First bytes of an MCAP file.
const MCAP: &[u8] = b"\x89MCAP";
/// Byte order marks of text in two bytes a character.
const WIDE: [&[u8]; 2] = [b"\xff\xfe", b"\xfe\xff"];

/// First bytes of what others write, what it is, and how it becomes a table.
const FOREIGN: [(&[u8], &str, &str); 15] = [
    (
        b"PK",
        "a spreadsheet or a zip archive",
        "save the sheet as CSV, or unpack the archive",
    ),
    (
        b"\xd0\xcf\x11\xe0",
        "a spreadsheet of old Excel",
        "save the sheet as CSV",
    ),
    (b"PAR1", "a Parquet file", PYTHON),
    (b"ARROW1", "an Arrow file", PYTHON),
    (b"\x89HDF", "an HDF5 file, as MATLAB 7.3 writes", PYTHON),
    (
        b"MATLAB",
        "a MATLAB file",
        "write a table: writetable(T, 'data.csv')",
    ),
    (
        b"MDF ",
        "an MDF file",
        "frames: `can_logconvert FILE OUT.log` (pip install \"python-can[mf4]\"); channels: export them as CSV",
    ),
    (
        b"UnFinMF",
        "an MDF file that was not finished",
        "export it as CSV with the tool that wrote it",
    ),
    (b"LOGG", "a CAN log of Vector (BLF)", CAN),
    (b"date ", "a CAN log of Vector (ASC)", CAN),
    (
        b"#ROSBAG",
        "a bag of ROS 1",
        "convert it to MCAP: mcap convert FILE.bag FILE.mcap",
    ),
    (
        b"SQLite",
        "a database, perhaps a bag of ROS 2",
        "convert a bag to MCAP: ros2 bag convert",
    ),
    (
        b"\x28\xb5\x2f\xfd",
        "packed by zstd",
        "unpack it: zstd -d FILE",
    ),
    (b"BZh", "packed by bzip2", "unpack it: bunzip2 -k FILE"),
    (b"\xfd7zXZ", "packed by xz", "unpack it: unxz -k FILE"),
];
const PYTHON: &str = "read it in Python and give the table to heft.estimate, or write it as CSV";
const CAN: &str =
    "convert it to a log of candump: `can_logconvert FILE OUT.log` (pip install python-can)";

impl Kind {
    /// What a name says; nothing where it says nothing.
    #[must_use]
    pub fn by_name(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return Some(Self::Recording);
        }
        Self::by_ending(path)
    }

    fn by_ending(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        match ending.as_str() {
            LOG => Some(Self::Log),
            RECORDING => Some(Self::Recording),
            PACKED => {
                Self::by_ending(Path::new(path.file_stem()?)).filter(|k| *k != Self::Recording)
            }
            other => TABLES.contains(&other).then_some(Self::Table),
        }
    }

    /// What a file is: by its first bytes, else by its name, else a table if it is text.
    ///
    /// # Errors
    /// It cannot be read, or it is a kind that heft does not read; the error says how to convert it.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let named = Self::by_name(path);
        if path.is_dir() {
            return Ok(Self::Recording);
        }
        if std::fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            return Err(Error::new(
                "this is a pipe or a device, and heft reads a file more than once",
                path.display().to_string(),
                "write it to a file (a packed .csv.gz is read as it is); `heft serve` and `heft run --input -` read pipes",
            ));
        }
        let mut head = Vec::new();
        let begin = File::open(path).and_then(|f| f.take(HEAD).read_to_end(&mut head));
        begin.map_err(|e| Error::system("read the data", path, &e))?;
        if head.starts_with(MCAP) {
            return Ok(Self::Recording);
        }
        if named == Some(Self::Recording) {
            return Ok(Self::Recording);
        }
        let place = || path.display().to_string();
        let text = head.trim_ascii_start();
        if let Some((_, what, remedy)) = FOREIGN.iter().find(|(magic, ..)| head.starts_with(magic))
        {
            return Err(Error::new(
                format!("this is {what}, which heft does not read"),
                place(),
                *remedy,
            ));
        }
        if named == Some(Self::Log) {
            return Ok(Self::Log);
        }
        if text.starts_with(b"{") || text.starts_with(b"[{") {
            return Err(Error::new(
                "this is JSON, which heft does not read",
                place(),
                PYTHON,
            ));
        }
        if named.is_some() || head.starts_with(&GZIP) {
            return Ok(Self::Table);
        }
        let is_wide = WIDE.iter().any(|mark| head.starts_with(mark));
        if head.contains(&0) && !is_wide {
            return Err(Error::new(
                "the kind of file is not known from its name or its first bytes",
                place(),
                "give a table (.csv), a CAN log (.log) or an MCAP file (.mcap)",
            ));
        }
        let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
        match parse(&String::from_utf8_lossy(line)) {
            Some(_) if !line.is_empty() => Ok(Self::Log),
            _ => Ok(Self::Table),
        }
    }
}

/// So much of a file is looked at [bytes].
const HEAD: u64 = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, content: &[u8]) -> Result<Kind, Error> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("written");
        Kind::of(&path)
    }

    #[test]
    fn a_table_is_known_by_what_is_in_it_whatever_its_name() {
        for name in ["a.csv", "a.TSV", "a.dat", "a", "a.export", "2026.05.01"] {
            assert_eq!(
                of(name, b"t,speed\n0,1\n").ok(),
                Some(Kind::Table),
                "{name}"
            );
        }
        assert_eq!(of("a.csv.gz", &GZIP).ok(), Some(Kind::Table));
        assert_eq!(of("a", b"\xff\xfet\0;\0a\0\n\0").ok(), Some(Kind::Table));
    }

    #[test]
    fn a_log_and_a_recording_are_known_without_their_endings() {
        let frame = b"(1700000000.000000) can0 123#0011223344556677\n";
        assert_eq!(of("trace", frame).ok(), Some(Kind::Log));
        assert_eq!(of("a.log", frame).ok(), Some(Kind::Log));
        assert_eq!(of("a.log.gz", &GZIP).ok(), Some(Kind::Log));
        let named_so = of("a.log", b"LOGG\x90\0").expect_err("BLF");
        assert!(named_so.what.contains("BLF"), "{named_so}");
        assert_eq!(of("run.csv", b"\x89MCAP0\r\n").ok(), Some(Kind::Recording));
    }

    #[test]
    fn a_pipe_is_refused_and_not_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.csv");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.is_ok_and(|status| status.success()));
        let error = Kind::of(&path).expect_err("a pipe").to_string();
        assert!(
            error.contains("pipe") && error.contains("heft serve"),
            "{error}"
        );
    }

    #[test]
    fn what_heft_does_not_read_is_named_with_the_way_to_convert_it() {
        for (content, what, remedy) in [
            (&b"PK\x03\x04"[..], "spreadsheet", "save the sheet as CSV"),
            (b"PAR1\0", "Parquet", "Python"),
            (b"MDF     4.10", "MDF", "can_logconvert"),
            (b"LOGG\x90", "Vector", "can_logconvert"),
            (b"{\"t\": 0}", "JSON", "CSV"),
        ] {
            let error = of("a.csv", content).expect_err("not read").to_string();
            assert!(error.contains(what) && error.contains(remedy), "{error}");
        }
        let error = of("a", b"\x7fELF\0\0").expect_err("a program").to_string();
        assert!(error.contains("not known"), "{error}");
    }
}
