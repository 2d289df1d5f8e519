//! Detects the kind of a file: by its first bytes, else by its name.

use std::io::Read;
use std::path::Path;

use crate::can::{self, Line, parse};
use crate::csv;
use crate::packed::GZIP;
use crate::wide;
use crate::{Error, file, parts};

/// Kind of a source of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A table with a header, plain or compressed by gzip.
    Table,
    /// Lines of candump, plain or compressed by gzip.
    Log,
    /// An MCAP file, of heft or foreign, or the folder of a run.
    Recording,
}

/// Endings of tables and CAN logs.
const TABLES: [&str; 5] = ["csv", "txt", "tsv", "tab", "dat"];
const LOG: &str = "log";
const RECORDING: &str = "mcap";
const PACKED: &str = "gz";

/// First bytes of an MCAP file.
pub(crate) const MCAP: &[u8] = b"\x89MCAP";

macro_rules! rows {
    ($( $begin:expr, $what:expr, $remedy:expr; )*) => { [$( ($begin, $what, $remedy) ),*] };
}

/// The command of Python that writes a table as CSV, by what reads it and the packages that this needs.
macro_rules! frame {
    ($read:literal, $packages:literal) => {
        concat!(
            "write it as CSV: python3 -c \"",
            $read,
            ".to_csv('NEW.csv')\" (pip install ",
            $packages,
            "), or give that frame to heft.estimate"
        )
    };
}

/// Foreign formats: first bytes, name, and how to convert them to a table.
const FOREIGN: [(&[u8], &str, &str); 49] = rows! {
    b"PK", "a spreadsheet or a zip archive", "save the sheet as CSV, or unpack the archive";
    b"\xd0\xcf\x11\xe0", "a spreadsheet of old Excel", "save the sheet as CSV";
    b"PAR1", "a Parquet file", PARQUET;
    b"ARROW1", "an Arrow file", FEATHER;
    b"\xff\xff\xff\xff", "a stream of Arrow", STREAM;
    b"FEA1", "a Feather file", FEATHER;
    b"ORC", "an ORC file", ORC;
    b"Obj\x01", "an Avro file", PYTHON;
    b"\x93NUMPY", "an array of NumPy", PYTHON;
    b"\x80\x04\x95", "a pickle of Python", PYTHON;
    b"\x80\x05\x95", "a pickle of Python", PYTHON;
    HDF, "an HDF5 file, as MATLAB 7.3 writes", PYTHON;
    MATLAB, "a MATLAB file", "write a table: writetable(T, 'data.csv')";
    b"TDSh", "the index of a TDMS file of LabVIEW", "export the file itself (.tdms) as CSV";
    b"CDF\x01", "a netCDF file", PYTHON;
    b"CDF\x02", "a netCDF file", PYTHON;
    b"TDSm", "a TDMS file of LabVIEW", EXPORT;
    b"ULog", "a log of PX4 (ULog)", EXPORT;
    b"MDF ", "an MDF file",
        "frames: `can_logconvert FILE OUT.log` (pip install \"python-can[mf4]\"); channels: `python3 -c \"import asammdf; asammdf.MDF('FILE').to_dataframe(raster=0.01).to_csv('NEW.csv')\"` (pip install asammdf)";
    b"UnFinMF", "an MDF file that was not finished", EXPORT;
    b"LOGG", "a CAN log of Vector (BLF)", CAN;
    DATE, "a CAN log of Vector (ASC)", CAN;
    b"base hex", "a CAN log of Vector (ASC)", CAN;
    b"base dec", "a CAN log of Vector (ASC)", CAN;
    b";$FILEVERSION", "a CAN trace of PEAK (TRC)", CAN;
    b"Chn Identifier", "a CAN log of Kvaser (CanKing)", ASC;
    b"\xd4\xc3\xb2\xa1", CAPTURE, RECORD;
    b"\x4d\x3c\xb2\xa1", CAPTURE, RECORD;
    b"\n\r\r\n", CAPTURE, RECORD;
    b"***BUSMASTER", "a CAN log of BUSMASTER", ASC;
    b"VERSION \"", "a DBC file", "give the log that it describes, and the DBC beside it: `heft map LOG --dbc FILE`";
    b"#ROSBAG", "a bag of ROS 1", BAG;
    b"rosbag2_bagfile", "the contents of a bag of ROS 2",
        "give the .mcap file beside it; a bag of .db3 files, or a packed one, becomes one by `rosbags-convert --src BAG --dst NEW --dst-storage mcap` (pip install rosbags)";
    b"SQLite", "a database (SQLite)",
        "a bag of ROS 2: `rosbags-convert --src FOLDER --dst NEW --dst-storage mcap` (pip install rosbags); another: `sqlite3 -header -csv FILE 'select * from TABLE' > NEW.csv`";
    b"version https://git-lfs", "the name of a file in Git LFS, not the file", "fetch it: git lfs pull";
    b"%PDF", "a PDF", EXPORT;
    b"{\\rtf", "a text of a word processor", EXPORT;
    b"<!DOCTYPE", PAGE, DOWNLOAD;
    b"<!doctype", PAGE, DOWNLOAD;
    b"<html", PAGE, DOWNLOAD;
    b"<?xml", "XML", EXPORT;
    ZSTD, "packed by zstd", "unpack it: zstd -d FILE";
    b"\x04\x22\x4d\x18", "packed by lz4", "unpack it: lz4 -d FILE";
    b"\xff\xfe\0\0", FOUR, TO_UTF8;
    b"\0\0\xfe\xff", FOUR, TO_UTF8;
    b"BZh", "packed by bzip2", "unpack it: bunzip2 -k FILE";
    b"\xfd7zXZ", "packed by xz", "unpack it: unxz -k FILE";
    b"7z\xbc\xaf", "packed by 7-Zip", "unpack it: 7z x FILE";
    b"Rar!", "packed by RAR", "unpack it: unrar x FILE";
};
/// First bytes of binary formats that may also begin the names of a table: `PAR1,PAR2`, `LOGGER 7`.
const LETTERS: [&[u8]; 6] = [b"PK", b"PAR1", b"FEA1", b"ORC", b"ULog", b"LOGG"];
/// First bytes of zstd.
pub(crate) const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";
const MATLAB: &[u8] = b"MATLAB";
const DATE: &[u8] = b"date ";
const HDF: &[u8] = b"\x89HDF";
const BAG: &str = "convert a bag to MCAP: `rosbags-convert --src BAG --dst NEW --dst-storage mcap` (pip install rosbags; BAG is the file of ROS 1, the folder of ROS 2)";
const CAPTURE: &str = "a capture of Wireshark or tcpdump (pcap)";
const RECORD: &str = "record the bus with candump -L, and give that log";
const PAGE: &str = "a page, perhaps of a login";
const FOUR: &str = "text in four bytes a character (UTF-32)";
const TO_UTF8: &str = "convert it: iconv -f UTF-32 -t UTF-8 FILE > NEW";
const DOWNLOAD: &str = "download the file itself";
const EXPORT: &str = "export it as CSV with the tool that wrote it";
const PYTHON: &str = "read it in Python and give the table to heft.estimate, or write it as CSV";
const PARQUET: &str = frame!(
    "import pandas; pandas.read_parquet('FILE')",
    "pandas pyarrow"
);
const FEATHER: &str = frame!(
    "import pandas; pandas.read_feather('FILE')",
    "pandas pyarrow"
);
const ORC: &str = frame!("import pandas; pandas.read_orc('FILE')", "pandas pyarrow");
const STREAM: &str = frame!(
    "import pyarrow as p; p.ipc.open_stream('FILE').read_pandas()",
    "pandas pyarrow"
);
const LINES: &str = frame!(
    "import pandas; pandas.read_json('FILE', lines=True)",
    "pandas"
);
const JSON: &str = frame!("import pandas; pandas.read_json('FILE')", "pandas");
const SHEET: &str = "open it in a spreadsheet, and save the sheet as CSV";
const ASC: &str =
    "export it as ASC, then `can_logconvert FILE.asc OUT.log` (pip install python-can)";
const CAN: &str =
    "convert it to a log of candump: `can_logconvert FILE OUT.log` (pip install python-can)";

impl Kind {
    /// The kind by the name; none if the name does not decide.
    pub fn by_name(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return Some(Self::Recording);
        }
        Self::by_ending(path)
    }

    /// Whether the name is that of a recording.
    pub fn is_recording(path: &Path) -> bool {
        Self::by_name(path) == Some(Self::Recording)
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

    /// The kind by the first bytes, else by the name, else a table if it is text.
    ///
    /// # Errors
    /// It cannot be read, or it has a format that heft does not read; the error states how to convert it.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let named = Self::by_name(path);
        if path.is_dir() || !path.exists() && parts::exists(path) {
            return Ok(Self::Recording);
        }
        let head = begin_of(path).map_err(|e| Error::system("read the data", path, &e))?;
        if head.starts_with(MCAP) {
            return Ok(Self::Recording);
        }
        if !head.is_empty() && head.iter().all(|b| *b == 0) {
            return Err(Error::new(
                "the file holds bytes of zero instead of data",
                path.display().to_string(),
                "take another copy of it, if there is one: its writer reserved the room and wrote nothing, or the disk lost it",
            ));
        }
        if named == Some(Self::Recording) {
            return Ok(Self::Recording);
        }
        let place = || path.display().to_string();
        if let Some(error) = of_others(&head, path) {
            return Err(error);
        }
        if head.starts_with(&GZIP) {
            return Ok(named.unwrap_or(Self::Table));
        }
        let head = wide::head(head);
        if is_no_text(&head) {
            let text: Vec<u8> = head.iter().copied().filter(|b| *b != 0).collect();
            return Err(match is_no_text(&text) {
                true => no_text(place()),
                false => Error::new("bytes of zero stand among the text", place(), csv::ZEROS),
            });
        }
        let text = head.trim_ascii_start();
        if text.starts_with(b"{") || text.starts_with(b"[{") {
            return Err(Error::new(
                "this is JSON, which heft does not read",
                place(),
                if has_objects_by_line(text) {
                    LINES
                } else {
                    JSON
                },
            ));
        }
        if path.extension().is_some_and(|ending| ending == "toml") {
            return Err(Error::new(
                "this is TOML: a signal map or a machine file, and no data",
                place(),
                "name the data here, a signal map by --map, a machine file by --config",
            ));
        }
        if is_of_pairs(behind_comments(text)) {
            return Err(Error::new(
                "each row names its values (key=value), as InfluxDB's line protocol does, which heft does not read",
                place(),
                "write a table with the names once, above the values (InfluxDB: a query to CSV)",
            ));
        }
        Ok(of_text(text, named))
    }
}

/// The error for a folder without data: the first file by name that has a known foreign format.
#[must_use]
pub fn foreign(folder: &Path) -> Option<Error> {
    let files = folder.read_dir().ok()?.flatten().map(|entry| entry.path());
    let mut files: Vec<_> = files.filter(|file| file.is_file()).collect();
    files.sort();
    files
        .iter()
        .find_map(|file| of_others(&begin_of(file).ok()?, file))
}

/// The first bytes of a file.
fn begin_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut head = Vec::new();
    file::open(path)?.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}

/// The remedy for a tar archive, which is recognized by the bytes behind the name of its first file.
pub(crate) fn of_tar(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let is_tar = head.get(257..262) == Some(b"ustar");
    is_tar.then_some(("a tar archive", "unpack it: tar -xf FILE"))
}

/// The error for a foreign format, by its first bytes. Files of MATLAB 4 are recognized by their name only.
fn of_others(head: &[u8], path: &Path) -> Option<Error> {
    let begin = behind_comments(head);
    let is_matlab = path.extension().is_some_and(|ending| ending == "mat");
    let is_foreign = |(magic, ..): &&(&[u8], _, _)| {
        let is_so = head.starts_with(magic) || begin.starts_with(magic);
        // A table may also begin with a date, or with a name of these letters.
        let is_name =
            *magic == DATE && is_parted(begin) || LETTERS.contains(magic) && is_plain(head);
        is_so && !is_name || is_matlab && *magic == MATLAB
    };
    let known = FOREIGN.iter().find(is_foreign);
    let row_of = |begin: &[u8]| FOREIGN.iter().find(|row| row.0 == begin);
    let known = known
        .or_else(|| row_of(HDF).filter(|_| is_hdf_behind(head)))
        .or_else(|| row_of(DATE).filter(|_| is_asc(begin)));
    let known = known.map(|(_, what, remedy)| match *what {
        PAGE if has_table(head) => ("a table in a page (HTML)", SHEET),
        what => (what, *remedy),
    });
    let (what, remedy) = known.or_else(|| of_tar(head))?;
    Some(Error::new(
        format!("this is {what}, which heft does not read as data"),
        path.display().to_string(),
        remedy,
    ))
}

/// Whether the bytes are text with separators and without control characters.
fn is_plain(head: &[u8]) -> bool {
    let is_strange = |b: &u8| b.is_ascii_control() && !b.is_ascii_whitespace();
    let is_text = std::str::from_utf8(head).is_ok() && !head.iter().any(is_strange);
    is_text && head.iter().any(|b| b",;\t|".contains(b))
}

/// Whether a page holds a table, as programs write for a sheet (.xls).
fn has_table(page: &[u8]) -> bool {
    const TABLE: &[u8] = b"<table";
    page.windows(TABLE.len())
        .any(|part| part.eq_ignore_ascii_case(TABLE))
}

/// Whether each line of JSON is an object (JSON lines).
fn has_objects_by_line(text: &[u8]) -> bool {
    let mut lines = text.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let is_object = |line: Option<&[u8]>| line.is_some_and(|line| line.starts_with(b"{\""));
    lines
        .next()
        .is_some_and(|line| is_object(Some(line)) && line.ends_with(b"}"))
        && is_object(lines.next())
}

/// Formats of [`FOREIGN`] that hold no samples.
const NO_DATA: [&[u8]; 8] = [
    b"VERSION \"",
    b"rosbag2_bagfile",
    b"%PDF",
    b"{\\rtf",
    b"<!DOCTYPE",
    b"<!doctype",
    b"<html",
    b"<?xml",
];

/// What a file is that may hold samples in a format that heft does not read, by its first bytes.
#[must_use]
pub fn unread(path: &Path) -> Option<&'static str> {
    let head = begin_of(path).ok()?;
    let is_text = is_plain(&head);
    let mut rows = FOREIGN
        .iter()
        .filter(|(magic, ..)| !(is_text && LETTERS.contains(magic)));
    let row = rows.find(|(magic, ..)| head.starts_with(magic));
    let known = row.filter(|(magic, ..)| !NO_DATA.contains(magic));
    known.map(|(_, what, _)| *what)
}

/// Whether the text is of frames as Vector writes them, without the header above them: `0.0104 1 18FF0100x Rx d 8 01 02 ...`.
fn is_asc(text: &[u8]) -> bool {
    let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
    let line = String::from_utf8_lossy(line);
    let words: Vec<&str> = line.split_whitespace().take(6).collect();
    let [time, channel, id, way, kind, length] = words[..] else {
        return false;
    };
    let is_hex = id
        .trim_end_matches('x')
        .chars()
        .all(|c| c.is_ascii_hexdigit());
    time.parse::<f64>().is_ok()
        && channel.parse::<u8>().is_ok()
        && is_hex
        && matches!(way, "Rx" | "Tx")
        && matches!(kind, "d" | "r")
        && length.parse::<u8>().is_ok()
}

/// Whether an HDF5 file begins behind a block of its user, at a power of two from 512.
fn is_hdf_behind(head: &[u8]) -> bool {
    let at = |place: usize| head.get(place..).is_some_and(|rest| rest.starts_with(HDF));
    [512, 1024, 2048].into_iter().any(at)
}

/// Whether most parts of the first line are pairs of a name and its value.
fn is_of_pairs(text: &[u8]) -> bool {
    let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
    let parts = line
        .split(|b| b", \t;".contains(b))
        .filter(|part| !part.is_empty());
    let is_pair = |part: &&[u8]| {
        let at = part.iter().position(|b| *b == b'=');
        at.is_some_and(|at| at > 0 && part[at + 1..].iter().any(u8::is_ascii_digit))
    };
    let (all, pairs) = (parts.clone().count(), parts.filter(is_pair).count());
    pairs > 2 && 2 * pairs > all
}

/// The error for a log without a map: frames do not describe themselves.
pub(crate) fn no_map(place: &str) -> Error {
    Error::new(
        "a CAN log needs a signal map",
        place,
        "give one with --map; it names the DBC file and the signals",
    )
}

/// The error for a program, a picture or the like.
pub(crate) fn no_text(place: impl Into<String>) -> Error {
    Error::new(
        "this is no text, and of no kind that heft knows by its first bytes",
        place,
        "give a table (.csv), a CAN log (.log) or an MCAP file (.mcap)",
    )
}

/// Whether these bytes are a program, a picture or the like. Trailing zeros are ignored: a file may be padded with them.
pub(crate) fn is_no_text(head: &[u8]) -> bool {
    let filled = head.iter().rev().take_while(|b| **b == 0).count();
    let text = &head[..head.len() - filled];
    // Escape sequences of terminal colours are text.
    let is_strange = |b: &&u8| b.is_ascii_control() && !b.is_ascii_whitespace() && **b != 0x1b;
    STRANGE * text.iter().filter(is_strange).count() > text.len()
}

/// Bytes per control character below which a file is no text; a strange name contains one.
const STRANGE: usize = 20;

/// A text after leading blanks and comments (`//`).
fn behind_comments(text: &[u8]) -> &[u8] {
    let text = text.trim_ascii_start();
    match text.iter().position(|b| *b == b'\n') {
        Some(end) if text.starts_with(b"//") => behind_comments(&text[end..]),
        _ => text,
    }
}

/// Whether the first line has separators.
fn is_parted(text: &[u8]) -> bool {
    let mut line = text.iter().take_while(|b| **b != b'\n');
    line.any(|b| b",;\t|".contains(b))
}

/// Table or log, by the lines: a frame means a log; separators without a frame mean a table.
fn of_text(text: &[u8], named: Option<Kind>) -> Kind {
    let is_frame = |line: &[u8]| matches!(parse(&can::text(line)), Some(Line::Frame { .. }));
    match named {
        _ if text.split(|b| *b == b'\n').any(is_frame) => Kind::Log,
        Some(Kind::Log) if !is_parted(text) && !csv::is_by_blanks(text) => Kind::Log,
        _ => Kind::Table,
    }
}

/// Number of bytes that are read [bytes].
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
        for names in ["PAR1,PAR2", "LOGGER 7\nt,a", "PKT,t", "ORC,t"] {
            let text = format!("{names}\n0,1\n");
            assert_eq!(of("a.csv", text.as_bytes()).ok(), Some(Kind::Table));
        }
        assert_eq!(of("a.csv.gz", &GZIP).ok(), Some(Kind::Table));
        assert_eq!(of("a.log", b"t,speed\n0,1\n").ok(), Some(Kind::Table));
        assert_eq!(of("a.log", b"t speed\n0 1\n").ok(), Some(Kind::Table));
        assert_eq!(of("a.log", b"no frame\nno table\n").ok(), Some(Kind::Log));
        assert_eq!(of("a.csv", b"date time;speed\n").ok(), Some(Kind::Table));
        assert_eq!(of("a", b"t\n\0\0\0\0\0\0").ok(), Some(Kind::Table));
        assert_eq!(of("a", b"\xff\xfet\0;\0a\0\n\0").ok(), Some(Kind::Table));
    }

    #[test]
    fn a_log_and_a_recording_are_known_without_their_endings() {
        let frame = b"(1700000000.000000) can0 123#0011223344556677\n";
        assert_eq!(of("trace", frame).ok(), Some(Kind::Log));
        assert_eq!(of("a.log", frame).ok(), Some(Kind::Log));
        assert_eq!(
            of("a.txt", &[b"# day 1\n", &frame[..]].concat()).ok(),
            Some(Kind::Log)
        );
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
            (b"PAR1\0", "Parquet", "read_parquet"),
            (
                b"\xff\xff\xff\xff\x08\x03",
                "stream of Arrow",
                "open_stream",
            ),
            (b"SQLite format 3\0", "SQLite", "sqlite3 -header"),
            (b"<html><TABLE><tr>", "a table in a page", "save the sheet"),
            (b"{\"t\":0,\"a\":1}\n{\"t\":1}\n", "JSON", "lines=True"),
            (b"MDF     4.10", "MDF", "can_logconvert"),
            (b"LOGG\x90", "Vector", "can_logconvert"),
            (
                b"// version 9\nbase hex  timestamps absolute\n",
                "Vector",
                "can_logconvert",
            ),
            (b"date Sam Sep 30\n", "Vector", "can_logconvert"),
            (
                b"0.01 1  18FF0100x Rx d 8 01 02\n",
                "Vector",
                "can_logconvert",
            ),
            (&[&[0; 512][..], b"\x89HDF\r\n"].concat(), "HDF5", "Python"),
            (b"VERSION \"\"\n\nNS_ :\n", "DBC", "--dbc"),
            (
                b"Chn Identifier Flg   DLC  D0\n",
                "Kvaser",
                "can_logconvert",
            ),
            (b"\n<html>", "a page", "download"),
            (b"<!doctype html>\n", "a page", "download"),
            (b"\xff\xfe\0\0t\0\0\0", "UTF-32", "iconv"),
            (b"{\"t\": 0}", "JSON", "CSV"),
            (b"\xd4\xc3\xb2\xa1\x02\0\x04\0", "Wireshark", "candump -L"),
            (b"\n\r\r\n\x1c\0\0\0", "Wireshark", "candump -L"),
            (b"ex,m=e1 a=1,b=2.5,c=-3 178\n", "key=value", "CSV"),
            (b"time=0.1 speed=2 slope=0.01\n", "key=value", "CSV"),
        ] {
            let error = of("a.csv", content).expect_err("not read").to_string();
            assert!(error.contains(what) && error.contains(remedy), "{error}");
        }
        let error = of("a.toml", b"[columns]\n").expect_err("a map");
        assert!(error.to_string().contains("--map"), "{error}");
        let error = of("a", b"\x7fELF\0\0").expect_err("a program").to_string();
        assert!(error.contains("no text"), "{error}");
    }
}
