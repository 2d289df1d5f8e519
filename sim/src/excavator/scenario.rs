//! The scenarios of the simulated excavator, by name.

use super::calibration;
use super::cycle;
use super::event::Event;
use super::path::{Joint, Path};
use super::payload::Load;
use super::plant::{Dynamics, Plant};
use super::plants::{at_rest, swing, working_swing};
use super::plateaus::Targets;
use super::torque::Swing;
use crate::named::scenarios;

scenarios! {
    /// A named course of events.
    Base "base" "load, swing 97 degrees while the arm extends, brake";
    Gentle "gentle" "the same with the arm extended late: the inertia changes little in the swing";
    Paper "paper" "gentle, with the paper's equation of motion (no posture rate)";
    Constant "constant" "a long swing at constant posture, 150 kg";
    TwoSwings "two-swings" "swing, dump in the stop, swing back";
    SoftBrake "soft-brake" "base, but the torque is reduced to 60 % instead of braking";
    Drop "drop" "350 kg dumped as braking begins, on a path of its own";
    DropAccelerating "drop-accelerating" "bucket opens and 423 kg fall while accelerating";
    DropReversal "drop-reversal" "the same across the torque reversal";
    DropBraking "drop-braking" "the same while braking";
    HalfAccelerating "half-accelerating" "half of the load falls while accelerating";
    HalfBraking "half-braking" "half of the load falls while braking";
    SlowDrop "slow-drop" "the load leaves in 2.0 s, from accelerating into braking";
    SlowBraking "slow-braking" "the load leaves in 1.7 s while braking";
    OpenAccelerating "open-accelerating" "bucket opens 60 degrees while accelerating, the load stays";
    OpenBraking "open-braking" "bucket opens 60 degrees while braking, the load stays";
    OpenEmpty "open-empty" "an empty bucket opens while braking";
    StillAccelerating "still-accelerating" "the load falls in 0.4 s while accelerating, the bucket angle does not move";
    StillBraking "still-braking" "the load falls while braking, the bucket angle does not move";
    PickUpAccelerating "pick-up-accelerating" "300 kg are taken up in 0.6 s while accelerating";
    PickUpBraking "pick-up-braking" "300 kg are taken up in 0.6 s while braking";
    Cycle "cycle" "without end: dig, swing, dump, swing back, with 288, 423, 200 and 350 kg in turn";
    Calibration "calibration" "without end: four times the same with 423 kg, then slow full lifts of the boom";
}

use Scenario::*;

impl Scenario {
    /// The scenario of a name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::all().find(|scenario| scenario.name() == name)
    }

    /// Mass in a full bucket if the run does not state one \[kg\]. `cycle` and `calibration` have their own.
    pub fn default_payload(self) -> f64 {
        match self {
            Constant => 150.0,
            Drop => 350.0,
            _ => self.event().map_or(288.0, |event| event.payload),
        }
    }

    /// Time at which the record begins \[s\].
    pub fn start(self) -> f64 {
        if self.is_endless() { 0.0 } else { 5.0 }
    }

    /// Whether it continues from its first second for as long as the run lasts.
    pub fn is_endless(self) -> bool {
        matches!(self, Cycle | Calibration)
    }

    /// Length of the record \[s\]; infinite for an endless scenario.
    pub fn duration(self) -> f64 {
        match self {
            Constant => 11.5,
            TwoSwings => 11.0,
            Cycle | Calibration => f64::INFINITY,
            _ => 4.8,
        }
    }

    /// First and last time during the swing at which material leaves or enters the bucket \[s\], or at which the bucket moves as if it
    /// did.
    pub fn change(self) -> Option<(f64, f64)> {
        match self {
            Drop => Some((7.75, 8.45)),
            _ => self.event().map(|event| event.change),
        }
    }

    /// The plant, its torque plateaus solved, with a full bucket of `payload` \[kg\].
    pub fn plant(self, payload: Option<f64>) -> Plant {
        let mass = payload.unwrap_or(self.default_payload());
        match self {
            Base => working(Path::base(), mass, (9.6, 10.5)),
            Gentle => working(Path::gentle(), mass, (10.2, 11.2)),
            Paper => paper(mass),
            Constant => constant(mass),
            TwoSwings => two_swings(mass),
            SoftBrake => soft_brake(mass),
            Drop => drop_in_swing(mass),
            Cycle => cycle::plant(payload),
            Calibration => calibration::plant(payload),
            _ => self.event().map_or_else(
                || working(Path::base(), mass, (9.6, 10.5)),
                |e| e.plant(mass),
            ),
        }
    }

    /// The base path with 423 kg dumped in 0.65 s, the bucket opening at `time` \[s\].
    pub fn dump_at(time: f64) -> Plant {
        Event::dump(time).plant(423.0)
    }

    fn event(self) -> Option<Event> {
        Some(match self {
            DropAccelerating => Event::dump(6.40),
            DropReversal => Event::dump(7.05),
            DropBraking => Event::dump(7.70),
            HalfAccelerating => Event::half(6.40),
            HalfBraking => Event::half(7.70),
            SlowDrop => Event::slow(6.20, 2.0),
            SlowBraking => Event::slow(7.50, 1.7),
            OpenAccelerating => Event::open(6.40),
            OpenBraking => Event::open(7.70),
            OpenEmpty => Event::open_empty(7.70),
            StillAccelerating => Event::still(6.40, 0.40),
            StillBraking => Event::still(7.85, 0.65),
            PickUpAccelerating => Event::pick_up(6.40),
            PickUpBraking => Event::pick_up(7.85),
            _ => return None,
        })
    }
}

fn filled(mass: f64, dump: (f64, f64)) -> Vec<Load> {
    vec![Load {
        mass,
        fill: (1.5, 3.4),
        dump,
    }]
}

fn working(path: Path, mass: f64, dump: (f64, f64)) -> Plant {
    swing(at_rest(path, filled(mass, dump)), working_swing())
}

fn paper(mass: f64) -> Plant {
    let mut plant = at_rest(Path::gentle(), filled(mass, (10.2, 11.2)));
    plant.machine.dynamics = Dynamics::Paper;
    swing(plant, working_swing())
}

fn constant(mass: f64) -> Plant {
    swing(
        at_rest(Path::constant(), vec![Load::kept(mass)]),
        Targets::working(5.5, 12.5, 16.0),
    )
}

fn two_swings(mass: f64) -> Plant {
    let mut path = Path::base();
    path.joints[0]
        .moves
        .extend(Joint::new(0.0, &[(11.3, 13.5, -10.0)]).moves);
    path.joints[1]
        .moves
        .extend(Joint::new(0.0, &[(11.3, 14.0, -40.0)]).moves);
    let plant = swing(at_rest(path, filled(mass, (9.6, 10.5))), working_swing());
    swing(plant, Targets::back(11.2, 13.0, 14.8))
}

/// The drive continues with 60 % of its torque and fades out, without braking.
fn soft_brake(mass: f64) -> Plant {
    let mut plant = working(Path::base(), mass, (9.6, 10.5));
    for Swing {
        accelerate, brake, ..
    } in &mut plant.swings
    {
        *brake = -0.6 * *accelerate;
    }
    plant
}

fn drop_in_swing(mass: f64) -> Plant {
    let path = Path {
        joints: [
            Joint::new(40.0, &[(3.2, 5.6, 15.0), (5.7, 7.6, 7.0)]),
            Joint::new(
                -110.0,
                &[(0.8, 3.2, -30.0), (3.2, 5.4, -6.0), (6.0, 9.6, 44.0)],
            ),
            Joint::new(-35.0, &[(1.4, 3.4, -50.0), (7.55, 8.6, 68.0)]),
        ],
    };
    working(path, mass, (7.75, 8.45))
}

#[cfg(test)]
mod tests {
    use super::super::plateaus::Plateaus;
    use super::*;

    #[test]
    fn every_name_means_its_own_scenario() {
        for scenario in Scenario::all() {
            assert_eq!(Scenario::parse(scenario.name()), Some(scenario));
        }
        assert_eq!(Scenario::parse("no such thing"), None);
    }

    #[test]
    fn every_working_swing_meets_its_velocities() {
        for scenario in
            Scenario::all().filter(|s| !matches!(s, SoftBrake | Constant) && !s.is_endless())
        {
            let plant = scenario.plant(None);
            let swing = plant.swings[0];
            let rest = Plant {
                swings: Vec::new(),
                ..plant.clone()
            };
            assert_eq!(
                Plateaus::new(&rest, working_swing()).solve(),
                swing,
                "{}",
                scenario.name()
            );
            assert!(
                (1000.0..6000.0).contains(&swing.accelerate),
                "{}",
                scenario.name()
            );
            assert!(
                (500.0..6000.0).contains(&swing.brake),
                "{}",
                scenario.name()
            );
        }
    }
}
