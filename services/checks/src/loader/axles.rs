//! Consistency checks of a loader's axles (torques, wheel speeds) and accelerometer.
//!
//! Averages of blocks, with the specific force along the path, D = dv/dt + g slope:
//!
//! | what | sound |
//! |---|---|
//! | front over rear wheel speed | 1 |
//! | torque of an axle and D | the same sign |
//! | acceleration over dv/dt | 1 |
//! | c4 in (w_f - w_r)/w = c1 sgn v + c2 (dv/dt)/abs v + c3 T + c4 T D | positive: what accelerates the machine unloads its front wheels, which slip more |
//! | c5 of a further term c5 (T_f - T_r) | positive: more torque, more slip |
//!
//! c1 is the difference of the radii, c2 the lag of one wheel speed behind the other, c3 the load distribution. c4 identifies the
//! wheels of the front axle also where both axles carry similar torques; c5 needs torques that differ.

use std::ops::Range;

use estimation::GRAVITY;
use estimation::loader::Sample;
use recording::Finding;

use super::grade::Grade;
use super::pair::{Pair, about};
use super::regression::Regression;
use super::speed::Speed;
use crate::advice::{write_sign, write_unit};
use crate::units::TURNING;

/// Duration of a block, and longest time between two of its rows \[s\].
const BLOCK: f64 = 0.2;
const GAP: f64 = 0.2;
/// Speed below which the machine may stand, or dig [m/s].
const DRIVES: f64 = 1.0;
/// Articulation \[rad\] or yaw rate \[rad/s\] above which the axles roll at different speeds.
const TURNS: f64 = 0.05;
/// Slip difference above which it is not the slip by torque.
const SLIPS: f64 = 0.2;
/// Fewest blocks for a verdict, dv/dt of hard acceleration [m/s^2], and fewest blocks with slip. Half of the blocks must be hard.
const ENOUGH: f64 = 50.0;
const HARD: f64 = 0.3;
const SLIPPING: f64 = 100.0;
/// Least correlation of two related quantities: .74 to 1.0 of torque and D was recorded, .83 to .99 of acceleration and dv/dt.
const TOGETHER: f64 = 0.5;
/// Least correlation of torque and acceleration, and range that means lbf ft: mass times radius by torque and accelerometer over that of
/// the machine file. 1.01 to 1.24 was recorded, by tyres, axles and loads; torques in lbf ft give .738 times as much.
const MOVED: f64 = 0.95;
const LIGHT: Range<f64> = 0.6..0.85;
/// Ratio below which the torques are those at the motor: the gear from motor to wheel has at least four turns to one.
const AT_MOTOR: f64 = 1.24 / 4.0;
/// Feet in a metre.
const FEET: f64 = 3.281;
/// Factor within which a ratio identifies a unit, also with another tyre or gear.
const ABOUT: f64 = 1.3;
/// Factor within which the wheel speeds of both axles agree: units are exact, and tyres differ by a few percent.
const TURN_ALIKE: f64 = 1.12;
/// Factor within which a ratio identifies a thousandth: the split of the torque between the axles is arbitrary.
const THOUSANDTH: f64 = 10.0;
/// Root mean square of the torque over the machine's weight at the wheel radius, below which no machine moves.
const MOVES: f64 = 2e-3;
/// Least difference of the torques that their sum does not explain, as a share of a torque; .86 was recorded where the drive shifts torque
/// between the axles, up to .015 where it does not.
const DIFFER: f64 = 0.1;
/// Significance of c4 and c5 in standard deviations, as of independent blocks; -4.5 to 55 were recorded, the least in turns.
const SURE: f64 = 8.0;

/// Rows of a block.
#[derive(Default)]
struct Block {
    begin: f64,
    end: f64,
    rows: f64,
    /// Sums of [`values`].
    sums: [f64; 7],
    turns: bool,
}

/// Speed, wheel speeds, torques, slope, acceleration.
fn values(s: &Sample) -> Option<[f64; 7]> {
    let turning = [s.speed?, s.front_wheel_speed?, s.rear_wheel_speed?];
    let torques = [s.front_torque?, s.rear_torque?];
    let rest = [s.slope.unwrap_or(0.0), s.acceleration.unwrap_or(f64::NAN)];
    let [v, f, r] = turning;
    let ([tf, tr], [slope, a]) = (torques, rest);
    Some([v, f, r, tf, tr, slope, a])
}

/// Accumulates the rows of a recording.
#[derive(Default)]
pub(super) struct Axles {
    block: Block,
    /// Speed and middle time of the block before.
    last: Option<[f64; 2]>,
    blocks: f64,
    hard: f64,
    wheels: Pair,
    torques: Pair,
    /// Torque of each axle, and D.
    pulls: [Pair; 2],
    acceleration: Pair,
    grade: Grade,
    speed: Speed,
    /// T regressed on sgn v, v and the measured acceleration.
    moved: Regression<4>,
    /// Slip difference regressed on sgn v, (dv/dt)/abs v, T and T D.
    slips: Regression<5>,
    /// The same, regressed on T_f - T_r too.
    split: Regression<6>,
}

impl Axles {
    pub(super) fn see(&mut self, s: &Sample) {
        let gap = s.time - self.block.end;
        let Some(values) = values(s).filter(|_| !s.brake) else {
            return;
        };
        if self.block.rows > 0.0 && !(0.0..GAP).contains(&gap) {
            self.block = Block::default();
            self.last = None;
        }
        let block = &mut self.block;
        if block.rows == 0.0 {
            block.begin = s.time;
        }
        block.rows += 1.0;
        block.end = s.time;
        block
            .sums
            .iter_mut()
            .zip(values)
            .for_each(|(sum, value)| *sum += value);
        let turns = |x: Option<f64>| x.is_some_and(|x| x.abs() > TURNS);
        block.turns |= turns(s.articulation) || turns(s.yaw_rate);
        if block.end - block.begin >= BLOCK {
            let block = std::mem::take(&mut self.block);
            self.add(&block);
        }
    }

    fn add(&mut self, block: &Block) {
        let [
            v,
            front,
            rear,
            front_torque,
            rear_torque,
            slope,
            acceleration,
        ] = block.sums.map(|sum| sum / block.rows);
        let middle = 0.5 * (block.begin + block.end);
        let Some([before, then]) = self.last.replace([v, middle]) else {
            return;
        };
        let gain = (v - before) / (middle - then);
        if !(v.abs() > DRIVES && (middle - then) < BLOCK + GAP) {
            return;
        }
        self.blocks += 1.0;
        self.speed
            .see(v, [front, rear], [front_torque, rear_torque]);
        self.hard += f64::from(u8::from(gain.abs() > HARD));
        let force = gain + GRAVITY * slope;
        self.wheels.see(front, rear);
        self.torques.see(front_torque, rear_torque);
        self.pulls[0].see(front_torque, force);
        self.pulls[1].see(rear_torque, force);
        self.acceleration.see(acceleration, gain);
        let torque = front_torque + rear_torque;
        self.moved.see([v.signum(), v, acceleration, torque]);
        self.grade.see(v, gain, slope, acceleration, torque);
        let slip = 2.0 * (front - rear) / (front + rear).abs();
        if slip.abs() < SLIPS && !block.turns {
            self.slips
                .see([v.signum(), gain / v.abs(), torque, torque * force, slip]);
            let more = front_torque - rear_torque;
            self.split.see([
                v.signum(),
                gain / v.abs(),
                torque,
                torque * force,
                more,
                slip,
            ]);
        }
    }

    /// The fault of a column and its remedy, for a machine with this mass times wheel radius [kg m].
    pub(super) fn fault(&self, moment: f64) -> Option<Finding> {
        if self.blocks < ENOUGH || 2.0 * self.hard < ENOUGH {
            return None;
        }
        // The torques are compared with the slope: it is checked first.
        let what = self.wheel_unit().or_else(|| self.slope());
        let what = what.or_else(|| self.torque(moment));
        let what = what.or_else(|| self.accelerometer());
        let what = what.or_else(|| self.pound_feet(moment));
        what.or_else(|| self.exchanged())
    }

    /// Exchanged axles: of the wheel speeds, or of the torques where they differ.
    fn exchanged(&self) -> Option<Finding> {
        if self.slips.rows < SLIPPING {
            return None;
        }
        if self.slips.significance() < -SURE {
            return Some(Finding::new(
                "front_wheel_speed and rear_wheel_speed seem to be exchanged: the rear wheels slip more while the machine accelerates, which presses them down",
                "exchange the two in the signal map",
            ));
        }
        let torque = (self.pulls[0].squares[0] / self.blocks).sqrt();
        let differ = self.split.left() > DIFFER * torque;
        (differ && self.split.significance() < -SURE).then(|| Finding::new(
                "front_torque and rear_torque seem to be exchanged: the wheels of the axle with the larger torque slip less",
                "exchange the two in the signal map",
            ),
        )
    }

    /// The fault of the slope by accelerometer and torques.
    pub(super) fn slope(&self) -> Option<Finding> {
        self.grade.fault()
    }

    /// The fault of the speed by the wheel speeds.
    pub(super) fn speed(&self) -> Option<Finding> {
        self.speed.fault()
    }

    fn wheel_unit(&self) -> Option<Finding> {
        let ratio = self.wheels.ratio();
        let is_about = |unit: f64| about(ratio / unit, TURN_ALIKE);
        let of = |(name, unit): &(&'static str, f64)| {
            let axle = is_about(*unit).then_some("front");
            axle.or(is_about(1.0 / unit).then_some("rear"))
                .map(|axle| (axle, *name))
        };
        let (axle, unit) = TURNING.iter().find_map(of)?;
        Some(Finding::new(
            format!(
                "{axle}_wheel_speed seems to be in {unit}: front over rear wheel speed is {ratio:.3}"
            ),
            write_unit(unit, &format!("{axle}_wheel_speed")),
        ))
    }

    fn torque(&self, moment: f64) -> Option<Finding> {
        let turned = self.pulls.map(|pull| pull.correlation() < -TOGETHER);
        let sign = match turned {
            [true, true] => Some(("front_torque and rear_torque", "have")),
            [true, false] => Some(("front_torque", "has")),
            [false, true] => Some(("rear_torque", "has")),
            [false, false] => None,
        };
        if let Some((names, have)) = sign {
            return Some(Finding::new(
                format!(
                    "{names} {have} the other sign: a torque that drives the machine forwards is positive"
                ),
                write_sign(names),
            ));
        }
        let ratio = self.torques.ratio();
        let weak = self
            .pulls
            .map(|pull| (pull.squares[0] / self.blocks).sqrt() < MOVES * moment * GRAVITY);
        let (names, seem) = match weak {
            [true, true] => ("front_torque and rear_torque", "seem"),
            [true, false] if about(1e3 * ratio, THOUSANDTH) => ("front_torque", "seems"),
            [false, true] if about(1e-3 * ratio, THOUSANDTH) => ("rear_torque", "seems"),
            _ => return None,
        };
        Some(Finding::new(
            format!("{names} {seem} to be in kN m: N m that small would not move the machine"),
            write_unit("kNm", names),
        ))
    }

    /// Torques that would move a machine lighter than the empty one: they are in lbf ft.
    fn pound_feet(&self, moment: f64) -> Option<Finding> {
        let [_, moved] = self.moved.coefficients();
        let ratio = moved / moment;
        let is_so = self.moved.correlation() > MOVED && LIGHT.contains(&ratio);
        is_so.then(|| {
            Finding::new(
                format!(
                    "front_torque and rear_torque seem to be in lbf ft: they accelerate {ratio:.2} times the described mass, less than the empty machine",
                ),
                format!(
                    "{}; or state machine.mass and machine.wheel_radius, whose product is too large",
                    write_unit("lbf ft", "both"),
                ),
            )
        })
    }

    /// Share of the described mass times radius that the torques move, if no machine is so light.
    pub(super) fn at_motor(&self, moment: f64) -> Option<f64> {
        let [_, moved] = self.moved.coefficients();
        let ratio = moved / moment;
        let is_enough = self.blocks >= ENOUGH && self.moved.correlation() > MOVED;
        (is_enough && (0.0..AT_MOTOR).contains(&ratio)).then_some(ratio)
    }

    fn accelerometer(&self) -> Option<Finding> {
        let (together, size) = (self.acceleration.correlation(), self.acceleration.ratio());
        if together < -TOGETHER {
            return Some(Finding::new(
                "acceleration has the other sign: it is positive while the machine becomes faster forwards",
                write_sign("acceleration"),
            ));
        }
        let units = [
            ("g", size * GRAVITY, "ten times"),
            ("mg", size * GRAVITY / 1e3, "a hundredth"),
            ("ft/s^2", size / FEET, "a third"),
        ];
        let (unit, _, changes) = units
            .into_iter()
            .find(|(_, ratio, _)| together > TOGETHER && about(*ratio, ABOUT))?;
        Some(Finding::new(
            format!("acceleration seems to be in {unit}: the speed changes {changes} as fast"),
            write_unit(unit, "acceleration"),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    /// The fault of a machine of 10 t, half of it on each axle, centre of gravity 1 m high, wheelbase 3 m, wheels of .7 m. Slip is a
    /// twentieth of torque over load.
    fn said(change: impl Fn(&mut Sample)) -> Option<Finding> {
        driven(change).fault(7e3)
    }

    fn driven(change: impl Fn(&mut Sample)) -> Axles {
        moved_by(|time| [4.0 + 2.0 * time.sin(), 2.0 * time.cos()], change)
    }

    /// Two minutes with this speed and acceleration.
    fn moved_by(motion: impl Fn(f64) -> [f64; 2], change: impl Fn(&mut Sample)) -> Axles {
        let mut axles = Axles::default();
        for k in 0..12_000 {
            let time = f64::from(k) / 100.0;
            let [speed, gain] = motion(time);
            let direction = speed.signum();
            let torque = 0.5 * 0.7 * (10e3 * gain + 2e3 * direction);
            let moved = 10e3 * gain / 3.0;
            let slip = |load: f64| 0.05 * direction * torque / (0.7 * load);
            let wheel = |load: f64| speed / 0.7 * (1.0 + slip(load));
            let mut sample = Sample {
                time,
                speed: Some(speed),
                front_wheel_speed: Some(wheel(49e3 - moved)),
                rear_wheel_speed: Some(wheel(49e3 + moved)),
                front_torque: Some(torque),
                rear_torque: Some(torque),
                slope: Some(0.0),
                acceleration: Some(gain),
                ..Sample::default()
            };
            change(&mut sample);
            axles.see(&sample);
        }
        axles
    }

    #[test]
    fn a_wheel_speed_that_is_late_is_not_that_of_the_other_axle() {
        // Forward and back by turns; it accelerates for 2 s, and slows down for 6.
        let shuttles = |time: f64| {
            let part = time % 8.0;
            let [speed, gain] = if part < 2.0 {
                [1.0 + 2.0 * part, 2.0]
            } else {
                [5.0 - (part - 2.0) / 1.5, -1.0 / 1.5]
            };
            let direction = if time % 16.0 < 8.0 { 1.0 } else { -1.0 };
            [direction * speed, direction * gain]
        };
        let told = |late: f64, exchanged: bool| {
            let axles = moved_by(shuttles, |s| {
                let gained = s.acceleration.unwrap_or(0.0) * late / 0.7;
                s.front_wheel_speed = s.front_wheel_speed.map(|w| w - gained);
                if exchanged {
                    std::mem::swap(&mut s.front_wheel_speed, &mut s.rear_wheel_speed);
                }
            });
            axles.fault(7e3).is_some()
        };
        for late in [-0.01, 0.0, 0.01] {
            assert!(!told(late, false) && told(late, true), "{late} s");
        }
    }

    #[test]
    fn exchanged_torques_are_named_where_the_drive_shifts_torque_between_the_axles() {
        let said = |shift: f64, exchanged: bool| {
            said(|s| {
                let more = shift * 1e3 * (0.7 * s.time).sin();
                let slip = 0.05 * more / (0.7 * 49e3);
                let wheel = s.speed.unwrap_or(0.0) / 0.7 * slip;
                s.front_torque = s.front_torque.map(|x| x + more);
                s.rear_torque = s.rear_torque.map(|x| x - more);
                s.front_wheel_speed = s.front_wheel_speed.map(|x| x + wheel);
                s.rear_wheel_speed = s.rear_wheel_speed.map(|x| x - wheel);
                if exchanged {
                    std::mem::swap(&mut s.front_torque, &mut s.rear_torque);
                }
            })
        };
        assert_eq!(
            [said(0.0, false), said(0.0, true), said(1.0, false)],
            [None, None, None]
        );
        let words = text(said(1.0, true));
        assert!(
            words.starts_with("front_torque and rear_torque seem to be exchanged"),
            "{words}"
        );
    }

    #[test]
    fn torques_at_the_motor_are_distinguished_from_those_of_a_machine_of_half_the_size() {
        let ratio = |by: f64| {
            let both = driven(move |s| {
                times(&mut s.front_torque, by);
                times(&mut s.rear_torque, by);
            });
            both.at_motor(7e3)
        };
        assert!(ratio(0.04).is_some_and(|ratio| (0.03..0.06).contains(&ratio)));
        assert_eq!((ratio(0.5), ratio(1.0), ratio(-1.0)), (None, None, None));
    }

    fn times(value: &mut Option<f64>, by: f64) {
        *value = value.map(|x| x * by);
    }

    #[test]
    fn the_column_that_the_others_contradict_is_named() {
        assert_eq!(said(|_| {}), None);
        let first = |change: fn(&mut Sample)| text(said(change));
        for (said, words) in [
            (
                first(|s| times(&mut s.front_wheel_speed, 9.55)),
                "front_wheel_speed seems to be in rpm",
            ),
            (
                first(|s| times(&mut s.rear_wheel_speed, 57.3)),
                "rear_wheel_speed seems to be in deg/s",
            ),
            (
                first(|s| times(&mut s.rear_torque, -1.0)),
                "rear_torque has the other sign",
            ),
            (
                first(|s| times(&mut s.front_torque, 1e-3)),
                "front_torque seems to be in kN m",
            ),
            (
                first(|s| times(&mut s.acceleration, -1.0)),
                "acceleration has the other sign",
            ),
            (
                first(|s| times(&mut s.acceleration, 1.0 / 9.81)),
                "acceleration seems to be in g",
            ),
            (
                first(|s| times(&mut s.acceleration, 1e3 / 9.81)),
                "acceleration seems to be in mg",
            ),
            (
                first(|s| times(&mut s.acceleration, 3.28)),
                "acceleration seems to be in ft/s^2",
            ),
            (
                first(|s| std::mem::swap(&mut s.front_wheel_speed, &mut s.rear_wheel_speed)),
                "front_wheel_speed and rear_wheel_speed seem to be exchanged",
            ),
        ] {
            assert!(said.starts_with(words), "{words}: {said}");
        }
        let both = |by: f64| {
            said(move |s| {
                times(&mut s.front_torque, by);
                times(&mut s.rear_torque, by);
            })
        };
        assert_eq!(both(0.5), None);
        assert_eq!(both(0.9), None);
        assert!(both(0.7376).is_some_and(|said| said.remedy.contains("`unit = \"lbf ft\"`")));
        assert!(both(1e-3).is_some_and(|said| said.remedy.contains("`unit = \"kNm\"`")));
        assert!(both(-1.0).is_some_and(|said| said.what.contains("have the other sign")));
        // Without an accelerometer, in turns, and with tyres of another size nothing is reported.
        assert_eq!(said(|s| s.acceleration = None), None);
        assert_eq!(said(|s| times(&mut s.front_wheel_speed, 1.05)), None);
        assert_eq!(
            said(|s| {
                std::mem::swap(&mut s.front_wheel_speed, &mut s.rear_wheel_speed);
                s.articulation = Some(0.3);
            }),
            None
        );
    }
}
