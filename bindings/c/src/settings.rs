//! A description as an array of doubles: one for each key, for a list its length.
//!
//! Flags are 0 or 1, choices count from 0, NaN is "none" and ends a list.

use core::fmt;

use estimation::keys::{Form, Key, Numbers, Table, Value};
use estimation::{excavator, loader};

/// A description of a machine.
pub trait Settings: Default {
    /// Its table `index`; none past the end.
    fn table(&self, index: usize) -> Option<&dyn Table>;
    /// The same, to write.
    fn table_mut(&mut self, index: usize) -> Option<&mut dyn Table>;
    /// The defaults of a machine of the size that it states.
    #[must_use]
    fn of_its_size(&self) -> Self;
}

/// The tables of a description in their order.
macro_rules! tables {
    ($description:ty: $($index:literal $table:ident),+) => {
        impl Settings for $description {
            fn table(&self, index: usize) -> Option<&dyn Table> {
                match index {
                    $($index => Some(&self.$table),)+
                    _ => None,
                }
            }
            fn table_mut(&mut self, index: usize) -> Option<&mut dyn Table> {
                match index {
                    $($index => Some(&mut self.$table),)+
                    _ => None,
                }
            }
            fn of_its_size(&self) -> Self {
                self.of_its_size()
            }
        }
    };
}

tables!(excavator::keys::Description: 0 machine, 1 geometry, 2 boom_cylinder, 3 sensors, 4 prior, 5 estimator, 6 paper);
tables!(loader::keys::Description: 0 machine, 1 lift_arm, 2 lift_cylinder, 3 sensors, 4 prior, 5 estimator);

/// A key with its place.
#[derive(Clone, Copy)]
pub struct Place {
    /// Table, such as `machine.geometry`.
    pub table: &'static str,
    /// Key within it.
    pub key: &'static Key,
    /// Position of its first double.
    pub first: usize,
    /// Position of the table, and of the key within it.
    at: (usize, usize),
}

impl Place {
    /// Number of its doubles.
    #[must_use]
    pub fn width(&self) -> usize {
        width(self.key.form)
    }
}

fn width(form: Form) -> usize {
    match form {
        Form::List(length) => length,
        Form::Numbers => Numbers::MOST,
        _ => 1,
    }
}

/// All keys in their order.
pub fn places<S: Settings>(settings: &S) -> impl Iterator<Item = Place> + '_ {
    let (mut at, mut first) = ((0, 0), 0);
    core::iter::from_fn(move || {
        loop {
            let table = settings.table(at.0)?;
            let Some(key) = table.keys().get(at.1) else {
                at = (at.0 + 1, 0);
                continue;
            };
            let place = Place {
                table: table.name(),
                key,
                first,
                at,
            };
            first += place.width();
            at.1 += 1;
            return Some(place);
        }
    })
}

/// Calls `put` with the doubles of a description, each with its position.
pub fn write<S: Settings>(settings: &S, mut put: impl FnMut(usize, f64)) {
    for place in places(settings) {
        let table = settings.table(place.at.0);
        let value = table.and_then(|table| table.get(place.at.1));
        for i in 0..place.width() {
            put(
                place.first + i,
                value.map_or(f64::NAN, |value| number(&value, place.key.form, i)),
            );
        }
    }
}

/// Double `i` of a value.
fn number(value: &Value, form: Form, i: usize) -> f64 {
    match (value, form) {
        (Value::Number(x), _) => *x,
        (Value::Flag(on), _) => f64::from(u8::from(*on)),
        (Value::Numbers(list), _) => list.get(i).copied().unwrap_or(f64::NAN),
        (Value::Word(word), Form::Choice(words)) => {
            let found = words.iter().position(|w| w == word);
            found.map_or(f64::NAN, |found| found as f64)
        }
        _ => f64::NAN,
    }
}

/// A double that is not valid for its key.
pub struct Unfit {
    place: Place,
    #[cfg(feature = "std")]
    number: f64,
}

impl fmt::Display for Unfit {
    #[cfg(feature = "std")]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}.{} cannot be {:?}",
            self.place.table, self.place.key.name, self.number
        )?;
        match self.place.key.range {
            Some(range) => write!(f, ", but {:?} to {:?}", range.low, range.high),
            None => Ok(()),
        }
    }

    /// Without numbers: formatting them takes 15 kB of code.
    #[cfg(not(feature = "std"))]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { table, key, .. } = self.place;
        write!(f, "{table}.{} cannot be this number", key.name)
    }
}

/// A description from its doubles.
///
/// # Errors
/// The first key whose doubles are not valid.
pub fn read<S: Settings>(get: impl Fn(usize) -> f64) -> Result<S, Unfit> {
    let defaults = S::default();
    let mut settings = S::default();
    for place in places(&defaults) {
        let mut numbers = [f64::NAN; Numbers::MOST];
        let numbers = &mut numbers[..place.width()];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = get(place.first + i);
        }
        let unfit = Unfit {
            place,
            #[cfg(feature = "std")]
            number: numbers[0],
        };
        let Some(value) = value(place.key.form, numbers) else {
            return Err(unfit);
        };
        let outside = place.key.range.and_then(|range| value.outside(range));
        let table = settings.table_mut(place.at.0);
        if outside.is_some() || !table.is_some_and(|table| table.set(place.at.1, &value)) {
            return Err(unfit);
        }
    }
    Ok(settings)
}

/// A description in which each key with the value of the reference machine gets that of a machine of the stated size. A machine file
/// does the same for keys that it does not state.
pub fn completed<S: Settings>(stated: S) -> S {
    let (plain, sized) = (S::default(), stated.of_its_size());
    let mut all = stated;
    for Place { at, .. } in places(&plain) {
        let of = |settings: &S| settings.table(at.0).and_then(|table| table.get(at.1));
        let is_open = of(&all) == of(&plain);
        if let (true, Some(value), Some(table)) = (is_open, of(&sized), all.table_mut(at.0)) {
            // A default is valid for its key.
            table.set(at.1, &value);
        }
    }
    all
}

/// The value of these doubles.
fn value(form: Form, numbers: &[f64]) -> Option<Value<'static>> {
    let first = numbers[0];
    match form {
        Form::OptionalNumber if first.is_nan() => Some(Value::None),
        Form::Number | Form::OptionalNumber | Form::Count => {
            first.is_finite().then_some(Value::Number(first))
        }
        Form::Flag => (first == 0.0 || first == 1.0).then_some(Value::Flag(first == 1.0)),
        Form::Choice(words) => {
            let index = (0..words.len()).find(|i| *i as f64 == first)?;
            words.get(index).map(|word| Value::Word(word))
        }
        Form::List(_) | Form::Numbers => {
            let end = numbers
                .iter()
                .position(|x| x.is_nan())
                .unwrap_or(numbers.len());
            Numbers::new(&numbers[..end]).map(Value::Numbers)
        }
    }
}

/// Whether this number is valid for the key whose first double is at `first`.
#[must_use]
pub fn can_take<S: Settings>(first: usize, number: f64) -> bool {
    let defaults = S::default();
    let place = places(&defaults).find(|place| place.first == first);
    place.is_some_and(|place| {
        let value = value(place.key.form, &[number]);
        value.is_some_and(|value| place.key.range.and_then(|r| value.outside(r)).is_none())
    })
}

/// Position of the double of the key of this name with its table, such as `sensors.rate`; of a list
/// of variable length its first. A list of fixed length has no single double.
#[must_use]
pub fn position<S: Settings>(path: &[u8]) -> Option<usize> {
    let found = places(&S::default()).find(|place| {
        let rest = path.strip_prefix(place.table.as_bytes());
        rest.and_then(|rest| rest.strip_prefix(b".")) == Some(place.key.name.as_bytes())
    });
    let found = found.filter(|place| !matches!(place.key.form, Form::List(_)));
    found.map(|place| place.first)
}
