//! Check of data for the expected units and signs, and the described machine.
//!
//! | what | model | found by |
//! |---|---|---|
//! | wheels | v = r w | the ratio of the sums of v w and w w: an effective radius |
//! | torques | integral of T / r = m (dv + g integral of the slope) + f integral of sign(v), in spans of a second | least squares: an effective mass m |
//!
//! Slip, tyres and loads change radius and mass by a fraction; a wrong unit, sign or machine by a factor of several.

use super::super::sample::Sample;
use crate::GRAVITY;

/// Least number of rows and of spans for a result.
const ROWS: f64 = 500.0;
const SPANS: f64 = 10.0;
/// Length of a span, and time between two rows beyond which there is a gap [s].
const SPAN: f64 = 1.0;
const GAP: f64 = 0.2;
/// Speed below which the machine may stand [m/s].
const STANDS: f64 = 0.2;
/// Least share of the squares that the model explains, of the wheels and of the torques.
const WHEELS_EXPLAINED: f64 = 0.95;
const TORQUES_EXPLAINED: f64 = 0.9;
/// Factor within which another tyre or load stays, and factor within which a supposed unit must fit.
const ALIKE: f64 = 2.0;
const ABOUT: f64 = 1.3;
/// Units of a speed per metre per second, and the factor within which a stated radius is right, less than their spacing.
const SPEEDS: [(&str, f64); 4] = [
    ("knot", 1.944),
    ("mph", 2.237),
    ("ft/s", 3.281),
    ("km/h", 3.6),
];
const STATED: f64 = 1.08;
/// Slip within which wheel speeds in m/s equal the speed of the machine.
const SLIP: f64 = 0.05;

/// Disagreement of data and description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mismatch {
    /// The speed, or one of the wheel speeds, has the other sign.
    SpeedSign,
    /// The speed of the front or of the rear wheels has the other sign.
    WheelSign(&'static str),
    /// The speed is in this unit.
    Speed(&'static str),
    /// The wheel speeds are in revolutions per minute.
    Revolutions,
    /// The wheel speeds are those of the tread, in the unit of the speed.
    Tread,
    /// The speed is this multiple of that of the wheels.
    Radius(f64),
    /// The torques are in kilonewton metres.
    Kilonewtons,
    /// The torques have the other sign.
    TorqueSign,
    /// The torques accelerate this multiple of the described mass.
    Mass(f64),
}

impl core::fmt::Display for Mismatch {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::SpeedSign => f.write_str("speed and wheel speeds have opposite signs"),
            Self::WheelSign(axle) => write!(f, "{axle}_wheel_speed has the other sign"),
            Self::Speed(unit) => write!(f, "speed seems to be in {unit}"),
            Self::Revolutions => f.write_str("the wheel speeds seem to be in revolutions per minute"),
            Self::Tread => f.write_str("the wheel speeds seem to be those of the tread, as long as speed: rad/s is expected"),
            Self::Radius(ratio) => write!(f, "the machine drives {ratio:.2} times as fast as its wheels turn"),
            Self::Kilonewtons => f.write_str("front_torque and rear_torque seem to be in kN m: the machine accelerates a thousand times more than they"),
            Self::TorqueSign => f.write_str("torques and speed seem to have opposite signs"),
            Self::Mass(ratio) => write!(f, "the torques accelerate {ratio:.2} times the described mass"),
        }
    }
}

/// Sums of a wheel: speed times wheel speed, and the squares.
#[derive(Clone, Copy, Debug, Default)]
struct Wheel {
    both: f64,
    own: f64,
    speed: f64,
    rows: f64,
}

impl Wheel {
    fn see(&mut self, speed: f64, wheel: f64) {
        self.both += speed * wheel;
        self.own += wheel * wheel;
        self.speed += speed * speed;
        self.rows += f64::from(u8::from(speed.abs() > STANDS));
    }

    /// Effective radius, where speed and wheel speed are proportional [m].
    fn radius(&self) -> Option<f64> {
        let together = self.both * self.both > WHEELS_EXPLAINED * self.own * self.speed;
        (self.rows >= ROWS && together).then(|| self.both / self.own)
    }
}

/// Sums over the present span.
#[derive(Clone, Copy, Debug)]
struct Span {
    begin: f64,
    speed: f64,
    impulse: f64,
    climb: f64,
    rolled: f64,
}

/// Check of the rows of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Plausible {
    mass: f64,
    radius: f64,
    last: Option<f64>,
    wheels: [Wheel; 2],
    span: Option<Span>,
    spans: f64,
    /// Squares and products of gain in speed, rolled time and impulse.
    gain: f64,
    cross: f64,
    rolled: f64,
    impulse: f64,
    gain_impulse: f64,
    rolled_impulse: f64,
}

impl Plausible {
    /// For a machine of this mass \[kg\] and wheel radius \[m\].
    #[must_use]
    pub fn new(mass: f64, radius: f64) -> Self {
        Self {
            mass,
            radius,
            last: None,
            wheels: [Wheel::default(); 2],
            span: None,
            spans: 0.0,
            gain: 0.0,
            cross: 0.0,
            rolled: 0.0,
            impulse: 0.0,
            gain_impulse: 0.0,
            rolled_impulse: 0.0,
        }
    }

    /// Adds a row.
    pub fn push(&mut self, sample: &Sample) {
        let sample = sample.plausible(self.mass, self.radius);
        let dt = self
            .last
            .replace(sample.time)
            .map(|last| sample.time - last);
        let Some(speed) = sample.speed else {
            self.span = None;
            return;
        };
        let wheels = [sample.front_wheel_speed, sample.rear_wheel_speed];
        for (sums, wheel) in self.wheels.iter_mut().zip(wheels) {
            if let Some(wheel) = wheel {
                sums.see(speed, wheel);
            }
        }
        let (Some(front), Some(rear), Some(dt), false) =
            (sample.front_torque, sample.rear_torque, dt, sample.brake)
        else {
            self.span = None;
            return;
        };
        if !(0.0..GAP).contains(&dt) {
            self.span = None;
            return;
        }
        let mut span = self.span.unwrap_or(Span {
            begin: sample.time - dt,
            speed,
            impulse: 0.0,
            climb: 0.0,
            rolled: 0.0,
        });
        span.impulse += (front + rear) / self.radius * dt;
        span.climb += GRAVITY * sample.slope.unwrap_or(0.0) * dt;
        if speed.abs() > STANDS {
            span.rolled += speed.signum() * dt;
        }
        let is_over = sample.time - span.begin >= SPAN;
        if is_over {
            self.add(&span, speed);
        }
        self.span = (!is_over).then_some(span);
    }

    fn add(&mut self, span: &Span, speed: f64) {
        let gain = speed - span.speed + span.climb;
        self.spans += 1.0;
        self.gain += gain * gain;
        self.cross += gain * span.rolled;
        self.rolled += span.rolled * span.rolled;
        self.impulse += span.impulse * span.impulse;
        self.gain_impulse += gain * span.impulse;
        self.rolled_impulse += span.rolled * span.impulse;
    }

    /// Returns the disagreement of data and description, if there is one.
    #[must_use]
    pub fn mismatch(&self) -> Option<Mismatch> {
        self.of_wheels().or_else(|| self.of_torques())
    }

    fn of_wheels(&self) -> Option<Mismatch> {
        let [Some(front), Some(rear)] = [self.wheels[0].radius(), self.wheels[1].radius()] else {
            return None;
        };
        match [front < 0.0, rear < 0.0] {
            [true, true] => return Some(Mismatch::SpeedSign),
            [true, false] => return Some(Mismatch::WheelSign("front")),
            [false, true] => return Some(Mismatch::WheelSign("rear")),
            [false, false] => {}
        }
        let all = |is_so: &dyn Fn(f64) -> bool| is_so(front) && is_so(rear);
        let about = |unit: f64| all(&|r| within(r / self.radius / unit, ABOUT));
        let ratio = (front + rear) / 2.0 / self.radius;
        match () {
            () if within(ratio, ABOUT) => None,
            () if all(&|r| (r - 1.0).abs() < SLIP) => Some(Mismatch::Tread),
            () if about(core::f64::consts::TAU / 60.0) => Some(Mismatch::Revolutions),
            () => match speed_unit(ratio) {
                Some(unit) => Some(Mismatch::Speed(unit)),
                None if within(ratio, ALIKE) => None,
                None => Some(Mismatch::Radius(ratio)),
            },
        }
    }

    fn of_torques(&self) -> Option<Mismatch> {
        let det = self.gain * self.rolled - self.cross * self.cross;
        if self.spans < SPANS || det <= 0.0 {
            return None;
        }
        let mass = (self.gain_impulse * self.rolled - self.rolled_impulse * self.cross) / det;
        let drag = (self.rolled_impulse * self.gain - self.gain_impulse * self.cross) / det;
        let explained = mass * self.gain_impulse + drag * self.rolled_impulse;
        if explained < TORQUES_EXPLAINED * self.impulse {
            return None;
        }
        // The wheels determine their radius themselves.
        let rolled = self.wheels[0].radius().unwrap_or(self.radius);
        let ratio = mass / self.mass * (self.radius / rolled).abs();
        match () {
            () if within(-ratio, ALIKE) => Some(Mismatch::TorqueSign),
            () if within(ratio, ALIKE) => None,
            () if within(1e3 * ratio.abs(), ALIKE) => Some(Mismatch::Kilonewtons),
            () => Some(Mismatch::Mass(ratio)),
        }
    }
}

/// The unit that explains this ratio of speed to wheel speed, the nearest of them.
fn speed_unit(ratio: f64) -> Option<&'static str> {
    let distance = |unit: f64| (ratio / unit).max(unit / ratio);
    let nearest = SPEEDS
        .into_iter()
        .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    let factor = |unit: &str| if unit == "km/h" { ABOUT } else { STATED };
    nearest
        .filter(|(name, unit)| within(ratio / unit, factor(name)))
        .map(|(name, _)| name)
}

/// Whether a ratio is 1 within a factor.
fn within(ratio: f64, factor: f64) -> bool {
    (1.0 / factor..=factor).contains(&ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine of 5 t on wheels of .6 m that accelerates and brakes for a minute, with some rolling resistance.
    fn seen(change: impl Fn(&mut Sample)) -> Option<Mismatch> {
        let mut plausible = Plausible::new(5000.0, 0.6);
        for k in 0..6000 {
            let time = f64::from(k) / 100.0;
            let (sin, cos) = crate::math::sin_cos(time);
            let (speed, gain) = (2.0 + 1.5 * sin, 1.5 * cos);
            let force = 5000.0 * gain + 1000.0;
            let mut sample = Sample {
                time,
                speed: Some(speed),
                front_wheel_speed: Some(speed / 0.6 * 1.01),
                rear_wheel_speed: Some(speed / 0.6 * 0.99),
                front_torque: Some(0.3 * force),
                rear_torque: Some(0.3 * force),
                ..Sample::default()
            };
            change(&mut sample);
            plausible.push(&sample);
        }
        plausible.mismatch()
    }

    fn times(value: &mut Option<f64>, by: f64) {
        *value = value.map(|x| x * by);
    }

    #[test]
    fn units_and_signs_are_identified() {
        let torques = |by: f64| {
            move |s: &mut Sample| {
                times(&mut s.front_torque, by);
                times(&mut s.rear_torque, by);
            }
        };
        let wheels = |by: f64| {
            move |s: &mut Sample| {
                times(&mut s.front_wheel_speed, by);
                times(&mut s.rear_wheel_speed, by);
            }
        };
        assert_eq!(seen(|_| {}), None);
        assert_eq!(seen(torques(1.5)), None);
        for (name, unit) in SPEEDS {
            assert_eq!(
                seen(|s| times(&mut s.speed, unit)),
                Some(Mismatch::Speed(name))
            );
        }
        assert_eq!(seen(torques(1e-3)), Some(Mismatch::Kilonewtons));
        assert_eq!(seen(torques(-1.0)), Some(Mismatch::TorqueSign));
        let at_motor = seen(torques(0.05));
        assert!(matches!(at_motor, Some(Mismatch::Mass(r)) if (r - 0.05).abs() < 0.01));
        assert_eq!(
            seen(wheels(60.0 / core::f64::consts::TAU)),
            Some(Mismatch::Revolutions)
        );
        assert_eq!(seen(wheels(0.6)), Some(Mismatch::Tread));
        assert_eq!(seen(wheels(-1.0)), Some(Mismatch::SpeedSign));
        assert_eq!(
            seen(|s| times(&mut s.speed, 3.6)),
            Some(Mismatch::Speed("km/h"))
        );
        let front = seen(|s| times(&mut s.front_wheel_speed, -1.0));
        assert_eq!(front, Some(Mismatch::WheelSign("front")));
        // Noise is no sign, and too short a recording gives no result.
        assert_eq!(
            seen(|s| s.speed = Some(crate::math::sin_cos(1e3 * s.time).0)),
            None
        );
        assert_eq!(seen(|s| s.speed = s.speed.filter(|_| s.time < 4.0)), None);
    }
}
