//! The estimate after a row: values, intervals and verdict.

use super::Method;
use super::doubts::stated_ratio::together;
use super::estimate::Estimate;
use super::filter::{Belief, CgFilter, RowReport};
use super::floors::{Learns, with_floors};
use super::layout::{CG_HEIGHT, Each, FRONT_WHEEL, Layout, REAR_WHEEL, SPEED};
use super::settings::Settings;
use super::verdict::{Doubt, Intervals};
use crate::Quantity;
use crate::math::norm;

/// Shift of the centre of gravity by posture and load, as a share of the reported standard deviation, up to which it counts as that of the
/// empty machine. Stored from run to run it stays below .27 of that: of a trusted ratio the prior keeps at most a quarter (`verdict`).
const NEAR: f64 = 0.2;

/// Centre of gravity with its load, its shift from that of the states, and the standard deviations of filter and report.
fn intervals<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &CgFilter<N, M, B>,
    settings: &Settings,
    learns: &Learns,
    doubt: &Doubt,
) -> (Each<f64>, Each<f64>, Intervals) {
    let x = filter.state();
    let own = Each::of(|i| x[i]);
    let std = Each {
        ratio: doubt.ratio_std,
        height: filter.std(CG_HEIGHT),
    };
    let (centre, loaded_std) = filter.known_load.loaded(&settings.machine, own, std);
    let shift = Each {
        ratio: centre.ratio - own.ratio,
        height: centre.height - own.height,
    };
    let doubted = |std: f64, beyond: f64, centre: f64| {
        norm(&[doubt.birge * std, beyond, doubt.wavering * centre])
    };
    let doubted = Each {
        ratio: doubted(loaded_std.ratio, doubt.beyond.ratio, centre.ratio),
        height: doubted(loaded_std.height, doubt.beyond.height, centre.height),
    };
    let filter = Each {
        ratio: doubt.birge * std.ratio,
        height: doubt.birge * std.height,
    };
    let (mut centre, mut reported) = (centre, with_floors(settings, learns, centre, doubted));
    if let Some(stated) = doubt.stated {
        let slips = Quantity {
            value: centre.ratio,
            std: reported.ratio,
        };
        let limit = settings.estimator.converged_ratio * stated.value;
        let both = together(slips, filter.ratio, stated, limit);
        (centre.ratio, reported.ratio) = (both.value, both.std);
    }
    if doubt.spans > 0.0 {
        reported.ratio = norm(&[reported.ratio, doubt.spans]);
    }
    let intervals = Intervals {
        filter,
        reported,
        ratio: centre.ratio,
    };
    (centre, shift, intervals)
}

/// Whether the centre of gravity is that of the empty machine with its arm at the reference: a load is known to be absent, and what the
/// arm's posture and the weighed rest move is small against the reported standard deviations.
fn is_of_empty<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &CgFilter<N, M, B>,
    settings: &Settings,
    shift: Each<f64>,
    reported: Each<f64>,
) -> bool {
    if !filter.known_load.is_some() {
        return filter.is_told_empty(&settings.machine);
    }
    !filter.known_load.is_open()
        && shift.ratio.abs() <= NEAR * reported.ratio
        && shift.height.abs() <= NEAR * reported.height
}

/// Values, intervals and verdict after a row.
pub(super) fn answer<const N: usize, const M: usize, B: Belief<N, M>>(
    filter: &CgFilter<N, M, B>,
    settings: &Settings,
    method: Method,
    row: &RowReport<M>,
) -> Estimate {
    let x = filter.state();
    let layout = const { Layout::of(N) };
    let learns = filter.learns(settings);
    let doubt = filter.doubt(settings, &learns);
    let (centre, shift, intervals) = intervals(filter, settings, &learns, &doubt);
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
        slip_stiffness: filter.slip_stiffness(settings),
        cg_height: Quantity {
            value: centre.height,
            std: reported.height,
        },
        cg_ratio: Quantity {
            value: centre.ratio,
            std: reported.ratio,
        },
        cg_distance: (1.0 - centre.ratio) * settings.machine.wheelbase,
        spade_force_x: filter.digging_force(settings),
        payload: None,
        trusted_payload: false,
        changing: doubt.changing,
        of_empty: is_of_empty(filter, settings, shift, reported),
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
