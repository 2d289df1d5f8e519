use crate::{Field, Hops, Message, Stamp, Value};

/// A function that works on any payload type; [`Payload::visit`] calls it with the right one.
pub trait Visitor {
    /// What it returns.
    type Output;
    /// Called with the payload type of the channel.
    fn visit<M: Message>(self) -> Self::Output;
}

/// A function that takes a message of any type.
pub trait Receiver {
    /// What it returns.
    type Output;
    /// Called with the message in the envelope.
    fn receive<M: Message>(self, message: &M) -> Self::Output;
}

fn fields<M: Message>(_: &M) -> &'static [Field] {
    M::FIELDS
}

/// What a message is to its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carries {
    /// What was measured.
    Sensors,
    /// The truth behind it.
    Truth,
    /// What is estimated from it.
    Estimate,
    /// What is between them.
    Between,
    /// It is of no machine: every process has it.
    Common,
}

/// Everything that must be said once per message type: `payloads!` is called with all of them and their roles.
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
            /// What it is to its machine.
            #[must_use]
            pub const fn carries(self) -> Carries {
                match self {
                    $( Self::$name => Carries::$carries, )*
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
            /// Hands the message inside to `receiver`.
            pub fn open<R: Receiver>(&self, receiver: R) -> R::Output {
                match self {
                    $( Self::$name(m) => receiver.receive(m), )*
                }
            }

            /// Which payload is inside.
            #[must_use]
            pub const fn payload(&self) -> Payload {
                match self {
                    $( Self::$name(_) => Payload::$name, )*
                }
            }

            /// Identity of the sample.
            #[must_use]
            pub fn stamp(&self) -> &Stamp {
                match self {
                    $( Self::$name(m) => m.stamp(), )*
                }
            }

            /// Says that it was made from simulated samples.
            pub fn mark_simulated(&mut self) {
                match self {
                    $( Self::$name(m) => m.mark_simulated(), )*
                }
            }

            /// Publish times.
            #[must_use]
            pub fn hops(&self) -> &Hops {
                match self {
                    $( Self::$name(m) => m.hops(), )*
                }
            }

            /// All fields, those of stamp and hops first.
            #[must_use]
            pub fn fields(&self) -> &'static [Field] {
                match self {
                    $( Self::$name(m) => fields(m), )*
                }
            }

            /// Value of field `index`; `None` past the end.
            #[must_use]
            pub fn get(&self, index: usize) -> Option<Value> {
                match self {
                    $( Self::$name(m) => m.get(index), )*
                }
            }
        }
    };
}

crate::machines!(payloads_of_machines);
