//! `--state FILE`: parameters that take long to identify and change slowly are remembered from run to run.
//!
//! Only what was trusted is remembered, per parameter with standard deviation and time, and a centre of gravity only where it is that
//! of the empty machine. A constant of the machine is followed to the end of the run: its last posterior contains all rows. That of the
//! last trusted row would be selected by the verdict, which depends on the estimate. They are the priors of the next run, without a
//! verdict ([`config::recalled`]). A value that is no better known than the described prior, or contradicts it, is not used. The
//! description in a recording contains those priors, so a replay needs nothing else.
//!
//! A state outlives versions of heft: it contains what its description stated beside the defaults, renamed keys are
//! accepted, and unknown fields are ignored. Its last line is the checksum of all lines before it.

mod file;
mod lock;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use config::{Description, recalled};
use messages::channels::Channel;
use messages::{Machine, Message, excavator_bits, loader_bits};
use runtime::since_1970;
use steps::stages::Pipeline;

use self::file::{FORMAT, Refusal, Remembered, State, read, sealed, set_aside, stated};
use crate::failure::Failure;

/// Time between two writes of the file.
const PERIOD: Duration = Duration::from_secs(60);

/// A parameter to remember, by the sheet of its machine: its row, the field of its standard deviation, and
/// the keys that both restore. The content of the bucket and a load are not slow.
type Slow = (&'static sheet::Quantity, &'static str, [&'static str; 2]);

fn slow(machine: Machine) -> impl Iterator<Item = Slow> {
    let rows = machine.quantities().iter();
    rows.filter_map(|row| Some((row, row.std?, row.kept?)))
}

/// Flags of a row whose inputs are recent and whose innovations have their predicted size.
fn sound(machine: Machine) -> u32 {
    match machine {
        Machine::Excavator => excavator_bits::CONSISTENT | excavator_bits::FRESH,
        Machine::Loader => loader_bits::CONSISTENT | loader_bits::FRESH,
    }
}

/// The memory of a run.
#[derive(Debug)]
pub struct Memory {
    machine: Machine,
    /// Channel of the parameters: that of the headline estimate.
    channel: Option<&'static str>,
    file: PathBuf,
    state: State,
    /// Keys of the constants of the machine that this run has trusted.
    trusted: BTreeSet<&'static str>,
    written: Instant,
    /// Why the last write failed. Reported once until a write succeeds again.
    failed: Option<String>,
    /// The file, locked for this run; none before the first write.
    lock: Option<fs::File>,
}

impl Memory {
    /// Opens the file of an earlier run, if there is one that fits, and puts its parameters into the
    /// description. Returns a line for the user.
    pub fn open(
        file: &Path,
        description: &mut Description,
        methods: &BTreeMap<String, String>,
    ) -> Result<(Self, String), Failure> {
        let fresh = State {
            heft: crate::build::IDENTITY.into(),
            format: FORMAT,
            machine: description.machine().name().into(),
            stated: stated(description),
            description_sha256: String::new(),
            methods: methods.clone(),
            parameters: BTreeMap::new(),
        };
        let place = file.display();
        is_no_link(file)?;
        let lock = lock::taken(file)?;
        let (state, line) = match read(file, description, methods) {
            Ok(Some(parameters)) => {
                let said = restore(&parameters, since_1970().as_secs(), description);
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
                // Stored for inspection; an unfit state does not stop a run.
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
        let mut memory = Self {
            machine: description.machine(),
            channel: Pipeline::of(description.machine())
                .main_output()
                .map(|c| c.name),
            file: file.to_owned(),
            state,
            trusted: BTreeSet::new(),
            written: Instant::now(),
            failed: None,
            // Without a file to lock, the first write refuses one that another run has made meanwhile.
            lock: lock.filter(|_| file.exists()),
        };
        // A file that cannot be written is reported before the run, not after it.
        memory.write()?;
        Ok((memory, line))
    }

    /// Remembers the trusted parameters of an estimate; a constant of the machine also later, in rows with sound inputs.
    pub fn see<M: Message>(&mut self, channel: &Channel, message: &M) {
        if self.channel != Some(channel.name) {
            return;
        }
        let flags = message.bits_of("flags");
        let sound = sound(self.machine);
        for (row, std, [key, _]) in slow(self.machine) {
            let (Some(value), Some(std)) = (message.number(row.name), message.number(std)) else {
                continue;
            };
            let trusted = flags & row.trusted != 0 && flags & row.kept_while == row.kept_while;
            if trusted && row.is_of_machine {
                self.trusted.insert(key);
            }
            let follows = flags & sound == sound && self.trusted.contains(key);
            if (trusted || follows) && std > 0.0 && value.is_finite() && std.is_finite() {
                let learnt = since_1970().as_secs();
                let remembered = Remembered {
                    value,
                    std,
                    learnt,
                    of_empty: row.kept_while != 0,
                };
                self.state.parameters.insert(key.into(), remembered);
            }
        }
    }

    /// Writes the file if a minute has passed.
    pub fn tick(&mut self) {
        if self.written.elapsed() >= PERIOD {
            self.save();
        }
    }

    /// Writes the file now. A failure is reported once; the run goes on.
    pub fn save(&mut self) {
        self.written = Instant::now();
        let failure = self.write().err();
        if let Some(failure) = failure.as_ref().filter(|_| self.failed.is_none()) {
            tracing::warn!("the learnt state is not stored: {failure}");
        }
        self.failed = failure.map(|failure| failure.what());
    }

    /// Why the last write failed, if it did.
    pub fn failed(&self) -> Option<&str> {
        self.failed.as_deref()
    }

    /// Writes atomically: at every moment the file holds the old state or the new one.
    fn write(&mut self) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(&self.state).map_err(Failure::internal)?;
        let text = sealed(text.trim_end_matches("\n}"));
        let new = self
            .file
            .with_extension(format!("{}.new", std::process::id()));
        let written = (|| {
            let mut options = fs::OpenOptions::new();
            options.write(true).create_new(true).mode(0o600);
            let mut file = match options.open(&new) {
                // In a container the process id is always the same: the file remains from a power failure.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                    fs::remove_file(&new)?;
                    options.open(&new)?
                }
                opened => opened?,
            };
            file.write_all(text.as_bytes())?;
            file.sync_all()?;
            // Before others see it.
            lock::lock(&file)?;
            match self.lock {
                Some(_) => fs::rename(&new, &self.file)?,
                None => lock::rename_to_new(&new, &self.file)?,
            }
            Ok(file)
        })();
        let file = written.map_err(|e: io::Error| {
            let _ = fs::remove_file(&new); // the error that is returned matters more
            match e.kind() {
                io::ErrorKind::AlreadyExists => lock::in_use(&self.file),
                _ => Failure::file("write", &self.file, &e),
            }
        })?;
        self.lock = Some(file);
        Ok(())
    }
}

/// Refuses a link: the first write would replace it by a file, and what it leads to would never change.
fn is_no_link(file: &Path) -> Result<(), Failure> {
    match fs::read_link(file) {
        Err(_) => Ok(()),
        Ok(target) => Err(Failure::input(
            "the state is a link, which a write would replace by a file",
            format!("--state {}", file.display()),
            format!(
                "name the file itself: {}",
                file.with_file_name(target).display()
            ),
        )),
    }
}

/// Puts remembered parameters into a description. Returns as text which were restored, and which not.
fn restore(
    parameters: &BTreeMap<String, Remembered>,
    now: u64,
    description: &mut Description,
) -> String {
    let (mut said, mut left) = (Vec::new(), Vec::new());
    for (row, _, keys) in slow(description.machine()) {
        let Some(old) = parameters.get(keys[0]) else {
            continue;
        };
        let restored = if row.kept_while != 0 && !old.of_empty {
            Err("an older heft stored it, perhaps with a load".into())
        } else {
            restore_one(keys, *old, now, description)
        };
        match restored {
            Ok([value, std]) => said.push(format!("{} {value:.4} ± {std:.2}", row.name)),
            Err(why) => left.push(format!("{} ({why})", keys[0])),
        }
    }
    let known: Vec<&str> = slow(description.machine()).map(|s| s.2[0]).collect();
    let unknown = parameters.keys().filter(|k| !known.contains(&k.as_str()));
    left.extend(unknown.map(|key| format!("{key} (this heft remembers no such key)")));
    match (said.is_empty(), left.is_empty()) {
        (true, true) => "nothing to restore: nothing was trusted yet".into(),
        (true, false) => format!("nothing restored: {}", left.join(", ")),
        (false, true) => format!("restored {}", said.join(", ")),
        (false, false) => format!("restored {}; not {}", said.join(", "), left.join(", ")),
    }
}

/// Puts the prior from a remembered parameter under its key, and its standard deviation under that key. Returns both, or why the
/// description's own prior stays.
fn restore_one(
    [key, std_key]: [&str; 2],
    old: Remembered,
    now: u64,
    description: &mut Description,
) -> Result<[f64; 2], String> {
    let prior = description.number(std_key).unwrap_or(0.0);
    // Standard deviation 0: stated as exactly known.
    if prior <= 0.0 {
        return Err(format!("{std_key} is 0: it is known exactly"));
    }
    // A time in the future: a clock was wrong by at least that much.
    let pause = now.abs_diff(old.learnt) as f64;
    let mut with = description.clone();
    // A value outside its range is named as such.
    with.set(&format!("{key}={}", old.value))
        .map_err(|error| error.what)?;
    let stated = [description.number(key).unwrap_or(old.value), prior];
    let found = [old.value, old.std];
    config::serves(found, stated)?;
    let [value, std] = recalled(found, stated, pause);
    let set = [format!("{key}={value}"), format!("{std_key}={std}")];
    with.set_all(&set).map_err(|error| error.what)?;
    *description = with;
    Ok([value, std])
}

#[cfg(test)]
mod tests {
    use config::recalled;
    use messages::channels::LOADER_CG_UKF;
    use messages::{LoaderEstimate, Machine};

    use super::file::SEAL;
    use super::*;

    fn loader() -> Description {
        Description::default_of(Machine::Loader)
    }

    /// Flags of a trusted ratio of the empty machine.
    const EMPTY: u32 = loader_bits::TRUSTED_RATIO | loader_bits::OF_EMPTY;

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
        // The file that a power failure left of a process with the same number.
        let left = file.with_extension(format!("{}.new", std::process::id()));
        fs::write(left, "half").unwrap();
        let (mut memory, said) = Memory::open(&file, &mut loader(), &methods).unwrap();
        assert!(said.contains("nothing to remember yet"), "{said}");
        memory.see(&LOADER_CG_UKF, &estimate(0.50, 0));
        memory.see(&LOADER_CG_UKF, &estimate(0.47, EMPTY));
        memory.see(&LOADER_CG_UKF, &estimate(0.60, 0));
        // With a load, or with the arm elsewhere.
        memory.see(&LOADER_CG_UKF, &estimate(0.60, loader_bits::TRUSTED_RATIO));
        memory.see(&LOADER_CG_UKF, &estimate(0.55, loader_bits::OF_EMPTY));
        memory.save();
        let text = fs::read_to_string(&file).unwrap();
        assert!(
            text.contains("prior.cg_ratio") && !text.contains("cg_height"),
            "{text}"
        );
        drop(memory);
        let mut next = loader();
        let (_, said) = Memory::open(&file, &mut next, &methods).unwrap();
        let (before, after) = (loader(), next);
        let prior = |d: &Description, name: &str| {
            ["", "_std"].map(|of| d.number(&format!("prior.{name}{of}")).unwrap())
        };
        let found = [("slip_stiffness", [24.0, 0.5]), ("cg_ratio", [0.47, 0.01])];
        for (name, found) in found {
            assert!(said.contains(name), "{said}");
            let expected = recalled(found, prior(&before, name), 0.0);
            let off = [0, 1].map(|i| prior(&after, name)[i] / expected[i] - 1.0);
            assert!(off.iter().all(|o| o.abs() < 1e-6), "{name}: {off:?}");
        }
        assert_eq!(
            after.number("prior.cg_height"),
            before.number("prior.cg_height")
        );
        // The same description again: restored values do not count as a change of it.
        let (_, said) = Memory::open(&file, &mut loader(), &methods).unwrap();
        assert!(said.contains("restored"), "{said}");
    }

    #[test]
    fn a_constant_of_the_machine_is_followed_once_trusted_while_inputs_are_sound() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        let (mut memory, _) = Memory::open(&file, &mut loader(), &BTreeMap::new()).unwrap();
        let sound = loader_bits::CONSISTENT | loader_bits::FRESH;
        let of = |slip_stiffness, flags| LoaderEstimate {
            slip_stiffness,
            ..estimate(0.47, flags)
        };
        let mut stored = |slip_stiffness, flags| {
            memory.see(&LOADER_CG_UKF, &of(slip_stiffness, flags));
            let found = memory.state.parameters.get("prior.slip_stiffness");
            found.map(|found| found.value)
        };
        assert_eq!(stored(21.0, sound), None);
        assert_eq!(stored(22.0, sound | loader_bits::TRUSTED_RATIO), Some(22.0));
        assert_eq!(stored(23.0, sound), Some(23.0));
        assert_eq!(stored(29.0, loader_bits::FRESH), Some(23.0));
        assert!(!memory.state.parameters.contains_key("prior.cg_ratio"));
    }

    #[test]
    fn of_two_runs_with_one_state_the_second_is_refused_until_the_first_has_ended() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        let open = || Memory::open(&file, &mut loader(), &BTreeMap::new());
        let (mut first, _) = open().unwrap();
        for _ in 0..2 {
            let said = open().expect_err("refused").to_string();
            assert!(said.starts_with("another run uses this state"), "{said}");
            // Each write is a new file.
            first.save();
            assert_eq!(first.failed(), None);
        }
        drop(first);
        let (mut second, said) = open().unwrap();
        assert!(!said.contains("not used"), "{said}");
        // Two that start at once see no file both.
        fs::remove_file(&file).unwrap();
        let (_third, _) = open().unwrap();
        second.lock = None;
        second.save();
        assert!(
            second
                .failed()
                .is_some_and(|why| why.starts_with("another run"))
        );
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 1, "the state alone");
    }

    #[test]
    fn a_write_that_fails_is_known_until_one_succeeds() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("inside");
        fs::create_dir(&inside).unwrap();
        let file = inside.join("state.json");
        let (mut memory, _) = Memory::open(&file, &mut loader(), &BTreeMap::new()).unwrap();
        assert_eq!(memory.failed(), None);
        fs::remove_dir_all(&inside).unwrap();
        memory.save();
        let why = memory.failed().expect("no folder");
        assert_eq!(why, "cannot write the file: no such file or folder");
        fs::create_dir(&inside).unwrap();
        memory.save();
        assert_eq!(memory.failed(), None);
    }

    #[test]
    fn a_state_that_does_not_fit_is_set_aside_and_reported_and_the_run_starts() {
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
            ("machine file was changed since: machine.mass;", &mut || {
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
        // All states that were refused in turn are stored.
        let kept = fs::read_dir(folder.path()).unwrap().flatten();
        let kept = kept.filter(|f| f.file_name().to_string_lossy().contains(".refused"));
        assert_eq!(kept.count(), 4);
        std::os::unix::fs::symlink("elsewhere.json", folder.path().join("link")).unwrap();
        let link = Memory::open(&folder.path().join("link"), &mut loader(), &other);
        let said = link.expect_err("refused").to_string();
        let itself = folder.path().join("elsewhere.json");
        let remedy = format!("name the file itself: {}", itself.display());
        assert!(said.contains(&remedy), "{said}");
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

    /// A state identified with this description, written to a file.
    fn learnt(file: &Path, description: &Description) -> String {
        let _ = fs::remove_file(file);
        let (mut memory, _) =
            Memory::open(file, &mut description.clone(), &BTreeMap::new()).unwrap();
        memory.see(&LOADER_CG_UKF, &estimate(0.47, loader_bits::TRUSTED_RATIO));
        memory.save();
        fs::read_to_string(file).unwrap()
    }

    /// The line of a run with this description and this text as its state.
    fn said_of(text: &str, description: &Description) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        fs::write(&file, text).unwrap();
        let opened = Memory::open(&file, &mut description.clone(), &BTreeMap::new());
        opened.unwrap().1
    }

    /// The text with its checksum computed again: a file as another version of heft may have written it.
    fn resealed(text: &str) -> String {
        sealed(text.rsplit_once(SEAL).unwrap().0)
    }

    #[test]
    fn every_byte_that_is_damaged_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        let text = learnt(&file, &loader());
        assert_eq!(resealed(&text), text);
        for at in 0..text.len() {
            for bit in [1, 0x80] {
                let mut bytes = text.clone().into_bytes();
                bytes[at] ^= bit;
                fs::write(&file, &bytes).unwrap();
                let found = read(&file, &loader(), &BTreeMap::new());
                let Err(Refusal::Unfit(why)) = found else {
                    panic!("byte {at}, bit {bit}: used, or taken for a file of others");
                };
                assert!(why.starts_with("damaged: "), "byte {at}: {why}");
            }
        }
        for cut in ["", "\0\0\0\0", &text[..40], &text[..text.len() - 80]] {
            assert!(
                said_of(cut, &loader()).contains("not used: damaged"),
                "{cut}"
            );
        }
    }

    #[test]
    fn states_of_other_versions_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("state.json");
        let mut described = loader();
        described.set("sensors.slope_follows=0.3").unwrap();
        let text = learnt(&file, &described);

        // A state from before keys were renamed, and one with a field, a parameter and a key unknown to this version.
        let old_name = text.replace("slope_acceleration_sensitivity", "slope_follows");
        let more = text.replace("\"stated\": {", "\"stated\": { \"sensors.new\": \"1.0\",");
        let more = more.replace("\"machine\":", "\"new\": [1],\n  \"machine\":");
        for other in [&text, &resealed(&old_name), &resealed(&more)] {
            let said = said_of(other, &described);
            assert!(said.contains("restored slip_stiffness"), "{said}");
        }
        let said = said_of(&text, &loader());
        let key = "machine file was changed since: sensors.slope_acceleration_sensitivity;";
        assert!(said.contains(key), "{said}");

        let newer = resealed(&text.replace("\"format\": 2", "\"format\": 3"));
        let said = said_of(&newer, &described);
        assert!(said.contains("a newer heft wrote it: format 3"), "{said}");
        let bare = text.rsplit_once(SEAL).unwrap().0.to_owned() + "\n}\n";
        let said = said_of(&bare, &described);
        assert!(said.contains("its checksum is missing"), "{said}");
    }

    #[test]
    fn a_state_of_the_first_format_is_read_if_it_is_sound() {
        let first = |value: &str| {
            let hash = recording::sha256(loader().to_toml());
            format!(
                "{{\n  \"heft\": \"0.2.0 abc\",\n  \"machine\": \"loader\",\n  \"description_sha256\": \"{hash}\",\n  \
                 \"methods\": {{}},\n  \"parameters\": {{\n    \"prior.cg_ratio\": {{\n      \"value\": {value},\n      \
                 \"std\": 0.01,\n      \"learnt\": 1700000000\n    }},\n    \"prior.slip_stiffness\": {{\n      \
                 \"value\": 21.0,\n      \"std\": 0.5,\n      \"learnt\": 1700000000\n    }}\n  }}\n}}\n"
            )
        };
        let said = said_of(&first("0.47"), &loader());
        // It is years old, and so the stated value.
        assert!(said.contains("restored slip_stiffness 19.0000"), "{said}");
        let loaded = "; not prior.cg_ratio (an older heft stored it, perhaps with a load)";
        assert!(said.ends_with(loaded), "{said}");
        let mut changed = loader();
        changed.set("machine.mass=11000").unwrap();
        let said = said_of(&first("0.47"), &changed);
        assert!(said.contains("an older heft wrote it"), "{said}");
        for damaged in ["1e999", "\"0.47\"", "0.4.7"] {
            let said = said_of(&first(damaged), &loader());
            assert!(said.contains("not used: damaged"), "{damaged}: {said}");
        }
    }

    #[test]
    fn what_restores_nothing_is_named_with_its_reason() {
        let learnt = 1_700_000_000;
        let remembered = |value| Remembered {
            value,
            std: 0.01,
            learnt,
            of_empty: true,
        };
        let of = |pairs: &[(&str, f64)]| {
            let pairs = pairs.iter();
            pairs
                .map(|(key, value)| ((*key).to_owned(), remembered(*value)))
                .collect()
        };
        let outside = [("prior.cg_ratio", 7.0), ("prior.of_tomorrow", 1.0)];
        let mut description = loader();
        let said = restore(&of(&outside), learnt, &mut description);
        let reasons = "nothing restored: prior.cg_ratio (prior.cg_ratio is 7, outside from 0.01 to 0.99), \
                       prior.of_tomorrow (this heft remembers no such key)";
        assert_eq!(said, reasons);
        assert_eq!(description, loader());
        let more = of(&[&outside[..], &[("prior.slip_stiffness", 24.0)]].concat());
        let said = restore(&more, learnt, &mut description);
        assert!(
            said.starts_with("restored slip_stiffness 23.0000"),
            "{said}"
        );
        assert!(said.contains("; not prior.cg_ratio ("), "{said}");

        let mut exact = Description::default_of(Machine::Excavator);
        exact.set("prior.damping_std=0").unwrap();
        let damping = of(&[("machine.nominal_damping", 1600.0)]);
        let said = restore(&damping, learnt, &mut exact);
        assert!(said.contains("prior.damping_std is 0"), "{said}");
        assert!(restore(&of(&[]), learnt, &mut exact).contains("nothing was trusted yet"));
    }
}
