//! An estimator that takes sample by sample.

use std::sync::{Mutex, MutexGuard, PoisonError};

use config::Description;
use messages::fnv64;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyBytes, PyDict, PyString, PyTuple};
use recording::frame::Cell;
use steps::chain::{Chain, chain, last_answer, method};

use crate::kind::{AnyFeed, kind};
use crate::{described, machine, refused};

/// Steps through samples as they come; wrapped by `heft.Estimator`.
#[pyclass(module = "heft._heft", frozen)]
pub struct Estimator {
    description: Description,
    method: String,
    /// Names of the signals, the time first.
    signals: Vec<Py<PyString>>,
    state: Mutex<State>,
}

struct State {
    feed: Box<dyn AnyFeed>,
    chain: Chain,
}

/// First bytes of a state: the version that wrote it.
const HEAD: &str = concat!("heft state ", env!("HEFT_SOURCES"), "\n");
/// Largest state of a stage \[bytes\].
const MOST: usize = 1 << 20;

#[pymethods]
impl Estimator {
    #[new]
    fn new(
        py: Python<'_>,
        kind_of: &str,
        text: Option<&str>,
        settings: Vec<String>,
        signals: Vec<String>,
        asked: Option<&str>,
    ) -> PyResult<Self> {
        let description = described(machine(kind_of)?, text, &settings)?;
        let method = method(description.machine(), asked).to_owned();
        let mut names = vec!["t"];
        names.extend(
            signals
                .iter()
                .map(String::as_str)
                .filter(|name| *name != "t"),
        );
        let feed = kind(&description).feed(&names)?;
        let chain = chain(&description, &method).map_err(refused)?;
        feed.check(&description, &method)?;
        Ok(Self {
            signals: names
                .iter()
                .map(|name| PyString::intern(py, name).unbind())
                .collect(),
            state: Mutex::new(State { feed, chain }),
            description,
            method,
        })
    }

    /// The cells of the estimate of a sample, in the order of `header`.
    fn step<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        values: &Bound<'py, PyDict>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        // Converting numbers may run Python code: never while the state is locked, where it could step again.
        let mut row = Vec::with_capacity(self.signals.len());
        row.push(t);
        let mut taken = 0;
        for name in &self.signals[1..] {
            let value = values.get_item(name)?;
            taken += usize::from(value.is_some());
            row.push(match value.filter(|value| !value.is_none()) {
                None => f64::NAN,
                Some(value) => value
                    .extract()
                    .map_err(|error| PyTypeError::new_err(format!("{name}: {error}")))?,
            });
        }
        if taken != values.len() {
            return Err(self.unknown(values));
        }
        let mut cells = Vec::with_capacity(32);
        {
            let mut state = self.held(py);
            let State { feed, chain } = &mut *state;
            let estimate = last_answer(chain, feed.sample(&row));
            let estimate =
                estimate.ok_or_else(|| refused("the sample has no answer; please report this"))?;
            feed.cells(&estimate, &mut |cell| cells.push(cell));
        }
        let cells = cells.into_iter().map(|cell| match cell {
            Cell::Number(x) => pyo3::types::PyFloat::new(py, x).into_any(),
            Cell::Flag(x) => pyo3::types::PyBool::new(py, x).to_owned().into_any(),
            Cell::Word(x) => PyString::intern(py, x).into_any(),
        });
        PyTuple::new(py, cells.collect::<Vec<_>>())
    }

    /// The complete state, with the identity of its estimator.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let state = self.held(py);
        let mut bytes = HEAD.as_bytes().to_vec();
        let names: Vec<String> = self.signals.iter().map(|s| s.to_string()).collect();
        let machine = self.description.machine().name();
        for text in [
            machine,
            &self.method,
            &names.join(","),
            &self.description.to_toml(),
        ] {
            put(&mut bytes, text.as_bytes());
        }
        bytes.extend(state.feed.count().to_le_bytes());
        for (_, step) in &state.chain {
            put(&mut bytes, &saved(step.as_ref())?);
        }
        let sum = fnv64(&bytes).to_le_bytes();
        bytes.extend(sum);
        Ok(PyBytes::new(py, &bytes))
    }

    /// The estimator that wrote this state.
    #[staticmethod]
    fn from_state(py: Python<'_>, state: &[u8]) -> PyResult<Self> {
        let foreign =
            || refused("these bytes are no state of this version of heft, or damaged; begin anew");
        let (rest, sum) = state.split_last_chunk::<8>().ok_or_else(foreign)?;
        let mut rest = rest.strip_prefix(HEAD.as_bytes()).ok_or_else(foreign)?;
        if *sum != fnv64(&state[..state.len() - 8]).to_le_bytes() {
            return Err(foreign());
        }
        let mut text = || {
            let text = take(&mut rest).and_then(|bytes| std::str::from_utf8(bytes).ok());
            text.map(str::to_owned).ok_or_else(foreign)
        };
        let (machine, method, signals, description) = (text()?, text()?, text()?, text()?);
        let signals = signals.split(',').map(str::to_owned).collect();
        let new = Self::new(
            py,
            &machine,
            Some(&description),
            Vec::new(),
            signals,
            Some(&method),
        )?;
        let (count, mut rest) = rest.split_first_chunk::<8>().ok_or_else(foreign)?;
        {
            let mut state = new.held(py);
            state.feed.go_on_from(u64::from_le_bytes(*count));
            for (_, step) in &mut state.chain {
                let bytes = take(&mut rest).ok_or_else(foreign)?;
                if !step.restore(bytes) {
                    return Err(foreign());
                }
            }
        }
        Ok(new)
    }

    #[getter]
    fn machine(&self) -> &'static str {
        self.description.machine().name()
    }

    #[getter]
    fn method(&self) -> &str {
        &self.method
    }

    #[getter]
    fn signals(&self, py: Python<'_>) -> Vec<Py<PyString>> {
        self.signals[1..].iter().map(|s| s.clone_ref(py)).collect()
    }

    #[getter]
    fn description(&self) -> String {
        self.description.to_toml()
    }
}

impl Estimator {
    /// Locks the state for this thread; a waiting thread releases Python's lock.
    fn held(&self, py: Python<'_>) -> MutexGuard<'_, State> {
        let state = self.state.lock_py_attached(py);
        state.unwrap_or_else(PoisonError::into_inner)
    }

    /// The error for a value whose name is no signal.
    fn unknown(&self, values: &Bound<'_, PyDict>) -> PyErr {
        let known: Vec<String> = self.signals[1..].iter().map(|s| s.to_string()).collect();
        let given = values
            .keys()
            .iter()
            .map(|k| k.to_string())
            .collect::<Vec<_>>();
        let other = given.iter().find(|name| !known.contains(name));
        let other = other.map_or("", String::as_str);
        refused(format!(
            "{other} is none of the signals of this estimator ({}); name it in signals=[...]",
            known.join(", ")
        ))
    }
}

fn saved(step: &dyn steps::stages::AnyStep) -> PyResult<Vec<u8>> {
    let mut room = vec![0; 1 << 13];
    loop {
        if let Some(length) = step.save(&mut room) {
            room.truncate(length);
            return Ok(room);
        }
        if room.len() >= MOST {
            return Err(refused("this method has no state that can be saved"));
        }
        room.resize(2 * room.len(), 0);
    }
}

/// Appends bytes, preceded by their length.
fn put(into: &mut Vec<u8>, bytes: &[u8]) {
    into.extend((bytes.len() as u64).to_le_bytes());
    into.extend(bytes);
}

/// Takes bytes that are preceded by their length.
fn take<'a>(from: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, rest) = from.split_first_chunk::<8>()?;
    let (bytes, rest) =
        rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    *from = rest;
    Some(bytes)
}
