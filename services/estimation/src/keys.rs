//! Settings as a description names them: every key with its unit, range, default and text stands
//! in one table, and the structure that the algorithms read is made by that table.
//!
//! No allocation: a reader of files brings the text, this module says what a key takes.

use core::ops::Deref;

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
    /// A list of at most [`Numbers::MOST`] numbers; one number counts as a list of one.
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

impl Range {
    /// Nothing of a machine is nearer to zero, in SI units, than this and not zero: squares of such a number vanish.
    pub const TINY: f64 = 1e-18;

    /// Whether a number is too near to zero to mean anything.
    #[must_use]
    pub fn is_tiny(number: f64) -> bool {
        number != 0.0 && number.abs() < Self::TINY
    }

    /// Whether it holds a number.
    fn holds(self, number: f64) -> bool {
        (self.low..=self.high).contains(&number) && !Self::is_tiny(number)
    }
}

/// One key of a description.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Name within its table.
    pub name: &'static str,
    /// Name with its table, as `--set` takes it.
    pub path: &'static str,
    /// SI unit, "" for pure numbers and words.
    pub unit: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// What it holds.
    pub form: Form,
    /// For numbers, and each number of a list.
    pub range: Option<Range>,
}

/// A short list of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Numbers {
    values: [f64; Self::MOST],
    length: usize,
}

impl Numbers {
    /// It cannot be longer.
    pub const MOST: usize = 8;

    /// No number.
    pub const EMPTY: Self = Self {
        values: [0.0; Self::MOST],
        length: 0,
    };

    /// The numbers as a list; `None` if there are too many.
    pub fn new(numbers: &[f64]) -> Option<Self> {
        let mut list = Self::EMPTY;
        list.values
            .get_mut(..numbers.len())?
            .copy_from_slice(numbers);
        list.length = numbers.len();
        Some(list)
    }
}

impl Deref for Numbers {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values[..self.length]
    }
}

/// Value of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// Number or count.
    Number(f64),
    /// An optional number that is not given.
    None,
    /// Flag.
    Flag(bool),
    /// Choice.
    Word(&'a str),
    /// List of numbers.
    Numbers(Numbers),
}

impl Value<'_> {
    /// The first number of the value that lies outside `range`.
    pub fn outside(&self, range: Range) -> Option<f64> {
        let outside = |x: &f64| !range.holds(*x);
        match self {
            Self::Number(x) => Some(*x).filter(outside),
            Self::Numbers(list) => list.iter().copied().find(outside),
            Self::None | Self::Flag(_) | Self::Word(_) => None,
        }
    }
}

/// A type that a key can have.
pub trait Setting: Sized {
    /// What it holds.
    const FORM: Form;
    /// As a value.
    fn to_value(&self) -> Value<'static>;
    /// From a value; `None` if it does not fit the form.
    fn from_value(value: &Value) -> Option<Self>;
}

impl Setting for f64 {
    const FORM: Form = Form::Number;
    fn to_value(&self) -> Value<'static> {
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
    fn to_value(&self) -> Value<'static> {
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
    fn to_value(&self) -> Value<'static> {
        Value::Number(*self as f64)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(x) if *x >= 0.0 && *x % 1.0 == 0.0 => Some(*x as usize),
            _ => None,
        }
    }
}

impl Setting for bool {
    const FORM: Form = Form::Flag;
    fn to_value(&self) -> Value<'static> {
        Value::Flag(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Flag(x) => Some(*x),
            _ => None,
        }
    }
}

impl Setting for Numbers {
    const FORM: Form = Form::Numbers;
    fn to_value(&self) -> Value<'static> {
        Value::Numbers(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Numbers(list) => Some(*list),
            Value::Number(x) => Self::new(&[*x]),
            _ => None,
        }
    }
}

impl<const N: usize> Setting for [f64; N] {
    const FORM: Form = Form::List(N);
    fn to_value(&self) -> Value<'static> {
        Value::Numbers(Numbers::new(self).unwrap_or(Numbers::EMPTY))
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Numbers(list) => Self::try_from(&**list).ok(),
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
    fn get(&self, index: usize) -> Option<Value<'static>>;
    /// Sets key `index`; false if there is none or the value does not fit its form. The range is
    /// not looked at.
    fn set(&mut self, index: usize, value: &Value) -> bool;

    /// The first number that is NaN or outside the range of its key: the path of that key, the number, the range.
    fn outside(&self) -> Option<(&'static str, f64, Range)> {
        let number = |(index, key): (usize, &Key)| {
            let range = key.range?;
            Some((key.path, self.get(index)?.outside(range)?, range))
        };
        self.keys().iter().enumerate().find_map(number)
    }
}

/// Defines a table together with its keys.
macro_rules! table {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident, $table:literal {
            $(
                $(#[doc = $field_doc:literal])+
                $field:ident: $type:ty = $default:expr, $unit:tt $(, $low:literal to $high:literal)?;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name {
            $( $(#[doc = $field_doc])+ #[doc = $crate::keys::unit!($unit)] pub $field: $type, )*
        }

        impl $name {
            /// Every key at its default.
            pub const DEFAULT: Self = Self { $( $field: $default, )* };
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl $crate::keys::Table for $name {
            fn name(&self) -> &'static str {
                $table
            }
            fn keys(&self) -> &'static [$crate::keys::Key] {
                const KEYS: &[$crate::keys::Key] = &[$( $crate::keys::Key {
                    name: stringify!($field),
                    path: concat!($table, ".", stringify!($field)),
                    unit: $unit,
                    doc: concat!($($field_doc),+),
                    form: <$type as $crate::keys::Setting>::FORM,
                    range: $crate::keys::range!($($low to $high)?),
                } ),*];
                KEYS
            }
            fn get(&self, index: usize) -> Option<$crate::keys::Value<'static>> {
                let values = [$( $crate::keys::Setting::to_value(&self.$field) ),*];
                values.into_iter().nth(index)
            }
            fn set(&mut self, index: usize, value: &$crate::keys::Value) -> bool {
                let mut _at = 0;
                $(
                    if index == _at {
                        return <$type as $crate::keys::Setting>::from_value(value)
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

/// The unit in words; nothing for pure numbers.
macro_rules! unit {
    ("") => {
        ""
    };
    ($unit:tt) => {
        concat!(" Unit: ", $unit, ".")
    };
}

macro_rules! range {
    () => {
        None
    };
    ($low:literal to $high:literal) => {
        Some($crate::keys::Range {
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
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum $name { $( $(#[doc = $variant_doc])+ $variant, )+ }

        impl $crate::keys::Setting for $name {
            const FORM: $crate::keys::Form = $crate::keys::Form::Choice(&[$($word),+]);
            fn to_value(&self) -> $crate::keys::Value<'static> {
                $crate::keys::Value::Word(match self { $( Self::$variant => $word, )+ })
            }
            fn from_value(value: &$crate::keys::Value) -> Option<Self> {
                match value {
                    $( $crate::keys::Value::Word($word) => Some(Self::$variant), )+
                    _ => None,
                }
            }
        }
    };
}

pub(crate) use {choice, range, table, unit};
