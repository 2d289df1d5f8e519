use crate::{
    Credit, ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, Field, Health, Hops,
    LoaderEstimate, LoaderSensors, LoaderTruth, Message, Stamp, SwingMotion, Value,
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

/// The same expression for whichever message is inside.
macro_rules! each {
    ($envelope:expr, $m:ident => $value:expr) => {
        match $envelope {
            Envelope::ExcavatorSensors($m) => $value,
            Envelope::ExcavatorTruth($m) => $value,
            Envelope::SwingMotion($m) => $value,
            Envelope::ExcavatorEstimate($m) => $value,
            Envelope::LoaderSensors($m) => $value,
            Envelope::LoaderTruth($m) => $value,
            Envelope::LoaderEstimate($m) => $value,
            Envelope::Health($m) => $value,
            Envelope::Credit($m) => $value,
        }
    };
}

fn fields<M: Message>(_: &M) -> &'static [Field] {
    M::FIELDS
}

impl Envelope {
    /// Hands the message inside to `receiver`.
    pub fn open<R: Receiver>(&self, receiver: R) -> R::Output {
        each!(self, m => receiver.receive(m))
    }

    /// Identity of the sample.
    #[must_use]
    pub fn stamp(&self) -> &Stamp {
        each!(self, m => m.stamp())
    }

    /// Publish times.
    #[must_use]
    pub fn hops(&self) -> &Hops {
        each!(self, m => m.hops())
    }

    /// All fields, those of stamp and hops first.
    #[must_use]
    pub fn fields(&self) -> &'static [Field] {
        each!(self, m => fields(m))
    }

    /// Value of field `index`; `None` past the end.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Value> {
        each!(self, m => m.get(index))
    }
}
