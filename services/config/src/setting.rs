use messages::Machine;

use crate::Error;

/// What a key holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// A number.
    Number,
    /// A number, or `"none"`.
    OptionalNumber,
    /// A whole number.
    Count,
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A list of numbers of exactly this length.
    List(usize),
    /// A list of numbers of any length; one number counts as a list of one.
    Numbers,
}

/// Smallest and largest number allowed, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest.
    pub low: f64,
    /// Largest.
    pub high: f64,
}

/// One key of a description.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Name within its table.
    pub name: &'static str,
    /// SI unit, "" for pure numbers and words.
    pub unit: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// What it holds.
    pub form: Form,
    /// For numbers, and each number of a list.
    pub range: Option<Range>,
}

/// Value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Number or count.
    Number(f64),
    /// An optional number that is not given.
    None,
    /// Flag.
    Flag(bool),
    /// Choice.
    Word(String),
    /// List of numbers.
    Numbers(Vec<f64>),
}

impl Value {
    /// The first number of the value that lies outside `range`.
    pub(crate) fn outside(&self, range: Range) -> Option<f64> {
        let outside = |x: &f64| !(range.low..=range.high).contains(x);
        match self {
            Self::Number(x) => Some(*x).filter(outside),
            Self::Numbers(list) => list.iter().copied().find(outside),
            _ => None,
        }
    }
}

/// A type that a key can have.
pub trait Setting: Sized {
    /// What it holds.
    const FORM: Form;
    /// As a value.
    fn to_value(&self) -> Value;
    /// From a value; `None` if it does not fit the form.
    fn from_value(value: &Value) -> Option<Self>;
}

impl Setting for f64 {
    const FORM: Form = Form::Number;
    fn to_value(&self) -> Value {
        Value::Number(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(x) => Some(*x),
            _ => None,
        }
    }
}

impl Setting for Option<f64> {
    const FORM: Form = Form::OptionalNumber;
    fn to_value(&self) -> Value {
        self.map_or(Value::None, Value::Number)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(x) => Some(Some(*x)),
            Value::None => Some(None),
            _ => None,
        }
    }
}

impl Setting for usize {
    const FORM: Form = Form::Count;
    fn to_value(&self) -> Value {
        Value::Number(*self as f64)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(x) if x.fract() == 0.0 && *x >= 0.0 => Some(*x as usize),
            _ => None,
        }
    }
}

impl Setting for bool {
    const FORM: Form = Form::Flag;
    fn to_value(&self) -> Value {
        Value::Flag(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Flag(x) => Some(*x),
            _ => None,
        }
    }
}

impl Setting for Vec<f64> {
    const FORM: Form = Form::Numbers;
    fn to_value(&self) -> Value {
        Value::Numbers(self.clone())
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Numbers(list) => Some(list.clone()),
            Value::Number(x) => Some(vec![*x]),
            _ => None,
        }
    }
}

impl<const N: usize> Setting for [f64; N] {
    const FORM: Form = Form::List(N);
    fn to_value(&self) -> Value {
        Value::Numbers(self.to_vec())
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Numbers(list) => list.as_slice().try_into().ok(),
            _ => None,
        }
    }
}

/// One table of a description.
pub trait Table {
    /// Name, such as `sensors`.
    fn name(&self) -> &'static str;
    /// Its keys, in the order in which they are printed.
    fn keys(&self) -> &'static [Key];
    /// Value of key `index`.
    fn get(&self, index: usize) -> Option<Value>;
    /// Sets key `index`; false if there is none or the value does not fit its form.
    fn set(&mut self, index: usize, value: &Value) -> bool;
}

/// A complete description: a machine's tables.
pub trait Tables: Default + Clone {
    /// Which machine.
    const MACHINE: Machine;
    /// All tables, in the order in which they are printed.
    fn tables(&self) -> Vec<&dyn Table>;
    /// All tables, to write.
    fn tables_mut(&mut self) -> Vec<&mut dyn Table>;
    /// What contradicts itself between keys that are each in range (`file` and `line` left empty).
    fn contradictions(&self) -> Vec<Error>;
}

/// Defines a table together with its keys.
macro_rules! table {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident, $table:literal {
            $(
                $(#[doc = $field_doc:literal])+
                $field:ident: $type:ty = $default:expr, $unit:literal $(, $low:literal to $high:literal)?;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name {
            $( $(#[doc = $field_doc])+ #[doc = concat!(" Unit: ", $unit, ".")] pub $field: $type, )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $( $field: $default, )* }
            }
        }

        impl $crate::Table for $name {
            fn name(&self) -> &'static str {
                $table
            }
            fn keys(&self) -> &'static [$crate::Key] {
                const KEYS: &[$crate::Key] = &[$( $crate::Key {
                    name: stringify!($field),
                    unit: $unit,
                    doc: concat!($($field_doc),+),
                    form: <$type as $crate::Setting>::FORM,
                    range: $crate::setting::range!($($low to $high)?),
                } ),*];
                KEYS
            }
            fn get(&self, index: usize) -> Option<$crate::Value> {
                let values = [$( $crate::Setting::to_value(&self.$field) ),*];
                values.into_iter().nth(index)
            }
            fn set(&mut self, index: usize, value: &$crate::Value) -> bool {
                let mut _at = 0;
                $(
                    if index == _at {
                        return <$type as $crate::Setting>::from_value(value)
                            .map(|v| self.$field = v)
                            .is_some();
                    }
                    _at += 1;
                )*
                false
            }
        }
    };
}

macro_rules! range {
    () => {
        None
    };
    ($low:literal to $high:literal) => {
        Some($crate::Range {
            low: $low,
            high: $high,
        })
    };
}

/// Defines a choice between words.
macro_rules! choice {
    (
        $(#[doc = $doc:literal])*
        pub enum $name:ident { $( $(#[doc = $variant_doc:literal])+ $variant:ident = $word:literal, )+ }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name { $( $(#[doc = $variant_doc])+ $variant, )+ }

        impl $crate::Setting for $name {
            const FORM: $crate::Form = $crate::Form::Choice(&[$($word),+]);
            fn to_value(&self) -> $crate::Value {
                $crate::Value::Word(match self { $( Self::$variant => $word, )+ }.to_owned())
            }
            fn from_value(value: &$crate::Value) -> Option<Self> {
                match value {
                    $( $crate::Value::Word(word) if word == $word => Some(Self::$variant), )+
                    _ => None,
                }
            }
        }
    };
}

/// Gives a machine its tables and the functions of a description.
macro_rules! machine {
    ($name:ident, $machine:expr, [$($table:ident),+]) => {
        impl $crate::Tables for $name {
            const MACHINE: messages::Machine = $machine;
            fn tables(&self) -> Vec<&dyn $crate::Table> {
                vec![$( &self.$table ),+]
            }
            fn tables_mut(&mut self) -> Vec<&mut dyn $crate::Table> {
                vec![$( &mut self.$table ),+]
            }
            fn contradictions(&self) -> Vec<$crate::Error> {
                contradictions(self)
            }
        }

        impl $name {
            /// Reads a description; keys that it does not name keep their defaults.
            ///
            /// # Errors
            /// Everything that is wrong with the text, each with its line.
            pub fn parse(text: &str, file_name: &str) -> Result<Self, $crate::Errors> {
                $crate::parse::parse(text, file_name)
            }

            /// Sets one key, as `--set` does: `sensors.swing_velocity_std=0.008`.
            ///
            /// # Errors
            /// No such key, or a value that it cannot have; the description is then unchanged.
            pub fn set(&mut self, assignment: &str) -> Result<(), $crate::Error> {
                self.set_all(&[assignment])
            }

            /// Sets several keys in their order. Limits that are moved together need not fit one
            /// by one.
            ///
            /// # Errors
            /// As [`Self::set`]; the description is then unchanged.
            pub fn set_all(&mut self, assignments: &[impl AsRef<str>]) -> Result<(), $crate::Error> {
                $crate::parse::set_all(self, assignments)
            }

            /// The whole description with its comments; [`Self::parse`] gives the same value back,
            /// every number to the last bit.
            #[must_use]
            pub fn to_toml(&self) -> String {
                $crate::print::print(self)
            }
        }
    };
}

pub(crate) use {choice, machine, range, table};
