//! Attachment and material against inertia: the study behind Figs. 2 and 3 of the paper.
//!
//! JSON: `{"reference":J,"rows":[{"posture":1,"attachment":"bucket","payload":0,"inertia":..,"ratio":..},..]}`,
//! the ratio to the empty bucket in posture 1.

use crate::text::{Table, plain, verdict};
use crate::{Error, Options, Report};
use serde_json::json;
use sim::excavator::{Attachment, Geometry};

/// Boom, arm, bucket [deg].
const POSTURES: [[f64; 3]; 2] = [[55.0, -146.0, -85.0], [45.0, -75.0, -60.0]];
/// Ratios as specified, per posture: bucket 0 and 423 kg, crusher 0 and 423 kg.
const EXPECTED: [[f64; 4]; 2] = [[1.000, 1.330, 1.213, 1.399], [1.838, 3.472, 3.207, 4.841]];
/// Half of the last digit.
const TOLERANCE: f64 = 5e-4;

/// Evaluates the table; it needs no seeds.
pub fn evaluate(_: &Options) -> Result<Report, Error> {
    let tools = [
        ("bucket", Attachment::bucket()),
        ("crusher", Attachment::crusher()),
    ];
    let inertia = |tool: Attachment, posture: [f64; 3], mass: f64| {
        Geometry::with(tool)
            .inertia(posture.map(f64::to_radians), [0.0; 3])
            .total(mass)
    };
    let reference = inertia(tools[0].1, POSTURES[0], 0.0);
    let mut table = Table::headed("posture; attachment; payload kg; inertia kg m2; ratio; target");
    let (mut rows, mut met) = (Vec::new(), true);
    for (number, posture) in POSTURES.into_iter().enumerate() {
        let loads = tools.iter().flat_map(|tool| [(tool, 0.0), (tool, 423.0)]);
        for (((name, tool), mass), expected) in loads.zip(EXPECTED[number]) {
            let value = inertia(*tool, posture, mass);
            let ratio = value / reference;
            let close = (ratio - expected).abs() <= TOLERANCE;
            met &= close;
            let cells = [
                (number + 1).to_string(),
                (*name).to_owned(),
                plain(mass, 0),
                plain(value, 1),
                plain(ratio, 3),
            ];
            table.row(cells.into_iter().chain([verdict(close)]));
            rows.push(json!({
                "posture": number + 1, "attachment": name, "payload": mass, "inertia": value, "ratio": ratio,
            }));
        }
    }
    let text = format!(
        "Attachment and material (Figs. 2, 3): inertia relative to the empty bucket in posture 1\n\n{table}"
    );
    Ok(Report {
        text,
        json: json!({ "reference": reference, "rows": rows }),
        met,
    })
}
