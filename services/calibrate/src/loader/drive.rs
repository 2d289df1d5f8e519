//! A prepared recording of a loader: its rows, and its stretches of driving.

use std::ops::Range;

use estimation::loader::{Sample, wheel_spins};

use crate::column::{increasing, moving_mean, percentile};

/// Duration of a bin [s].
pub const BIN: f64 = 0.5;
/// Speed below which slip carries no information [m/s].
const SLOWEST: f64 = 0.7;
/// Period below which rows are averaged [s].
const PERIOD: f64 = 0.05;
/// Half width of the window that smooths torques and slope [s].
const WINDOW: f64 = 0.011;
/// Half width of the window in which torque and slope are differentiated [s].
const RATE: f64 = 0.051;
/// Half width of the window that smooths the speed to find stretches [s].
const SPEED_WINDOW: f64 = 0.1;
/// Longest duration of a stretch, and its least [s].
const LENGTH: f64 = 5.05;
const SHORTEST: f64 = 1.0;
/// Longest gap in the rows of a stretch [s].
const HOLE: f64 = 0.1;
/// Bucket force, as a share of the weight, above which the machine digs.
const DIGGING: f64 = 0.01;
/// Articulation, or yaw per wheelbase, above which the machine drives a curve [rad].
const BENT: f64 = 0.03;
/// Share of the driving time beyond which a wheel that seems to spin has another radius or unit than stated.
const MOST_SPIN: f64 = 1.0 / 3.0;
/// Duration at both ends of a recording that is left out, because delayed signals are read there [s].
const ENDS: f64 = 0.5;

/// A prepared recording; missing values are NaN.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Its name, for sentences.
    pub name: String,
    /// Time of each row \[s\].
    pub time: Vec<f64>,
    /// Speed [m/s].
    pub speed: Vec<f64>,
    /// Wheel speeds, front and rear [rad/s].
    pub wheels: [Vec<f64>; 2],
    /// Axle torques, smoothed, gaps filled, front and rear [N m].
    pub torques: [Vec<f64>; 2],
    /// Their rates [N m/s].
    pub torque_rates: [Vec<f64>; 2],
    /// Measured slope, smoothed, gaps filled \[rad\].
    pub slope: Vec<f64>,
    /// Its rate [rad/s].
    pub slope_rates: Vec<f64>,
    /// Specific force [m/s^2].
    pub acceleration: Vec<f64>,
    /// Median of the measured mass; `None` without a column \[kg\].
    pub mass: Option<f64>,
    /// Stretches of driving.
    pub blocks: Vec<Range<usize>>,
    /// Whether there is an accelerometer.
    pub has_acceleration: bool,
}

impl Drive {
    /// Prepares a recording; `weight` \[N\] is the scale of digging forces, `wheelbase` \[m\] that of curves.
    pub fn new(name: &str, samples: &[Sample], weight: f64, wheelbase: f64) -> Self {
        let rows = averaged(&increasing(samples, |s| s.time));
        let column = |of: fn(&Sample) -> Option<f64>| -> Vec<f64> {
            rows.iter().map(|s| of(s).unwrap_or(f64::NAN)).collect()
        };
        let time: Vec<f64> = rows.iter().map(|s| s.time).collect();
        let inputs = [
            column(|s| s.front_torque),
            column(|s| s.rear_torque),
            column(|s| s.slope),
        ]
        .map(|values| moving_mean(&time, &values, WINDOW));
        let acceleration = column(|s| s.acceleration);
        let speed = column(|s| s.speed);
        let pace = moving_mean(&time, &speed, SPEED_WINDOW);
        let masses: Vec<f64> = rows.iter().filter_map(|s| s.mass).collect();
        let drives: Vec<bool> = rows
            .iter()
            .enumerate()
            .map(|(k, s)| {
                pace[k].abs() > SLOWEST
                    && inputs.iter().all(|values| values[k].is_finite())
                    && !digs(s, weight)
                    && !turns(s, pace[k], wheelbase)
                    && !s.brake
            })
            .collect();
        let [front, rear, slope] = inputs.map(filled);
        let torque_rates = [&front, &rear].map(|torque| rates(&time, torque));
        let mut drive = Self {
            name: name.to_owned(),
            wheels: [
                column(|s| s.front_wheel_speed),
                column(|s| s.rear_wheel_speed),
            ],
            torques: [front, rear],
            torque_rates,
            slope_rates: rates(&time, &slope),
            slope,
            speed,
            mass: (!masses.is_empty()).then(|| percentile(masses, 0.5)),
            has_acceleration: acceleration.iter().any(|a| a.is_finite()),
            acceleration,
            blocks: Vec::new(),
            time,
        };
        drive.blocks = drive.stretches(&drives);
        drive
    }

    /// Leaves out the rows in which a wheel of this rolling radius \[m\] spins. Returns for how long one does \[s\].
    pub fn leave_out_spin(&mut self, radius: f64) -> f64 {
        let spins = |k: usize| {
            let mut wheels = self.wheels.iter();
            wheels.any(|wheel| wheel_spins(radius * wheel[k], self.speed[k]))
        };
        let before = self.driving_time();
        let mut rolls = Vec::new();
        let mut spun = 0.0;
        for block in &self.blocks {
            let rows: Vec<usize> = block.clone().collect();
            for run in rows.chunk_by(|a, b| spins(*a) == spins(*b)) {
                let run = run[0]..run[run.len() - 1] + 1;
                let lasts = self.time[run.end.min(block.end - 1)] - self.time[run.start];
                if spins(run.start) {
                    spun += lasts;
                } else if lasts > SHORTEST {
                    rolls.push(run);
                }
            }
        }
        if spun > MOST_SPIN * before {
            return 0.0;
        }
        self.blocks = rolls;
        spun
    }

    /// Duration of driving \[s\].
    pub fn driving_time(&self) -> f64 {
        let blocks = self.blocks.iter();
        blocks
            .map(|b| self.time[b.end - 1] - self.time[b.start])
            .sum()
    }

    /// Speed that a hundredth of the rows exceed [m/s].
    pub fn fastest(&self) -> f64 {
        percentile(self.speed.iter().map(|v| v.abs()).collect(), 0.99)
    }

    /// Row before the time `late` after that of row `k`, and the share of the step from it to the next.
    pub fn place(&self, k: usize, late: f64) -> (usize, f64) {
        let (time, last) = (&self.time, self.time.len().saturating_sub(2));
        let wanted = time[k] + late;
        let mut row = k.min(last);
        while row < last && time[row + 1] <= wanted {
            row += 1;
        }
        while row > 0 && time[row] > wanted {
            row -= 1;
        }
        let share = (wanted - time[row]) / (time[row + 1] - time[row]);
        (row, share.clamp(0.0, 1.0))
    }

    /// The whole bins of a stretch.
    pub fn bins(&self, block: &Range<usize>) -> Vec<Range<usize>> {
        let mut bins = Vec::new();
        let mut first = block.start;
        for k in block.clone() {
            if self.time[k] - self.time[first] > BIN - 1e-9 {
                bins.push(first..k);
                first = k;
            }
        }
        bins
    }

    fn stretches(&self, drives: &[bool]) -> Vec<Range<usize>> {
        let Some((&begin, &end)) = self.time.first().zip(self.time.last()) else {
            return Vec::new();
        };
        let goes = |k: usize| drives[k] && self.time[k] > begin + ENDS && self.time[k] < end - ENDS;
        let mut blocks = Vec::new();
        let mut k = 0;
        while k < self.time.len() {
            let first = k;
            while k < self.time.len()
                && goes(k)
                && self.time[k] - self.time[first] < LENGTH
                && (k == first || self.time[k] - self.time[k - 1] < HOLE)
            {
                k += 1;
            }
            if k > first && self.time[k - 1] - self.time[first] > SHORTEST {
                blocks.push(first..k);
            }
            k = k.max(first + 1);
        }
        blocks
    }
}

/// Averages rows of a high rate: this reduces their noise, and the work of a fit.
fn averaged(rows: &[Sample]) -> Vec<Sample> {
    let steps = rows.windows(2).map(|w| w[1].time - w[0].time).collect();
    let period = percentile(steps, 0.5);
    let count = if period > 0.0 {
        ((PERIOD / period + 0.1) as usize).max(1)
    } else {
        1
    };
    let mean = |chunk: &[Sample], of: fn(&Sample) -> Option<f64>| {
        let values = chunk.iter().filter_map(of).filter(|v| v.is_finite());
        let (sum, count) = values.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    // A chunk with a gap is left out.
    let whole = |chunk: &&[Sample]| {
        chunk[chunk.len() - 1].time - chunk[0].time < 1.5 * period * chunk.len() as f64
    };
    let means = rows.chunks_exact(count).filter(whole).map(|chunk| Sample {
        time: chunk.iter().map(|s| s.time).sum::<f64>() / chunk.len() as f64,
        speed: mean(chunk, |s| s.speed),
        front_wheel_speed: mean(chunk, |s| s.front_wheel_speed),
        rear_wheel_speed: mean(chunk, |s| s.rear_wheel_speed),
        front_torque: mean(chunk, |s| s.front_torque),
        rear_torque: mean(chunk, |s| s.rear_torque),
        slope: mean(chunk, |s| s.slope),
        acceleration: mean(chunk, |s| s.acceleration),
        mass: mean(chunk, |s| s.mass),
        spade_force_x: mean(chunk, |s| s.spade_force_x),
        spade_force_z: mean(chunk, |s| s.spade_force_z),
        boom_moving: chunk.iter().any(|s| s.boom_moving),
        articulation: mean(chunk, |s| s.articulation),
        yaw_rate: mean(chunk, |s| s.yaw_rate),
        brake: chunk.iter().any(|s| s.brake),
        lift_angle: mean(chunk, |s| s.lift_angle),
        tilt_angle: mean(chunk, |s| s.tilt_angle),
        lift_head_pressure: mean(chunk, |s| s.lift_head_pressure),
        lift_rod_pressure: mean(chunk, |s| s.lift_rod_pressure),
        truck: chunk[0].truck,
    });
    means.collect()
}

fn digs(s: &Sample, weight: f64) -> bool {
    let (x, z) = (
        s.spade_force_x.unwrap_or(0.0),
        s.spade_force_z.unwrap_or(0.0),
    );
    let force = (x * x + z * z).sqrt();
    force > DIGGING * weight || s.boom_moving
}

fn turns(s: &Sample, speed: f64, wheelbase: f64) -> bool {
    let bend = s.articulation.unwrap_or(0.0).abs();
    let turn = s.yaw_rate.unwrap_or(0.0).abs() * wheelbase / speed.abs().max(SLOWEST);
    bend.max(turn) > BENT
}

/// Slope between the rows some time before and after each.
fn rates(time: &[f64], values: &[f64]) -> Vec<f64> {
    let (mut first, mut last) = (0, 0);
    time.iter()
        .map(|&t| {
            while last + 1 < time.len() && time[last + 1] <= t + RATE {
                last += 1;
            }
            while time[first] < t - RATE {
                first += 1;
            }
            if last > first {
                (values[last] - values[first]) / (time[last] - time[first])
            } else {
                0.0
            }
        })
        .collect()
}

/// Fills gaps with the value before them, or 0.
fn filled(mut values: Vec<f64>) -> Vec<f64> {
    let mut last = 0.0;
    for value in &mut values {
        if value.is_finite() {
            last = *value;
        } else {
            *value = last;
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve seconds at 2 m/s between two standstills.
    fn there(torque: impl Fn(f64) -> Option<f64>) -> Vec<Sample> {
        (0..1600)
            .map(|k| {
                let t = f64::from(k) * 0.01;
                let speed = if (2.0..14.0).contains(&t) { 2.0 } else { 0.0 };
                Sample {
                    time: t,
                    speed: Some(speed),
                    front_torque: torque(t),
                    rear_torque: torque(t),
                    slope: Some(0.0),
                    ..Sample::default()
                }
            })
            .collect()
    }

    #[test]
    fn stretches_are_driving_without_holes_in_the_inputs() {
        let whole = Drive::new("a", &there(|_| Some(100.0)), 4e4, 2.3);
        assert!(
            (whole.driving_time() - 12.0).abs() < 0.3,
            "{}",
            whole.driving_time()
        );
        assert!(whole.blocks.len() == 3);
        let lost = |t: f64| (!(6.0..7.0).contains(&t)).then_some(100.0);
        let holed = Drive::new("a", &there(lost), 4e4, 2.3);
        assert!((holed.driving_time() - 11.0).abs() < 0.3);
        assert!(Drive::new("a", &[], 4e4, 2.3).blocks.is_empty());
    }

    #[test]
    fn wheels_that_spin_are_left_out_and_those_of_another_radius_are_not() {
        let with = |until: f64| {
            let mut rows = there(|_| Some(100.0));
            for row in &mut rows {
                let wheel = row.speed.map(|v| v / 0.5);
                row.front_wheel_speed = wheel;
                let spins = (6.0..until).contains(&row.time);
                row.rear_wheel_speed = if spins { Some(16.0) } else { wheel };
            }
            let mut drive = Drive::new("a", &rows, 4e4, 2.3);
            [drive.leave_out_spin(0.5), drive.driving_time()]
        };
        assert_eq!(with(6.0)[0], 0.0);
        let [spun, rolls] = with(8.0);
        assert!((spun - 2.0).abs() < 0.2, "{spun}");
        assert!((9.0..10.1).contains(&rolls), "{rolls}");
        let [spun, rolls] = with(14.0);
        assert_eq!(spun, 0.0, "another radius");
        assert!(rolls > 11.5, "{rolls}");
    }

    #[test]
    fn digging_braking_and_curves_are_left_out() {
        let rows = |change: fn(&mut Sample)| {
            let mut rows = there(|_| Some(100.0));
            rows.iter_mut().for_each(change);
            Drive::new("a", &rows, 4e4, 2.3).blocks.len()
        };
        assert_eq!(rows(|s| s.brake = true), 0);
        assert_eq!(rows(|s| s.spade_force_x = Some(3000.0)), 0);
        assert_eq!(rows(|s| s.articulation = Some(-0.2)), 0);
        assert_eq!(rows(|s| s.yaw_rate = Some(0.2)), 0);
        assert_eq!(rows(|s| s.slope = Some(f64::NAN)), 0);
    }
}
