//! The wheel loader: its signals, the columns of its estimates, its frames on a CAN bus.

use messages::channels::{ChannelOf, LOADER_CG_EKF, LOADER_CG_UKF, LOADER_SENSORS, LOADER_TRUTH};
use messages::{
    LOADER_METHODS, LOADER_REASONS, LoaderEstimate, LoaderSensors, LoaderTruth, Machine, SIMULATED,
    loader_bits as bits,
};

use crate::can::{FrameTable, Quantity};
use crate::csv::Column::{self, Flag, Value as Field};
use crate::csv::Estimate;
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
    const COLUMNS: &'static [Column] = &[
        Field("speed", bits::STATE),
        Field("front_wheel_speed", bits::STATE),
        Field("rear_wheel_speed", bits::STATE),
        Field("slip_stiffness", bits::STATE),
        Field("slip_stiffness_std", bits::STATE),
        Field("cg_height", bits::STATE),
        Field("cg_height_std", bits::STATE),
        Field("cg_ratio", bits::STATE),
        Field("cg_ratio_std", bits::STATE),
        Field("cg_distance", bits::STATE),
        Field("spade_force_x", bits::ESTIMATED_SPADE_FORCE_X),
        Field("spade_force_x_std", bits::ESTIMATED_SPADE_FORCE_X),
        Field("slope_bias", bits::SLOPE_BIAS),
        Field("front_radius_scale", bits::RADIUS_SCALES),
        Field("rear_radius_scale", bits::RADIUS_SCALES),
        Field("nis", 0),
        Flag("excited_ratio", bits::EXCITED_RATIO),
        Flag("excited_height", bits::EXCITED_HEIGHT),
        Flag("consistent", bits::CONSISTENT),
        Flag("fresh", bits::FRESH),
        Flag("converged_ratio", bits::CONVERGED_RATIO),
        Flag("converged_height", bits::CONVERGED_HEIGHT),
        Flag("frozen", bits::FROZEN),
        Flag("reset", bits::RESET),
        Flag("trusted_ratio", bits::TRUSTED_RATIO),
        Flag("trusted_height", bits::TRUSTED_HEIGHT),
    ];
    const EXTRA: (&'static [Column], u32) = (
        &[
            Field("payload", bits::PAYLOAD),
            Field("payload_std", bits::PAYLOAD),
        ],
        bits::PAYLOAD,
    );
    const REFUSED: u32 = bits::REFUSED;
    const METHODS: &'static [&'static str] = LOADER_METHODS;
    const REASONS: &'static [(&'static str, &'static str)] = LOADER_REASONS;
    fn reason(&self) -> u32 {
        self.reason
    }
    fn bits(&self) -> (u32, u32, u32) {
        (self.flags, self.estimated, self.method)
    }
}

/// Its frames.
pub(crate) const FRAMES: FrameTable = FrameTable {
    machine: Machine::Loader,
    channels: &[LOADER_CG_UKF.any(), LOADER_CG_EKF.any()],
    quantities: &[
        Quantity {
            name: "ratio",
            field: "cg_ratio",
            std_field: "cg_ratio_std",
            unit: "",
            scale: 1e-6,
            offset: 0.0,
            estimated: bits::STATE,
            trusted: bits::TRUSTED_RATIO,
            group: 0xff20,
        },
        Quantity {
            name: "height",
            field: "cg_height",
            std_field: "cg_height_std",
            unit: "m",
            scale: 1e-5,
            offset: 0.0,
            estimated: bits::STATE,
            trusted: bits::TRUSTED_HEIGHT,
            group: 0xff21,
        },
    ],
    flags: &[
        ("trusted_ratio", bits::TRUSTED_RATIO),
        ("trusted_height", bits::TRUSTED_HEIGHT),
        ("excited_ratio", bits::EXCITED_RATIO),
        ("excited_height", bits::EXCITED_HEIGHT),
        ("consistent", bits::CONSISTENT),
        ("fresh", bits::FRESH),
        ("converged_ratio", bits::CONVERGED_RATIO),
        ("converged_height", bits::CONVERGED_HEIGHT),
        ("identifiable_ratio", bits::IDENTIFIABLE_RATIO),
        ("identifiable_height", bits::IDENTIFIABLE_HEIGHT),
        ("simulated", SIMULATED),
    ],
    verdict: 0xff2f,
};
