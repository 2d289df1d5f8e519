//! The functions of FMI 3.0 that an importer calls: all the unsafe code of the FMU.
//!
//! The same library serves both machines: the instantiation token identifies the machine. Functions that a co-simulation
//! unit without events, clocks and partial derivatives need not support return `fmi3Error`.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use heft_c::{Excavator, Loader};

use crate::description::token;
use crate::model::{Model, Variables};

const OK: c_int = 0;
const WARNING: c_int = 1;
const ERROR: c_int = 3;

type Log = Option<unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char)>;

/// State of an instance in the standard's state machine.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Instantiated,
    Initialization,
    Step,
    Terminated,
}

/// The object behind an importer's handle.
struct Instance {
    model: Box<dyn Model>,
    state: State,
    log: Log,
    environment: *mut c_void,
    /// The warning on ignored inputs was given.
    is_warned: bool,
}

impl Instance {
    /// Warns once of inputs that change and are not declared as connected.
    fn warn(&mut self) {
        let ignored = match self.is_warned {
            true => Vec::new(),
            false => self.model.ignored(),
        };
        if !ignored.is_empty() {
            self.is_warned = true;
            let all = ignored.join(", ");
            self.tell(
                WARNING,
                &format!("values are ignored, as these are not set to true: {all}"),
            );
        }
    }

    /// Reports an error; false, for `fmi3Error`.
    fn refuse(&self, message: &str) -> bool {
        self.tell(ERROR, message);
        false
    }

    /// Whether `function` may be called in this state; otherwise reports what to call first.
    fn is_in(&self, state: State, function: &str) -> bool {
        if self.state == state {
            return true;
        }
        let first = match (self.state, state) {
            (State::Terminated, _) => "after fmi3Terminate: call fmi3Reset",
            (_, State::Instantiated) => "after the initialization: call fmi3Reset",
            (_, State::Initialization) => {
                "outside of the initialization: call fmi3EnterInitializationMode"
            }
            _ => "before the initialization has ended: call fmi3ExitInitializationMode",
        };
        self.refuse(&format!("{function} {first} first"))
    }

    fn tell(&self, status: c_int, message: &str) {
        if let (Some(log), Ok(text)) = (self.log, CString::new(message)) {
            // SAFETY: the importer's own callback with its own environment and C strings.
            unsafe {
                log(
                    self.environment,
                    status,
                    match status {
                        WARNING => c"logStatusWarning".as_ptr(),
                        _ => c"logStatusError".as_ptr(),
                    },
                    text.as_ptr(),
                )
            };
        }
    }
}

/// Runs `body` on an instance; a panic or a false becomes `fmi3Error`.
///
/// # Safety
/// `instance` is null or comes from [`fmi3InstantiateCoSimulation`] and is used by nobody else.
unsafe fn with(instance: *mut c_void, body: impl FnOnce(&mut Instance) -> bool) -> c_int {
    // SAFETY: the caller's promise.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else {
        return ERROR;
    };
    match catch_unwind(AssertUnwindSafe(|| body(instance))) {
        Ok(true) => OK,
        _ => ERROR,
    }
}

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    instantiation_token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediates: usize,
    environment: *mut c_void,
    log: Log,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    if instantiation_token.is_null() {
        return std::ptr::null_mut();
    }
    // SAFETY: the importer gives a C string.
    let given = unsafe { CStr::from_ptr(instantiation_token) };
    let model: Box<dyn Model> = match given.to_str() {
        Ok(text) if text == token::<Excavator>() => Box::new(Variables::<Excavator>::default()),
        Ok(text) if text == token::<Loader>() => Box::new(Variables::<Loader>::default()),
        _ => return std::ptr::null_mut(),
    };
    let instance = Instance {
        model,
        state: State::Instantiated,
        log,
        environment,
        is_warned: false,
    };
    Box::into_raw(Box::new(instance)).cast()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: made by `Box::into_raw` above, and given back once.
        drop(unsafe { Box::from_raw(instance.cast::<Instance>()) });
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: bool,
    _stop_time: f64,
) -> c_int {
    // SAFETY: the importer's promise.
    unsafe {
        with(instance, |instance| {
            let may = instance.is_in(State::Instantiated, "fmi3EnterInitializationMode");
            if may {
                instance.model.begin(start_time);
                instance.state = State::Initialization;
            }
            may
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> c_int {
    // SAFETY: the importer's promise.
    unsafe {
        with(instance, |instance| {
            if !instance.is_in(State::Initialization, "fmi3ExitInitializationMode") {
                return false;
            }
            match instance.model.start() {
                Ok(()) => {
                    instance.state = State::Step;
                    true
                }
                Err(what) => instance.refuse(&what),
            }
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> c_int {
    // SAFETY: the importer's promise.
    unsafe {
        with(instance, |instance| {
            let may = instance.is_in(State::Step, "fmi3Terminate");
            if may {
                instance.state = State::Terminated;
            }
            may
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> c_int {
    // SAFETY: the importer's promise.
    unsafe {
        with(instance, |instance| {
            instance.model.reset();
            instance.state = State::Instantiated;
            true
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    time: f64,
    length: f64,
    _no_set_state: bool,
    event_needed: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_time: *mut f64,
) -> c_int {
    // SAFETY: the importer's promise; each pointer is null or its own.
    unsafe {
        with(instance, |instance| {
            for flag in [event_needed, terminate, early_return] {
                if let Some(flag) = flag.as_mut() {
                    *flag = false;
                }
            }
            if !instance.is_in(State::Step, "fmi3DoStep") {
                return false;
            }
            if !(time.is_finite() && length.is_finite() && length > 0.0) {
                return instance.refuse(&format!(
                    "fmi3DoStep at {time} s by {length} s: the time must be finite, the length finite and above 0"
                ));
            }
            if let Some(last) = last_time.as_mut() {
                *last = time + length;
            }
            instance.warn();
            instance.model.step(time, length)
        })
    }
}

/// Message on a variable that did not accept a value.
fn not_set(reference: u32, value: &str) -> String {
    format!(
        "the variable with the value reference {reference} does not take {value}: parameters, `has...` and `method` are fixed \
         once the initialization has ended, and outputs cannot be set"
    )
}

/// Message on a variable that does not exist.
fn not_there(reference: u32, function: &str) -> String {
    format!(
        "{function}: no variable of this type has the value reference {reference}; take it from the modelDescription.xml of this unit"
    )
}

/// Getter and setter of one type of variables.
macro_rules! access {
    ($type:ty, $get:ident, $set:ident, $read:ident, $write:ident) => {
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $get(
            instance: *mut c_void,
            references: *const u32,
            count: usize,
            values: *mut $type,
            value_count: usize,
        ) -> c_int {
            if count != value_count || (count > 0 && (references.is_null() || values.is_null())) {
                return ERROR;
            }
            // SAFETY: the importer's promise; both arrays have `count` elements.
            unsafe {
                with(instance, |instance| {
                    (0..count).all(|i| {
                        let reference = references.add(i).read();
                        let value = instance.model.$read(reference);
                        match value {
                            Some(value) => values.add(i).write(value),
                            None => instance.tell(ERROR, &not_there(reference, stringify!($get))),
                        }
                        value.is_some()
                    })
                })
            }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn $set(
            instance: *mut c_void,
            references: *const u32,
            count: usize,
            values: *const $type,
            value_count: usize,
        ) -> c_int {
            if count != value_count || (count > 0 && (references.is_null() || values.is_null())) {
                return ERROR;
            }
            // SAFETY: the importer's promise; both arrays have `count` elements.
            unsafe {
                with(instance, |instance| {
                    if instance.state == State::Terminated {
                        return instance.is_in(State::Step, stringify!($set));
                    }
                    (0..count).all(|i| {
                        let (reference, value) = (references.add(i).read(), values.add(i).read());
                        instance.model.$write(reference, value)
                            || instance.refuse(&not_set(reference, &format!("{value:?}")))
                    })
                })
            }
        }
    };
}

access!(f64, fmi3GetFloat64, fmi3SetFloat64, float, set_float);
access!(bool, fmi3GetBoolean, fmi3SetBoolean, boolean, set_boolean);
access!(
    i64,
    fmi3GetInt64,
    fmi3SetInt64,
    enumeration,
    set_enumeration
);

/// What `fmi3GetFMUState` saves.
type Saved = (Box<dyn Model>, State);

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    if state.is_null() {
        return ERROR;
    }
    // SAFETY: the importer's promise; a state that it passes in is one of ours, or null.
    unsafe {
        with(instance, |instance| {
            let old = state.read().cast::<Saved>();
            if !old.is_null() {
                drop(Box::from_raw(old));
            }
            let saved: Saved = (instance.model.copy(), instance.state);
            state.write(Box::into_raw(Box::new(saved)).cast());
            true
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: the importer's promise; the state is one of ours, or null.
    unsafe {
        with(instance, |instance| {
            let Some((model, state)) = state.cast::<Saved>().as_ref() else {
                return false;
            };
            (instance.model, instance.state) = (model.copy(), *state);
            true
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeFMUState(_instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: the importer's promise; the state is one of ours, or null.
    unsafe {
        if let Some(state) = state.as_mut()
            && !state.is_null()
        {
            drop(Box::from_raw(state.cast::<Saved>()));
            *state = std::ptr::null_mut();
        }
    }
    OK
}

/// Functions without effect: they read none of their arguments.
macro_rules! always {
    ($status:expr; $($name:ident),* $(,)?) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> c_int {
            $status
        }
    )*};
}

always!(OK; fmi3SetDebugLogging);

always!(ERROR;
    fmi3EnterEventMode, fmi3EnterStepMode, fmi3EnterConfigurationMode, fmi3ExitConfigurationMode,
    fmi3GetFloat32, fmi3GetInt8, fmi3GetUInt8, fmi3GetInt16, fmi3GetUInt16, fmi3GetInt32,
    fmi3GetUInt32, fmi3GetUInt64, fmi3GetString, fmi3GetBinary, fmi3GetClock,
    fmi3SetFloat32, fmi3SetInt8, fmi3SetUInt8, fmi3SetInt16, fmi3SetUInt16, fmi3SetInt32,
    fmi3SetUInt32, fmi3SetUInt64, fmi3SetString, fmi3SetBinary, fmi3SetClock,
    fmi3GetNumberOfVariableDependencies, fmi3GetVariableDependencies,
    fmi3SerializedFMUStateSize, fmi3SerializeFMUState, fmi3DeserializeFMUState,
    fmi3GetDirectionalDerivative, fmi3GetAdjointDerivative,
    fmi3GetIntervalDecimal, fmi3GetIntervalFraction, fmi3GetShiftDecimal, fmi3GetShiftFraction,
    fmi3SetIntervalDecimal, fmi3SetIntervalFraction, fmi3SetShiftDecimal, fmi3SetShiftFraction,
    fmi3EvaluateDiscreteStates, fmi3UpdateDiscreteStates, fmi3EnterContinuousTimeMode,
    fmi3CompletedIntegratorStep, fmi3SetTime, fmi3SetContinuousStates,
    fmi3GetContinuousStateDerivatives, fmi3GetEventIndicators, fmi3GetContinuousStates,
    fmi3GetNominalsOfContinuousStates, fmi3GetNumberOfEventIndicators,
    fmi3GetNumberOfContinuousStates, fmi3GetOutputDerivatives, fmi3ActivateModelPartition,
);

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateModelExchange() -> *mut c_void {
    std::ptr::null_mut()
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateScheduledExecution() -> *mut c_void {
    std::ptr::null_mut()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::reference::{INPUT, TIME};

    unsafe extern "C" fn keep(
        environment: *mut c_void,
        _: c_int,
        _: *const c_char,
        text: *const c_char,
    ) {
        // SAFETY: the test's own list, and a C string.
        let (all, text) = unsafe {
            (
                environment.cast::<Vec<String>>().as_mut(),
                CStr::from_ptr(text),
            )
        };
        all.expect("a list")
            .push(text.to_string_lossy().into_owned());
    }

    fn excavator(said: &mut Vec<String>) -> Instance {
        Instance {
            model: Box::new(Variables::<Excavator>::default()),
            state: State::Instantiated,
            log: Some(keep),
            environment: std::ptr::from_mut(said).cast(),
            is_warned: false,
        }
    }

    /// A step of this length at this time.
    ///
    /// # Safety
    /// That of [`fmi3DoStep`].
    unsafe fn step(instance: *mut c_void, time: f64, length: f64) -> c_int {
        let none = std::ptr::null_mut;
        let last = std::ptr::null_mut();
        // SAFETY: the caller's promise, and null pointers.
        unsafe { fmi3DoStep(instance, time, length, true, none(), none(), none(), last) }
    }

    #[test]
    fn what_is_refused_is_said() {
        let mut said = Vec::<String>::new();
        let mut instance = excavator(&mut said);
        let handle: *mut c_void = (&raw mut instance).cast();
        let mut value = 0.0;
        // SAFETY: the instance and each array live until the end of the test.
        unsafe {
            assert_eq!(step(handle, 0.0, 0.01), ERROR);
            assert_eq!(fmi3GetFloat64(handle, &123_456, 1, &mut value, 1), ERROR);
        }
        assert!(
            said[0].contains("fmi3ExitInitializationMode first"),
            "{said:?}"
        );
        assert!(
            said[1].contains(
                "fmi3GetFloat64: no variable of this type has the value reference 123456"
            )
        );
    }

    #[test]
    fn a_step_has_a_length_and_nothing_moves_after_the_end() {
        let mut said = Vec::<String>::new();
        let mut instance = excavator(&mut said);
        let handle: *mut c_void = (&raw mut instance).cast();
        let mut time = f64::NAN;
        // SAFETY: the instance and each array live until the end of the test.
        unsafe {
            assert_eq!(fmi3Terminate(handle), ERROR);
            assert_eq!(fmi3ExitInitializationMode(handle), ERROR);
            let begin = || fmi3EnterInitializationMode(handle, false, 0.0, 5.0, false, 0.0);
            assert_eq!([begin(), fmi3ExitInitializationMode(handle)], [OK; 2]);
            assert_eq!(begin(), ERROR);
            assert_eq!(fmi3GetFloat64(handle, &TIME, 1, &mut time, 1), OK);
            assert_eq!(time.to_bits(), 5.0_f64.to_bits(), "the time of the start");
            for length in [0.0, -0.01, f64::NAN, f64::INFINITY] {
                assert_eq!(step(handle, 5.0, length), ERROR, "{length}");
            }
            assert_eq!(step(handle, f64::NAN, 0.01), ERROR);
            assert_eq!(step(handle, 5.0, 0.01), OK);
            let mut before = std::ptr::null_mut();
            assert_eq!(fmi3GetFMUState(handle, &mut before), OK);
            assert_eq!([fmi3Terminate(handle), fmi3Terminate(handle)], [OK, ERROR]);
            assert_eq!(step(handle, 5.01, 0.01), ERROR);
            assert_eq!(fmi3SetFloat64(handle, &INPUT, 1, &0.0, 1), ERROR);
            assert_eq!(begin(), ERROR);
            // Results can still be read, and a saved state or a reset begins again.
            assert_eq!(fmi3GetFloat64(handle, &TIME, 1, &mut time, 1), OK);
            assert_eq!(fmi3SetFMUState(handle, before), OK);
            assert_eq!(step(handle, 5.01, 0.01), OK);
            assert_eq!(fmi3FreeFMUState(handle, &mut before), OK);
            assert_eq!([fmi3Reset(handle), begin()], [OK; 2]);
        }
        assert_eq!(time.to_bits(), 5.01_f64.to_bits());
        let says = |what: &str| said.iter().filter(|text| text.contains(what)).count();
        assert_eq!(says("finite and above 0"), 5, "{said:?}");
        assert_eq!(says("after fmi3Terminate: call fmi3Reset first"), 4);
    }
}
