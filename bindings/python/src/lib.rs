//! The native part of the Python package `heft`: the steps of the pipeline on columns, recordings as
//! columns, the tables of messages. Arrays of numbers are passed as bytes.

mod estimator;
mod hints;
mod kind;

use std::path::Path;

use config::Description;
use messages::{Machine, NumberType, Value, channels};
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList, PyTuple};
use recording::frame::{self, Values};
use recording::{Kind, Lacks, Map, Reader};
use steps::stages::Pipeline;

use crate::kind::{Estimates, kind};

// Of the package, so that it is found where a process of a pool sends it on.
create_exception!(
    heft,
    HeftError,
    PyValueError,
    "What is wrong, where, and what to do about it."
);

/// The error in the words of the package, whose parameters are not called like options.
fn refused(error: impl std::fmt::Display) -> PyErr {
    let text = error.to_string();
    let said = Python::attach(|py| {
        let words = py.import("heft._words")?;
        words.call_method1("in_python", (&text,))?.extract()
    });
    HeftError::new_err(said.unwrap_or(text))
}

#[pymodule]
fn _heft(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("HeftError", m.py().get_type::<HeftError>())?;
    m.add_function(wrap_pyfunction!(signals, m)?)?;
    m.add_class::<estimator::Estimator>()?;
    m.add_function(wrap_pyfunction!(estimate, m)?)?;
    m.add_function(wrap_pyfunction!(estimate_file, m)?)?;
    m.add_function(wrap_pyfunction!(header, m)?)?;
    m.add_function(wrap_pyfunction!(methods, m)?)?;
    m.add_function(wrap_pyfunction!(nearest, m)?)?;
    m.add_function(wrap_pyfunction!(label, m)?)?;
    m.add_function(wrap_pyfunction!(reasons, m)?)?;
    m.add_function(wrap_pyfunction!(description, m)?)?;
    m.add_function(wrap_pyfunction!(undescribed, m)?)?;
    m.add_function(wrap_pyfunction!(read, m)?)?;
    m.add_function(wrap_pyfunction!(schema, m)?)
}

fn machine(name: &str) -> PyResult<Machine> {
    Machine::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Machine::ALL.iter().map(|m| m.name()).collect();
        refused(format!(
            "there is no machine {name}; machines are {}",
            known.join(", ")
        ))
    })
}

/// Columns that samples of a machine can have.
#[pyfunction]
fn signals(machine: &str) -> PyResult<Vec<String>> {
    Ok(frame::signals_of(self::machine(machine)?))
}

/// A description: the text, or the defaults, and then the keys that are set individually.
fn described(machine: Machine, text: Option<&str>, settings: &[String]) -> PyResult<Description> {
    let mut description = match text {
        Some(text) => Description::parse(text, "config", Some(machine)).map_err(refused)?,
        None => Description::default_of(machine),
    };
    if description.machine() != machine {
        let other = description.machine().name();
        return Err(refused(format!(
            "the machine file is one of the {other}, not of the {}; give that of this machine, or name the other machine",
            machine.name()
        )));
    }
    description.set_all(settings).map_err(refused)?;
    Ok(description)
}

#[pyfunction]
fn description(machine: &str, text: Option<&str>, settings: Vec<String>) -> PyResult<String> {
    Ok(described(self::machine(machine)?, text, &settings)?.to_toml())
}

/// What is said of a machine that neither a text nor keys describe; none of a described one.
#[pyfunction]
fn undescribed(
    machine: &str,
    text: Option<&str>,
    settings: Vec<String>,
) -> PyResult<Option<String>> {
    let description = described(self::machine(machine)?, text, &settings)?;
    Ok(reference(&description, text, &settings))
}

/// What is said where nobody describes the machine: its size decides what is trusted.
fn reference(description: &Description, text: Option<&str>, settings: &[String]) -> Option<String> {
    let machine = description.machine();
    (text.is_none() && settings.is_empty()).then(|| {
        format!(
            "the {machine} is taken for the reference machine of {} t; say what yours is: config=\"machine.toml\", or config={{\"{}\": 21000}}",
            config::reference_mass(machine) / 1000.0,
            config::mass_key(machine)
        )
    })
}

/// Columns of the estimates, indices of the refused rows, number of rows, missing and damaged parts of the file,
/// and warnings on the data.
type EstimateColumns<'py> = (
    Bound<'py, PyList>,
    Vec<u32>,
    usize,
    Vec<String>,
    Vec<String>,
);

#[pyfunction]
fn estimate<'py>(
    py: Python<'py>,
    machine: &str,
    columns: Vec<(String, Bound<'py, PyBytes>)>,
    text: Option<&str>,
    settings: Vec<String>,
    method: Option<&str>,
) -> PyResult<EstimateColumns<'py>> {
    let description = described(self::machine(machine)?, text, &settings)?;
    let columns: Vec<(&str, Vec<f64>)> = columns
        .iter()
        .map(|(name, bytes)| (name.as_str(), numbers(bytes.as_bytes())))
        .collect();
    let length = columns.first().map_or(0, |(_, values)| values.len());
    let result =
        py.detach(|| kind(&description).of_columns(&description, method, &columns, length));
    let mut found = result?;
    found.hints.extend(reference(&description, text, &settings));
    estimated(py, found)
}

/// The estimates of a file: a table, a recording, or a CAN log with its map.
#[pyfunction]
fn estimate_file<'py>(
    py: Python<'py>,
    machine: &str,
    path: &str,
    map: Option<&str>,
    text: Option<&str>,
    settings: Vec<String>,
    method: Option<&str>,
) -> PyResult<EstimateColumns<'py>> {
    let machine = self::machine(machine)?;
    let own = if text.is_none() {
        recorded_description(path)?
    } else {
        None
    };
    let description = described(machine, text.or(own.as_deref()), &settings)?;
    let result = py.detach(|| {
        let map = map
            .map(|map| Map::read(Path::new(map)))
            .transpose()
            .map_err(refused)?;
        kind(&description).of_file(&description, method, Path::new(path), map.as_ref())
    });
    let mut found = result?;
    found
        .hints
        .extend(reference(&description, text.or(own.as_deref()), &settings));
    estimated(py, found)
}

/// The description in a recording of heft: a file of any name, or the folder of a run.
fn recorded_description(path: &str) -> PyResult<Option<String>> {
    let path = Path::new(path);
    // What cannot be read is named where its rows are read.
    if !Kind::of(path).is_ok_and(|kind| kind == Kind::Recording) {
        return Ok(None);
    }
    let reader = Reader::open(path).map_err(refused)?;
    Ok(reader.metadata().get("description").cloned())
}

fn estimated(py: Python<'_>, found: Estimates) -> PyResult<EstimateColumns<'_>> {
    let Estimates {
        columns,
        refused,
        rows,
        lacks,
        hints,
    } = found;
    let columns = columns
        .into_iter()
        .map(|(name, unit, values)| to_python(py, name, unit, "", values));
    let columns = PyList::new(py, columns.collect::<PyResult<Vec<_>>>()?)?;
    Ok((columns, refused, rows, words(&lacks), hints))
}

/// The doubles of an array.
fn numbers(bytes: &[u8]) -> Vec<f64> {
    let words = bytes
        .chunks_exact(8)
        .map(|b| <[u8; 8]>::try_from(b).unwrap_or_default());
    words.map(f64::from_le_bytes).collect()
}

/// `(name, unit, meaning, (kind, content))`.
fn to_python<'py>(
    py: Python<'py>,
    name: &str,
    unit: &str,
    meaning: &str,
    values: Values,
) -> PyResult<Bound<'py, PyTuple>> {
    let bytes = |bytes: &[u8]| PyBytes::new(py, bytes);
    let content = match values {
        Values::Numbers(x) => {
            let x: Vec<u8> = x.iter().flat_map(|x| x.to_le_bytes()).collect();
            ("numbers", bytes(&x)).into_pyobject(py)?
        }
        Values::Flags(x) => {
            let x: Vec<u8> = x.into_iter().map(u8::from).collect();
            ("flags", bytes(&x)).into_pyobject(py)?
        }
        Values::Words(codes, words) => ("words", (bytes(&codes), words)).into_pyobject(py)?,
    };
    (name, unit, meaning, content).into_pyobject(py)
}

/// The columns of a machine's estimates: name, unit, what they hold.
#[pyfunction]
fn header(machine: &str) -> PyResult<Vec<(&'static str, &'static str, &'static str)>> {
    let description = Description::default_of(self::machine(machine)?);
    let header = kind(&description).header();
    let word = |kind| match kind {
        frame::Kind::Number => "float",
        frame::Kind::Flag => "bool",
        frame::Kind::Method => "method",
        frame::Kind::Reason => "reason",
    };
    Ok(header
        .into_iter()
        .map(|(name, unit, kind)| (name, unit, word(kind)))
        .collect())
}

/// Names and words of a machine's reasons.
#[pyfunction]
fn reasons(machine: &str) -> PyResult<Vec<(&'static str, &'static str)>> {
    Ok(kind(&Description::default_of(self::machine(machine)?))
        .reasons()
        .to_vec())
}

/// The methods of a machine.
#[pyfunction]
fn methods(machine: &str) -> PyResult<Vec<&'static str>> {
    let pipeline = Pipeline::of(self::machine(machine)?);
    Ok(pipeline
        .stages
        .iter()
        .flat_map(|s| s.methods())
        .copied()
        .collect())
}

/// The name among these that is nearest to a word, if one is near.
#[pyfunction]
fn nearest(word: &str, names: Vec<String>) -> Option<String> {
    config::nearest(word, names.iter().map(String::as_str)).map(str::to_owned)
}

/// What a truck is called, as the number that a table has for it.
#[pyfunction]
fn label(text: &str) -> f64 {
    recording::csv::label(text)
}

/// Names of channels with their columns, missing and damaged parts of the recording as text, and its description.
type RecordedChannels<'py> = (Bound<'py, PyList>, Vec<String>, Option<String>);

#[pyfunction]
fn read<'py>(py: Python<'py>, path: &str) -> PyResult<RecordedChannels<'py>> {
    let reader = Reader::open(path).map_err(refused)?;
    let channels = PyList::empty(py);
    for channel in reader.channels() {
        channels.append((channel, recorded(py, &reader, channel)?))?;
    }
    let description = reader.metadata().get("description").cloned();
    Ok((channels, words(&reader.lacks()), description))
}

fn words(lacks: &Lacks) -> Vec<String> {
    lacks.all().into_iter().map(str::to_owned).collect()
}

fn recorded<'py>(
    py: Python<'py>,
    reader: &Reader,
    channel: &str,
) -> PyResult<Vec<Bound<'py, PyTuple>>> {
    let columns = frame::channel(reader, channel).map_err(refused)?;
    let verdict = frame::verdict(channel, &columns);
    let by_name = |name: &str| verdict.iter().any(|v| v.name == name);
    let numbers = columns
        .into_iter()
        .filter(|column| !by_name(&column.field.name));
    let numbers = numbers.map(|column| {
        let bytes: Vec<u8> = match column.field.kind {
            NumberType::F64 => column
                .values
                .iter()
                .flat_map(|v| v.as_f64().to_le_bytes())
                .collect(),
            NumberType::U32 => column
                .values
                .iter()
                .flat_map(|v| word(*v).to_le_bytes()[..4].to_vec())
                .collect(),
            NumberType::U64 => column
                .values
                .iter()
                .flat_map(|v| word(*v).to_le_bytes())
                .collect(),
        };
        let kind = match column.field.kind {
            NumberType::F64 => "numbers",
            NumberType::U32 => "u4",
            NumberType::U64 => "u8",
        };
        let content = (kind, PyBytes::new(py, &bytes));
        (
            column.field.name,
            column.field.unit,
            column.meaning,
            content,
        )
            .into_pyobject(py)
    });
    let mut all: Vec<Bound<'py, PyTuple>> = numbers.collect::<PyResult<_>>()?;
    for v in verdict.clone() {
        all.push(to_python(py, &v.name, "", v.meaning, v.values)?);
    }
    Ok(all)
}

/// A count or bits.
fn word(value: Value) -> u64 {
    match value {
        Value::U32(v) => u64::from(v),
        Value::U64(v) => v,
        Value::F64(_) => 0,
    }
}

type Fields = Vec<(&'static str, &'static str, &'static str, &'static str)>;

/// The messages with their fields: name, unit, meaning, type.
#[pyfunction]
fn schema() -> Vec<(&'static str, Fields)> {
    let kind = |kind| match kind {
        NumberType::F64 => "f64",
        NumberType::U32 => "u32",
        NumberType::U64 => "u64",
    };
    let mut all: Vec<(&'static str, Fields)> = Vec::new();
    for message in channels::all().map(|channel| channel.payload.shape()) {
        if !all.iter().any(|(name, _)| *name == message.name) {
            let fields = message.fields.iter();
            let fields = fields.map(|f| (f.name, f.unit, f.doc.trim(), kind(f.kind)));
            all.push((message.name, fields.collect()));
        }
    }
    all
}
