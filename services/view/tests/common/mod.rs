//! Runs made up for the tests: the motion is plausible, the noise seeded, the verdict derived.
#![allow(dead_code, reason = "each test file uses a part")]

use messages::{
    ExcavatorEstimate, ExcavatorTruth, Health, Hops, LoaderEstimate, LoaderTruth, Stamp,
    SwingMotion, excavator_bits as x, loader_bits as l,
};
use view::{Estimator, MachineRun, Parts, Run};

/// Standard normal numbers: the sum of twelve uniform ones of a seeded generator.
pub struct Noise(pub u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

pub fn stamp(n: usize, rate: f64) -> Stamp {
    let time = n as f64 / rate;
    Stamp {
        sequence: n as u64,
        time,
        measured_ns: 1_000_000_000 + (time * 1e9) as u64,
        ..Default::default()
    }
}

/// Publish times with a lognormal-looking jitter of some microseconds.
fn hops(stamp: &Stamp, noise: &mut Noise, filtered: bool) -> Hops {
    let mut hop = |us: f64| (1e3 * us * (0.3 * noise.normal()).exp()) as u64;
    let sensor_ns = stamp.measured_ns + hop(6.0);
    let filter_ns = sensor_ns + hop(12.0);
    let estimate_ns = filter_ns + hop(14.0);
    Hops {
        sensor_ns,
        filter_ns: if filtered { filter_ns } else { 0 },
        estimate_ns,
        ..Default::default()
    }
}

/// Swing velocity and acceleration: two swings of 5 s with a pause after each.
fn swing(t: f64) -> (f64, f64) {
    let phase = (t % 7.0) / 5.0;
    if phase >= 1.0 {
        return (0.0, 0.0);
    }
    let (s, c) = (std::f64::consts::PI * phase).sin_cos();
    (0.9 * s * s, 0.9 * 2.0 * s * c * std::f64::consts::PI / 5.0)
}

pub fn excavator_truth(n: usize, rate: f64) -> ExcavatorTruth {
    let t = n as f64 / rate;
    let (velocity, acceleration) = swing(t);
    let inertia = 7000.0 + 1500.0 * (0.7 * t).sin();
    ExcavatorTruth {
        stamp: stamp(n, rate),
        inertia,
        damping: 1500.0,
        friction: 250.0,
        torque: inertia * acceleration + 1500.0 * velocity,
        velocity,
        acceleration,
        payload: 288.0,
        known: 0x7f,
        ..Default::default()
    }
}

pub fn excavator_estimate(
    n: usize,
    rate: f64,
    noise: &mut Noise,
    paper: bool,
) -> ExcavatorEstimate {
    let truth = excavator_truth(n, rate);
    let t = truth.stamp.time;
    let share = 0.012 + 0.3 * (-3.0 * (t - 0.4).max(0.0)).exp() + if paper { 0.03 } else { 0.0 };
    let wave = (2.1 * t).sin() + 0.3 * noise.normal();
    let excited = truth.velocity > 0.1;
    let mut flags = x::CONSISTENT | x::FRESH;
    flags |= if excited { x::EXCITED } else { x::HELD };
    flags |= if share * 1.96 < 0.1 { x::CONVERGED } else { 0 };
    flags |= if paper || t < 0.6 { 0 } else { x::IDENTIFIABLE };
    let all = x::CONSISTENT | x::FRESH | x::EXCITED | x::CONVERGED | x::IDENTIFIABLE;
    flags |= if flags & all == all { x::TRUSTED } else { 0 };
    flags |= if paper && t % 3.0 < 0.4 { x::WINDOW } else { 0 };
    flags |= if paper && (t * 3.0).sin() > 0.9 {
        x::NOMINAL
    } else {
        0
    };
    ExcavatorEstimate {
        stamp: truth.stamp,
        hops: hops(&truth.stamp, noise, paper),
        inertia: truth.inertia * (1.0 + share * 0.7 * wave),
        inertia_std: share * truth.inertia,
        payload: 288.0 + 20.0 * wave,
        payload_std: 25.0,
        damping: 1500.0 + 30.0 * wave,
        damping_std: 45.0,
        torque: truth.torque + 80.0 * noise.normal(),
        torque_std: 80.0,
        velocity: truth.velocity + 0.003 * noise.normal(),
        acceleration: truth.acceleration + 0.05 * noise.normal(),
        nis: noise.normal().powi(2),
        forgetting_inertia: if !paper {
            0.0
        } else if flags & x::WINDOW != 0 {
            1.0
        } else {
            0.99
        },
        forgetting_damping: if paper { 0.69 } else { 0.0 },
        forgetting_torque: if paper { 0.1 } else { 0.0 },
        flags,
        estimated: x::INERTIA
            | x::DAMPING
            | x::TORQUE
            | x::ACCELERATION
            | if paper { 0 } else { x::PAYLOAD },
        method: if paper { 1 } else { 3 },
        ..Default::default()
    }
}

pub fn loader_truth(n: usize, rate: f64) -> LoaderTruth {
    let t = n as f64 / rate;
    let speed = 2.0 * (0.25 * t).sin().abs();
    LoaderTruth {
        stamp: stamp(n, rate),
        speed,
        front_wheel_speed: speed / 0.55,
        rear_wheel_speed: speed / 0.55,
        cg_height: 0.91,
        cg_ratio: 0.42,
        slip_stiffness: 18.4,
        known: 0x3f,
        ..Default::default()
    }
}

pub fn loader_estimate(n: usize, rate: f64, noise: &mut Noise, method: u32) -> LoaderEstimate {
    let truth = loader_truth(n, rate);
    let t = truth.stamp.time;
    let ratio_std = 0.006 + 0.04 * (-0.3 * t).exp();
    let height_std = 0.06 + 0.1 * (-0.05 * t).exp();
    let wave = (0.4 * t + f64::from(method)).sin() + 0.1 * noise.normal();
    let mut flags = l::CONSISTENT | l::FRESH | l::EXCITED_RATIO | l::EXCITED_HEIGHT;
    if ratio_std < 0.03 * 0.42 {
        flags |= l::CONVERGED_RATIO | l::TRUSTED_RATIO;
    }
    let cg_ratio = 0.42 + ratio_std * 0.7 * wave;
    LoaderEstimate {
        stamp: truth.stamp,
        hops: hops(&truth.stamp, noise, false),
        speed: truth.speed + 0.01 * noise.normal(),
        front_wheel_speed: truth.front_wheel_speed,
        rear_wheel_speed: truth.rear_wheel_speed,
        slip_stiffness: 18.4 + 0.4 * wave,
        slip_stiffness_std: 0.6,
        cg_height: 0.91 + height_std * 0.6 * wave,
        cg_height_std: height_std,
        cg_ratio,
        cg_ratio_std: ratio_std,
        cg_distance: (1.0 - cg_ratio) * 2.8,
        front_radius_scale: 1.0 + 0.0001 * wave,
        rear_radius_scale: 1.0 - 0.0001 * wave,
        nis: (noise.normal().powi(2) + noise.normal().powi(2) + noise.normal().powi(2)) / 6.0,
        flags,
        estimated: l::STATE | l::RADIUS_SCALES,
        method,
        ..Default::default()
    }
}

pub fn health(process: u32, n: u64) -> Health {
    Health {
        stamp: Stamp {
            sequence: n,
            time: n as f64 * 0.1,
            ..Default::default()
        },
        process,
        pid: 4000 + process,
        state: 1,
        steps: 100 * n,
        late: n / 20,
        lost: u64::from(process),
        step_p50_ns: 410,
        step_p99_ns: 930,
        step_max_ns: 21_000,
        age_p50_ns: 22_000,
        age_p99_ns: 41_000,
        age_p999_ns: 95_000,
        age_max_ns: 310_000,
        ..Default::default()
    }
}

pub const PROCESSES: [&str; 5] = ["sensor", "kalman", "rls", "ukf", "logger"];

fn common(run: Run) -> Run {
    let pairs = [
        ("heft.version", "0.1.0"),
        ("scenario", "two swings <made up>"),
        ("seed", "1"),
        ("host", "test"),
        ("kernel", "Linux 6.1"),
        ("scheduling", "other"),
        (
            "config",
            "[machine]\nnominal_damping = 1500\n\n[sensors]\nrate = 100\nswing_velocity_std = 0.005\n",
        ),
        (
            "description.sha256",
            "8d969eef6ecad3c29a3a629280e686cf0c3f5d5a86aff3ca12020c923adc6c92",
        ),
    ];
    Run {
        metadata: pairs.map(|(k, v)| (k.to_owned(), v.to_owned())).to_vec(),
        health: (0..PROCESSES.len() as u32)
            .map(|p| health(p, 200))
            .collect(),
        processes: PROCESSES.map(str::to_owned).to_vec(),
        ..run
    }
}

/// Estimates of `seconds` at `rate` by two methods; sample 700 is lost.
pub fn excavator(seconds: f64, rate: f64, truth: bool) -> Run {
    let n = (seconds * rate) as usize;
    let mut noise = Noise(7);
    let mut estimates = |paper: bool| -> Vec<_> {
        (0..n)
            .filter(|&i| i != 700)
            .map(|i| excavator_estimate(i, rate, &mut noise, paper))
            .collect()
    };
    let estimators = vec![
        Estimator {
            channel: "excavator/inertia_rls".into(),
            estimates: estimates(true),
            extremes: Default::default(),
        },
        Estimator {
            channel: "excavator/inertia_ukf".into(),
            estimates: estimates(false),
            extremes: Default::default(),
        },
    ];
    let motion = |i: usize| SwingMotion {
        stamp: stamp(i, rate),
        innovation: 0.005 * noise.normal(),
        innovation_std: 0.005,
        ..Default::default()
    };
    let motion = (0..n).map(motion).collect();
    let truth = if truth {
        (0..n).map(|i| excavator_truth(i, rate)).collect()
    } else {
        Vec::new()
    };
    common(Run {
        parts: Parts {
            excavator: MachineRun { estimators, truth },
            ..Default::default()
        },
        motion,
        ..Default::default()
    })
}

pub fn loader(seconds: f64, rate: f64, truth: bool) -> Run {
    let n = (seconds * rate) as usize;
    let mut noise = Noise(11);
    let mut estimates = |method| -> Vec<_> {
        (0..n)
            .map(|i| loader_estimate(i, rate, &mut noise, method))
            .collect()
    };
    let estimators = vec![
        Estimator {
            channel: "loader/cg_ekf".into(),
            estimates: estimates(3),
            extremes: Default::default(),
        },
        Estimator {
            channel: "loader/cg_ukf".into(),
            estimates: estimates(0),
            extremes: Default::default(),
        },
    ];
    let truth = if truth {
        (0..n).map(|i| loader_truth(i, rate)).collect()
    } else {
        Vec::new()
    };
    common(Run {
        parts: Parts {
            loader: MachineRun { estimators, truth },
            ..Default::default()
        },
        ..Default::default()
    })
}

/// Writes the run as a recording.
pub fn record(path: &std::path::Path, metadata: &recording::Metadata, run: &Run) {
    use messages::channels::{self, EXCAVATOR_MOTION, EXCAVATOR_TRUTH, HEALTH, LOADER_TRUTH};
    let _ = std::fs::remove_file(path); // of an earlier test
    let mut writer = recording::Writer::create(path, metadata).expect("created");
    let channel = |name: &str| channels::find(name).expect("a channel of the table");
    run.health
        .iter()
        .for_each(|m| writer.write(&HEALTH, m).expect("written"));
    run.motion
        .iter()
        .for_each(|m| writer.write(&EXCAVATOR_MOTION, m).expect("written"));
    run.parts
        .excavator
        .truth
        .iter()
        .for_each(|m| writer.write(&EXCAVATOR_TRUTH, m).expect("written"));
    run.parts
        .loader
        .truth
        .iter()
        .for_each(|m| writer.write(&LOADER_TRUTH, m).expect("written"));
    for e in &run.parts.excavator.estimators {
        e.estimates
            .iter()
            .for_each(|m| writer.write(channel(&e.channel), m).expect("written"));
    }
    for e in &run.parts.loader.estimators {
        e.estimates
            .iter()
            .for_each(|m| writer.write(channel(&e.channel), m).expect("written"));
    }
    writer.finish().expect("finished");
}
