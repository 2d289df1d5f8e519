//! `--state FILE`: what took long to learn and changes slowly is remembered from run to run.
//!
//! Only what was trusted is remembered, per parameter with its standard deviation and the day. The next run
//! begins with it as its prior: widened for the pause, never narrower than a share of the described prior,
//! and without a verdict. The description that a recording carries holds those priors, so a replay needs
//! nothing else.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use config::{Description, widened};
use messages::channels::Channel;
use messages::{Machine, Message};
use serde::{Deserialize, Serialize};
use steps::stages::Pipeline;

use crate::failure::Failure;

/// Time between two writes.
const PERIOD: Duration = Duration::from_secs(60);

/// Refused states that are kept beside a state.
const MOST_KEPT: u32 = 1000;
/// Largest file that is read as a state \[bytes\].
const LARGEST: u64 = 1 << 20;

/// A parameter that is worth remembering, by the sheet of its machine: its row, the field of its standard deviation, and
/// the keys that both restore. A content of the bucket or a load is not slow.
type Slow = (&'static sheet::Quantity, &'static str, [&'static str; 2]);

fn slow(machine: Machine) -> impl Iterator<Item = Slow> {
    let rows = machine.quantities().iter();
    rows.filter_map(|row| Some((row, row.std?, row.kept?)))
}

/// A remembered parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Remembered {
    /// In the unit of its key.
    value: f64,
    /// Its standard deviation when it was last trusted.
    std: f64,
    /// When that was [s since 1970].
    learnt: u64,
}

/// What the file holds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct State {
    heft: String,
    machine: String,
    /// Of the description without what was restored.
    description_sha256: String,
    /// Methods of the run, by process.
    methods: BTreeMap<String, String>,
    /// By the key that they restore.
    parameters: BTreeMap<String, Remembered>,
}

/// The memory of a run.
#[derive(Debug)]
pub struct Memory {
    machine: Machine,
    /// The channel that is listened to: that of the headline estimate.
    channel: Option<&'static str>,
    file: PathBuf,
    state: State,
    written: Instant,
    /// The last attempt failed: said once.
    failed: bool,
}

impl Memory {
    /// Opens the file of an earlier run, if there is one that fits, and puts what it remembers into the
    /// description. Returns what there is to say of it, a line.
    pub fn open(
        file: &Path,
        description: &mut Description,
        methods: &BTreeMap<String, String>,
    ) -> Result<(Self, String), Failure> {
        let fresh = State {
            heft: crate::build::IDENTITY.into(),
            machine: description.machine().name().into(),
            description_sha256: recording::sha256(description.to_toml()),
            methods: methods.clone(),
            parameters: BTreeMap::new(),
        };
        let place = file.display();
        let (state, line) = match read(file, &fresh) {
            Ok(Some(old)) => {
                let said = restore(&old.parameters, now(), description)?;
                let parameters = old.parameters;
                (
                    State {
                        parameters,
                        ..fresh
                    },
                    format!("{place}: {said}"),
                )
            }
            Ok(None) => (fresh, format!("{place}: nothing to remember yet")),
            Err(Refusal::Unfit(why)) => {
                // Kept, for whoever wants to know; never a reason not to run.
                let aside = set_aside(file).map_err(|e| Failure::file("keep", file, &e))?;
                (
                    fresh,
                    format!("{place}: not used: {why}; kept as {}", aside.display()),
                )
            }
            Err(Refusal::Foreign(why)) => {
                return Err(Failure::input(
                    format!("this is no state of heft: {why}"),
                    format!("--state {place}"),
                    "name a file that is not there yet, or one that heft has written",
                ));
            }
        };
        let memory = Self {
            machine: description.machine(),
            channel: Pipeline::of(description.machine())
                .main_output()
                .map(|c| c.name),
            file: file.to_owned(),
            state,
            written: Instant::now(),
            failed: false,
        };
        // Whoever cannot write says so before the work, not after it.
        memory.write()?;
        Ok((memory, line))
    }

    /// Looks at an estimate.
    pub fn see<M: Message>(&mut self, channel: &Channel, message: &M) {
        if self.channel != Some(channel.name) {
            return;
        }
        for (row, std, [key, _]) in slow(self.machine) {
            let number = |name| {
                M::index(name)
                    .and_then(|i| message.get(i))
                    .map(messages::Value::as_f64)
            };
            let (Some(value), Some(std), Some(flags)) =
                (number(row.name), number(std), number("flags"))
            else {
                continue;
            };
            if flags as u32 & row.trusted != 0 && std > 0.0 && value.is_finite() && std.is_finite()
            {
                let learnt = now();
                let remembered = Remembered { value, std, learnt };
                self.state.parameters.insert(key.into(), remembered);
            }
        }
    }

    /// Writes the file where a minute has passed.
    pub fn tick(&mut self) {
        if self.written.elapsed() >= PERIOD {
            self.save();
        }
    }

    /// Writes the file now. What cannot be written is said, once; the run goes on.
    pub fn save(&mut self) {
        self.written = Instant::now();
        if let Err(failure) = self.write() {
            if !self.failed {
                tracing::warn!("{failure}");
            }
            self.failed = true;
        }
    }

    /// In one step: at every moment there is the old state or the new one.
    fn write(&self) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(&self.state).map_err(Failure::internal)? + "\n";
        let new = self
            .file
            .with_extension(format!("{}.new", std::process::id()));
        let written = (|| {
            let mut options = fs::OpenOptions::new();
            let mut file = options
                .write(true)
                .create_new(true)
                .mode(0o600)
                .open(&new)?;
            file.write_all(text.as_bytes())?;
            file.sync_all()?;
            fs::rename(&new, &self.file)
        })();
        written.map_err(|e| {
            let _ = fs::remove_file(&new); // the error that is returned matters more
            Failure::file("write", &self.file, &e)
        })
    }
}

/// Why a file is not used.
enum Refusal {
    /// It is no state of heft: it stays as it is.
    Foreign(String),
    /// A state that does not fit this run.
    Unfit(String),
}

/// Moves a file beside itself, under the first name that is free.
fn set_aside(file: &Path) -> std::io::Result<PathBuf> {
    let name = file.file_name().unwrap_or_default().to_os_string();
    for number in 1..=MOST_KEPT {
        let mut aside = name.clone();
        aside.push(match number {
            1 => ".refused".to_owned(),
            n => format!(".refused-{n}"),
        });
        let aside = file.with_file_name(aside);
        // Never over something that is there, also where two runs do it at a time.
        let flags = rustix::fs::RenameFlags::NOREPLACE;
        match rustix::fs::renameat_with(rustix::fs::CWD, file, rustix::fs::CWD, &aside, flags) {
            Ok(()) => return Ok(aside),
            Err(rustix::io::Errno::EXIST) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Err(std::io::Error::other(format!(
        "{MOST_KEPT} refused states are beside it: remove those that nobody needs"
    )))
}

/// The text of a regular file of the size of a state; `None` if there is nothing.
fn text_of(file: &Path) -> std::io::Result<Option<String>> {
    use std::io::Read;
    let mut options = fs::OpenOptions::new();
    // A pipe is not waited for.
    let flags = rustix::fs::OFlags::NONBLOCK.bits() as i32;
    let opened = match options.read(true).custom_flags(flags).open(file) {
        Ok(opened) => opened,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e),
    };
    if !opened.metadata()?.is_file() {
        return Err(std::io::Error::other("it is no regular file"));
    }
    let mut text = String::new();
    opened.take(LARGEST + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LARGEST {
        return Err(std::io::Error::other("it is too large for one"));
    }
    Ok(Some(text))
}

/// Whether a damaged text was a state: it begins as heft writes them.
fn is_ours(text: &str) -> bool {
    let begin: String = text.split_whitespace().take(2).collect();
    begin.starts_with("{\"heft\":")
}

/// The state in a file; `None` if there is no file.
fn read(file: &Path, run: &State) -> Result<Option<State>, Refusal> {
    let text = text_of(file).map_err(|e| Refusal::Foreign(e.to_string()))?;
    let Some(text) = text else {
        return Ok(None);
    };
    let old: State = serde_json::from_str(&text).map_err(|e| {
        // Nothing at all is what a host leaves that lost its power.
        if text.trim_start().is_empty() || is_ours(&text) {
            Refusal::Unfit(format!("damaged: {e}"))
        } else {
            Refusal::Foreign(e.to_string())
        }
    })?;
    fits(old, run).map(Some).map_err(Refusal::Unfit)
}

/// The state if it fits this run, or why not.
fn fits(old: State, run: &State) -> Result<State, String> {
    if old.machine != run.machine {
        return Err(format!("it is of the machine {}", old.machine));
    }
    if old.description_sha256 != run.description_sha256 {
        return Err("the description was changed since".into());
    }
    if old.methods != run.methods {
        return Err("it was learnt by another method".into());
    }
    let sound = |r: &Remembered| r.value.is_finite() && r.std.is_finite() && r.std > 0.0;
    if !old.parameters.values().all(sound) {
        return Err("damaged: a number that is none".into());
    }
    Ok(old)
}

/// Puts remembered parameters into a description; what was done, in words.
fn restore(
    parameters: &BTreeMap<String, Remembered>,
    now: u64,
    description: &mut Description,
) -> Result<String, Failure> {
    let mut said = Vec::new();
    for (row, _, [key, std_key]) in slow(description.machine()) {
        let (Some(old), Some(prior)) = (parameters.get(key), number(description, std_key)) else {
            continue;
        };
        // 0 says that it is known exactly.
        if prior <= 0.0 {
            continue;
        }
        // Learnt in the future: a clock was wrong, by that much at least.
        let std = widened(old.std, prior, now.abs_diff(old.learnt) as f64);
        let mut restored = description.clone();
        let set = [format!("{key}={}", old.value), format!("{std_key}={std}")];
        // Outside what the description allows: it begins from the prior.
        if restored.set_all(&set).is_ok() {
            *description = restored;
            said.push(format!("{} {:.4} ± {:.2}", row.name, old.value, std));
        }
    }
    Ok(if said.is_empty() {
        "nothing to restore".into()
    } else {
        format!("restored {}", said.join(", "))
    })
}

/// A number of a description by its key.
fn number(description: &Description, key: &str) -> Option<f64> {
    let (table, name) = key.split_once('.')?;
    let text = description.to_toml();
    let mut lines = text
        .lines()
        .skip_while(|l| l.trim() != format!("[{table}]"));
    lines.next()?;
    let mut own = lines.take_while(|l| !l.starts_with('['));
    let line = own.find_map(|l| l.strip_prefix(name)?.trim_start().strip_prefix('='))?;
    line.split('#').next()?.trim().parse().ok()
}

fn now() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |d| d.as_secs())
}

#[cfg(test)]
mod tests {
    use config::LEAST_SHARE;
    use messages::channels::LOADER_CG_UKF;
    use messages::{LoaderEstimate, Machine, loader_bits};

    use super::*;

    fn loader() -> Description {
        Description::default_of(Machine::Loader)
    }

    fn estimate(ratio: f64, flags: u32) -> LoaderEstimate {
        LoaderEstimate {
            slip_stiffness: 24.0,
            slip_stiffness_std: 0.5,
            cg_ratio: ratio,
            cg_ratio_std: 0.01,
            cg_height: 1.1,
            cg_height_std: 0.05,
            flags,
            ..LoaderEstimate::default()
        }
    }

    #[test]
    fn what_was_trusted_is_the_prior_of_the_next_run_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        let methods = BTreeMap::new();
        let (mut memory, said) = Memory::open(&file, &mut loader(), &methods).unwrap();
        assert!(said.contains("nothing to remember yet"), "{said}");
        memory.see(&LOADER_CG_UKF, &estimate(0.50, 0));
        memory.see(&LOADER_CG_UKF, &estimate(0.47, loader_bits::TRUSTED_RATIO));
        memory.see(&LOADER_CG_UKF, &estimate(0.60, 0));
        memory.save();
        let text = fs::read_to_string(&file).unwrap();
        assert!(
            text.contains("prior.cg_ratio") && !text.contains("cg_height"),
            "{text}"
        );
        let mut next = loader();
        let (_, said) = Memory::open(&file, &mut next, &methods).unwrap();
        assert!(said.contains("restored slip_stiffness 24"), "{said}");
        let (before, after) = (loader(), next);
        assert_eq!(number(&after, "prior.cg_ratio"), Some(0.47));
        assert_eq!(
            number(&after, "prior.cg_height"),
            number(&before, "prior.cg_height")
        );
        let std = |d: &Description| number(d, "prior.cg_ratio_std").unwrap();
        assert!(
            (std(&after) / std(&before) - LEAST_SHARE).abs() < 1e-9,
            "floored"
        );
        // The same description again: what was restored is no change of it.
        let (_, said) = Memory::open(&file, &mut loader(), &methods).unwrap();
        assert!(said.contains("restored"), "{said}");
    }

    #[test]
    fn a_state_that_does_not_fit_is_kept_aside_reported_and_no_reason_not_to_run() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        let other = BTreeMap::from([("ukf".to_owned(), "isr-ukf".to_owned())]);
        let mut changed = loader();
        changed.set_all(&["machine.mass=11000"]).unwrap();
        let cases: [(&str, &mut dyn FnMut() -> String); 4] = [
            ("damaged", &mut || {
                fs::write(&file, "{\"heft\": 1").unwrap();
                Memory::open(&file, &mut loader(), &BTreeMap::new())
                    .unwrap()
                    .1
            }),
            ("another method", &mut || {
                Memory::open(&file, &mut loader(), &other).unwrap().1
            }),
            ("description was changed", &mut || {
                Memory::open(&file, &mut changed, &other).unwrap().1
            }),
            ("of the machine loader", &mut || {
                let mut excavator = Description::default_of(Machine::Excavator);
                Memory::open(&file, &mut excavator, &other).unwrap().1
            }),
        ];
        for (words, open) in cases {
            let said = open();
            assert!(said.contains(words) && said.contains("kept as"), "{said}");
        }
        // None was lost of those that were refused in turn.
        let kept = fs::read_dir(folder.path()).unwrap().flatten();
        let kept = kept.filter(|f| f.file_name().to_string_lossy().contains(".refused"));
        assert_eq!(kept.count(), 4);
        let refused = folder.path().join("nowhere/state.json");
        assert!(
            Memory::open(&refused, &mut loader(), &other).is_err(),
            "said before the work"
        );
    }

    #[test]
    fn what_is_no_state_is_refused_and_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        fs::create_dir(file("folder")).unwrap();
        fs::write(file("my.csv"), "t,swing_velocity\n0,1\n").unwrap();
        fs::write(file("my.json"), "{\"other\": 1}").unwrap();
        let fifo = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        rustix::fs::mknodat(
            rustix::fs::CWD,
            file("fifo"),
            rustix::fs::FileType::Fifo,
            fifo,
            0,
        )
        .unwrap();
        let names = || {
            let entries = fs::read_dir(folder.path()).unwrap().flatten();
            let mut names: Vec<_> = entries.map(|e| e.file_name()).collect();
            names.sort();
            names
        };
        let before = names();
        for name in ["folder", "my.csv", "my.json", "fifo"] {
            let opened = Memory::open(&file(name), &mut loader(), &BTreeMap::new());
            assert!(opened.is_err(), "{name}");
        }
        assert_eq!(names(), before);
        assert_eq!(
            fs::read_to_string(file("my.csv")).unwrap(),
            "t,swing_velocity\n0,1\n"
        );
    }
}
