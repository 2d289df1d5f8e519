//! The native part of the Python package `heft`: the steps of the pipeline on columns, recordings as
//! columns, the tables of messages. Numbers cross the border as the bytes of their array.

use config::Description;
use messages::channels::{self, Visitor};
use messages::{Envelope, ExcavatorEstimate, NumberType, LoaderEstimate, Machine, Message, Value};
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList, PyTuple};
use recording::Reader;
use recording::csv::Estimate;
use recording::frame::{self, NamedColumn, Values};
use steps::stages::Pipeline;

create_exception!(_heft, HeftError, PyValueError, "What is wrong, where, and what to do about it.");

fn refused(error: impl std::fmt::Display) -> PyErr {
    HeftError::new_err(error.to_string())
}

#[pymodule]
fn _heft(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("HeftError", m.py().get_type::<HeftError>())?;
    m.add_function(wrap_pyfunction!(signals, m)?)?;
    m.add_function(wrap_pyfunction!(estimate, m)?)?;
    m.add_function(wrap_pyfunction!(description, m)?)?;
    m.add_function(wrap_pyfunction!(read, m)?)?;
    m.add_function(wrap_pyfunction!(schema, m)?)
}

fn machine(name: &str) -> PyResult<Machine> {
    Machine::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Machine::ALL.iter().map(|m| m.name()).collect();
        refused(format!("there is no machine {name}; machines are {}", known.join(", ")))
    })
}

/// Columns that samples of a machine can have.
#[pyfunction]
fn signals(machine: &str) -> PyResult<Vec<String>> {
    Ok(frame::signals_of(self::machine(machine)?))
}

/// A description: the text, or the defaults, and then the keys that are set one by one.
fn described(machine: Machine, text: Option<&str>, settings: &[String]) -> PyResult<Description> {
    let mut description = match text {
        Some(text) => Description::parse(text, "config", Some(machine)).map_err(refused)?,
        None => Description::default_of(machine),
    };
    if description.machine() != machine {
        let other = description.machine().name();
        return Err(refused(format!("the description is for a {other}, not a {}", machine.name())));
    }
    description.set_all(settings).map_err(refused)?;
    Ok(description)
}

#[pyfunction]
fn description(machine: &str, text: Option<&str>, settings: Vec<String>) -> PyResult<String> {
    Ok(described(self::machine(machine)?, text, &settings)?.to_toml())
}

#[pyfunction]
fn estimate<'py>(
    py: Python<'py>,
    machine: &str,
    columns: Vec<(String, Bound<'py, PyBytes>)>,
    text: Option<&str>,
    settings: Vec<String>,
    method: Option<&str>,
) -> PyResult<Bound<'py, PyList>> {
    let description = described(self::machine(machine)?, text, &settings)?;
    let columns: Vec<(&str, Vec<f64>)> = columns
        .iter()
        .map(|(name, bytes)| (name.as_str(), numbers(bytes.as_bytes())))
        .collect();
    let pipeline = Pipeline::of(description.machine());
    let main = pipeline.stage(pipeline.main).and_then(|s| s.methods().first().copied());
    let method = method.or(main).unwrap_or_default();
    let result = py.detach(|| match &description {
        Description::Excavator(d) => {
            let rows = frame::rows::<messages::ExcavatorSensors>(&columns).map_err(refused)?;
            if let Some((first, _)) = rows.first() {
                steps::excavator::check_columns(d, method, first).map_err(refused)?;
            }
            run::<_, _, ExcavatorEstimate>(&description, method, &rows)
        }
        Description::Loader(_) => {
            let rows = frame::rows::<messages::LoaderSensors>(&columns).map_err(refused)?;
            run::<_, _, LoaderEstimate>(&description, method, &rows)
        }
    })?;
    let columns = result.into_iter().map(|(name, unit, values)| to_python(py, name, unit, "", values));
    PyList::new(py, columns.collect::<PyResult<Vec<_>>>()?)
}

/// The doubles of an array.
fn numbers(bytes: &[u8]) -> Vec<f64> {
    let words = bytes.chunks_exact(8).map(|b| <[u8; 8]>::try_from(b).unwrap_or_default());
    words.map(f64::from_le_bytes).collect()
}

/// The stages that lead to a method's estimate, as `heft estimate` runs them.
fn run<S: Message, T, E: Estimate>(
    description: &Description,
    method: &str,
    rows: &[(S, T)],
) -> PyResult<Vec<NamedColumn>> {
    let pipeline = Pipeline::of(description.machine());
    let stage = pipeline.with_method(method);
    let stage = stage.ok_or_else(|| refused(pipeline.unknown(method)))?;
    let mut messages: Vec<Envelope> = rows.iter().map(|(s, _)| s.envelope()).collect();
    for row in pipeline.way_to(stage) {
        let mut step = row.start(description, method).map_err(refused)?;
        messages = messages.iter().filter_map(|m| step.answer(m)).collect();
    }
    let estimates: Vec<E> = messages.iter().filter_map(E::inside).copied().collect();
    Ok(frame::columns_of(&estimates))
}

/// `(name, unit, meaning, (kind, content))`.
fn to_python<'py>(
    py: Python<'py>,
    name: &str,
    unit: &str,
    meaning: &str,
    values: Values,
) -> PyResult<Bound<'py, PyTuple>> {
    let bytes = |bytes: Vec<u8>| PyBytes::new(py, &bytes).into_any();
    let (kind, content) = match values {
        Values::Numbers(x) => ("numbers", bytes(x.iter().flat_map(|x| x.to_le_bytes()).collect())),
        Values::Flags(x) => ("flags", bytes(x.into_iter().map(u8::from).collect())),
        Values::Words(x) => ("words", PyList::new(py, x)?.into_any()),
    };
    (name, unit, meaning, (kind, content)).into_pyobject(py)
}

/// One channel as columns.
#[pyfunction]
fn read<'py>(py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyList>> {
    let reader = Reader::open(path).map_err(refused)?;
    let channels = PyList::empty(py);
    for channel in reader.channels() {
        channels.append((channel, recorded(py, &reader, channel)?))?;
    }
    Ok(channels)
}

fn recorded<'py>(
    py: Python<'py>,
    reader: &Reader,
    channel: &str,
) -> PyResult<Vec<Bound<'py, PyTuple>>> {
    let columns = frame::channel(reader, channel).map_err(refused)?;
    let columns = columns.into_iter().map(|column| {
        let bytes: Vec<u8> = match column.field.kind {
            NumberType::F64 => column.values.iter().flat_map(|v| v.as_f64().to_le_bytes()).collect(),
            NumberType::U32 => column.values.iter().flat_map(|v| word(*v).to_le_bytes()[..4].to_vec()).collect(),
            NumberType::U64 => column.values.iter().flat_map(|v| word(*v).to_le_bytes()).collect(),
        };
        let kind = match column.field.kind {
            NumberType::F64 => "numbers",
            NumberType::U32 => "u4",
            NumberType::U64 => "u8",
        };
        let content = (kind, PyBytes::new(py, &bytes));
        (column.field.name, column.field.unit, column.meaning, content).into_pyobject(py)
    });
    columns.collect()
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
    struct Tell;
    impl Visitor for Tell {
        type Output = (&'static str, Fields);
        fn visit<M: Message>(self) -> Self::Output {
            let kind = |kind| match kind {
                NumberType::F64 => "f64",
                NumberType::U32 => "u32",
                NumberType::U64 => "u64",
            };
            let fields = M::FIELDS.iter().map(|f| (f.name, f.unit, f.doc.trim(), kind(f.kind)));
            (M::NAME, fields.collect())
        }
    }
    let mut all: Vec<(&'static str, Fields)> = Vec::new();
    for channel in channels::all() {
        let message = channel.payload.visit(Tell);
        if !all.iter().any(|(name, _)| *name == message.0) {
            all.push(message);
        }
    }
    all
}
