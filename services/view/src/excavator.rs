//! What people see of the excavator: its parameters, the words and panels of its own.

pub mod figures;
mod panels;
mod words;

pub(crate) use words::advice;

use messages::{
    EXCAVATOR_METHODS, ExcavatorEstimate, ExcavatorTruth, Machine, excavator_bits as bits,
};

use crate::estimate::{ANY, Estimate, InnovationRule, POSITIVE, Parameter, known};
use crate::panels::Panel;
use crate::run::Estimator;
use crate::words::Judgement;

type Row = Parameter<ExcavatorEstimate, ExcavatorTruth>;

macro_rules! row {
    ($($what:tt)*) => { crate::estimate::parameter!(bits::EXCITED, $($what)*) };
}

impl Estimate for ExcavatorEstimate {
    type Truth = ExcavatorTruth;
    const MACHINE: Machine = Machine::Excavator;
    const METHODS: &'static [&'static str] = EXCAVATOR_METHODS;
    const INNOVATION: InnovationRule = InnovationRule {
        window: 50,
        measurements: 1.0,
        limit: 1.8,
    };
    const PARAMETERS: &'static [Row] = &[
        Row {
            trusted: bits::TRUSTED,
            ..row!(
                "inertia",
                "Swing inertia",
                "kg m^2",
                POSITIVE,
                inertia,
                Some(|e| e.inertia_std),
                bits::INERTIA,
                Some(|t| known(t.known, 0, t.inertia))
            )
        },
        row!(
            "payload",
            "Payload",
            "kg",
            POSITIVE,
            payload,
            Some(|e| e.payload_std),
            bits::PAYLOAD,
            Some(|t| known(t.known, 6, t.payload))
        ),
        row!(
            "torque",
            "Torque",
            "N m",
            ANY,
            torque,
            Some(|e| e.torque_std),
            bits::TORQUE,
            Some(|t| known(t.known, 3, t.torque))
        ),
        row!(
            "damping",
            "Damping",
            "N m s/rad",
            POSITIVE,
            damping,
            Some(|e| e.damping_std),
            bits::DAMPING,
            Some(|t| known(t.known, 1, t.damping))
        ),
        row!(
            "friction",
            "Coulomb friction",
            "N m",
            POSITIVE,
            friction,
            Some(|e| e.friction_std),
            bits::FRICTION,
            Some(|t| known(t.known, 2, t.friction))
        ),
        row!(
            "offset",
            "Torque offset",
            "N m",
            ANY,
            offset,
            Some(|e| e.offset_std),
            bits::OFFSET,
            None
        ),
        row!(
            "velocity",
            "Swing velocity",
            "rad/s",
            ANY,
            velocity,
            None,
            u32::MAX,
            Some(|t| known(t.known, 4, t.velocity))
        ),
        row!(
            "acceleration",
            "Swing acceleration",
            "rad/s^2",
            ANY,
            acceleration,
            None,
            bits::ACCELERATION,
            Some(|t| known(t.known, 5, t.acceleration))
        ),
    ];

    const CONDITIONS: &'static [(&'static str, u32)] = &[
        ("excited", bits::EXCITED),
        ("consistent", bits::CONSISTENT),
        ("fresh", bits::FRESH),
        ("converged", bits::CONVERGED),
        ("identifiable", bits::IDENTIFIABLE),
        ("trusted", bits::TRUSTED),
    ];
    const MOTION_NAME: (&'static str, f64) = ("swing", 0.05);
    const STRETCH: &'static [&'static str] = &["inertia", "payload"];
    const SUMMED: &'static [&'static str] = &["payload"];

    fn motion(&self) -> f64 {
        self.velocity.abs()
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
        vec![words::inertia(self)]
    }

    fn forgetting(&self) -> Vec<f64> {
        [
            self.forgetting_inertia,
            self.forgetting_damping,
            self.forgetting_torque,
        ]
        .to_vec()
    }

    fn own_panels(estimator: &Estimator<Self>) -> Vec<Panel> {
        panels::forgetting(estimator)
            .into_iter()
            .chain(panels::activity(estimator))
            .collect()
    }
}
