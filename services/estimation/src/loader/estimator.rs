//! The estimator of the centre of gravity: one row in, one estimate out.

use super::answer::answer;
use super::doubts::witnesses::Witnesses;
use super::estimate::{Estimate, Status};
use super::filter::{Belief, CgFilter, RowReport};
use super::lift_arm::{LiftWitness, Said};
use super::load::payload::Payload;
#[cfg(not(feature = "every-method"))]
use super::settings::MustBe;
use super::settings::{Settings, SettingsError};
use super::{Columns, Method, Reason, Sample};
use crate::ekf::Ekf;
#[cfg(feature = "every-method")]
use crate::srukf::SquareRootUkf;

/// The filter that a method runs on. A controller with little flash has only those of `full-ekf` (without the feature
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

/// Applies an expression to whichever filter it is.
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
/// Every call of [`CgEstimator::step`] returns finite numbers, whatever the row contains. A row whose time does not increase is
/// refused and changes nothing. A step does not allocate, does not read a clock, and does the same work each time.
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
    /// An estimator before its first row.
    ///
    /// `full` and `full-ekf` need the acceleration column for their 12 states and run on 9 without it. They run on 10 and 8 where
    /// the machine is not taken for one at work.
    ///
    /// # Errors
    /// Names the first setting that cannot be used.
    pub fn new(
        settings: &Settings,
        method: Method,
        columns: Columns,
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        let states = match (columns.acceleration, settings.at_work()) {
            _ if method.has_six_states() => 6,
            (false, false) => 8,
            (false, true) => 9,
            (true, false) => 10,
            (true, true) => 12,
        };
        let filter = match (states, method.takes_tangent()) {
            (12, true) => Filter::TwelveByTangent(CgFilter::new(settings, method)),
            (10, true) => Filter::TenByTangent(CgFilter::new(settings, method)),
            (9, true) => Filter::NineByTangent(CgFilter::new(settings, method)),
            (8, true) => Filter::EightByTangent(CgFilter::new(settings, method)),
            (states, tangent) => other(settings, method, states, tangent)?,
        };
        let mut last = each!(&filter, f => {
            let row = RowReport::without_update(Status::Waiting, false);
            answer(f, settings, method, &row)
        });
        let lift = LiftWitness::new(settings).filter(|_| settings.at_work());
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

    /// Processes one row and returns the estimate.
    pub fn step(&mut self, sample: &Sample) -> Estimate {
        let machine = &self.settings.machine;
        let mut sample = sample.plausible(machine.mass, machine.wheel_radius);
        let (settings, method) = (&self.settings, self.method);
        // A row that the clock refuses changes nothing.
        let refused = self.refuses(sample.time);
        let lift = self.lift.as_mut().filter(|_| !refused);
        let weighed = lift.and_then(|lift| weigh(lift, &mut self.filter, settings, &sample));
        let mut answer = each!(&mut self.filter, f => step(f, settings, method, &mut sample));
        if answer.status == Status::Refused {
            self.refused += 1;
            self.refused_in_a_row = self.refused_in_a_row.saturating_add(1);
            answer = self.stale();
        } else {
            let period = answer.time - self.last.time;
            // A clock that was set back carries no information about the time between rows.
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
        self.last
    }

    /// Whether the clock will refuse a row of this time; called where a lift arm takes rows beside the filter.
    fn refuses(&self, time: f64) -> bool {
        self.lift.is_some() && each!(&self.filter, f => f.refuses(&self.settings, time))
    }

    /// The last estimate, for a row that was refused; trusted only as long as inputs count as fresh.
    fn stale(&self) -> Estimate {
        let mut answer = Estimate {
            status: Status::Refused,
            ..self.last
        };
        if f64::from(self.refused_in_a_row) * self.period > self.settings.estimator.fresh {
            answer.fresh = false;
            answer.reason = Reason::Missing;
            (answer.trusted_ratio, answer.trusted_height) = (false, false);
            answer.trusted_payload = false;
        }
        answer
    }

    /// Sets the payload, from weighing and boom position, for the rows to come; `None` where no payload is reported.
    ///
    /// From the first payload on, prior and states refer to the empty machine, so report it from the first row (mass 0 when empty).
    /// The estimate remains that of the loaded machine. While the lift pressures weigh the load, the weighing counts and not this
    /// payload.
    pub fn set_payload(&mut self, payload: Option<Payload>) {
        each!(&mut self.filter, f => f.known_load.report(payload));
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The last estimate; before the first row the prior.
    pub fn last(&self) -> &Estimate {
        &self.last
    }

    /// The filter's state \[v, w_f, w_r, K, h, lam, ..\], for analysis.
    pub fn state(&self) -> &[f64] {
        each!(&self.filter, f => f.state())
    }

    /// Standard deviation of state `i` in the filter, without floors and doubts, for analysis.
    #[doc(hidden)]
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
        (12, false) => Filter::Twelve(CgFilter::new(settings, method)),
        (10, false) => Filter::Ten(CgFilter::new(settings, method)),
        (9, false) => Filter::Nine(CgFilter::new(settings, method)),
        (8, false) => Filter::Eight(CgFilter::new(settings, method)),
        (_, false) => Filter::Six(CgFilter::new(settings, method)),
    })
}

/// Not in this build.
#[cfg(not(feature = "every-method"))]
fn other(_: &Settings, method: Method, _: usize, _: bool) -> Result<Filter, SettingsError> {
    Err(SettingsError {
        key: "method",
        value: f64::from(method.index()),
        must_be: MustBe::FullEkf,
    })
}

/// Returns what the lift pressure shows in a plausible row that the clock will accept.
fn weigh<'a>(
    lift: &'a mut LiftWitness,
    filter: &mut Filter,
    settings: &Settings,
    sample: &Sample,
) -> Option<Said<'a>> {
    let empty = lift.empty();
    let weighed = lift.step(sample, settings.estimator.fresh);
    // A reported payload is better than an unknown one.
    let counts =
        |said: &Said<'_>| !said.silent || !each!(&*filter, f => f.known_load.is_reported());
    let weighed = weighed.filter(counts);
    let carried = weighed.as_ref().map(|said| said.carried);
    each!(filter, f => f.set_weighed(settings, carried, empty));
    weighed
}

fn step<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &mut CgFilter<N, M, B>,
    settings: &Settings,
    method: Method,
    sample: &mut Sample,
) -> Estimate {
    let row = filter.step(settings, sample);
    answer(filter, settings, method, &row)
}
