//! The file of a state: its fields, its checksum, and whether it fits a run.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use config::Description;
use serde::{Deserialize, Serialize};

/// Largest number of refused states stored beside a state.
const MOST_KEPT: u32 = 1000;
/// Largest file that is read as a state \[bytes\].
const LARGEST: u64 = 1 << 20;
/// Version of the fields' meaning: increased if this version could misread them. A new field needs no increase.
pub(super) const FORMAT: u32 = 2;
/// Version of files that state none: a hash of the whole description, no checksum.
const FIRST_FORMAT: u32 = 1;
/// Text between the contents of a file and their checksum, in every format since the second.
pub(super) const SEAL: &str = ",\n  \"sha256\": \"";

/// A remembered parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Remembered {
    /// Value in the unit of its key.
    pub(super) value: f64,
    /// Its standard deviation when it was last trusted.
    pub(super) std: f64,
    /// Time of that [s since 1970].
    pub(super) learnt: u64,
    /// It is known to be of the empty machine. Files of before 0.4 lack it: they may hold the centre of gravity with a load.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) of_empty: bool,
}

/// The contents of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    /// The build that wrote it. The first field: it identifies a damaged file as one of heft.
    pub(super) heft: String,
    #[serde(default = "first_format")]
    pub(super) format: u32,
    pub(super) machine: String,
    /// What the description stated beside the defaults, by key; without restored values.
    #[serde(default)]
    pub(super) stated: BTreeMap<String, String>,
    /// Hash of the whole description, in the first format.
    #[serde(default, skip_serializing)]
    pub(super) description_sha256: String,
    /// Methods of the run, by process.
    pub(super) methods: BTreeMap<String, String>,
    /// Parameters by the key that they restore.
    pub(super) parameters: BTreeMap<String, Remembered>,
}

fn first_format() -> u32 {
    FIRST_FORMAT
}

/// Why a file is not used.
pub(super) enum Refusal {
    /// It is no state of heft: the file stays unchanged.
    Foreign(String),
    /// A state that does not fit this run.
    Unfit(String),
}

/// Renames a file within its folder, to the first free name.
pub(super) fn set_aside(file: &Path) -> std::io::Result<PathBuf> {
    let name = file.file_name().unwrap_or_default().to_os_string();
    for number in 1..=MOST_KEPT {
        let mut aside = name.clone();
        aside.push(match number {
            1 => ".refused".to_owned(),
            n => format!(".refused-{n}"),
        });
        let aside = file.with_file_name(aside);
        // Never overwrites a file, even if two runs rename at the same time.
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

/// The text of a regular file of the size of a state; `None` if there is no file.
fn text_of(file: &Path) -> std::io::Result<Option<String>> {
    use std::io::Read;
    let mut options = fs::OpenOptions::new();
    // Opening a pipe must not block.
    let flags = rustix::fs::OFlags::NONBLOCK.bits() as i32;
    let opened = match options.read(true).custom_flags(flags).open(file) {
        Ok(opened) => opened,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e),
    };
    if !opened.metadata()?.is_file() {
        return Err(std::io::Error::other("it is no regular file"));
    }
    let mut bytes = Vec::new();
    opened.take(LARGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST {
        return Err(std::io::Error::other("it is too large for one"));
    }
    // Bytes that are no text are damage like any other.
    Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
}

/// The stated keys of a description, in the form of a state.
pub(super) fn stated(description: &Description) -> BTreeMap<String, String> {
    let stated = description.stated().into_iter();
    stated.map(|(key, value)| (key.into(), value)).collect()
}

/// Contents without their last bracket, closed by their checksum.
pub(super) fn sealed(contents: &str) -> String {
    let sum = recording::sha256(contents);
    format!("{contents}{SEAL}{sum}\"\n}}\n")
}

/// Whether a damaged text was a state: it begins or ends as heft writes them, or is empty as after a power failure of the
/// host.
fn is_ours(text: &str) -> bool {
    let begin: String = text.split_whitespace().take(2).collect();
    begin.starts_with("{\"heft\":")
        || (text.contains("\n  \"parameters\": {") && text.contains(SEAL))
        || text.chars().all(|c| c.is_whitespace() || c == '\0')
}

/// The state in a text, whole.
fn whole(text: &str) -> Result<State, String> {
    let contents = text.rsplit_once(SEAL).map(|(contents, _)| contents);
    if contents.is_some_and(|contents| sealed(contents) != text) {
        return Err("its checksum is not that of its contents".into());
    }
    /// The fields that are read first: a later format may lack others that this one needs.
    #[derive(Deserialize)]
    struct Head {
        #[serde(default = "first_format")]
        format: u32,
    }
    let Head { format } = serde_json::from_str(text).map_err(|e| e.to_string())?;
    if contents.is_none() && format > FIRST_FORMAT {
        return Err("its checksum is missing".into());
    }
    if format > FORMAT {
        return Err(format!(
            "a newer heft wrote it: format {format}, this one reads up to {FORMAT}"
        ));
    }
    serde_json::from_str(text).map_err(|e| e.to_string())
}

/// The parameters in a file, by their present keys; `None` if there is no file.
pub(super) fn read(
    file: &Path,
    description: &Description,
    methods: &BTreeMap<String, String>,
) -> Result<Option<BTreeMap<String, Remembered>>, Refusal> {
    let text = text_of(file).map_err(|e| Refusal::Foreign(e.to_string()))?;
    let Some(text) = text else {
        return Ok(None);
    };
    let old = whole(&text).map_err(|why| {
        if is_ours(&text) {
            Refusal::Unfit(format!("damaged: {why}"))
        } else {
            Refusal::Foreign(why)
        }
    })?;
    fits(&old, description, methods).map_err(Refusal::Unfit)?;
    let today = |key: String| config::renamed(&key).map_or(key, str::to_owned);
    let parameters = old.parameters.into_iter();
    Ok(Some(parameters.map(|(k, v)| (today(k), v)).collect()))
}

/// Whether a state fits this run, or why not.
fn fits(
    old: &State,
    description: &Description,
    methods: &BTreeMap<String, String>,
) -> Result<(), String> {
    if old.machine != description.machine().name() {
        return Err(format!("it is of the machine {}", old.machine));
    }
    if old.format == FIRST_FORMAT {
        // A hash cannot distinguish a change by the user from renamed keys of heft.
        if old.description_sha256 != recording::sha256(description.to_toml()) {
            return Err("the machine file was changed since, or heft's defaults: \
                 an older heft wrote it, which did not say what was stated"
                .into());
        }
    } else {
        let changed = description.changed_since(&old.stated);
        if !changed.is_empty() {
            let keys = changed.join(", ");
            return Err(format!("the machine file was changed since: {keys}"));
        }
    }
    if old.methods != *methods {
        return Err("it was learnt by another method".into());
    }
    let sound = |r: &Remembered| r.value.is_finite() && r.std.is_finite() && r.std > 0.0;
    if !old.parameters.values().all(sound) {
        return Err("damaged: a number that is none".into());
    }
    Ok(())
}
