//! Tables of the channels, those of a machine in its own file. The supervisor, which creates the channels, every service and the
//! logger use them.

use core::marker::PhantomData;
use core::ops::Deref;

pub use crate::message::{Payload, Visitor};
use crate::{Credit, Health, Keyframe, Machine, Message};

/// Rate of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// The rate of the sensors.
    Sensors,
    /// Fixed \[Hz\].
    Hz(f64),
}

/// A channel, whatever its message.
#[derive(Debug, Clone, Copy)]
pub struct Channel {
    /// Name, as iceoryx2 and the recording show it.
    pub name: &'static str,
    /// Payload type.
    pub payload: Payload,
    /// Messages by which a slow reader may lag before the oldest is dropped. 512 hold 51 ms at 10 kHz: without real-time
    /// scheduling a reader can be delayed by 20 ms.
    pub depth: usize,
    /// Rate of its messages.
    pub rate: Rate,
}

impl Channel {
    /// Its name after the last slash.
    pub fn last_name(&self) -> &'static str {
        self.name.rsplit('/').next().unwrap_or(self.name)
    }
}

/// A channel with its message type: a step on the wrong one does not compile.
#[derive(Debug)]
pub struct ChannelOf<M> {
    channel: Channel,
    message: PhantomData<fn() -> M>,
}

impl<M: Message> ChannelOf<M> {
    pub(crate) const fn new(name: &'static str, depth: usize, rate: Rate) -> Self {
        Self {
            channel: Channel {
                name,
                payload: M::PAYLOAD,
                depth,
                rate,
            },
            message: PhantomData,
        }
    }
}

impl<M> ChannelOf<M> {
    /// The same channel without its message type.
    pub const fn any(&self) -> &Channel {
        &self.channel
    }
}

impl<M> Deref for ChannelOf<M> {
    type Target = Channel;

    fn deref(&self) -> &Channel {
        &self.channel
    }
}

/// Channels: name, message, public name, depth, rate.
macro_rules! channels {
    ($( $(#[$doc:meta])* $name:ident: $message:ident = $text:literal, $depth:literal, $rate:expr; )*) => {
        $( $(#[$doc])* pub static $name: ChannelOf<$message> = ChannelOf::new($text, $depth, $rate); )*

        /// These channels.
        pub(crate) const OWN: &[&$crate::channels::Channel] = &[$( $name.any() ),*];
    };
}
pub(crate) use channels;

channels! {
    /// How each process is doing.
    HEALTH: Health = "health", 128, Rate::Hz(3.0);
    /// How far the logger has got.
    CREDIT: Credit = "credit", 16, Rate::Sensors;
    /// The complete state of each step, in pieces. Deep enough for two states of every process.
    KEYFRAME: Keyframe = "keyframe", 512, Rate::Hz(2.0);
}

macro_rules! channels_of_machines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        $( pub use crate::$module::channels::*; )*

        /// All channels: those of each machine, then the common ones.
        pub fn all() -> impl Iterator<Item = &'static Channel> {
            [$( crate::$module::channels::OWN, )* OWN].into_iter().flatten().copied()
        }
    };
}

crate::machines!(channels_of_machines);

/// The channel called `name`.
pub fn find(name: &str) -> Option<&'static Channel> {
    all().find(|c| c.name == name)
}

/// Channels of a machine, including the common ones.
pub fn of_machine(machine: Machine) -> impl Iterator<Item = &'static Channel> {
    all().filter(move |c| {
        c.name
            .split_once('/')
            .is_none_or(|(prefix, _)| prefix == machine.name())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;

    #[test]
    fn every_payload_variant_names_its_own_type() {
        for channel in all() {
            let Shape { name, fields, .. } = channel.payload.shape();
            assert_eq!(name, format!("{:?}", channel.payload));
            assert!(fields.len() > crate::HEAD, "{name} has fields of its own");
        }
    }

    #[test]
    fn fields_can_be_read_back_as_written() {
        struct RoundTrip;
        impl Visitor for RoundTrip {
            type Output = ();
            fn visit<M: Message>(self) {
                let mut message = M::default();
                for (i, field) in M::FIELDS.iter().enumerate() {
                    let value = match field.kind {
                        crate::NumberType::U32 => crate::Value::U32(i as u32 + 1),
                        crate::NumberType::U64 => crate::Value::U64(i as u64 + 1),
                        crate::NumberType::F64 => crate::Value::F64(i as f64 + 0.5),
                    };
                    assert!(message.set(i, value), "{} {}", M::NAME, field.name);
                    assert_eq!(message.get(i), Some(value), "{} {}", M::NAME, field.name);
                }
                assert_eq!(message.get(M::FIELDS.len()), None);
            }
        }
        for channel in all() {
            channel.payload.visit(RoundTrip);
        }
    }

    #[test]
    fn a_machine_sees_its_own_channels_and_the_common_ones() {
        let names: Vec<_> = of_machine(Machine::Loader).map(|c| c.name).collect();
        assert_eq!(
            names,
            [
                "loader/sensors",
                "loader/truth",
                "loader/cg_ekf",
                "loader/cg_ukf",
                "loader/loads",
                "health",
                "credit",
                "keyframe"
            ]
        );
    }
}
