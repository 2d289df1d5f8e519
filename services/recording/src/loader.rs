//! The wheel loader: its signals, the columns of its estimates, its frames on a CAN bus.

use messages::channels::{
    ChannelOf, LOADER_CG_EKF, LOADER_CG_UKF, LOADER_LOADS, LOADER_SENSORS, LOADER_TRUTH,
};
use messages::{LoaderEstimate, LoaderSensors, LoaderTruth, Machine};

use sheet::loader::{FLAGS, LOADS_GROUP, QUANTITIES, VERDICT_FRAME};
use sheet::{count_framed, count_framed_flags};

use crate::can::{FrameTable, flags, quantities};
use crate::csv::{Estimate, estimate_of};
use crate::signal::Sensors;

impl Sensors for LoaderSensors {
    type Truth = LoaderTruth;
    const MACHINE: Machine = Machine::Loader;
    const SENSORS: &'static ChannelOf<Self> = &LOADER_SENSORS;
    const TRUTH: &'static ChannelOf<Self::Truth> = &LOADER_TRUTH;
    const REQUIRED: &'static [&'static [&'static str]] = sheet::loader::REQUIRED;
    const SIGNALS: &'static [sheet::Signal] = sheet::loader::SIGNALS;
}

impl Estimate for LoaderEstimate {
    estimate_of!(loader, loader_bits, LOADER_METHODS, LOADER_REASONS);
}

/// Its frames.
pub(crate) const FRAMES: FrameTable = FrameTable {
    machine: Machine::Loader,
    channels: &[LOADER_CG_UKF.any(), LOADER_CG_EKF.any()],
    quantities: &quantities::<{ count_framed(QUANTITIES) }>(QUANTITIES),
    flags: &flags::<{ count_framed_flags(FLAGS) }>(FLAGS, VERDICT_FRAME),
    verdict: VERDICT_FRAME.group,
    loads: LOADER_LOADS.any(),
    loads_group: LOADS_GROUP,
};
