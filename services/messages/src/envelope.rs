use crate::{
    Credit, ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, Health, LoaderEstimate,
    LoaderSensors, LoaderTruth, Message, SwingMotion,
};

/// Any message, for queues that carry all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "each variant is the type of its name")]
pub enum Envelope {
    ExcavatorSensors(ExcavatorSensors),
    ExcavatorTruth(ExcavatorTruth),
    SwingMotion(SwingMotion),
    ExcavatorEstimate(ExcavatorEstimate),
    LoaderSensors(LoaderSensors),
    LoaderTruth(LoaderTruth),
    LoaderEstimate(LoaderEstimate),
    Health(Health),
    Credit(Credit),
}

/// A function that takes a message of any type.
pub trait Receiver {
    /// What it returns.
    type Output;
    /// Called with the message in the envelope.
    fn receive<M: Message>(self, message: &M) -> Self::Output;
}

impl Envelope {
    /// Hands the message inside to `receiver`.
    pub fn open<R: Receiver>(&self, receiver: R) -> R::Output {
        match self {
            Self::ExcavatorSensors(m) => receiver.receive(m),
            Self::ExcavatorTruth(m) => receiver.receive(m),
            Self::SwingMotion(m) => receiver.receive(m),
            Self::ExcavatorEstimate(m) => receiver.receive(m),
            Self::LoaderSensors(m) => receiver.receive(m),
            Self::LoaderTruth(m) => receiver.receive(m),
            Self::LoaderEstimate(m) => receiver.receive(m),
            Self::Health(m) => receiver.receive(m),
            Self::Credit(m) => receiver.receive(m),
        }
    }
}
