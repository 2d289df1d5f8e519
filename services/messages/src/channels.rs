//! The one table of channels: read by the supervisor, who creates them, by every service and by
//! the logger.

use crate::{
    Credit, ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, Health, LoaderEstimate,
    LoaderSensors, LoaderTruth, Message, SwingMotion,
};

/// Rate of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// That of the sensors.
    Sensors,
    /// Fixed [Hz].
    Hz(f64),
}

/// Payload of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Payload {
    /// [`ExcavatorSensors`]
    ExcavatorSensors,
    /// [`ExcavatorTruth`]
    ExcavatorTruth,
    /// [`SwingMotion`]
    SwingMotion,
    /// [`ExcavatorEstimate`]
    ExcavatorEstimate,
    /// [`LoaderSensors`]
    LoaderSensors,
    /// [`LoaderTruth`]
    LoaderTruth,
    /// [`LoaderEstimate`]
    LoaderEstimate,
    /// [`Health`]
    Health,
    /// [`Credit`]
    Credit,
}

/// A function that works on any payload type; [`Payload::visit`] calls it with the right one.
pub trait Visitor {
    /// What it returns.
    type Output;
    /// Called with the payload type of the channel.
    fn visit<M: Message>(self) -> Self::Output;
}

impl Payload {
    /// Calls `visitor` with the Rust type of this payload.
    pub fn visit<V: Visitor>(self, visitor: V) -> V::Output {
        match self {
            Self::ExcavatorSensors => visitor.visit::<ExcavatorSensors>(),
            Self::ExcavatorTruth => visitor.visit::<ExcavatorTruth>(),
            Self::SwingMotion => visitor.visit::<SwingMotion>(),
            Self::ExcavatorEstimate => visitor.visit::<ExcavatorEstimate>(),
            Self::LoaderSensors => visitor.visit::<LoaderSensors>(),
            Self::LoaderTruth => visitor.visit::<LoaderTruth>(),
            Self::LoaderEstimate => visitor.visit::<LoaderEstimate>(),
            Self::Health => visitor.visit::<Health>(),
            Self::Credit => visitor.visit::<Credit>(),
        }
    }
}

/// A channel.
#[derive(Debug, Clone, Copy)]
pub struct Channel {
    /// Name, as iceoryx2 and the recording show it.
    pub name: &'static str,
    /// Payload type.
    pub payload: Payload,
    /// Samples that a slow reader may be behind before the oldest is dropped. 512 hold 51 ms at
    /// 10 kHz: without real-time scheduling a reader can be away for 20 ms.
    pub depth: usize,
    /// How often.
    pub rate: Rate,
}

const fn channel(name: &'static str, payload: Payload, depth: usize, rate: Rate) -> Channel {
    Channel {
        name,
        payload,
        depth,
        rate,
    }
}

/// What the excavator's sensors measured.
pub const EXCAVATOR_SENSORS: Channel = channel(
    "excavator/sensors",
    Payload::ExcavatorSensors,
    512,
    Rate::Sensors,
);
/// The truth behind them, where there is one.
pub const EXCAVATOR_TRUTH: Channel = channel(
    "excavator/truth",
    Payload::ExcavatorTruth,
    512,
    Rate::Sensors,
);
/// Swing motion after the filter stage.
pub const EXCAVATOR_MOTION: Channel =
    channel("excavator/motion", Payload::SwingMotion, 512, Rate::Sensors);
/// Estimates of the regression.
pub const EXCAVATOR_INERTIA_RLS: Channel = channel(
    "excavator/inertia_rls",
    Payload::ExcavatorEstimate,
    512,
    Rate::Sensors,
);
/// Estimates of the state-space filters.
pub const EXCAVATOR_INERTIA_UKF: Channel = channel(
    "excavator/inertia_ukf",
    Payload::ExcavatorEstimate,
    512,
    Rate::Sensors,
);
/// What the loader's sensors measured.
pub const LOADER_SENSORS: Channel =
    channel("loader/sensors", Payload::LoaderSensors, 512, Rate::Sensors);
/// The truth behind them, where there is one.
pub const LOADER_TRUTH: Channel = channel("loader/truth", Payload::LoaderTruth, 512, Rate::Sensors);
/// Estimates of the extended Kalman filter.
pub const LOADER_CG_EKF: Channel =
    channel("loader/cg_ekf", Payload::LoaderEstimate, 512, Rate::Sensors);
/// Estimates of the square-root unscented Kalman filter.
pub const LOADER_CG_UKF: Channel =
    channel("loader/cg_ukf", Payload::LoaderEstimate, 512, Rate::Sensors);
/// How each process is doing.
pub const HEALTH: Channel = channel("health", Payload::Health, 128, Rate::Hz(3.0));
/// How far the logger has got.
pub const CREDIT: Channel = channel("credit", Payload::Credit, 16, Rate::Sensors);

/// All channels.
pub const CHANNELS: &[Channel] = &[
    EXCAVATOR_SENSORS,
    EXCAVATOR_TRUTH,
    EXCAVATOR_MOTION,
    EXCAVATOR_INERTIA_RLS,
    EXCAVATOR_INERTIA_UKF,
    LOADER_SENSORS,
    LOADER_TRUTH,
    LOADER_CG_EKF,
    LOADER_CG_UKF,
    HEALTH,
    CREDIT,
];

/// Channels of the machine `name` ("excavator", "loader"), health and credit included.
pub fn of_machine(name: &str) -> impl Iterator<Item = &'static Channel> {
    CHANNELS.iter().filter(move |c| {
        c.name
            .split_once('/')
            .is_none_or(|(machine, _)| machine == name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Names;
    impl Visitor for Names {
        type Output = (&'static str, usize);
        fn visit<M: Message>(self) -> Self::Output {
            (M::NAME, M::FIELDS.len())
        }
    }

    #[test]
    fn every_payload_variant_names_its_own_type() {
        for channel in CHANNELS {
            let (name, fields) = channel.payload.visit(Names);
            assert_eq!(name, format!("{:?}", channel.payload));
            assert!(fields > crate::HEAD, "{name} has fields of its own");
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
                        crate::Kind::U32 => crate::Value::U32(i as u32 + 1),
                        crate::Kind::U64 => crate::Value::U64(i as u64 + 1),
                        crate::Kind::F64 => crate::Value::F64(i as f64 + 0.5),
                    };
                    assert!(message.set(i, value), "{} {}", M::NAME, field.name);
                    assert_eq!(message.get(i), Some(value), "{} {}", M::NAME, field.name);
                }
                assert_eq!(message.get(M::FIELDS.len()), None);
            }
        }
        for channel in CHANNELS {
            channel.payload.visit(RoundTrip);
        }
    }

    #[test]
    fn a_machine_sees_its_own_channels_and_the_common_ones() {
        let names: Vec<_> = of_machine("loader").map(|c| c.name).collect();
        assert_eq!(
            names,
            [
                "loader/sensors",
                "loader/truth",
                "loader/cg_ekf",
                "loader/cg_ukf",
                "health",
                "credit"
            ]
        );
    }
}
