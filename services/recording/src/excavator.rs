//! The excavator: its signals, the columns of its estimates, its frames on a CAN bus.

use messages::channels::{
    ChannelOf, EXCAVATOR_INERTIA_RLS, EXCAVATOR_INERTIA_UKF, EXCAVATOR_SENSORS, EXCAVATOR_TRUTH,
};
use messages::{
    EXCAVATOR_METHODS, EXCAVATOR_REASONS, ExcavatorEstimate, ExcavatorSensors, ExcavatorTruth,
    Machine, SIMULATED, excavator_bits as bits,
};

use crate::can::{FrameTable, Quantity};
use crate::csv::Column::{self, Flag, Value as Field};
use crate::csv::Estimate;
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
    const COLUMNS: &'static [Column] = &[
        Field("inertia", bits::INERTIA),
        Field("inertia_std", bits::INERTIA),
        Field("damping", bits::DAMPING),
        Field("damping_std", bits::DAMPING),
        Field("torque", bits::TORQUE),
        Field("torque_std", bits::TORQUE),
        Field("payload", bits::PAYLOAD),
        Field("payload_std", bits::PAYLOAD),
        Field("velocity", 0),
        Field("acceleration", bits::ACCELERATION),
        Flag("excited", bits::EXCITED),
        Flag("consistent", bits::CONSISTENT),
        Flag("fresh", bits::FRESH),
        Flag("converged", bits::CONVERGED),
        Flag("identifiable", bits::IDENTIFIABLE),
        Flag("held", bits::HELD),
        Flag("changing", bits::CHANGING),
        Flag("reset", bits::RESET),
        Flag("trusted", bits::TRUSTED),
    ];
    const EXTRA: (&'static [Column], u32) = (
        &[
            Field("friction", bits::FRICTION),
            Field("friction_std", bits::FRICTION),
            Field("offset", bits::OFFSET),
            Field("offset_std", bits::OFFSET),
        ],
        bits::FRICTION | bits::OFFSET,
    );
    const REFUSED: u32 = bits::REFUSED;
    const METHODS: &'static [&'static str] = EXCAVATOR_METHODS;
    const REASONS: &'static [(&'static str, &'static str)] = EXCAVATOR_REASONS;
    fn reason(&self) -> u32 {
        self.reason
    }
    fn bits(&self) -> (u32, u32, u32) {
        (self.flags, self.estimated, self.method)
    }
}

/// Its frames.
pub(crate) const FRAMES: FrameTable = FrameTable {
    machine: Machine::Excavator,
    channels: &[EXCAVATOR_INERTIA_UKF.any(), EXCAVATOR_INERTIA_RLS.any()],
    quantities: &[
        Quantity {
            name: "inertia",
            field: "inertia",
            std_field: "inertia_std",
            unit: "kg m^2",
            scale: 0.1,
            offset: 0.0,
            estimated: bits::INERTIA,
            trusted: bits::TRUSTED,
            group: 0xff10,
        },
        Quantity {
            name: "payload",
            field: "payload",
            std_field: "payload_std",
            unit: "kg",
            scale: 0.01,
            offset: -1e6,
            estimated: bits::PAYLOAD,
            trusted: bits::TRUSTED,
            group: 0xff11,
        },
        Quantity {
            name: "damping",
            field: "damping",
            std_field: "damping_std",
            unit: "N m s/rad",
            scale: 0.1,
            offset: 0.0,
            estimated: bits::DAMPING,
            trusted: bits::TRUSTED,
            group: 0xff12,
        },
    ],
    flags: &[
        ("trusted", bits::TRUSTED),
        ("excited", bits::EXCITED),
        ("consistent", bits::CONSISTENT),
        ("fresh", bits::FRESH),
        ("converged", bits::CONVERGED),
        ("identifiable", bits::IDENTIFIABLE),
        ("changing", bits::CHANGING),
        ("simulated", SIMULATED),
    ],
    verdict: 0xff1f,
};
