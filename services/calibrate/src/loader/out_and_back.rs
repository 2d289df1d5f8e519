//! The same path out and back: places that the machine passes in both directions.
//!
//! Turned round, the machine has the opposite slope in every place, and the zero of the slope sensor stays:
//! ```text
//! th_there(x) + th_back(x) = 0,   th = (s + tau_s s' - b - kappa (a/g))/(1 - kappa)
//! ```
//! The mean over a section of the path therefore determines the zero b, for any road. The motion then determines that of the accelerometer,
//! and the balance of force the rolling resistance. Places are matched by the distance that the wheels roll. The tracks are not
//! exactly the same, and the marks are met within some metres. The offset is the one at which the slopes mirror each other best; where
//! they do not, it is not the same path. The rest of the offset resembles a delay of the sensor (0.1 m at 3 m/s is 17 ms), so it
//! is also a parameter.

use std::collections::BTreeMap;

use super::drive::Drive;
use super::guess::Guess;
use crate::model::Innovation;

/// Length of a cell, over which slopes are compared, and the step of the offset [m].
const CELL: f64 = 2.0;
const STEP: f64 = 0.5;
/// Number of cells in a section.
const CELLS: i64 = 5;
/// Distance within which marks are met [m]; the lengths out and back agree within it or within this share.
const MARK: f64 = 10.0;
const SHARE: f64 = 0.05;
/// Least number of cells that both drives pass.
const FEWEST: usize = 50;
/// Least correlation of the slopes on the same path.
const SAME: f64 = 0.9;

/// Rows of a drive with their weights, whose sum is 1.
type Rows = Vec<(usize, f64)>;

/// A section of the path.
#[derive(Debug, Clone)]
pub struct Section {
    /// Its rows, out and back.
    rows: [Rows; 2],
    /// Gradient of the outward slope [rad/m].
    gradient: f64,
}

/// Two recordings of the same path.
#[derive(Debug, Clone)]
pub struct OutAndBack {
    /// Out and back.
    pub recordings: [usize; 2],
    /// Its sections.
    pub sections: Vec<Section>,
    /// Correlation of the slope out with the negative slope back.
    pub correlation: f64,
}

impl OutAndBack {
    /// Matches two drives under values of the sensors.
    ///
    /// # Errors
    /// Explains why they are not the same path out and back.
    pub fn new(drives: &[Drive], recordings: [usize; 2], g: &Guess) -> Result<Self, String> {
        let [there, back] = recordings.map(|r| &drives[r]);
        let [out, home] = [there, back].map(|drive| distances(drive, g.radius));
        let [far, near] = [&out, &home].map(|rolled| rolled.last().copied().unwrap_or(0.0));
        if far * near < 0.0 {
            return Err("the machine was not turned round but drove back in reverse, where the slope keeps its sign".into());
        }
        if (far.abs() - near.abs()).abs() > MARK.max(SHARE * far.abs()) {
            return Err(format!(
                "there it goes {:.0} m and back {:.0} m",
                far.abs(),
                near.abs()
            ));
        }
        let cells_there = cells(there, &out, |x| x);
        let slopes_there = slopes(there, &cells_there, g);
        let steps = (MARK / STEP) as i32;
        let (mut best, mut same, mut most) = (0.0, -1.0, 0);
        for k in -steps..=steps {
            let end = 0.5 * (far + near) + STEP * f64::from(k);
            let slopes_back = slopes(back, &cells(back, &home, |x| end - x), g);
            let (correlation, count) = mirrored(&slopes_there, &slopes_back);
            most = most.max(count);
            if count >= FEWEST && correlation > same {
                (best, same) = (end, correlation);
            }
        }
        if most < FEWEST {
            return Err(format!(
                "they have only {:.0} m of straight driving in common",
                CELL * most as f64
            ));
        }
        if same < SAME {
            return Err(format!(
                "the slopes out and back do not mirror each other (correlation {same:.2}, of one path {SAME} or more): it is another path, or one too even to tell"
            ));
        }
        let cells_back = cells(back, &home, |x| best - x);
        Ok(Self {
            recordings,
            sections: sections(&cells_there, &cells_back, &slopes_there),
            correlation: same,
        })
    }

    /// The residual of a section under the values of both drives, the second starting this far `ahead` of the match [m].
    pub fn residual(
        &self,
        drives: &[Drive],
        section: usize,
        guesses: &[Guess; 2],
        ahead: f64,
    ) -> Innovation {
        let section = &self.sections[section];
        let mean = |i: usize| -> f64 {
            let drive = &drives[self.recordings[i]];
            let rows = section.rows[i].iter();
            rows.map(|&(k, weight)| weight * slope(drive, &guesses[i], k))
                .sum()
        };
        let std = guesses[0].scatter.path;
        Innovation {
            value: mean(0) + mean(1) + section.gradient * ahead,
            variance: std * std,
        }
    }

    /// Length that both drives pass [m].
    pub fn length(&self) -> f64 {
        CELL * CELLS as f64 * self.sections.len() as f64
    }
}

/// Slope of the road from the sensor in a row.
fn slope(drive: &Drive, g: &Guess, k: usize) -> f64 {
    let prompt = drive.slope[k] + g.slope_delay * drive.slope_rates[k];
    g.prompt_slope(prompt, g.force(drive, k))
}

/// Distance that the wheels have rolled at each row, forward positive [m].
fn distances(drive: &Drive, radius: f64) -> Vec<f64> {
    let (mut rolled, mut speed) = (0.0, 0.0);
    let mut last = drive.time.first().copied().unwrap_or(0.0);
    let rows = drive.time.iter().enumerate();
    rows.map(|(k, &time)| {
        let rim = 0.5 * radius * (drive.wheels[0][k] + drive.wheels[1][k]);
        let now = if rim.is_finite() { rim } else { speed };
        rolled += 0.5 * (speed + now) * (time - last);
        (speed, last) = (now, time);
        rolled
    })
    .collect()
}

/// The rows of straight driving in each cell of the path.
fn cells(drive: &Drive, rolled: &[f64], place: impl Fn(f64) -> f64) -> BTreeMap<i64, Vec<usize>> {
    let mut cells: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    let is_whole = |k: &usize| !drive.has_acceleration || drive.acceleration[*k].is_finite();
    for k in drive.blocks.iter().flat_map(Clone::clone).filter(is_whole) {
        let cell = (place(rolled[k]) / CELL).floor() as i64;
        cells.entry(cell).or_default().push(k);
    }
    cells
}

/// Mean slope in each cell.
fn slopes(drive: &Drive, cells: &BTreeMap<i64, Vec<usize>>, g: &Guess) -> BTreeMap<i64, f64> {
    let mean = |rows: &Vec<usize>| {
        rows.iter().map(|&k| slope(drive, g, k)).sum::<f64>() / rows.len() as f64
    };
    cells
        .iter()
        .map(|(cell, rows)| (*cell, mean(rows)))
        .collect()
}

/// Correlation of the slopes out with the negative slopes back in the common cells, and their number.
fn mirrored(there: &BTreeMap<i64, f64>, back: &BTreeMap<i64, f64>) -> (f64, usize) {
    let both: Vec<(f64, f64)> = there
        .iter()
        .filter_map(|(cell, a)| Some((*a, -back.get(cell)?)))
        .collect();
    let count = both.len().max(1) as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| both.iter().map(of).sum::<f64>() / count;
    let middle = (mean(|p| p.0), mean(|p| p.1));
    let moment = |of: fn(f64, f64) -> f64| -> f64 {
        let away = both.iter().map(|p| (p.0 - middle.0, p.1 - middle.1));
        away.map(|(a, b)| of(a, b)).sum()
    };
    let size = (moment(|a, _| a * a) * moment(|_, b| b * b)).sqrt();
    let correlation = if size > 0.0 {
        moment(|a, b| a * b) / size
    } else {
        0.0
    };
    (correlation, both.len())
}

/// The sections of which both drives pass every cell.
fn sections(
    there: &BTreeMap<i64, Vec<usize>>,
    back: &BTreeMap<i64, Vec<usize>>,
    slopes: &BTreeMap<i64, f64>,
) -> Vec<Section> {
    let mut sections: BTreeMap<i64, (i64, [Rows; 2])> = BTreeMap::new();
    for (cell, rows) in there {
        let Some(others) = back.get(cell) else {
            continue;
        };
        let (count, section) = sections.entry(cell.div_euclid(CELLS)).or_default();
        *count += 1;
        for (side, rows) in section.iter_mut().zip([rows, others]) {
            let weight = 1.0 / (CELLS as f64 * rows.len() as f64);
            side.extend(rows.iter().map(|&k| (k, weight)));
        }
    }
    let whole = sections.into_iter().filter(|(_, of)| of.0 == CELLS);
    whole
        .map(|(number, (_, rows))| {
            let (first, last) = (CELLS * number, CELLS * (number + 1) - 1);
            let rise = slopes[&last] - slopes[&first];
            Section {
                rows,
                gradient: rise / (CELL * (CELLS - 1) as f64),
            }
        })
        .collect()
}
