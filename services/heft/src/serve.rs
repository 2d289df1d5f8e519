//! Estimates of many machines in few processes. A column of the table names the machine of each row, and the hash of this name
//! selects a shard: one process per core by default. A shard that dies is replaced by one that receives its last state
//! and every sample since. The estimates equal those of a run without a death, bit for bit.

mod frames;
mod play;
mod records;
mod remote;
mod rows;
mod shard;
mod suspects;
mod until_signal;

use std::collections::{BTreeMap, HashMap};
use std::ffi::OsString;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufRead, BufReader, Read};
use std::sync::Arc;
use std::time::Instant;

use checks::Look;
use config::Description;
use messages::Message as _;
use recording::{LineDecoder, MAX_LINE, Map, NameColumn, NamedLine};

pub use self::play::{Machines, Played, play};
use self::records::Records;
use self::remote::{RemoteShard, Served};
pub use self::rows::{Form, Out, Rows, is_table};
pub use self::shard::serve as serve_shard;
pub use self::suspects::{Findings, Suspects};
pub use self::until_signal::UntilSignal;
use crate::doubts::most_rows_were_taken;
use crate::failure::Failure;
use crate::fault::counted;

/// Name of the column with the machine of a row.
pub const NAME: &str = "machine";
/// Largest number of machines of one router. A column that holds no machine names exceeds it.
pub const MOST_MACHINES: usize = 100_000;
/// Message on further machines: they are left out, so that invented names do not end the estimates of the others.
const TOO_MANY: &str = "is of a machine beyond the first 100 000";
/// Largest number of machines named in one message on a common lack.
const MOST_NAMED: usize = 10;
/// Longest name \[bytes\].
const LONGEST_NAME: usize = 200;

/// A stream of samples, and its name in messages.
pub struct Input {
    /// Its name, such as that of a file.
    pub name: Arc<str>,
    /// The stream.
    pub content: Box<dyn Read>,
}

/// Starts the shards, calls `feed`, and waits until the shards have answered all samples.
fn with_shards<T>(
    count: usize,
    arguments: &[OsString],
    rows: &Rows,
    feed: impl FnOnce(&[RemoteShard]) -> Result<T, Failure>,
) -> Result<(T, Served), Failure> {
    let shards = (0..count).map(|_| RemoteShard::start(arguments, rows));
    let shards = shards.collect::<Result<Vec<_>, _>>()?;
    let fed = std::thread::scope(|scope| {
        shards.iter().for_each(|w| w.listen(scope));
        let fed = feed(&shards);
        shards.iter().for_each(RemoteShard::close);
        fed
    });
    if let Some(failure) = shards.iter().find_map(RemoteShard::failure) {
        return Err(failure);
    }
    let mut served = Served::default();
    shards.iter().for_each(|shard| shard.add_to(&mut served));
    Ok((fed?, served))
}

/// Settings that all machines share.
#[derive(Clone, Copy)]
pub struct Common<'a> {
    /// Description of each machine.
    pub description: &'a Description,
    /// Signal map of the input.
    pub map: Option<&'a Map>,
    /// Number of shards.
    pub shards: usize,
    /// Arguments of the shard processes.
    pub arguments: &'a [OsString],
}

/// Reads the samples of many machines from `input` and writes their estimates as `rows`.
pub fn route<L: Look>(
    input: Input,
    form: Form,
    common: Common<'_>,
    rows: Rows,
) -> Result<(), Failure> {
    let began = Instant::now();
    let name = Arc::clone(&input.name);
    let mut suspects = Suspects::<L>::new(common.description, common.map);
    let Common {
        shards, arguments, ..
    } = common;
    let ((samples, left_out), served) =
        with_shards(shards, arguments, &rows, |shards| match form {
            Form::Table => Router::new(&input.name, common.map, shards, &rows, &mut suspects)
                .take_all(input.content),
            Form::Messages => {
                Records::new(&input.name, shards, &rows, &mut suspects).take_all(input.content)
            }
        })?;
    // A name of which every line was left out is not counted as a machine.
    let members = rows.finish()?;
    let machines = members.values().filter(|member| member.rows > 0).count();
    let machines = counted(machines as u64, "machine", "machines");
    let processes = counted(shards as u64, "process", "processes");
    let seconds = began.elapsed().as_secs_f64();
    let parts = match form {
        Form::Table => "lines",
        Form::Messages => "messages",
    };
    eprintln!(
        "{machines}, {} in {seconds:.1} s by {processes}; {left_out} {parts} left out, {} replaced",
        counted(samples, "sample", "samples"),
        counted(served.replaced.into(), "process", "processes")
    );
    if served.refused > 0 {
        eprintln!(
            "{} samples were refused: their time is missing or does not increase",
            served.refused
        );
    }
    if form == Form::Table && samples == 0 {
        return Err(Failure::input(
            "the input ended without a sample",
            name,
            format!(
                "give a table with the columns {NAME}, t and the signals, and a row per sample"
            ),
        ));
    }
    if left_out > samples {
        return Err(Failure::input(
            format!("{left_out} {parts} were left out, beside {samples} samples"),
            name,
            "see what was said of the first of them",
        ));
    }
    most_rows_were_taken(served.refused as usize, samples as usize)?;
    suspects.finish(&members).report()
}

/// Index of the shard of a machine, by the hash of its name.
fn shard_of(name: &str, shards: usize) -> usize {
    let mut hasher = DefaultHasher::new();
    name.hash(&mut hasher);
    (hasher.finish() % shards as u64) as usize
}

fn unreadable(input: &str, error: &std::io::Error) -> Failure {
    let what = format!("cannot read: {error}");
    Failure::input(what, input, "check what writes to it")
}

/// Message on rows below a header that differs from the first.
const OTHER_TABLE: &str = "belongs to another table, as its header has other columns, or in another order: give each its own heft serve";

/// Sends each row to the shard of its machine.
struct Router<'a, 'b, L: Look> {
    input: &'a Arc<str>,
    map: Option<&'a Map>,
    shards: &'a [RemoteShard<'a>],
    rows: &'a Rows,
    column: NameColumn,
    numbers: HashMap<String, usize>,
    decoders: Vec<Member<L>>,
    suspects: &'a mut Suspects<'b, L>,
    bytes: Vec<u8>,
    /// Number of lines read.
    lines: u64,
    /// Whether the current rows belong to a header with other columns.
    is_foreign: bool,
    samples: u64,
    refused: u64,
}

/// A machine: the decoder of its rows, and its shard.
struct Member<L: Look> {
    name: String,
    decoder: LineDecoder<L::Sensors>,
    shard: usize,
}

impl<'a, 'b, L: Look> Router<'a, 'b, L> {
    fn new(
        input: &'a Arc<str>,
        map: Option<&'a Map>,
        shards: &'a [RemoteShard<'a>],
        rows: &'a Rows,
        suspects: &'a mut Suspects<'b, L>,
    ) -> Self {
        Self {
            input,
            map,
            shards,
            rows,
            column: NameColumn::new(NAME, Arc::clone(input)),
            numbers: HashMap::new(),
            decoders: Vec::new(),
            suspects,
            bytes: Vec::new(),
            lines: 0,
            is_foreign: false,
            samples: 0,
            refused: 0,
        }
    }

    /// Reads the whole input. Returns the number of samples and of lines that were left out.
    fn take_all(mut self, input: impl Read) -> Result<(u64, u64), Failure> {
        let mut input = BufReader::with_capacity(1 << 16, input);
        let mut line = Vec::new();
        loop {
            if !input.buffer().contains(&b'\n') {
                // The next read may block: first send what is buffered.
                self.shards.iter().for_each(RemoteShard::flush);
                if let Some(failure) = self.shards.iter().find_map(RemoteShard::failure) {
                    return Err(failure);
                }
            }
            line.clear();
            let most = MAX_LINE as u64 + 1;
            let read = (&mut input).take(most).read_until(b'\n', &mut line);
            if read.map_err(|e| unreadable(self.input, &e))? == 0 {
                break;
            }
            self.lines += 1;
            if line.len() > MAX_LINE && !self.column.is_found() {
                return Err(Failure::input(
                    format!(
                        "line {} has more than {MAX_LINE} bytes: this is no table",
                        self.lines
                    ),
                    self.input,
                    format!("give a table with the columns {NAME}, t and the signals"),
                ));
            }
            if line.len() > MAX_LINE {
                let skipped = input.skip_until(b'\n');
                skipped.map_err(|e| unreadable(self.input, &e))?;
                self.refuse("is too long");
                continue;
            }
            self.take(line.trim_ascii_end())?;
        }
        if !self.column.is_found() {
            return Err(Failure::input(
                "the input ended without a header",
                self.input,
                format!("give a table with the columns {NAME}, t and the signals"),
            ));
        }
        for number in 0..self.decoders.len() {
            self.decoders[number].decoder.finish();
            self.send(number);
            self.refused += self.decoders[number].decoder.refused();
        }
        self.tell_empty();
        Ok((self.samples, self.refused))
    }

    /// Reports the columns without a value in any row of a machine.
    fn tell_empty(&self) {
        let mut machines: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for (name, number) in &self.numbers {
            for words in self.decoders[*number].decoder.empty() {
                machines.entry(words).or_default().push(name);
            }
        }
        for (words, mut names) in machines {
            names.sort_unstable();
            let (all, first) = (names.len(), names.len().min(MOST_NAMED));
            let more = match all - first {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            eprintln!("{words}: machine {}{more}", names[..first].join(", "));
        }
    }

    fn take(&mut self, line: &[u8]) -> Result<(), Failure> {
        if line.trim_ascii().is_empty() {
            return Ok(());
        }
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        let name = match self.column.take(line)? {
            NamedLine::Row(_) if self.is_foreign => {
                self.refuse(OTHER_TABLE);
                return Ok(());
            }
            NamedLine::Row(name) => name,
            NamedLine::Header(is_same) => {
                self.is_foreign = !is_same;
                self.refuse(if is_same {
                    "is the header once more"
                } else {
                    OTHER_TABLE
                });
                return Ok(());
            }
            NamedLine::Above => {
                if self.column.is_found() {
                    // Missing columns are reported at the header, not at the first row.
                    self.decoder()?;
                }
                return Ok(());
            }
        };
        let Some(name) = name.filter(|n| n.len() <= LONGEST_NAME) else {
            self.refuse(
                "names no machine, or by more than 200 bytes, a quote or a control character",
            );
            return Ok(());
        };
        let number = match self.numbers.get(&name) {
            Some(number) => *number,
            None if self.decoders.len() >= MOST_MACHINES => {
                self.refuse(TOO_MANY);
                return Ok(());
            }
            None => self.add(name)?,
        };
        let decoder = &mut self.decoders[number].decoder;
        decoder.skip_to(self.lines - 1);
        decoder.take(line, 0)?;
        self.send(number);
        Ok(())
    }

    fn decoder(&self) -> Result<LineDecoder<L::Sensors>, Failure> {
        let mut decoder = LineDecoder::new(self.map.cloned())?.of(Arc::clone(self.input));
        for line in self.column.above() {
            decoder.take(line, 0)?;
        }
        decoder.check_header()?;
        Ok(decoder)
    }

    /// Adds a machine and returns its number.
    fn add(&mut self, name: String) -> Result<usize, Failure> {
        let number = self.decoders.len();
        let shard = shard_of(&name, self.shards.len());
        self.decoders.push(Member {
            name: name.clone(),
            decoder: self.decoder()?,
            shard,
        });
        self.rows.add(&name);
        self.numbers.insert(name, number);
        Ok(number)
    }

    /// Sends the samples that the decoder of a machine has completed.
    fn send(&mut self, number: usize) {
        let Member {
            name,
            decoder,
            shard,
        } = &mut self.decoders[number];
        while let Some((mut sample, _)) = decoder.row() {
            self.suspects.see(number as u32, name, &sample);
            sample.stamp_mut().machine = number as u32;
            frames::pack(&sample, &mut self.bytes);
            self.samples += 1;
            self.shards[*shard].send(number as u32, &self.bytes);
        }
        for remark in decoder.take_remarks() {
            tracing::warn!("{remark}");
        }
    }

    fn refuse(&mut self, why: &str) {
        self.refused += 1;
        if self.refused <= 5 {
            tracing::warn!("line {} of {} {why}; left out", self.lines, self.input);
        }
    }
}
