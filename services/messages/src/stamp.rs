use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// Identity of a sample, made by the sensor process and copied unchanged through every stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("Stamp")]
#[repr(C)]
pub struct Stamp {
    /// Number of the machine (0 where there is only one).
    pub machine: u32,
    /// Restarts of the source before it made this sample.
    pub epoch: u32,
    /// Number of the sample since the start of the run, from 0; a gap is a lost sample.
    pub sequence: u64,
    /// Time of the measurement by the data \[s\].
    pub time: f64,
    /// Time of the measurement on the host's monotonic clock \[ns\].
    pub measured_ns: u64,
}

/// Times at which each stage published the sample, on the host's monotonic clock \[ns\]; 0 = not passed. The restarts show a
/// replay where a stage's state was reset.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("Hops")]
#[repr(C)]
pub struct Hops {
    /// Published by the sensor process.
    pub sensor_ns: u64,
    /// Published by the filter stage, where the sample went through one.
    pub filter_ns: u64,
    /// Published by the estimator.
    pub estimate_ns: u64,
    /// Restarts of the filter stage before it published this; each resets its state.
    pub filter_restarts: u32,
    /// Restarts of the estimator before it published this.
    pub estimate_restarts: u32,
}

/// A stage that leaves its mark in the [`Hops`] of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hop {
    /// The filter stage.
    Filter,
    /// The estimator.
    Estimate,
}

impl Hops {
    /// Notes the time of publication \[ns\] and the restarts of a stage.
    pub fn mark(&mut self, hop: Hop, now_ns: u64, restarts: u32) {
        match hop {
            Hop::Filter => (self.filter_ns, self.filter_restarts) = (now_ns, restarts),
            Hop::Estimate => (self.estimate_ns, self.estimate_restarts) = (now_ns, restarts),
        }
    }

    /// Restarts of a stage before it published this.
    pub fn restarts(&self, hop: Hop) -> u32 {
        match hop {
            Hop::Filter => self.filter_restarts,
            Hop::Estimate => self.estimate_restarts,
        }
    }
}
