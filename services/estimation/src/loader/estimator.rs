//! The estimator of the centre of gravity: one row in, one answer out.

use super::estimate::{Estimate, Status};
use super::filter::{Belief, CgFilter, RowReport};
use super::layout::{CG_HEIGHT, CG_RATIO, Each, FRONT_WHEEL, Layout, REAR_WHEEL, SPEED};
use super::lift_arm::{LiftWitness, Weighed};
use super::payload::Payload;
#[cfg(not(feature = "every-method"))]
use super::settings::MustBe;
use super::settings::{Settings, SettingsError};
use super::verdict::{Doubt, Intervals, Learns, with_floors};
use super::witnesses::Witnesses;
use super::{Columns, Method, Reason, Sample};
use crate::Quantity;
use crate::ekf::Ekf;
use crate::math::norm;
#[cfg(feature = "every-method")]
use crate::srukf::SquareRootUkf;

/// The filter that a method runs on. A controller with little flash has those of `full-ekf` alone (without the feature
/// `every-method`).
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant)] // no allocator
#[cfg_attr(not(feature = "every-method"), allow(clippy::enum_variant_names))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Filter {
    #[cfg(feature = "every-method")]
    Six(CgFilter<6, 3, SquareRootUkf<6, 3>>),
    #[cfg(feature = "every-method")]
    Eight(CgFilter<8, 3, SquareRootUkf<8, 3>>),
    #[cfg(feature = "every-method")]
    Nine(CgFilter<9, 3, SquareRootUkf<9, 3>>),
    #[cfg(feature = "every-method")]
    Ten(CgFilter<10, 4, SquareRootUkf<10, 4>>),
    #[cfg(feature = "every-method")]
    Twelve(CgFilter<12, 4, SquareRootUkf<12, 4>>),
    #[cfg(feature = "every-method")]
    SixByTangent(CgFilter<6, 3, Ekf<6, 3>>),
    EightByTangent(CgFilter<8, 3, Ekf<8, 3>>),
    NineByTangent(CgFilter<9, 3, Ekf<9, 3>>),
    TenByTangent(CgFilter<10, 4, Ekf<10, 4>>),
    TwelveByTangent(CgFilter<12, 4, Ekf<12, 4>>),
}

/// The same with whichever filter it is.
macro_rules! each {
    ($filter:expr, $f:ident => $then:expr) => {
        match $filter {
            #[cfg(feature = "every-method")]
            Filter::Six($f) => $then,
            #[cfg(feature = "every-method")]
            Filter::Eight($f) => $then,
            #[cfg(feature = "every-method")]
            Filter::Nine($f) => $then,
            #[cfg(feature = "every-method")]
            Filter::Ten($f) => $then,
            #[cfg(feature = "every-method")]
            Filter::Twelve($f) => $then,
            #[cfg(feature = "every-method")]
            Filter::SixByTangent($f) => $then,
            Filter::EightByTangent($f) => $then,
            Filter::NineByTangent($f) => $then,
            Filter::TenByTangent($f) => $then,
            Filter::TwelveByTangent($f) => $then,
        }
    };
}

/// Estimates the centre of gravity of a wheel loader while it works.
///
/// Every call of [`CgEstimator::step`] answers with finite numbers, whatever the row holds. A row whose time does not
/// increase is refused and changes nothing. A step does not allocate, does not read a clock, and does the same work each time.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CgEstimator {
    settings: Settings,
    method: Method,
    filter: Filter,
    refused: u64,
    /// Time between the last two accepted rows [s].
    period: f64,
    /// Rows refused since the last accepted one.
    refused_in_a_row: u32,
    last: Estimate,
    /// The lift arm, where it is described and the method is one for machines at work.
    lift: Option<LiftWitness>,
    witnesses: Witnesses,
}

impl CgEstimator {
    /// An estimator that waits for its first row.
    ///
    /// `full` and `full-ekf` need the acceleration column for their 10 states (11 with the delay of the speed) and run on 8 (9)
    /// without it.
    ///
    /// # Errors
    /// Names the first setting that cannot be used.
    pub fn new(
        settings: &Settings,
        method: Method,
        columns: Columns,
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        let late = usize::from(settings.at_work());
        let states = match (method.has_six_states(), columns.acceleration) {
            (true, _) => 6,
            (false, false) => 8 + late,
            (false, true) => 10 + late,
        };
        let filter = match (states, method.takes_tangent()) {
            (11, true) => Filter::TwelveByTangent(CgFilter::new(settings, method)),
            (10, true) => Filter::TenByTangent(CgFilter::new(settings, method)),
            (9, true) => Filter::NineByTangent(CgFilter::new(settings, method)),
            (8, true) => Filter::EightByTangent(CgFilter::new(settings, method)),
            (states, tangent) => other(settings, method, states, tangent)?,
        };
        let waiting = Status::Waiting;
        let mut last = each!(&filter, f => report(f, settings, method, &RowReport::without_update(waiting, false)));
        let lift = LiftWitness::new(
            &settings.lift_arm,
            &settings.lift_cylinder,
            &settings.machine,
            &settings.sensors,
            &settings.prior,
        )
        .filter(|_| settings.at_work());
        last.payload = lift.as_ref().map(LiftWitness::unknown);
        Ok(Self {
            settings: *settings,
            method,
            filter,
            refused: 0,
            period: 0.0,
            refused_in_a_row: 0,
            last,
            lift,
            witnesses: Witnesses::default(),
        })
    }

    /// Takes one row and answers.
    pub fn step(&mut self, sample: &Sample) -> Estimate {
        let machine = &self.settings.machine;
        let sample = sample.plausible(machine.mass, machine.wheel_radius);
        let weighed = self.weigh(&sample);
        let (settings, method) = (&self.settings, self.method);
        let mut answer = each!(&mut self.filter, f => step(f, settings, method, sample));
        if answer.status == Status::Refused {
            self.refused += 1;
            self.refused_in_a_row = self.refused_in_a_row.saturating_add(1);
            answer = self.stale();
        } else {
            let period = answer.time - self.last.time;
            // A clock that was set back says nothing of the time between rows.
            if period > 0.0 {
                self.period = period;
            }
            self.refused_in_a_row = 0;
            if let Some(weighed) = weighed {
                self.witnesses
                    .judge(&self.settings, &mut answer, &weighed, period);
            } else {
                answer.payload = self.lift.as_ref().map(LiftWitness::unknown);
            }
        }
        answer.refused = self.refused;
        self.last = answer;
        answer
    }

    /// What the lift pressure says of a plausible row that the clock will take.
    fn weigh(&mut self, sample: &Sample) -> Option<Weighed> {
        let lift = self.lift.as_mut()?;
        let weighed = lift.step(sample);
        let empty = lift.empty();
        each!(&mut self.filter, f => f.set_weighed(weighed, empty));
        weighed
    }

    /// The last answer to a row that was refused; believed only as long as inputs count as fresh.
    fn stale(&self) -> Estimate {
        let mut answer = Estimate {
            status: Status::Refused,
            ..self.last
        };
        if f64::from(self.refused_in_a_row) * self.period > self.settings.estimator.fresh {
            answer.fresh = false;
            answer.reason = Reason::Missing;
            (answer.trusted_ratio, answer.trusted_height) = (false, false);
        }
        answer
    }

    /// Tells the payload from weighing and boom position for the rows to come, or that there is none to be reported.
    ///
    /// From the first payload on, prior and states mean the empty machine, so tell it from the first row (mass 0 when
    /// empty). The reported values stay those of the loaded machine.
    pub fn set_payload(&mut self, payload: Option<Payload>) {
        each!(&mut self.filter, f => f.known_load.report(payload));
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The last answer; before the first row the prior.
    pub fn last(&self) -> &Estimate {
        &self.last
    }

    /// The filter's state \[v, w_f, w_r, K, h, lam, ..\], for analysis.
    pub fn state(&self) -> &[f64] {
        each!(&self.filter, f => f.state())
    }

    /// Standard deviation of state `i` in the filter, without floors and doubts, for analysis.
    pub fn state_std(&self, i: usize) -> f64 {
        each!(&self.filter, f => f.std(i))
    }
}

/// The filters beside those of `full-ekf`.
#[cfg(feature = "every-method")]
#[allow(clippy::unnecessary_wraps)] // the other build refuses
fn other(
    settings: &Settings,
    method: Method,
    states: usize,
    tangent: bool,
) -> Result<Filter, SettingsError> {
    Ok(match (states, tangent) {
        (_, true) => Filter::SixByTangent(CgFilter::new(settings, method)),
        (11, false) => Filter::Twelve(CgFilter::new(settings, method)),
        (10, false) => Filter::Ten(CgFilter::new(settings, method)),
        (9, false) => Filter::Nine(CgFilter::new(settings, method)),
        (8, false) => Filter::Eight(CgFilter::new(settings, method)),
        (_, false) => Filter::Six(CgFilter::new(settings, method)),
    })
}

/// Left out of this build.
#[cfg(not(feature = "every-method"))]
fn other(_: &Settings, method: Method, _: usize, _: bool) -> Result<Filter, SettingsError> {
    Err(SettingsError {
        key: "method",
        value: f64::from(method.index()),
        must_be: MustBe::FullEkf,
    })
}

fn step<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &mut CgFilter<N, M, B>,
    settings: &Settings,
    method: Method,
    sample: Sample,
) -> Estimate {
    let row = filter.step(sample);
    report(filter, settings, method, &row)
}

/// Centre of gravity with its load, and the deviations of filter and report.
fn intervals<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &CgFilter<N, M, B>,
    settings: &Settings,
    doubt: &Doubt,
) -> (Each<f64>, Intervals) {
    let x = filter.state();
    let layout = const { Layout::of(N) };
    let own = Each {
        ratio: x[CG_RATIO],
        height: x[CG_HEIGHT],
    };
    let std = Each {
        ratio: filter.std(CG_RATIO),
        height: filter.std(CG_HEIGHT),
    };
    let (centre, loaded_std) = filter.known_load.loaded(&settings.machine, own, std);
    let beyond = doubt.beyond;
    let reported = with_floors(
        settings,
        Learns {
            radii: layout.radii.is_some(),
            load_sensitivity: filter.sensitivity_left(),
            acceleration: M > 3,
        },
        centre,
        Each {
            ratio: norm(&[
                doubt.birge * loaded_std.ratio,
                beyond.ratio,
                doubt.wavering * centre.ratio,
            ]),
            height: norm(&[
                doubt.birge * loaded_std.height,
                beyond.height,
                doubt.wavering * centre.height,
            ]),
        },
    );
    let intervals = Intervals {
        filter: Each {
            ratio: doubt.birge * std.ratio,
            height: doubt.birge * std.height,
        },
        reported,
        ratio: centre.ratio,
    };
    (centre, intervals)
}

/// Values, intervals and verdict after a row.
fn report<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &CgFilter<N, M, B>,
    settings: &Settings,
    method: Method,
    row: &RowReport<M>,
) -> Estimate {
    let x = filter.state();
    let layout = const { Layout::of(N) };
    let doubt = filter.doubt();
    let (centre, intervals) = intervals(filter, settings, &doubt);
    let reported = intervals.reported;
    let verdict = filter
        .evidence
        .verdict(settings, &intervals, &doubt, row.frozen);
    let sound = verdict.consistent && verdict.fresh && !verdict.reset;
    let (excited, identifiable, converged) =
        (verdict.excited, verdict.identifiable, verdict.converged);
    let quantity = |i: usize| Quantity {
        value: x[i],
        std: filter.std(i),
    };
    let scale = |wheel: usize| layout.radii.map(|radii| 1.0 + x[radii[wheel]]);
    let used = row.accepted.iter().filter(|a| **a).count().max(1);
    Estimate {
        started: filter.last_time().is_some(),
        time: filter.last_time().unwrap_or(0.0),
        speed: x[SPEED],
        front_wheel_speed: x[FRONT_WHEEL],
        rear_wheel_speed: x[REAR_WHEEL],
        slip_stiffness: filter.slip_stiffness(),
        cg_height: Quantity {
            value: centre.height,
            std: reported.height,
        },
        cg_ratio: Quantity {
            value: centre.ratio,
            std: reported.ratio,
        },
        cg_distance: (1.0 - centre.ratio) * settings.machine.wheelbase,
        spade_force_x: layout.spade_force.map(|i| Quantity {
            value: filter.spade_force_x + x[i],
            std: filter.std(i),
        }),
        payload: None,
        trusted_payload: false,
        slope_bias: layout.slope_bias.map(|i| x[i]),
        front_radius_scale: scale(0),
        rear_radius_scale: scale(1),
        speed_delay: layout.speed_delay.map(quantity),
        nis: row.nis / used as f64,
        excited_ratio: excited.ratio,
        excited_height: excited.height,
        consistent: verdict.consistent,
        fresh: verdict.fresh,
        identifiable_ratio: identifiable.ratio,
        identifiable_height: identifiable.height,
        converged_ratio: converged.ratio,
        converged_height: converged.height,
        frozen: row.frozen,
        reset: verdict.reset,
        trusted_ratio: sound && excited.ratio && identifiable.ratio && converged.ratio,
        trusted_height: sound && excited.height && identifiable.height && converged.height,
        reason: verdict.reason,
        status: row.status,
        method,
        resets: filter.evidence.resets,
        refused: 0,
    }
}
