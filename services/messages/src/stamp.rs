use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// Identity of a sample, made by the sensor process and copied unchanged through every stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("Stamp")]
#[repr(C)]
pub struct Stamp {
    /// Which machine (0 where there is only one).
    pub machine: u32,
    /// How often the source had been restarted when it made this sample.
    pub epoch: u32,
    /// Number of the sample since the start of the run, from 0; a gap is a loss.
    pub sequence: u64,
    /// Time of the measurement as the data tell it \[s\].
    pub time: f64,
    /// Time of the measurement on the host's monotonic clock \[ns\].
    pub measured_ns: u64,
}

/// When each stage published the sample, on the host's monotonic clock \[ns\]; 0 = not passed.
/// And which life of that stage it was, so that a replay knows when its state began anew.
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
    /// Restarts of the filter stage before it published this: a new state each time.
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
    /// Notes when a stage published \[ns\], and how often it had been restarted before.
    pub fn mark(&mut self, hop: Hop, now_ns: u64, restarts: u32) {
        match hop {
            Hop::Filter => (self.filter_ns, self.filter_restarts) = (now_ns, restarts),
            Hop::Estimate => (self.estimate_ns, self.estimate_restarts) = (now_ns, restarts),
        }
    }

    /// How often a stage had been restarted when it published this.
    pub fn restarts(&self, hop: Hop) -> u32 {
        match hop {
            Hop::Filter => self.filter_restarts,
            Hop::Estimate => self.estimate_restarts,
        }
    }
}
