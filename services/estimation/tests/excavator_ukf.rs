//! The state-space modes are extended Kalman filters. The square-root UKF on the same model gives
//! the same inertia, up to a small share of the interval.

mod excavator_common;

use core::ops::Range;

use estimation::excavator::{Inertia, Method, Sample, SwingEstimator, Variant};
use estimation::model::Model;
use estimation::scalar::Scalar;
use estimation::sigma_points::Spread;
use estimation::srukf::SquareRootUkf;
use excavator_common::{COLUMNS, Table, golden_settings, samples};

/// Mode D over one step: velocity, payload, torque offset, damping.
struct Swing {
    period: f64,
    torque: f64,
    mean: Inertia,
    rate: Inertia,
}

impl Model<4, 1> for Swing {
    const DYNAMIC: usize = 1;
    const DIRECT: Range<usize> = 0..1;

    fn predict<T: Scalar>(&self, state: &[T; 4]) -> ([T; 4], [T; 1]) {
        let [w, m, d, b] = *state;
        let inertia = m * self.mean.per_payload + self.mean.empty;
        let rate = m * self.rate.per_payload + self.rate.empty;
        let friction = (w / 0.008).tanh() * 250.0;
        let acceleration = (d + self.torque - friction - (b + rate) * w) / inertia;
        ([w + acceleration * self.period, m, d, b], [w])
    }
}

fn step_between(before: &Sample, now: &Sample) -> Swing {
    let geometry = golden_settings().geometry;
    let inertia = |row: &Sample| geometry.inertia(row.posture.map(|q| q.unwrap()));
    let (a, b, h) = (inertia(before), inertia(now), now.time - before.time);
    Swing {
        period: h,
        torque: 0.5 * (before.torque.unwrap() + now.torque.unwrap()),
        mean: Inertia {
            empty: 0.5 * (a.empty + b.empty),
            per_payload: 0.5 * (a.per_payload + b.per_payload),
            ..Inertia::default()
        },
        rate: Inertia {
            empty: (b.empty - a.empty) / h,
            per_payload: (b.per_payload - a.per_payload) / h,
            ..Inertia::default()
        },
    }
}

#[test]
fn the_square_root_ukf_agrees_with_the_extended_kalman_filter_in_a_swing() {
    for case in 1..=3 {
        let rows = samples(&Table::golden(&format!("input_base_case{case}.csv")));
        let mut settings = golden_settings();
        settings.estimator.variant = Variant::Tolerant;
        let mut ekf = SwingEstimator::new(&settings, Method::PostureTorque, COLUMNS).unwrap();
        let mut ukf = None;
        let (mut worst, mut compared) = (0.0_f64, 0);
        for pair in rows.windows(2) {
            let e = ekf.step(&pair[1]);
            // The UKF does not model standstill: it starts with the state of the EKF when the machine
            // begins to move, detected by the torque or by a measured velocity.
            let (code, released) = (ekf.code(), ekf.details().velocity);
            if code == 1 {
                continue;
            }
            let setting_off = ukf.is_none();
            let filter: &mut SquareRootUkf<4, 1> = ukf.get_or_insert_with(|| {
                let (w, std) = match code {
                    2 => (released, f64::hypot(0.0025, 0.02)),
                    _ => (0.0, 1e-3),
                };
                let std = [std, 160.0, 60.0, 225.0];
                SquareRootUkf::new([w, 200.0, 0.0, 1500.0], &std, Spread::UNIT)
            });
            if setting_off && code == 2 {
                continue;
            }
            let swing = step_between(&pair[0], &pair[1]);
            let inertia = swing.mean.with_payload(filter.state[1]);
            let noise = [100.0 / 1.41 * swing.period / inertia, 0.1, 0.0, 0.0];
            filter.step(&swing, &noise, &[pair[1].velocity.unwrap()], &[0.005]);
            if !(6.5..9.0).contains(&pair[1].time) {
                continue;
            }
            let now = settings
                .geometry
                .inertia(pair[1].posture.map(|q| q.unwrap()));
            let difference = now.with_payload(filter.state[1]) - e.inertia;
            worst = worst.max((difference / e.inertia_std).abs());
            compared += 1;
        }
        println!("case {case}: worst difference {worst:.3} standard deviations");
        assert!(compared > 200 && worst < 0.3, "case {case}: {worst}");
    }
}
