//! Window: view of a run for a group of other users, with its latest messages in one file that only the supervisor writes.
//!
//! A reader of an iceoryx2 channel also writes: it takes a place in the channel's tables, creates the
//! memory of its connection, and returns what it has read. A user who may read there may therefore also stop a run. So that
//! memory stays closed, and only this window is open. It is written and read by system calls: no process waits
//! for another, and readers have no effect on the run.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 255 | `heft window 1 MACHINE LAYOUT` and a line feed; `LAYOUT` distinguishes versions of the messages |
//! | 8 per channel | number of messages so far |
//! | per channel, [`Channel::depth`] places | 8 bytes each: number of this message, from 1; its fields; a checksum |

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};

use messages::channels::{CREDIT, Channel, KEYFRAME, Visitor, of_machine};
use messages::{Machine, Message, NumberType, Value, fnv64};
use rustix::fs::{FallocateFlags, FlockOperation, Gid, Mode, OFlags};

use crate::domain::{is_name, new_file, random};
use crate::home::{SHARED_MEMORY, user};
use crate::{Domain, Error, Sink};

const HEAD: u64 = 256;
const WORD: u64 = 8;
const MAGIC: &str = "heft window 1";
const ENDING: &str = ".window";

/// Lets a group read a file of this user, or list a folder; other users get no rights, and nobody may write. A folder
/// that is open to other users already stays unchanged.
///
/// # Errors
/// This user is not in the group, or the file is not this user's.
pub fn share(path: &Path, group: u32) -> io::Result<()> {
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let file = File::from(rustix::fs::open(path, flags, Mode::empty())?);
    let about = file.metadata()?;
    if about.is_dir() && about.mode() & 0o077 != 0 {
        return Ok(());
    }
    open_to(&file, group, about.is_dir())
}

/// Sets the group first, then its rights.
fn open_to(file: &File, group: u32, is_folder: bool) -> io::Result<()> {
    let mode = if is_folder { 0o750 } else { 0o640 };
    rustix::fs::fchown(file, None, Some(Gid::from_raw(group)))?;
    rustix::fs::fchmod(file, Mode::from_raw_mode(mode))?;
    Ok(())
}

/// Place of a channel in the file.
#[derive(Debug, Clone, Copy)]
struct Place {
    channel: &'static Channel,
    /// Offset of its count [bytes].
    count: u64,
    /// Offset of its first message [bytes].
    first: u64,
    /// Length of one message [bytes].
    size: u64,
}

impl Place {
    fn at(&self, number: u64) -> u64 {
        self.first + (number % self.channel.depth as u64) * self.size
    }
}

/// The places of a machine's channels, and the length of the file. States of steps are not shown.
fn layout(machine: Machine) -> (Vec<Place>, u64) {
    let shown = of_machine(machine).filter(|c| c.name != CREDIT.name && c.name != KEYFRAME.name);
    let shown: Vec<_> = shown.collect();
    let mut end = HEAD + WORD * shown.len() as u64;
    let places = (0..).zip(shown).map(|(n, channel)| {
        let (count, first) = (HEAD + WORD * n, end);
        let size = WORD * (channel.payload.shape().fields.len() as u64 + 2);
        end += size * channel.depth as u64;
        Place {
            channel,
            count,
            first,
            size,
        }
    });
    (places.collect(), end)
}

/// The first line; it differs for a reader with other messages.
fn head(machine: Machine) -> String {
    let names = layout(machine).0.into_iter().map(|place| {
        let fields = place.channel.payload.shape().fields.iter();
        let fields = fields.map(|f| format!("{} {:?} ", f.name, f.kind));
        format!("{} {} ", place.channel.name, fields.collect::<String>())
    });
    let sum = fnv64(names.collect::<String>().as_bytes());
    format!("{MAGIC} {} {sum:016x}\n", machine.name())
}

/// The window of a run; it is removed with the run.
#[derive(Debug)]
pub struct Window {
    file: File,
    path: PathBuf,
    places: Vec<Place>,
    /// Number of messages of each channel so far.
    counts: Vec<u64>,
    bytes: Vec<u8>,
}

impl Window {
    /// Opens the window of a run to a group. Its name has a random number, so that nobody can create it first.
    ///
    /// # Errors
    /// This user is not in the group, or shared memory is full.
    pub fn open(domain: &Domain, machine: Machine, group: u32) -> Result<Self, Error> {
        let failed = |e: io::Error| {
            Error::new(
                format!("cannot show the run to the group {group}: {e}"),
                SHARED_MEMORY,
                "name a group that this user is in (usermod -aG; SupplementaryGroups= in a unit), or none",
            )
        };
        let (places, length) = layout(machine);
        let number = random().map_err(failed)?;
        let name = format!("{}{number:016x}{ENDING}", domain.prefix());
        let path = Path::new(SHARED_MEMORY).join(name);
        let file = new_file(&path).map_err(failed)?;
        let window = Self {
            counts: vec![0; places.len()],
            file,
            path,
            places,
            bytes: Vec::new(),
        };
        let made = (|| {
            rustix::fs::fallocate(&window.file, FallocateFlags::empty(), 0, length)?;
            window.file.write_all_at(head(machine).as_bytes(), 0)?;
            // This lock shows readers that the run is alive. No other process has the file open yet.
            rustix::fs::flock(&window.file, FlockOperation::NonBlockingLockExclusive)?;
            open_to(&window.file, group, false)
        })();
        made.map(|()| window).map_err(failed)
    }

    /// Shows a message.
    pub fn show<M: Message>(&mut self, channel: &Channel, message: &M) {
        let found = self
            .places
            .iter()
            .position(|p| p.channel.name == channel.name);
        let Some(i) = found else { return };
        let (place, count) = (self.places[i], self.counts[i]);
        self.bytes.clear();
        self.bytes.extend((count + 1).to_ne_bytes());
        for field in 0..M::FIELDS.len() {
            let word = match message.get(field) {
                Some(Value::U32(v)) => u64::from(v),
                Some(Value::U64(v)) => v,
                Some(Value::F64(v)) => v.to_bits(),
                None => 0,
            };
            self.bytes.extend(word.to_ne_bytes());
        }
        let sum = fnv64(&self.bytes);
        self.bytes.extend(sum.to_ne_bytes());
        self.counts[i] = count + 1;
        // The space was allocated at the start.
        let _ = self.file.write_all_at(&self.bytes, place.at(count));
        let _ = self
            .file
            .write_all_at(&(count + 1).to_ne_bytes(), place.count);
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// The window of another user's run, for a member of the group.
#[derive(Debug)]
pub struct GroupView {
    file: File,
    domain: String,
    /// User id of the run's owner.
    pub user: u32,
    places: Vec<Place>,
    /// Next message of each channel.
    next: Vec<u64>,
    machine: Machine,
}

impl GroupView {
    /// The windows that other users open to a group of this user, of runs that are alive.
    pub fn all() -> Vec<Self> {
        let groups = rustix::process::getgroups().unwrap_or_default();
        let own = rustix::process::getegid();
        let groups: Vec<u32> = groups
            .into_iter()
            .chain([own])
            .map(|g| g.as_raw())
            .collect();
        let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
        let mut all: Vec<Self> = entries
            .filter_map(|entry| Self::look(&entry.path(), &groups))
            .collect();
        all.sort_by(|a, b| (&a.domain, a.user).cmp(&(&b.domain, b.user)));
        all
    }

    /// A window is accepted where the user in its name created it, for a group of this user:
    /// other users can forge neither.
    fn look(path: &Path, groups: &[u32]) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let name = name.strip_prefix("heft-")?.strip_suffix(ENDING)?;
        let mut parts = name.split('.');
        let owner: u32 = parts.next()?.parse().ok()?;
        let domain = parts.next().filter(|name| is_name(name))?.to_owned();
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = File::from(rustix::fs::open(path, flags, Mode::empty()).ok()?);
        let about = file.metadata().ok()?;
        let is_meant = about.mode() & 0o7777 == 0o640 && groups.contains(&about.gid());
        if !about.is_file() || about.uid() != owner || owner == user() || !is_meant {
            return None;
        }
        let mut line = [0; HEAD as usize];
        file.read_exact_at(&mut line, 0).ok()?;
        let known = |machine: &Machine| line.starts_with(head(*machine).as_bytes());
        let machine = Machine::ALL.into_iter().find(known)?;
        let places = layout(machine).0;
        let mut shown = Self {
            next: vec![0; places.len()],
            user: owner,
            file,
            domain,
            places,
            machine,
        };
        // Messages from now on.
        shown.next = (0..shown.places.len()).map(|i| shown.count(i)).collect();
        shown.is_alive().then_some(shown)
    }

    /// Name of the run's domain.
    pub fn domain(&self) -> &str {
        &self.domain
    }

    /// The machine of the run.
    pub fn machine(&self) -> Machine {
        self.machine
    }

    /// Whether the run is alive.
    pub fn is_alive(&self) -> bool {
        let taken = rustix::fs::flock(&self.file, FlockOperation::NonBlockingLockShared);
        let _ = taken.map(|()| rustix::fs::flock(&self.file, FlockOperation::Unlock));
        taken.is_err()
    }

    fn count(&self, i: usize) -> u64 {
        let mut count = [0; WORD as usize];
        let read = self.file.read_exact_at(&mut count, self.places[i].count);
        read.map_or(0, |()| u64::from_ne_bytes(count))
    }

    /// Passes the new messages of `channels` to the sink; messages that were overwritten before are lost.
    pub fn drain<S: Sink>(&mut self, channels: &[&'static Channel], sink: &mut S) {
        for i in 0..self.places.len() {
            let place = self.places[i];
            let is_wanted = channels.iter().any(|c| c.name == place.channel.name);
            let count = self.count(i);
            let oldest = count.saturating_sub(place.channel.depth as u64);
            for number in self.next[i].max(oldest)..count {
                if is_wanted && let Some(words) = self.read(place, number) {
                    place.channel.payload.visit(Hand {
                        channel: place.channel,
                        words: &words,
                        sink,
                    });
                }
            }
            self.next[i] = count;
        }
    }

    /// The fields of a message; `None` where it has been overwritten.
    fn read(&self, place: Place, number: u64) -> Option<Vec<u64>> {
        let mut bytes = vec![0; place.size as usize];
        self.file.read_exact_at(&mut bytes, place.at(number)).ok()?;
        let (content, stated) = bytes.split_last_chunk()?;
        let (words, _) = content.as_chunks();
        let words: Vec<u64> = words.iter().map(|w| u64::from_ne_bytes(*w)).collect();
        // The sum does not match for a message that is written while it is read.
        let is_whole = fnv64(content) == u64::from_ne_bytes(*stated) && words[0] == number + 1;
        is_whole.then(|| words[1..].to_vec())
    }
}

struct Hand<'a, S> {
    channel: &'static Channel,
    words: &'a [u64],
    sink: &'a mut S,
}

impl<S: Sink> Visitor for Hand<'_, S> {
    type Output = ();
    fn visit<M: Message>(self) {
        let mut message = M::default();
        for (index, (field, word)) in M::FIELDS.iter().zip(self.words).enumerate() {
            let value = match field.kind {
                NumberType::U32 => Value::U32(*word as u32),
                NumberType::U64 => Value::U64(*word),
                NumberType::F64 => Value::F64(f64::from_bits(*word)),
            };
            message.set(index, value);
        }
        self.sink.accept(self.channel, &message);
    }
}
