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

/// The object behind an importer's handle.
struct Instance {
    model: Box<dyn Model>,
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
unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> c_int {
    // SAFETY: the importer's promise.
    unsafe {
        with(instance, |instance| match instance.model.start() {
            Ok(()) => true,
            Err(what) => {
                instance.tell(ERROR, &what);
                false
            }
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> c_int {
    // SAFETY: the importer's promise.
    unsafe {
        with(instance, |instance| {
            instance.model.reset();
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
            if let Some(last) = last_time.as_mut() {
                *last = time + length;
            }
            instance.warn();
            let is_done = instance.model.step(time, length);
            if !is_done {
                instance.tell(ERROR, "a step before the initialization has ended: call fmi3ExitInitializationMode first");
            }
            is_done
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
                    (0..count).all(|i| {
                        let (reference, value) = (references.add(i).read(), values.add(i).read());
                        let is_set = instance.model.$write(reference, value);
                        if !is_set {
                            instance.tell(ERROR, &not_set(reference, &format!("{value:?}")));
                        }
                        is_set
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

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, state: *mut *mut c_void) -> c_int {
    if state.is_null() {
        return ERROR;
    }
    // SAFETY: the importer's promise; a state that it passes in is one of ours, or null.
    unsafe {
        with(instance, |instance| {
            let old = state.read().cast::<Box<dyn Model>>();
            if !old.is_null() {
                drop(Box::from_raw(old));
            }
            state.write(Box::into_raw(Box::new(instance.model.copy())).cast());
            true
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: the importer's promise; the state is one of ours, or null.
    unsafe {
        with(instance, |instance| {
            match state.cast::<Box<dyn Model>>().as_ref() {
                Some(model) => instance.model = model.copy(),
                None => return false,
            }
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
            drop(Box::from_raw(state.cast::<Box<dyn Model>>()));
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

always!(OK; fmi3SetDebugLogging, fmi3EnterInitializationMode, fmi3Terminate);

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

    #[test]
    fn what_is_refused_is_said() {
        let mut said = Vec::<String>::new();
        let mut instance = Instance {
            model: Box::new(Variables::<Excavator>::default()),
            log: Some(keep),
            environment: (&raw mut said).cast(),
            is_warned: false,
        };
        let handle: *mut c_void = (&raw mut instance).cast();
        let none = std::ptr::null_mut;
        let mut value = 0.0;
        // SAFETY: the instance and each array live until the end of the test.
        unsafe {
            assert_eq!(
                fmi3DoStep(
                    handle,
                    0.0,
                    0.01,
                    true,
                    none(),
                    none(),
                    none(),
                    std::ptr::null_mut()
                ),
                ERROR
            );
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
}
