//! Calibration over simulated machines (`heft calibrate loader`): errors of the result from three recordings of two minutes,
//! coverage of its intervals, and errors of the estimator that uses it.
//!
//! Each seed is a machine of tier B (radii, torque gains, slope bias, tyres, resistance and mass not exactly known). Its speed is
//! up to 80 ms late and its torques up to 20 ms. Its axles differ in stiffness by up to 8 %. Its stiffness falls with the load by
//! an exponent of up to 0.15. Its load sensitivity differs from the stated one by 0.002 (standard deviation). The zero of its
//! accelerometer is off by 0.04 m/s^2 (standard deviation). The slope sensor of every other machine lags up to 0.5 s and follows
//! up to 40 % of the acceleration.
//! It drives two minutes empty, the same path back with the torque shifted between the axles, and elsewhere two minutes with
//! 1500 kg, weighed to 30 kg. The empty machine stood on axle scales of 0.5 %, level and tilted.
//!
//! JSON:
//! `{"load_sensitivity":{"median":..,"p95":..,"covered":..},..,"after":[{"line","ratio","height",..}],"machines":n,"refused":n}`:
//! errors in percent (radii of the radius, slope in mrad, delay in ms), coverage of the 95 % intervals in percent. `after` has
//! the largest errors of the estimator, median and p95 over the machines (`after_prompt` and `after_late` by slope sensor). They
//! are given for three descriptions: as described; as calibrated, which allows for other ground and worn tyres; and with the
//! uncertainty that may be stated on the ground of the recordings on the same day ([`same_ground`]).

mod machine;

use calibrate::loader::{self as calibration, Outcome, Role, StatedLoad};
use estimation::loader::{CgEstimator, Columns, Method, Settings};
use estimation::{HALF_WIDTH_95, Quantity};
use serde_json::{Map, Value, json};
use sim::loader::{Row, Run, Scenario, Simulation};
use sim::noise::Noise;

use machine::{Truth, input, way, weighed};

use super::candidate::{described, sample};
use super::honesty::{MOVING, judge};
use super::score::{Score, Summary};
use crate::text::{Table, plain, verdict};
use crate::{Error, Options, Report, seeds};
use statistics::judge::Tally;
use statistics::{median, p95, percentage};

/// Length of a recording, and of the work afterwards [s].
const LENGTH: f64 = 120.0;
const WORK: f64 = 160.0;
/// The weighed load and the accuracy of its scale [kg].
const LOAD: f64 = 1500.0;
const LOAD_STD: f64 = 30.0;
/// Standard deviation of the start of the return path from the mark [m].
const MARK_STD: f64 = 1.0;

/// Judged quantities: name, role, factor from the value to the printed unit; relative to the true value if the factor is
/// negative.
const JUDGED: [(&str, Role, f64); 16] = [
    ("front_radius", Role::FrontRadius, 100.0),
    ("rear_radius", Role::RearRadius, 100.0),
    ("load_sensitivity", Role::LoadSensitivity, -100.0),
    ("front_gain", Role::FrontGain, -100.0),
    ("rear_gain", Role::RearGain, -100.0),
    ("stiffness", Role::Stiffness, -100.0),
    ("stiffness_ratio", Role::StiffnessRatio, -100.0),
    ("load_exponent", Role::LoadExponent, 100.0),
    ("rolling_resistance", Role::Rolling, -100.0),
    ("slope_bias", Role::SlopeBias, 1e3),
    ("acceleration_offset", Role::AccelerationOffset, 1e3),
    ("slope_delay", Role::SlopeDelay, 1e3),
    ("slope_follows", Role::SlopeFollows, 100.0),
    ("speed_delay", Role::SpeedDelay, 1e3),
    ("ratio", Role::Ratio(0), -100.0),
    ("height", Role::Height(0), -100.0),
];

/// The estimator afterwards: line, scenario, largest allowed errors of ratio and height, median and p95 [percent].
const LINES: [(&str, Scenario, [f64; 2], [f64; 2]); 3] = [
    ("S1 bumpy", Scenario::Bumpy, [3.2, 9.2], [f64::INFINITY; 2]),
    (
        "S4 accel-decel",
        Scenario::AccelDecel,
        [3.0, 6.0],
        [f64::INFINITY; 2],
    ),
    (
        "work after 100 s",
        Scenario::WorkCycle,
        [f64::INFINITY, 2.0],
        [f64::INFINITY, 8.0],
    ),
];

/// Names of the three descriptions.
const DESCRIPTIONS: [&str; 3] = ["as described", "calibrated", "same ground"];
/// Uncertainty on the ground of the recordings, on the same day: slip stiffness, relative, and radii.
const SAME_GROUND: (f64, f64) = (0.02, 2e-4);

fn same_ground(calibrated: &config::Loader) -> config::Loader {
    let mut d = calibrated.clone();
    d.prior.slip_stiffness_std = SAME_GROUND.0 * d.prior.slip_stiffness;
    d.prior.radius_std = SAME_GROUND.1;
    d
}

/// Results of one machine.
struct MachineResult {
    /// Whether its slope sensor lags.
    lags: bool,
    /// Error of each judged parameter, and whether the interval holds.
    parameters: Vec<(f64, bool)>,
    /// Scores of each line by [`DESCRIPTIONS`].
    after: Vec<[Score; 3]>,
    /// Rows of the work in which the machine moves, for ratio and height.
    work: [Tally; 2],
}

fn one(seed: u64) -> Result<Option<MachineResult>, Error> {
    let truth = Truth::new(seed);
    let flat = truth.run(Scenario::WorkCycle, 1, None, LENGTH);
    let simulation = Simulation::new(&flat).map_err(Error::refused)?;
    let (machine, nominal) = (*simulation.machine(), *simulation.nominal());
    let mut noise = Noise::channel(seed, 101);
    let mass = Quantity {
        value: machine.mass + LOAD + LOAD_STD * noise.normal(),
        std: LOAD_STD,
    };
    let there = truth.rows(&flat)?;
    let length = way(&there).last().unwrap_or(0.0);
    let back = Run {
        road_seed: Some(flat.seed),
        turned_at: Some(length + MARK_STD * noise.normal()),
        ..truth.run(Scenario::Dither, 2, None, 2.0 * LENGTH)
    };
    let back = truth.rows(&back)?;
    let home = way(&back).take_while(|x| *x < length).count();
    let loaded = truth.run(Scenario::Dither, 3, Some(LOAD), LENGTH);
    let load = StatedLoad {
        mass: Some(mass),
        ..StatedLoad::default()
    };
    let inputs = [
        input("flat", &there, StatedLoad::default()),
        input("back", &back[..home], StatedLoad::default()),
        input("loaded", &truth.rows(&loaded)?, load),
    ];
    let before = described(&nominal);
    let outcome = calibration::calibrate(
        &inputs,
        &calibration::Options {
            weighed: weighed(&machine, &mut noise)?,
            out_and_back: &[[0, 1]],
            ..calibration::Options::of(&before)
        },
    )
    .map_err(Error::refused)?;
    if !outcome.faults.is_empty() {
        eprintln!("seed {seed}: {}", outcome.faults.join("; "));
        return Ok(None);
    }
    let Some((after, _)) = outcome.description(&before, &[]) else {
        return Ok(None);
    };
    let Some(parameters) = errors(&outcome, |role| true_value(role, &simulation, &truth)) else {
        return Ok(None);
    };
    let mut found = MachineResult {
        lags: truth.slope_lags(),
        parameters,
        after: Vec::new(),
        work: Default::default(),
    };
    for (course, (_, scenario, ..)) in LINES.into_iter().enumerate() {
        let duration = scenario.duration().min(WORK);
        let run = truth.run(scenario, 4 + course as u64, None, duration);
        let rows = truth.rows(&run)?;
        found.drive(&rows, scenario, [&before, &after, &same_ground(&after)])?;
    }
    Ok(Some(found))
}

/// True value of a parameter of the simulated machine.
fn true_value(role: Role, simulation: &Simulation, truth: &Truth) -> f64 {
    let (machine, gains) = (simulation.machine(), simulation.torque_gains());
    match role {
        Role::FrontRadius => machine.front_radius_error,
        Role::RearRadius => machine.rear_radius_error,
        Role::LoadSensitivity => machine.radius_load_sensitivity,
        Role::FrontGain => gains[0],
        Role::RearGain => gains[1],
        Role::Stiffness => machine.slip_stiffness,
        Role::StiffnessRatio => 1.0 + machine.stiffness_difference,
        Role::LoadExponent => machine.stiffness_exponent,
        Role::Rolling => machine.rolling_resistance,
        Role::SlopeBias => simulation.slope_bias(),
        Role::AccelerationOffset => truth.effects.acceleration_offset,
        Role::SlopeDelay => truth.effects.slope_lag,
        Role::SlopeFollows => truth.effects.slope_follows,
        Role::SpeedDelay => truth.effects.speed_delay,
        Role::Ratio(_) => machine.cg_ratio,
        Role::Height(_) => machine.cg_height,
        _ => 0.0,
    }
}

fn errors(outcome: &Outcome, true_value: impl Fn(Role) -> f64) -> Option<Vec<(f64, bool)>> {
    JUDGED
        .iter()
        .map(|&(_, role, factor)| {
            let quantity = outcome.quantity(role)?;
            let truth = true_value(role);
            let error = quantity.value - truth;
            let scale = if factor < 0.0 {
                -factor / truth
            } else {
                factor
            };
            Some((scale * error, error.abs() < HALF_WIDTH_95 * quantity.std))
        })
        .collect()
}

impl MachineResult {
    /// Runs the estimator with each description on the rows of a line.
    fn drive(
        &mut self,
        rows: &[Row],
        scenario: Scenario,
        descriptions: [&config::Loader; 3],
    ) -> Result<(), Error> {
        let mut scores = [Score::default(); 3];
        for (k, description) in descriptions.into_iter().enumerate() {
            let settings = Settings::of(description, Method::Full);
            let columns = Columns { acceleration: true };
            let mut estimator =
                CgEstimator::new(&settings, Method::Full, columns).map_err(Error::refused)?;
            for row in rows {
                let estimate = estimator.step(&sample(row));
                if row.time < scenario.evaluated_from() {
                    continue;
                }
                scores[k].take(row, &estimate);
                let works = scenario == Scenario::WorkCycle && row.truth.speed.abs() >= MOVING;
                if k == 1 && works {
                    let judged = judge(row, &estimate);
                    self.work
                        .iter_mut()
                        .zip(&judged)
                        .for_each(|(tally, row)| tally.push(row));
                }
            }
        }
        self.after.push(scores);
        Ok(())
    }
}

/// Evaluates the table.
pub(super) fn evaluate(options: &Options) -> Result<Report, Error> {
    let all = seeds(options, "calibration", one)?;
    let (machines, refused) = (all.len(), all.iter().filter(|f| f.is_none()).count());
    let found: Vec<MachineResult> = all.into_iter().flatten().collect();
    let mut json = Map::new();
    let mut table = Table::new(&["parameter", "median", "p95", "covered %"]);
    for (i, (name, ..)) in JUDGED.into_iter().enumerate() {
        let errors: Vec<f64> = found.iter().map(|f| f.parameters[i].0.abs()).collect();
        let covered = percentage(found.iter().map(|f| f.parameters[i].1));
        table.row([
            name.to_owned(),
            plain(median(&errors), 3),
            plain(p95(&errors), 3),
            plain(covered, 1),
        ]);
        json.insert(
            name.to_owned(),
            json!({"median": median(&errors), "p95": p95(&errors), "covered": covered}),
        );
    }
    let mut tables = String::new();
    let mut good = true;
    for (name, title, lags) in [
        ("after", "all machines", None),
        (
            "after_prompt",
            "slope sensors with a zero alone",
            Some(false),
        ),
        (
            "after_late",
            "slope sensors that lag and follow",
            Some(true),
        ),
    ] {
        let of: Vec<&MachineResult> = found
            .iter()
            .filter(|f| lags.is_none_or(|lags| f.lags == lags))
            .collect();
        let (lines, records, met) = lines(&of);
        json.insert(name.into(), Value::Array(records));
        tables += &format!("{title} ({})\n{lines}\n", of.len());
        good &= met || lags.is_some();
    }
    let mut text = format!(
        "Calibration of {machines} simulated loaders from two recordings of {LENGTH} s empty and one with {LOAD} kg ({refused} refused); errors in percent, of the slope in mrad, of delays in ms\n{table}\n\
         The estimator afterwards on new drives: largest error [%], median (p95) over the machines\n{tables}"
    );
    for (i, what) in ["ratio", "height"].into_iter().enumerate() {
        let mut work = Tally::default();
        found.iter().for_each(|f| work.add(&f.work[i]));
        let (trusted, wrong) = (100.0 * work.trusted(), 100.0 * work.wrong());
        text += &format!(
            "  {what} after 100 s of work: trusted {trusted:.0} % of the motion, of these {wrong:.1} % wrong\n"
        );
        json.insert(
            format!("{what}_after"),
            json!({"trusted": trusted, "wrong": wrong}),
        );
    }
    json.insert("machines".into(), json!(machines));
    json.insert("refused".into(), json!(refused));
    Ok(Report {
        text,
        json: Value::Object(json),
        met: good && refused == 0,
    })
}

/// The lines of the estimator, their records, and whether all targets are met.
fn lines(found: &[&MachineResult]) -> (Table, Vec<Value>, bool) {
    let mut table =
        Table::headed("line; ; ratio; rms; covered %; height; rms; covered %; target; ");
    let (mut records, mut met) = (Vec::new(), true);
    for (l, (line, _, ratio, height)) in LINES.into_iter().enumerate() {
        for (k, name) in DESCRIPTIONS.into_iter().enumerate() {
            let scores: Vec<Vec<Score>> = found.iter().map(|f| vec![f.after[l][k]]).collect();
            let summary = Summary::of(&scores, 0);
            let below = |errors: &super::score::Errors, limits: [f64; 2]| {
                errors.median <= limits[0] && errors.p95 <= limits[1]
            };
            let good = below(&summary.ratio, ratio) && below(&summary.height, height);
            met &= good || k != 1;
            let cell = |x: f64| {
                if x.is_finite() {
                    plain(x, 1)
                } else {
                    "-".into()
                }
            };
            let limit = |limits: [f64; 2]| limits.map(cell).join(" / ");
            let target = format!("{}; {}", limit(ratio), limit(height));
            let judged = match k {
                0 => [String::new(), String::new()],
                _ => [target, verdict(good)],
            };
            let mut cells = vec![line.to_owned(), name.to_owned()];
            cells.extend(summary.quantities());
            cells.extend(judged);
            table.row(cells);
            let mut record = summary.json();
            record["line"] = json!(line);
            record["description"] = json!(name);
            records.push(record);
        }
    }
    (table, records, met)
}
