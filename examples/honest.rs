//! Scores recordings with truth: trusted share of moving, wrong, rms, coverage.
use config::Excavator as Description;
use estimation::excavator::*;
use std::collections::BTreeMap;
fn main() {
    let folder = std::env::args()
        .nth(1)
        .unwrap_or("tests/golden/machines".into());
    let sets = std::env::args().nth(2).unwrap_or_default();
    let trace = std::env::var("TRACE").ok();
    let threshold: f64 = std::env::var("MOVING")
        .ok()
        .and_then(|v| v.parse().ok())
        .unwrap_or(0.05);
    let method = Method::parse(&std::env::var("METHOD").unwrap_or("auto".into())).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{folder}/excavator.json")).unwrap())
            .unwrap();
    let mut total = [0.0; 5];
    for (name, meta) in json.as_object().unwrap() {
        let mut d = Description::default();
        let mut all: Vec<String> = meta["sets"]
            .as_object()
            .unwrap()
            .iter()
            .map(|(k, v)| format!("{k}={}", v))
            .collect();
        all.extend(sets.split_whitespace().map(str::to_owned));
        d.set_all(&all).unwrap();
        let settings = kalman::excavator_settings(&d);
        let text = std::fs::read_to_string(format!("{folder}/{name}.csv")).unwrap();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let col: BTreeMap<&str, usize> = header.iter().enumerate().map(|(i, n)| (*n, i)).collect();
        let columns = Columns {
            velocity: true,
            angle: false,
            torque: true,
            posture: true,
        };
        let mut est = SwingEstimator::new(&settings, method, columns).unwrap();
        let (mut moving, mut trusted, mut wrong, mut sq, mut cov, mut rows) = (0, 0, 0, 0.0, 0, 0);
        let (mut tm, mut covmove, mut paysq) = (0, 0, 0.0);
        for line in lines {
            let cells: Vec<Option<f64>> = line.split(',').map(|c| c.parse().ok()).collect();
            let get = |n: &str| col.get(n).and_then(|&i| cells[i]);
            let sample = Sample {
                time: get("t").unwrap(),
                velocity: get("swing_velocity"),
                torque: get("swing_torque"),
                posture: [get("boom_angle"), get("arm_angle"), get("bucket_angle")],
                ..Sample::default()
            };
            let e = est.step(&sample);
            let truth = get("true_inertia").unwrap();
            let tw = get("true_velocity").unwrap();
            let err = e.inertia - truth;
            rows += 1;
            let is_moving = tw.abs() > threshold;
            if is_moving {
                moving += 1;
            }
            let covered = err.abs() <= 1.96 * e.inertia_std;
            if covered {
                cov += 1;
                if is_moving {
                    covmove += 1;
                }
            }
            if e.flags.trusted() {
                trusted += 1;
                if is_moving {
                    tm += 1;
                }
                sq += (err / truth) * (err / truth);
                if let Some(p) = e.payload {
                    paysq += (p.value - get("true_payload").unwrap()).powi(2);
                }
                if !covered || err.abs() > 0.1 * truth {
                    wrong += 1;
                }
            }
            if let Some(t) = &trace {
                if name.contains(t.as_str()) && rows % 10 == 0 {
                    println!(
                        "{:.2} w {:.3} T {:.0} true {:.0} est {:.0} +-{:.1}% err {:.1}% {} {} pay {:.0}/{:.0}+-{:.0}",
                        sample.time,
                        tw,
                        sample.torque.unwrap_or(0.0),
                        truth,
                        e.inertia,
                        196.0 * e.inertia_std / e.inertia,
                        100.0 * err / truth,
                        if e.flags.trusted() { "T" } else { "-" },
                        if covered { "c" } else { "X" },
                        e.payload.map_or(0.0, |p| p.value),
                        get("true_payload").unwrap(),
                        e.payload.map_or(0.0, |p| p.std)
                    );
                }
            }
        }
        let rated = meta["rated_payload_kg"].as_f64().unwrap();
        let v = [
            tm as f64 / moving as f64,
            wrong as f64 / (trusted as f64).max(1.0),
            100.0 * (sq / (trusted as f64).max(1.0)).sqrt(),
            cov as f64 / rows as f64,
            covmove as f64 / moving as f64,
        ];
        println!(
            "{name:28} trusted {:.3} wrong {:.3} rms {:.2} covered {:.3} moving {:.3} payload rms {:.1}%",
            v[0],
            v[1],
            v[2],
            v[3],
            v[4],
            100.0 * (paysq / (trusted as f64).max(1.0)).sqrt() / rated
        );
        for i in 0..5 {
            total[i] += v[i];
        }
    }
    println!(
        "mean {:?}",
        total.map(|t| (t / json.as_object().unwrap().len() as f64 * 1000.0).round() / 1000.0)
    );
}
