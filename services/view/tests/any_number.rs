//! Extreme numbers and short runs do not break a report, and put no NaN into it.

mod common;

use messages::{
    ExcavatorEstimate, ExcavatorTruth, Health, LoaderEstimate, LoaderTruth, Message, NumberType,
    SwingMotion, Value,
};
use view::{Estimator, MachineRun, Parts, Run, number, report};

/// A seeded generator of arbitrary bits, and of numbers that often cause errors.
struct Any(u64);

impl Any {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn double(&mut self) -> f64 {
        const WILD: [f64; 12] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            5e-324,
            f64::MIN_POSITIVE,
            f64::MAX,
            f64::MIN,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e16,
        ];
        match self.bits() % 4 {
            0 => f64::from_bits(self.bits()),
            1 => WILD[(self.bits() % 12) as usize],
            _ => (self.bits() % 2000) as f64 * 0.01 - 10.0,
        }
    }

    fn message<M: Message>(&mut self, number: u64, time: f64) -> M {
        let mut message = M::default();
        for (i, field) in M::FIELDS.iter().enumerate() {
            let value = match field.kind {
                NumberType::F64 => Value::F64(self.double()),
                // Each flag is set with a probability of one half.
                NumberType::U32 => Value::U32(self.bits() as u32),
                NumberType::U64 => Value::U64(self.bits() >> (self.bits() % 64)),
            };
            message.set(i, value);
        }
        message.stamp_mut().sequence = number;
        message.stamp_mut().time = time;
        message
    }

    fn messages<M: Message>(&mut self, times: &[f64]) -> Vec<M> {
        let numbered = times.iter().enumerate();
        numbered.map(|(n, t)| self.message(n as u64, *t)).collect()
    }
}

#[test]
fn any_doubles_can_be_printed() {
    let mut any = Any(0x5eed);
    for _ in 0..20_000 {
        let (value, std) = (any.double(), any.double());
        let places = any.bits() as i32;
        let digits = (any.bits() % 12) as i32;
        for text in [
            number::grouped(value, places),
            number::grouped(value, (places % 400).abs()),
            number::significant(value, digits),
            number::with_std(value, std, "kg"),
            number::interval_95(value, std),
            number::nanoseconds(value),
        ] {
            assert!(
                text.len() < 200 && !text.contains("NaN"),
                "{value:e} {std:e}: {text}"
            );
        }
    }
    for places in [i32::MIN, -400, 400, i32::MAX] {
        assert_ne!(number::grouped(12.5, places), "");
    }
}

#[test]
fn a_run_of_any_samples_makes_a_report() {
    let mut any = Any(0xface);
    let times: [&[f64]; 8] = [
        &[],
        &[0.0],
        &[3.0],
        &[0.0, 0.0],
        &[1.0, 2.0],
        &[5.0; 60],
        &[2.0, 1.0, 0.0],
        &[f64::NAN, f64::INFINITY, -1e308, 1e308],
    ];
    for round in 0..40 {
        let times = times[round % times.len()];
        let excavator = MachineRun {
            estimators: vec![Estimator {
                channel: "excavator/inertia_ukf".into(),
                estimates: any.messages::<ExcavatorEstimate>(times),
                extremes: Default::default(),
            }],
            truth: any.messages::<ExcavatorTruth>(times),
        };
        let loader = MachineRun {
            estimators: vec![Estimator {
                channel: "loader/cg_ukf".into(),
                estimates: any.messages::<LoaderEstimate>(times),
                extremes: Default::default(),
            }],
            truth: any.messages::<LoaderTruth>(times),
        };
        let html = report(&Run {
            parts: Parts { excavator, loader },
            motion: any.messages::<SwingMotion>(times),
            health: any.messages::<Health>(times),
            ..Default::default()
        });
        let inf = html
            .match_indices("inf")
            .find(|(at, _)| !html[at + 3..].starts_with(|c: char| c.is_ascii_alphabetic()));
        assert!(!html.contains("NaN") && inf.is_none(), "round {round}");
    }
}
