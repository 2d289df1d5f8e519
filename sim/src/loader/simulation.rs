//! A run: the plant in a scenario, and its sensor readings.

use super::acts::Acts;
use super::arm::{ArmSensors, LiftArm, Seen, Shaken};
use super::driver::Driver;
use super::effects::{self, Gears, Inclinometer, Late, PayloadReport};
use super::faults::{CHANNELS, damage};
use super::payload::Payload;
use super::plant::{GRAVITY, Machine, Plant};
use super::road::{Phases, Road};
use super::row::{Row, Truth};
use super::run::{InvalidRun, Run};
use super::scenario::Scenario;
use super::tier::{self, Calibration, Nominal, Tier};
use crate::fault::Injector;
use crate::noise::Noise;

/// Streams of [`Noise::channel`]: the sensors take 1 to 7.
const MACHINE_STREAM: u64 = 10;
const ROAD_STREAM: u64 = 11;
const DRIVER_STREAM: u64 = 12;
const JITTER_STREAM: u64 = 13;
/// Least distance of jittered time stamps [s].
const SHORTEST_ROW: f64 = 1e-4;

/// The rows of a run, in order.
#[derive(Clone, Debug)]
pub struct Simulation {
    plant: Plant,
    driver: Driver,
    acts: Acts,
    late_speed: Late,
    late_torques: [Late; 2],
    jitter: Noise,
    /// Time stamp of the last row [s].
    stamp: f64,
    /// Time of the next speed value [s].
    next_speed: f64,
    inclinometer: Inclinometer,
    machine: Machine,
    calibration: Calibration,
    nominal: Nominal,
    tells_mass: bool,
    arm: Option<ArmSensors>,
    noise: [Noise; 7],
    faults: Injector,
    rate: f64,
    next: u64,
    rows: u64,
}

impl Simulation {
    /// Draws the machine and the road, and places the machine on the road.
    ///
    /// # Errors
    /// Rate, duration or payload are out of range, or a fault names no channel.
    pub fn new(run: &Run) -> Result<Self, InvalidRun> {
        run.check()?;
        let stream = |channel| Noise::channel(run.seed, channel);
        let of = run.machine_seed.unwrap_or(run.seed);
        let mut machine_noise = Noise::channel(of, MACHINE_STREAM);
        let (mut machine, mut calibration, mut nominal) =
            tier::draw(run.size, run.tier, run.grade, &mut machine_noise);
        if let Some(of) = run.tyres_seed {
            let noise = &mut Noise::channel(of, MACHINE_STREAM);
            let (other, ..) = tier::draw(run.size, run.tier, run.grade, noise);
            machine.slip_stiffness = other.slip_stiffness;
            machine.front_radius_error = other.front_radius_error;
            machine.rear_radius_error = other.rear_radius_error;
            machine.relaxation_length = other.relaxation_length;
        }
        run.effects.apply(&mut machine);
        calibration.slope_bias += run.effects.slope_bias;
        for gain in [
            &mut calibration.front_torque_gain,
            &mut calibration.rear_torque_gain,
        ] {
            *gain *= 1.0 + run.effects.torque_gain;
        }
        calibration.rear_torque_gain *= 1.0 + run.effects.rear_torque_gain;
        calibration.mass_gain *= 1.0 + run.effects.mass_error;
        nominal.mass *= 1.0 + run.effects.mass_error;
        nominal.wheel_radius *= 1.0 + run.effects.radius_error;
        let mut surface = run.scenario.surface();
        if run.effects.roughness > 0.0 {
            surface.roughness = run.effects.roughness;
        }
        let ground = run.road_seed.unwrap_or(run.seed);
        let phases = Phases::draw(&mut Noise::channel(ground, ROAD_STREAM));
        let road = Road::new(&surface, &phases).turned(run.turned_at);
        let mut driver = Driver::new(run.scenario, run.payload, &machine, stream(DRIVER_STREAM))
            .reversing(run.effects.reverses)
            .with_arm(run.gauges.is_some());
        let mut acts = Acts {
            effects: run.effects,
            machine,
            gears: Gears::default(),
        };
        let plant = Plant::new(machine, road, run.scenario.start_speed(), &mut |t, x| {
            acts.inputs(&mut driver, t, x)
        });
        let duration = run.duration.unwrap_or(run.scenario.duration());
        Ok(Self {
            plant,
            driver,
            acts,
            late_speed: Late::default(),
            late_torques: Default::default(),
            jitter: stream(JITTER_STREAM),
            stamp: 0.0,
            next_speed: 0.0,
            inclinometer: Inclinometer::default(),
            machine,
            calibration,
            nominal,
            // A machine that weighs its bucket needs no scale under its axles.
            tells_mass: (run.tier == Tier::B || run.scenario.payload(run.payload) > 0.0)
                && !(matches!(run.scenario, Scenario::Loading | Scenario::Lifts)
                    && run.gauges.is_some()),
            arm: run
                .gauges
                .map(|gauges| ArmSensors::new(LiftArm::of(&machine), gauges, of)),
            noise: std::array::from_fn(|channel| stream(channel as u64 + 1)),
            faults: Injector::new(&run.faults, CHANNELS, run.seed)?,
            rate: run.rate,
            next: 0,
            rows: (duration * run.rate + 1e-6) as u64 + 1,
        })
    }

    /// The estimator's knowledge of the machine.
    pub fn nominal(&self) -> &Nominal {
        &self.nominal
    }

    /// Measured over true torque, front and rear.
    pub fn torque_gains(&self) -> [f64; 2] {
        let known = &self.calibration;
        [known.front_torque_gain, known.rear_torque_gain]
    }

    /// Bias of the slope sensor \[rad\].
    pub fn slope_bias(&self) -> f64 {
        self.calibration.slope_bias
    }

    /// The true machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    fn measure(&mut self, time: f64) -> Row {
        let arm = self.look_at_arm(time);
        let motion = self.plant.motion();
        let inputs = self.plant.inputs();
        let &[speed, front_wheel_speed, rear_wheel_speed, ..] = self.plant.state();
        let (grade, known) = (self.nominal.grade, &self.calibration);
        let noise: [f64; 7] = std::array::from_fn(|channel| self.noise[channel].normal());
        let torque = |true_torque: f64, gain: f64, n: f64| {
            true_torque * gain * (1.0 + grade.torque_std() * n)
        };
        let acceleration = motion.rate[0];
        let effects = self.acts.effects;
        let bend = effects.bend(time);
        let turning = (effects.steering != 0.0 && effects.steering_reported).then_some(bend);
        let braking = inputs.front_brake + inputs.rear_brake != 0.0;
        let step = 1.0 / self.rate;
        let slope = self
            .inclinometer
            .show(&effects, motion.slope, acceleration, step);
        let shown_speed = self.late_speed.pass(time, speed, effects.speed_delay);
        let gears = &self.acts.gears;
        let reported = gears.share(time - effects.gear_delay) / gears.share(time);
        let tells_mass = self.tells_mass && effects.payload_reported != PayloadReport::Nothing;
        let tells_boom = effects.payload_reported == PayloadReport::All;
        let specific_force = acceleration + GRAVITY * motion.slope.sin();
        let [front_torque, rear_torque] = [inputs.front_torque, inputs.rear_torque];
        let front_torque = self.late_torques[0].pass(time, front_torque, effects.torque_delay);
        let rear_torque = self.late_torques[1].pass(time, rear_torque, effects.torque_delay);
        let speed_comes = time >= self.next_speed - 0.5 * step;
        if speed_comes {
            self.next_speed += effects.speed_period;
        }
        let shown_speed = if speed_comes || effects.speed_period <= 0.0 {
            shown_speed * (1.0 + effects.speed_gain) + grade.speed_std() * noise[0]
        } else {
            f64::NAN
        };
        if effects.jitter > 0.0 {
            let late = effects.jitter * self.jitter.normal();
            self.stamp = (time + late).max(self.stamp + SHORTEST_ROW);
        } else {
            self.stamp = time;
        }
        Row {
            time: self.stamp,
            speed: shown_speed,
            front_wheel_speed: front_wheel_speed * (1.0 + effects.front_speed_gain)
                + grade.wheel_speed_std() * noise[1],
            rear_wheel_speed: rear_wheel_speed + grade.wheel_speed_std() * noise[2],
            front_torque: torque(front_torque * reported, known.front_torque_gain, noise[3]),
            rear_torque: torque(rear_torque * reported, known.rear_torque_gain, noise[4]),
            slope: slope + known.slope_bias + grade.slope_std() * noise[5],
            acceleration: specific_force
                + effects.acceleration_offset
                + grade.acceleration_std() * noise[6],
            mass: tells_mass.then_some(inputs.mass * known.mass_gain),
            spade_force_x: known.spade_force_x_known.then_some(inputs.spade_force_x),
            spade_force_z: Some(inputs.spade_force_z * known.spade_force_z_gain),
            boom_moving: tells_boom.then(|| self.driver.boom_moving(time)),
            articulation: turning.map(|bend| bend.angle),
            yaw_rate: turning.map(|bend| effects::yaw_rate(&self.machine, &bend, speed)),
            brake: (effects.brakes > 0.0 && effects.brakes_reported).then_some(braking),
            arm,
            payload: self.weigh(time),
            truth: Truth {
                speed,
                front_wheel_speed,
                rear_wheel_speed,
                cg_height: inputs.cg_height,
                cg_ratio: inputs.cg_ratio,
                slip_stiffness: self.machine.slip_stiffness,
                spade_force_x: inputs.spade_force_x,
                slope: motion.slope,
                payload: self.driver.payload(time).mass,
                acceleration,
            },
        }
    }

    /// Readings of the lift arm's sensors.
    fn look_at_arm(&mut self, time: f64) -> Option<Seen> {
        let motion = self.plant.motion();
        let inputs = self.plant.inputs();
        let pitch = self.plant.state()[7];
        let arm = self.driver.arm();
        let ahead = (1.0 - inputs.cg_ratio) * self.machine.wheelbase + arm.pivot_x;
        let by = Shaken {
            time,
            tilt: motion.slope + pitch,
            surge: motion.rate[0],
            heave: motion.rate[6] + ahead * motion.rate[8],
            payload: self.driver.payload(time).mass,
            contact: self.driver.contact(time),
            push: inputs.spade_force_x,
        };
        let driver = &self.driver;
        self.arm
            .as_mut()
            .map(|arm| arm.show(&by, |t| driver.stance(t)))
    }

    fn weigh(&self, time: f64) -> Payload {
        let (payload, known) = (self.driver.payload(time), &self.calibration);
        Payload {
            mass: payload.mass * known.payload_gain,
            height: payload.height + known.payload_height_error,
            reach: payload.reach + known.payload_reach_error,
        }
    }
}

impl Iterator for Simulation {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        while self.next < self.rows {
            let time = self.next as f64 / self.rate;
            if self.next > 0 {
                let (driver, acts) = (&mut self.driver, &mut self.acts);
                self.plant
                    .advance(time, &mut |t, state| acts.inputs(driver, t, state));
            }
            self.next += 1;
            let mut row = self.measure(time);
            let lost = self.faults.loses_row(time);
            damage(&mut row, &mut self.faults);
            if !lost {
                return Some(row);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::loader::Scenario;

    fn rows(run: &Run) -> Vec<Row> {
        Simulation::new(run).unwrap().collect()
    }

    #[test]
    fn the_same_seed_gives_the_same_rows_and_another_seed_others() {
        let run = Run {
            duration: Some(1.0),
            tier: Tier::B,
            ..Run::new(Scenario::WorkCycle)
        };
        assert_eq!(rows(&run), rows(&run));
        assert_ne!(
            rows(&run)[50].speed,
            rows(&Run {
                seed: 1,
                ..run.clone()
            })[50]
                .speed
        );
    }

    #[test]
    fn the_drive_keeps_the_wheels_of_a_machine_that_loads_from_spinning() {
        let most = |spins| {
            let mut run = Run {
                duration: Some(26.0),
                tier: Tier::B,
                payload: Some(1100.0),
                ..Run::new(Scenario::Loading)
            };
            run.effects.spins = spins;
            let radius = Simulation::new(&run).expect("a run").nominal().wheel_radius;
            let away = |r: &Row, wheel: f64| (radius * wheel - r.truth.speed).abs();
            let rows = rows(&run);
            let both = rows
                .iter()
                .map(|r| away(r, r.front_wheel_speed).max(away(r, r.rear_wheel_speed)));
            both.fold(0.0, f64::max)
        };
        assert!(most(false) < 1.2, "{} m/s", most(false));
        assert!(most(true) > 3.0, "{} m/s", most(true));
    }

    #[test]
    fn a_fault_changes_its_channel_and_nothing_else() {
        let run = Run {
            duration: Some(1.0),
            ..Run::new(Scenario::Bumpy)
        };
        let fault = Fault::parse("front_wheel_speed:scale=0,from=0.5,to=0.6").unwrap();
        let locked = rows(&Run {
            faults: vec![fault],
            ..run.clone()
        });
        for (sound, row) in rows(&run).iter().zip(&locked) {
            let expected = if (0.5..0.6).contains(&row.time) {
                0.0
            } else {
                sound.front_wheel_speed
            };
            assert_eq!(
                *row,
                Row {
                    front_wheel_speed: expected,
                    ..*sound
                }
            );
        }
    }

    #[test]
    fn missing_rows_are_left_out_and_the_time_can_jump() {
        let run = Run {
            duration: Some(1.0),
            ..Run::new(Scenario::Bumpy)
        };
        let faults = [
            "row:missing,from=0.2,to=0.4",
            "time:bias=-0.3,from=0.7,to=0.71",
            "slope:missing,from=0.9",
        ];
        let faults = faults.iter().map(|t| Fault::parse(t).unwrap()).collect();
        let rows = rows(&Run { faults, ..run });
        assert_eq!(rows.len(), 81);
        assert!(rows.iter().any(|row| (row.time - 0.4).abs() < 1e-9));
        assert!(rows.windows(2).any(|pair| pair[1].time < pair[0].time));
        assert!(rows.last().unwrap().slope.is_nan());
    }

    #[test]
    fn a_machine_of_tier_b_reports_no_horizontal_spading_force() {
        let run = Run {
            tier: Tier::B,
            duration: Some(6.0),
            ..Run::new(Scenario::Digging)
        };
        let last = rows(&run).pop().unwrap();
        assert_eq!(last.spade_force_x, None);
        assert!(last.truth.spade_force_x > 5000.0 && last.mass.is_some());
    }

    #[test]
    fn a_run_goes_on_after_the_end_of_its_scenario_and_keeps_its_speed_in_range() {
        let run = Run {
            duration: Some(200.0),
            rate: 10.0,
            tier: Tier::B,
            ..Run::new(Scenario::AccelDecel)
        };
        let rows = rows(&run);
        assert_eq!(rows.len(), 2001);
        assert!(
            rows.iter()
                .all(|row| (-0.5..8.0).contains(&row.truth.speed))
        );
        let spread = |from: f64| {
            let late = rows
                .iter()
                .filter(|row| row.time > from)
                .map(|row| row.truth.speed);
            late.clone().fold(f64::MIN, f64::max) - late.fold(f64::MAX, f64::min)
        };
        assert!(spread(100.0) > 2.0, "{}", spread(100.0));
    }

    #[test]
    fn what_cannot_be_simulated_is_refused() {
        let run = Run::new(Scenario::Bumpy);
        assert!(
            Simulation::new(&Run {
                rate: 0.0,
                ..run.clone()
            })
            .is_err()
        );
        assert!(
            Simulation::new(&Run {
                duration: Some(f64::NAN),
                ..run.clone()
            })
            .is_err()
        );
        assert!(
            Simulation::new(&Run {
                payload: Some(-1.0),
                ..run.clone()
            })
            .is_err()
        );
        let fault = Fault::parse("swing_velocity:missing").unwrap();
        assert!(
            Simulation::new(&Run {
                faults: vec![fault],
                ..run
            })
            .is_err()
        );
    }
}
