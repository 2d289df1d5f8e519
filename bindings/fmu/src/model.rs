//! One machine as the variables of an FMU.

use estimation::keys::Form;
use heft_c::settings::{Settings, completed, places, read, write};
use heft_c::{Machine, bits, sample};

/// First value reference of each kind of variable; the position in the machine's table is added.
pub mod reference {
    /// The time.
    pub const TIME: u32 = 0;
    /// Inputs: signals of a row.
    pub const INPUT: u32 = 1_000;
    /// Flags: the machine has this signal.
    pub const HAS: u32 = 2_000;
    /// Parameters: keys of the settings.
    pub const KEY: u32 = 3_000;
    /// Parameter: the method.
    pub const METHOD: u32 = 4_000;
    /// Outputs: numbers of an answer.
    pub const VALUE: u32 = 5_000;
    /// Outputs: bits of the verdict.
    pub const FLAG: u32 = 6_000;
    /// Outputs: the method estimates this quantity.
    pub const ESTIMATED: u32 = 7_000;
    /// Output: the method at work.
    pub const METHOD_USED: u32 = 8_000;
    /// Output: why it is not trusted.
    pub const REASON: u32 = 8_001;
    /// Flags: this key counts; its default is "none".
    pub const STATED: u32 = 9_000;
}
use reference::{
    ESTIMATED, FLAG, HAS, INPUT, KEY, METHOD, METHOD_USED, REASON, STATED, TIME, VALUE,
};

/// Operations of an importer on a machine of any kind. Setters and getters return whether
/// the variable exists.
pub trait Model {
    /// A number: input, parameter, output or the time.
    fn float(&self, reference: u32) -> Option<f64>;
    /// Sets an input, or before the first step a parameter.
    fn set_float(&mut self, reference: u32, value: f64) -> bool;
    /// A flag.
    fn boolean(&self, reference: u32) -> Option<bool>;
    /// Sets a flag before the first step.
    fn set_boolean(&mut self, reference: u32, value: bool) -> bool;
    /// A method by its number.
    fn enumeration(&self, reference: u32) -> Option<i64>;
    /// Sets the method before the first step.
    fn set_enumeration(&mut self, reference: u32, value: i64) -> bool;
    /// Sets the time at which the simulation begins \[s\].
    fn begin(&mut self, time: f64);
    /// Makes the estimator from the parameters.
    ///
    /// # Errors
    /// Which parameter is not valid, and why.
    fn start(&mut self) -> Result<(), String>;
    /// Takes the inputs as the row of this time \[s\], and advances to the end of the step; false before [`Model::start`].
    fn step(&mut self, time: f64, length: f64) -> bool;
    /// Inputs with a value that are not declared as connected, and keys with a value that are not declared as counting: the flags to be
    /// set, because these values are ignored.
    fn ignored(&self) -> Vec<String>;
    /// Resets to the start values.
    fn reset(&mut self);
    /// A copy of the whole state.
    fn copy(&self) -> Box<dyn Model>;
}

/// A machine and the values of its variables.
#[derive(Clone)]
pub struct Variables<M: Machine> {
    time: f64,
    inputs: Vec<f64>,
    columns: u32,
    keys: Vec<f64>,
    /// Keys whose default is "none", and whether each counts.
    unstated: Vec<Unstated>,
    stated: Vec<bool>,
    method: usize,
    machine: Option<M>,
    values: Vec<f64>,
    flags: u32,
    estimated: u32,
    method_used: usize,
    reason: u32,
}

impl<M: Machine> Default for Variables<M> {
    fn default() -> Self {
        let mut keys = Vec::new();
        write(&M::Settings::default(), |_, number| keys.push(number));
        let unstated = unstated(&M::Settings::default());
        for key in &unstated {
            keys[key.at] = key.start;
        }
        Self {
            time: 0.0,
            inputs: vec![0.0; M::SIGNALS.len()],
            columns: default_columns::<M>(),
            keys,
            stated: vec![false; unstated.len()],
            unstated,
            method: 0,
            machine: None,
            values: vec![0.0; M::VALUES.len()],
            flags: 0,
            estimated: 0,
            method_used: 0,
            reason: 0,
        }
    }
}

/// The signals required for an estimate, the first of each group. Others count only if
/// the user declares them: an importer gives 0 to an input that is not connected.
pub fn default_columns<M: Machine>() -> u32 {
    let required = M::REQUIRED.iter().filter_map(|group| group.first());
    let position = |name: &&str| M::SIGNALS.iter().position(|s| s.name == *name);
    let found = required.filter_map(position);
    found.fold(0, |all, i| all | 1 << (i - 1))
}

/// A key whose default is "none".
#[derive(Clone)]
pub struct Unstated {
    /// Position of its double.
    pub at: usize,
    /// Its name with its table.
    pub path: &'static str,
    /// Start value until the user states one: no number means "none" in every importer.
    pub start: f64,
}

/// The keys whose default is "none", in their order.
pub fn unstated<S: Settings>(settings: &S) -> Vec<Unstated> {
    let mut numbers = Vec::new();
    write(settings, |_, number| numbers.push(number));
    let is_none = |at: usize, form| matches!(form, Form::OptionalNumber) && numbers[at].is_nan();
    let keys = places(settings).filter(|place| is_none(place.first, place.key.form));
    keys.map(|place| Unstated {
        at: place.first,
        path: place.key.path,
        start: place
            .key
            .range
            .map_or(0.0, |range| 0.0_f64.clamp(range.low, range.high)),
    })
    .collect()
}

/// Position relative to `first` in a table of this length.
fn at(reference: u32, first: u32, length: usize) -> Option<usize> {
    let i = reference.checked_sub(first)? as usize;
    (i < length).then_some(i)
}

impl<M: Machine> Model for Variables<M> {
    fn float(&self, reference: u32) -> Option<f64> {
        if reference == TIME {
            return Some(self.time);
        }
        let input = at(reference, INPUT, self.inputs.len()).map(|i| self.inputs[i]);
        let key = at(reference, KEY, self.keys.len()).map(|i| self.keys[i]);
        let value = at(reference, VALUE, self.values.len()).map(|i| self.values[i]);
        input.or(key).or(value)
    }

    fn set_float(&mut self, reference: u32, value: f64) -> bool {
        if let Some(i) = at(reference, INPUT, self.inputs.len()) {
            self.inputs[i] = value;
            return true;
        }
        match at(reference, KEY, self.keys.len()) {
            Some(i) if self.machine.is_none() => {
                self.keys[i] = value;
                true
            }
            _ => false,
        }
    }

    fn boolean(&self, reference: u32) -> Option<bool> {
        let set = |word: u32, i: usize| word & (1 << i) != 0;
        let has = at(reference, HAS, M::SIGNALS.len()).filter(|i| *i > 0);
        let has = has.map(|i| set(self.columns, i - 1));
        let flag = at(reference, FLAG, M::FLAGS.len()).map(|i| set(self.flags, i));
        let estimated = at(reference, ESTIMATED, M::ESTIMATED.len());
        let stated = at(reference, STATED, self.stated.len()).map(|i| self.stated[i]);
        let estimated = estimated.map(|i| set(self.estimated, i));
        has.or(flag).or(estimated).or(stated)
    }

    fn set_boolean(&mut self, reference: u32, value: bool) -> bool {
        let stated = at(reference, STATED, self.stated.len());
        if let Some(i) = stated.filter(|_| self.machine.is_none()) {
            self.stated[i] = value;
            return true;
        }
        match at(reference, HAS, M::SIGNALS.len()) {
            Some(i) if i > 0 && self.machine.is_none() => {
                let bit = 1 << (i - 1);
                self.columns = if value {
                    self.columns | bit
                } else {
                    self.columns & !bit
                };
                true
            }
            _ => false,
        }
    }

    fn enumeration(&self, reference: u32) -> Option<i64> {
        match reference {
            METHOD => Some(self.method as i64),
            METHOD_USED => Some(self.method_used as i64),
            REASON => Some(i64::from(self.reason)),
            _ => None,
        }
    }

    fn set_enumeration(&mut self, reference: u32, value: i64) -> bool {
        let known = usize::try_from(value)
            .ok()
            .filter(|i| *i < M::METHODS.len());
        match known {
            Some(method) if reference == METHOD && self.machine.is_none() => {
                self.method = method;
                true
            }
            _ => false,
        }
    }

    fn begin(&mut self, time: f64) {
        self.time = time;
    }

    fn start(&mut self) -> Result<(), String> {
        let mut keys = self.keys.clone();
        let unstated = self.unstated.iter().zip(&self.stated);
        for (key, _) in unstated.filter(|(_, is_stated)| !**is_stated) {
            keys[key.at] = f64::NAN;
        }
        let stated = read(|i| keys[i]).map_err(|error| error.to_string())?;
        let settings = completed(stated);
        let machine = M::new(&settings, self.method, self.columns);
        self.machine = Some(machine.map_err(|error| error.to_string())?);
        Ok(())
    }

    fn step(&mut self, time: f64, length: f64) -> bool {
        let Some(machine) = &mut self.machine else {
            return false;
        };
        let mut row = self.inputs.clone();
        row[0] = time;
        for (i, number) in row.iter_mut().enumerate().skip(1) {
            if self.columns & (1 << (i - 1)) == 0 {
                *number = f64::NAN;
            }
        }
        let estimate = machine.step(&sample::<M>(&row));
        for (number, value) in self.values.iter_mut().zip(M::VALUES) {
            *number = (value.get)(&estimate);
        }
        self.flags = bits(M::FLAGS, &estimate);
        self.estimated = bits(M::ESTIMATED, &estimate);
        self.method_used = M::method(&estimate);
        self.reason = M::reason(&estimate);
        self.time = time + length;
        true
    }

    fn ignored(&self) -> Vec<String> {
        let inputs = M::SIGNALS.iter().zip(&self.inputs).enumerate().skip(1);
        let is_ignored = |i: usize, value: f64| {
            value != 0.0 && value.is_finite() && self.columns & (1 << (i - 1)) == 0
        };
        let inputs = inputs.filter(|(i, (_, value))| is_ignored(*i, **value));
        let keys = self.unstated.iter().zip(&self.stated);
        let keys = keys.filter(|(key, is_stated)| !**is_stated && self.keys[key.at] != key.start);
        let flags = inputs.map(|(_, (signal, _))| format!("has.{}", signal.name));
        let keys = keys.map(|(key, _)| format!("stated.{}", key.path));
        flags.chain(keys).collect()
    }

    fn reset(&mut self) {
        *self = Self::default();
    }

    fn copy(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heft_c::Excavator;

    #[test]
    fn a_key_whose_default_is_none_counts_where_it_is_stated() {
        let mut model = Variables::<Excavator>::default();
        let gain = |key: &Unstated| key.path == "sensors.swing_torque_gain_std";
        let i = model.unstated.iter().position(gain).expect("such a key");
        let key = KEY + model.unstated[i].at as u32;
        assert_eq!(model.float(key), Some(0.0));
        assert!(model.ignored().is_empty());
        // Out of its range, but ignored.
        assert!(model.set_float(key, 7.0) && model.start().is_ok());
        assert_eq!(model.ignored(), ["stated.sensors.swing_torque_gain_std"]);
        let mut model = Variables::<Excavator>::default();
        assert!(model.set_float(key, 7.0) && model.set_boolean(STATED + i as u32, true));
        assert_eq!(model.boolean(STATED + i as u32), Some(true));
        assert!(
            model
                .start()
                .is_err_and(|error| error.contains("swing_torque_gain_std"))
        );
        let mut model = Variables::<Excavator>::default();
        assert!(model.set_float(key, 0.02) && model.set_boolean(STATED + i as u32, true));
        assert!(model.start().is_ok() && model.ignored().is_empty());
    }
}
