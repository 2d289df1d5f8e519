//! The excavator: its signals, the columns of its estimates, its frames on a CAN bus.

use messages::channels::{
    ChannelOf, EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_LOADS, EXCAVATOR_SENSORS,
    EXCAVATOR_TRUTH,
};
use messages::{ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth, Machine};

use sheet::excavator::{FLAGS, LOADS_GROUP, QUANTITIES, VERDICT_FRAME};
use sheet::{count_framed, count_framed_flags};

use crate::can::{FrameTable, flags, quantities};
use crate::csv::{Estimate, estimate_of};
use crate::signal::Sensors;

impl Sensors for ExcavatorSensors {
    type Truth = ExcavatorTruth;
    const MACHINE: Machine = Machine::Excavator;
    const SENSORS: &'static ChannelOf<Self> = &EXCAVATOR_SENSORS;
    const TRUTH: &'static ChannelOf<Self::Truth> = &EXCAVATOR_TRUTH;
    const REQUIRED: &'static [&'static [&'static str]] = sheet::excavator::REQUIRED;
    const SIGNALS: &'static [sheet::Signal] = sheet::excavator::SIGNALS;
}

impl Estimate for ExcavatorEstimate {
    estimate_of!(
        excavator,
        excavator_bits,
        EXCAVATOR_METHODS,
        EXCAVATOR_REASONS
    );
}

/// Its frames.
pub(crate) const FRAMES: FrameTable = FrameTable {
    machine: Machine::Excavator,
    channels: &[EXCAVATOR_INERTIA_UKF.any(), EXCAVATOR_INERTIA_RLS.any()],
    quantities: &quantities::<{ count_framed(QUANTITIES) }>(QUANTITIES),
    flags: &flags::<{ count_framed_flags(FLAGS) }>(FLAGS, VERDICT_FRAME),
    verdict: VERDICT_FRAME.group,
    loads: EXCAVATOR_LOADS.any(),
    loads_group: LOADS_GROUP,
};
