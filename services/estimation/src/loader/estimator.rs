//! The estimator of the centre of gravity: one row in, one answer out.

use super::cg_model::has_delay;
use super::estimate::{Estimate, Status};
use super::filter::{CgFilter, RowReport};
use super::payload::Payload;
use super::settings::{Settings, SettingsError};
use super::verdict::{Intervals, with_floors};
use super::{Columns, Method, Reason, Sample};
use crate::Quantity;
use crate::math::sqrt;
use crate::root::standard_deviations;

/// The filter that a method runs on.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant)] // no allocator
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Filter {
    Six(CgFilter<6, 3>),
    Eight(CgFilter<8, 3>),
    Nine(CgFilter<9, 3>),
    Ten(CgFilter<10, 4>),
    Eleven(CgFilter<11, 4>),
}

/// The same with whichever filter it is.
macro_rules! each {
    ($filter:expr, $f:ident => $then:expr) => {
        match $filter {
            Filter::Six($f) => $then,
            Filter::Eight($f) => $then,
            Filter::Nine($f) => $then,
            Filter::Ten($f) => $then,
            Filter::Eleven($f) => $then,
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
}

impl CgEstimator {
    /// An estimator that waits for its first row.
    ///
    /// `full` needs the acceleration column for its 10 states and runs on 8 without it.
    ///
    /// # Errors
    /// Names the first setting that cannot be used.
    pub fn new(
        settings: &Settings,
        method: Method,
        columns: Columns,
    ) -> Result<Self, SettingsError> {
        settings.check(method)?;
        let mut settings = *settings;
        let mut tuning = settings.tuning(method);
        tuning.linearised |= method == Method::Ekf;
        settings.tuning = Some(tuning);
        let filter = match method {
            Method::Full => match (columns.acceleration, tuning.latency) {
                (true, true) => Filter::Eleven(CgFilter::new(&settings, method)),
                (true, false) => Filter::Ten(CgFilter::new(&settings, method)),
                (false, true) => Filter::Nine(CgFilter::new(&settings, method)),
                (false, false) => Filter::Eight(CgFilter::new(&settings, method)),
            },
            _ => Filter::Six(CgFilter::new(&settings, method)),
        };
        let last = each!(&filter, f => report(f, &settings, method, &waiting()));
        Ok(Self {
            settings,
            method,
            filter,
            refused: 0,
            period: 0.0,
            refused_in_a_row: 0,
            last,
        })
    }

    /// Takes one row and answers.
    pub fn step(&mut self, sample: &Sample) -> Estimate {
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
        }
        answer.refused = self.refused;
        self.last = answer;
        answer
    }

    /// The last answer to a row that was refused; believed only as long as inputs count as fresh.
    fn stale(&self) -> Estimate {
        let mut answer = Estimate {
            status: Status::Refused,
            ..self.last
        };
        if f64::from(self.refused_in_a_row) * self.period > self.settings.verdict.fresh {
            answer.fresh = false;
            answer.reason = Reason::Missing;
            (answer.trusted_ratio, answer.trusted_height) = (false, false);
        }
        answer
    }

    /// Tells the payload from weighing and boom position for the rows to come, or that there is none to be told.
    ///
    /// From the first payload on, prior and states mean the empty machine, so tell it from the first row (mass 0 when
    /// empty). The reported values stay those of the loaded machine.
    pub fn set_payload(&mut self, payload: Option<Payload>) {
        each!(&mut self.filter, f => f.set_payload(payload));
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

    /// Row `i` of the lower root of the filter's covariance, for analysis.
    pub fn covariance_root_row(&self, i: usize) -> &[f64] {
        each!(&self.filter, f => &f.covariance_root()[i])
    }
}

fn waiting<const M: usize>() -> RowReport<M> {
    RowReport {
        status: Status::Waiting,
        nis: 0.0,
        accepted: [false; M],
        deweighted: [false; M],
        frozen: false,
        set_aside: false,
    }
}

fn step<const N: usize, const M: usize>(
    filter: &mut CgFilter<N, M>,
    settings: &Settings,
    method: Method,
    sample: &Sample,
) -> Estimate {
    let row = filter.step(sample);
    report(filter, settings, method, &row)
}

/// Values, intervals and verdict after a row.
fn report<const N: usize, const M: usize>(
    filter: &CgFilter<N, M>,
    settings: &Settings,
    method: Method,
    row: &RowReport<M>,
) -> Estimate {
    let x = filter.state();
    let std = standard_deviations(filter.covariance_root());
    let (height, ratio, loaded_std) = loaded(filter, settings, (x[4], x[5]), (std[4], std[5]));
    let doubt = filter.doubt();
    let reported = with_floors(
        settings,
        filter.tuning(),
        N > 6,
        (ratio, height),
        (
            widened(doubt.birge * loaded_std.1, doubt.beyond[0]),
            widened(doubt.birge * loaded_std.0, doubt.beyond[1]),
        ),
    );
    let intervals = Intervals {
        filter: (doubt.birge * std[5], doubt.birge * std[4]),
        reported,
        ratio,
    };
    let verdict = filter
        .evidence
        .verdict(settings, &intervals, &doubt, row.frozen);
    let sound = verdict.consistent && verdict.fresh && !verdict.reset;
    let radii = match N {
        10 | 11 => Some((x[7], x[8])),
        8 | 9 => Some((x[6], x[7])),
        _ => None,
    };
    let delay = has_delay(N).then(|| Quantity {
        value: x[N - 1],
        std: std[N - 1],
    });
    let used = row.accepted.iter().filter(|a| **a).count().max(1);
    Estimate {
        started: filter.last_time().is_some(),
        time: filter.last_time().unwrap_or(0.0),
        speed: x[0],
        front_wheel_speed: x[1],
        rear_wheel_speed: x[2],
        slip_stiffness: Quantity {
            value: x[3],
            std: std[3],
        },
        cg_height: Quantity {
            value: height,
            std: reported.1,
        },
        cg_ratio: Quantity {
            value: ratio,
            std: reported.0,
        },
        cg_distance: (1.0 - ratio) * settings.machine.wheelbase,
        spade_force_x: (N >= 10).then(|| Quantity {
            value: filter.spade_force_x + x[6],
            std: std[6],
        }),
        slope_bias: (N >= 10).then(|| x[9]),
        front_radius_scale: radii.map(|r| 1.0 + r.0),
        rear_radius_scale: radii.map(|r| 1.0 + r.1),
        speed_delay: delay,
        nis: row.nis / used as f64,
        excited_ratio: verdict.excited_ratio,
        excited_height: verdict.excited_height,
        consistent: verdict.consistent,
        fresh: verdict.fresh,
        identifiable_ratio: verdict.identifiable_ratio,
        identifiable_height: verdict.identifiable_height,
        converged_ratio: verdict.converged_ratio,
        converged_height: verdict.converged_height,
        frozen: row.frozen,
        reset: verdict.reset,
        trusted_ratio: sound
            && verdict.excited_ratio
            && verdict.identifiable_ratio
            && verdict.converged_ratio,
        trusted_height: sound
            && verdict.excited_height
            && verdict.identifiable_height
            && verdict.converged_height,
        reason: verdict.reason,
        status: row.status,
        method,
        resets: filter.evidence.resets,
        refused: 0,
    }
}

/// The norm of two standard deviations; exactly the first where the second is zero.
fn widened(std: f64, beyond: f64) -> f64 {
    if beyond > 0.0 {
        sqrt(std * std + beyond * beyond)
    } else {
        std
    }
}

/// Height, ratio and their standard deviations (height first) with a known payload added.
fn loaded<const N: usize, const M: usize>(
    filter: &CgFilter<N, M>,
    settings: &Settings,
    (height, ratio): (f64, f64),
    std: (f64, f64),
) -> (f64, f64, (f64, f64)) {
    let Some(payload) = filter.payload() else {
        return (height, ratio, std);
    };
    let (mass, wheelbase) = (settings.machine.mass, settings.machine.wheelbase);
    let loading = payload.loading(mass, wheelbase);
    let height = loading.share * height + loading.height;
    let ratio = loading.share * ratio + loading.ratio;
    (
        height,
        ratio,
        payload.loaded_std(mass, wheelbase, (height, ratio), std),
    )
}
