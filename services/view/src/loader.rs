//! What people see of the wheel loader: its parameters, the words of its own.

pub mod figures;
mod words;

pub(crate) use words::advice;

use messages::{LOADER_METHODS, LoaderEstimate, LoaderTruth, Machine, loader_bits as bits};

use crate::estimate::{ANY, Estimate, InnovationRule, POSITIVE, Parameter, known};
use crate::words::Judgement;

type Row = Parameter<LoaderEstimate, LoaderTruth>;

macro_rules! row {
    ($($what:tt)*) => { crate::estimate::parameter!(bits::EXCITED_RATIO, $($what)*) };
}

impl Estimate for LoaderEstimate {
    type Truth = LoaderTruth;
    const MACHINE: Machine = Machine::Loader;
    const METHODS: &'static [&'static str] = LOADER_METHODS;
    const INNOVATION: InnovationRule = InnovationRule {
        window: 400,
        measurements: 3.0,
        limit: 2.0,
    };
    const PARAMETERS: &'static [Row] = &[
        Row {
            trusted: bits::TRUSTED_RATIO,
            ..row!(
                "cg_ratio",
                "Share of the weight on the front axle",
                "",
                (0.0, 1.0),
                cg_ratio,
                Some(|e| e.cg_ratio_std),
                bits::STATE,
                Some(|t| known(t.known, 4, t.cg_ratio))
            )
        },
        Row {
            trusted: bits::TRUSTED_HEIGHT,
            excited: bits::EXCITED_HEIGHT,
            ..row!(
                "cg_height",
                "Height of the centre of gravity",
                "m",
                POSITIVE,
                cg_height,
                Some(|e| e.cg_height_std),
                bits::STATE,
                Some(|t| known(t.known, 3, t.cg_height))
            )
        },
        row!(
            "slip_stiffness",
            "Tyre slip stiffness",
            "",
            POSITIVE,
            slip_stiffness,
            Some(|e| e.slip_stiffness_std),
            bits::STATE,
            Some(|t| known(t.known, 5, t.slip_stiffness))
        ),
        row!(
            "spade_force_x",
            "Horizontal spade force",
            "N",
            ANY,
            spade_force_x,
            Some(|e| e.spade_force_x_std),
            bits::ESTIMATED_SPADE_FORCE_X,
            Some(|t| known(t.known, 6, t.spade_force_x))
        ),
        row!(
            "speed",
            "Speed",
            "m/s",
            ANY,
            speed,
            None,
            bits::STATE,
            Some(|t| known(t.known, 0, t.speed))
        ),
        row!(
            "slope_bias",
            "Bias of the slope sensor",
            "rad",
            ANY,
            slope_bias,
            None,
            bits::SLOPE_BIAS,
            None
        ),
        row!(
            "front_radius_scale",
            "Front rolling radius over nominal",
            "",
            POSITIVE,
            front_radius_scale,
            None,
            bits::RADIUS_SCALES,
            None
        ),
        row!(
            "rear_radius_scale",
            "Rear rolling radius over nominal",
            "",
            POSITIVE,
            rear_radius_scale,
            None,
            bits::RADIUS_SCALES,
            None
        ),
    ];

    const CONDITIONS: &'static [(&'static str, u32)] = &[
        ("consistent", bits::CONSISTENT),
        ("fresh", bits::FRESH),
        ("ratio excited", bits::EXCITED_RATIO),
        ("ratio converged", bits::CONVERGED_RATIO),
        ("ratio trusted", bits::TRUSTED_RATIO),
        ("height excited", bits::EXCITED_HEIGHT),
        ("height converged", bits::CONVERGED_HEIGHT),
        ("height trusted", bits::TRUSTED_HEIGHT),
    ];
    const MOTION_NAME: (&'static str, f64) = ("drive", 0.3);
    const STRETCH: &'static [&'static str] = &["cg_ratio", "cg_height"];
    const SUMMED: &'static [&'static str] = &[];

    fn motion(&self) -> f64 {
        self.speed.abs()
    }

    fn method(&self) -> u32 {
        self.method
    }

    fn flags(&self) -> u32 {
        self.flags
    }

    fn nis(&self) -> f64 {
        self.nis
    }

    fn judgements(&self) -> Vec<Judgement> {
        vec![words::position(self), words::height(self)]
    }
}
