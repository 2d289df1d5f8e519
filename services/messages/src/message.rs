//! The interface of every payload, and the envelope for any of them.

use core::fmt::Debug;

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Field, Hops, Stamp, Value, Words};

/// Bit of the messages of a machine (in `columns`, `known` or `flags`): made from simulated samples, not from measurements.
pub const SIMULATED: u32 = 1 << 31;

/// A payload of a channel, with its own description.
pub trait Message: ZeroCopySend + Copy + Debug + Default + PartialEq + Send + 'static {
    /// Type name, as iceoryx2 and the recording show it.
    const NAME: &'static str;
    /// Its variant of [`Payload`].
    const PAYLOAD: Payload;
    /// All fields in the order of the structure, those of stamp and hops first.
    const FIELDS: &'static [Field];
    /// Names of the bits or codes in its fields.
    const WORDS: &'static [(&'static str, Words)] = &[];

    /// Identity of the sample.
    fn stamp(&self) -> &Stamp;
    /// Identity of the sample, mutable.
    fn stamp_mut(&mut self) -> &mut Stamp;
    /// Publish times.
    fn hops(&self) -> &Hops;
    /// Publish times, mutable.
    fn hops_mut(&mut self) -> &mut Hops;
    /// Value of field `index` of [`Message::FIELDS`]; `None` past the end.
    fn get(&self, index: usize) -> Option<Value>;
    /// Sets field `index`; false if there is none or the type differs.
    fn set(&mut self, index: usize, value: Value) -> bool;

    /// Whether it was made from simulated samples, see [`SIMULATED`].
    fn is_simulated(&self) -> bool;
    /// Marks it as made from simulated samples.
    fn mark_simulated(&mut self);

    /// The message without its type, for a queue of several types.
    fn envelope(&self) -> crate::Envelope;
    /// The message in an envelope; `None` if it contains another type.
    fn inside(envelope: &crate::Envelope) -> Option<&Self>;

    /// Position of the field called `name`.
    fn index(name: &str) -> Option<usize> {
        Self::FIELDS.iter().position(|f| f.name == name)
    }

    /// Value of the field called `name`.
    fn field(&self, name: &str) -> Option<Value> {
        self.get(Self::index(name)?)
    }

    /// The number in the field called `name`.
    fn number(&self, name: &str) -> Option<f64> {
        self.field(name).map(Value::as_f64)
    }

    /// The bits in the field called `name`; 0 if there is no such field.
    fn bits_of(&self, name: &str) -> u32 {
        match self.field(name) {
            Some(Value::U32(bits)) => bits,
            _ => 0,
        }
    }
}

/// A function that works on any payload type; [`Payload::visit`] calls it with the right one.
pub trait Visitor {
    /// Its result.
    type Output;
    /// Called with the payload type of the channel.
    fn visit<M: Message>(self) -> Self::Output;
}

/// A function that takes a message of any type.
pub trait Receiver {
    /// Its result.
    type Output;
    /// Called with the message in the envelope.
    fn receive<M: Message>(self, message: &M) -> Self::Output;
}

/// A message type as data.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// See [`Message::NAME`].
    pub name: &'static str,
    /// Length of its structure \[bytes\].
    pub size: usize,
    /// See [`Message::FIELDS`].
    pub fields: &'static [Field],
    /// See [`Message::WORDS`].
    pub words: &'static [(&'static str, Words)],
}

impl Shape {
    /// That of a message type.
    pub const fn of<M: Message>() -> Self {
        Self {
            name: M::NAME,
            size: size_of::<M>(),
            fields: M::FIELDS,
            words: M::WORDS,
        }
    }

    /// Position of the field called `name`.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|f| f.name == name)
    }

    /// Names of the bits or codes in the field called `name`.
    pub fn words_of(&self, name: &str) -> Option<&'static Words> {
        Words::of_field(self.words, name)
    }
}

/// Role of a message for its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carries {
    /// The measurements.
    Sensors,
    /// The truth behind the measurements.
    Truth,
    /// The estimates.
    Estimate,
    /// An intermediate result.
    Between,
    /// Common to all processes, of no machine.
    Common,
}

/// All message types with their roles; `payloads!` is called with them.
macro_rules! payloads_of_machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, [$($other:ident),*]; )*) => {
        payloads! {
            $( $sensors: Sensors, $truth: Truth, $( $other: Between, )* $estimate: Estimate, )*
            Health: Common, Credit: Common, Keyframe: Common,
        }
    };
}

macro_rules! payloads {
    ($( $name:ident: $carries:ident, )*) => {
        /// Payload of a channel.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Payload {
            $( #[doc = concat!("[`", stringify!($name), "`](crate::", stringify!($name), ")")] $name, )*
        }

        impl Payload {
            /// Its role for its machine.
            pub const fn carries(self) -> Carries {
                match self {
                    $( Self::$name => Carries::$carries, )*
                }
            }

            /// Its type as data.
            pub const fn shape(self) -> Shape {
                match self {
                    $( Self::$name => Shape::of::<crate::$name>(), )*
                }
            }

            /// Calls `visitor` with the Rust type of this payload.
            pub fn visit<V: Visitor>(self, visitor: V) -> V::Output {
                match self {
                    $( Self::$name => visitor.visit::<crate::$name>(), )*
                }
            }
        }

        /// Any message, for queues that carry all of them.
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[allow(missing_docs, reason = "each variant is the type of its name")]
        pub enum Envelope {
            $( $name(crate::$name), )*
        }

        impl Envelope {
            /// Passes the message inside to `receiver`.
            pub fn open<R: Receiver>(&self, receiver: R) -> R::Output {
                match self {
                    $( Self::$name(m) => receiver.receive(m), )*
                }
            }

            /// Type of the message inside.
            pub const fn payload(&self) -> Payload {
                match self {
                    $( Self::$name(_) => Payload::$name, )*
                }
            }

            /// Identity of the sample.
            pub fn stamp(&self) -> &Stamp {
                match self {
                    $( Self::$name(m) => m.stamp(), )*
                }
            }

            /// Marks it as made from simulated samples.
            pub fn mark_simulated(&mut self) {
                match self {
                    $( Self::$name(m) => m.mark_simulated(), )*
                }
            }

            /// Publish times.
            pub fn hops(&self) -> &Hops {
                match self {
                    $( Self::$name(m) => m.hops(), )*
                }
            }

            /// All fields, those of stamp and hops first.
            pub fn fields(&self) -> &'static [Field] {
                self.payload().shape().fields
            }

            /// Value of field `index`; `None` past the end.
            pub fn get(&self, index: usize) -> Option<Value> {
                match self {
                    $( Self::$name(m) => m.get(index), )*
                }
            }
        }
    };
}

crate::machines!(payloads_of_machines);

/// Defines a payload together with its description. So the structure that iceoryx2 carries and the table of the generic readers
/// cannot disagree.
macro_rules! message {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident, $type_name:tt, size $size:literal $(, marked in $mark:ident)? $(, words $words:ident)? {
            $( $(#[doc = $field_doc:expr])+ $field:ident: $type:ty, $unit:tt; )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, Default, PartialEq, iceoryx2_bb_derive_macros::ZeroCopySend)]
        #[type_name($type_name)]
        #[repr(C)]
        pub struct $name {
            /// Identity of the sample.
            pub stamp: $crate::Stamp,
            /// Publish times.
            pub hops: $crate::Hops,
            $( $(#[doc = $field_doc])+ #[doc = $crate::message::unit!($unit)] pub $field: $type, )*
        }

        // The size is part of the interface: readers in other languages declare it themselves.
        const _: () = assert!(core::mem::size_of::<$name>() == $size);
        const _: () = assert!(core::mem::align_of::<$name>() == 8);

        impl $crate::Message for $name {
            const NAME: &'static str = $type_name;
            const PAYLOAD: $crate::message::Payload = $crate::message::Payload::$name;
            const FIELDS: &'static [$crate::Field] = {
                const OWN: &[$crate::Field] = &[$( $crate::Field {
                    name: stringify!($field),
                    unit: $unit,
                    doc: concat!($($field_doc),+),
                    kind: <$type as $crate::field::FieldType>::KIND,
                } ),*];
                const ALL: [$crate::Field; $crate::field::HEAD + OWN.len()] =
                    $crate::field::join(OWN);
                &ALL
            };

            $( const WORDS: &'static [(&'static str, $crate::Words)] = $words; )?

            fn stamp(&self) -> &$crate::Stamp { &self.stamp }
            fn stamp_mut(&mut self) -> &mut $crate::Stamp { &mut self.stamp }
            fn hops(&self) -> &$crate::Hops { &self.hops }
            fn hops_mut(&mut self) -> &mut $crate::Hops { &mut self.hops }
            fn is_simulated(&self) -> bool {
                false $(|| self.$mark & $crate::SIMULATED != 0)?
            }
            fn mark_simulated(&mut self) {
                $(self.$mark |= $crate::SIMULATED;)?
            }
            fn envelope(&self) -> $crate::Envelope { $crate::Envelope::$name(*self) }
            fn inside(envelope: &$crate::Envelope) -> Option<&Self> {
                match envelope {
                    $crate::Envelope::$name(message) => Some(message),
                    _ => None,
                }
            }

            fn get(&self, index: usize) -> Option<$crate::Value> {
                if index < $crate::field::HEAD {
                    return Some($crate::field::get_head(&self.stamp, &self.hops, index));
                }
                let mut _at = $crate::field::HEAD;
                $(
                    if index == _at {
                        return Some($crate::field::FieldType::wrap(self.$field));
                    }
                    _at += 1;
                )*
                None
            }

            fn set(&mut self, index: usize, value: $crate::Value) -> bool {
                use $crate::field::FieldType;
                if index < $crate::field::HEAD {
                    return $crate::field::set_head(&mut self.stamp, &mut self.hops, index, value);
                }
                let mut _at = $crate::field::HEAD;
                $(
                    if index == _at {
                        return match <$type>::unwrap(value) {
                            Some(v) => { self.$field = v; true }
                            None => false,
                        };
                    }
                    _at += 1;
                )*
                false
            }
        }
    };
}

/// The unit as text; nothing for bits and pure numbers.
macro_rules! unit {
    ("") => {
        ""
    };
    ($unit:tt) => {
        concat!(" Unit: ", $unit, ".")
    };
}
pub(crate) use {message, unit};
