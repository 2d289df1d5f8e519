//! Counts loads from messages: the ledger of any machine, live and on recordings.
//!
//! Its input is the estimates of one process and the sensor signals of the truck and of the machine's mass.

use std::collections::VecDeque;

use config::Description;
use estimation::Quantity;
use estimation::loads::{Events, Ledger, Load, Row, Settings, Witness};
use messages::{
    Envelope, ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, LoaderSensors, Machine,
    excavator_bits, loader_bits,
};

mod guessed;
mod outage;
mod report;
mod scale;
mod why;

pub use guessed::guessed;
use guessed::shown_empty;
pub use outage::{MISSING, Outage, are_doubtful};
use outage::{Outages, Watched, fault};
pub use report::{channel, message};
use scale::Scale;
use why::why;
pub use why::{outage_words, reason_and_flags, why_words};

/// Number of loads stored while the machine works; the sums include all.
const REMEMBERED: usize = 1000;

/// Largest age of the pressures that weigh a boom \[s\].
const PRESSED: f64 = 0.25;

/// Settings of the counter that are not in the description.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Target weight of a truck \[kg\].
    pub target: Option<f64>,
    /// Pause between two loads after which another truck begins; 0: never \[s\].
    pub pause: f64,
}

impl Default for Options {
    fn default() -> Self {
        let settings = Settings::with_rated(1.0);
        Self {
            target: settings.target,
            pause: settings.pause,
        }
    }
}

/// Counts the loads of one machine.
#[derive(Debug, Clone)]
pub struct LoadCounter {
    machine: Machine,
    ledger: Ledger,
    scale: Scale,
    truck: Option<f64>,
    /// A measured mass that the scale has not processed yet [kg].
    mass: Option<f64>,
    /// Whether the cylinders are described, so that their pressures weigh.
    is_described: bool,
    guessed: Option<String>,
    /// Whether the latest sample has pressures; `None` where only estimates are received.
    pressure: Option<bool>,
    /// Time of the last boom pressure \[s\].
    pressed: f64,
    /// Whether samples have had pressures, and a mass.
    measured: [bool; 2],
    loads: VecDeque<Load>,
    outages: Outages,
    /// Largest number of stored loads.
    remembered: usize,
}

impl LoadCounter {
    /// A counter for the machine of a description.
    pub fn new(description: &Description, options: Options) -> Self {
        let (settings, empty) = match description {
            Description::Excavator(d) => (d.loads(), 0.0),
            Description::Loader(d) => (d.loads(), d.machine.mass),
        };
        let is_described = match description {
            Description::Excavator(d) => d.boom_cylinder.head_area > 0.0,
            Description::Loader(d) => d.lift_arm.length > 0.0,
        };
        let settings = Settings {
            target: options.target,
            pause: options.pause,
            ..settings
        };
        Self {
            machine: description.machine(),
            ledger: Ledger::new(settings),
            scale: Scale::new(empty),
            truck: None,
            mass: None,
            is_described,
            guessed: guessed(description),
            pressure: None,
            pressed: f64::NEG_INFINITY,
            measured: [false; 2],
            loads: VecDeque::new(),
            outages: Outages::default(),
            remembered: REMEMBERED,
        }
    }

    /// The same for a recording, all of whose loads are needed at its end.
    #[must_use]
    pub fn remembering_all(self) -> Self {
        Self {
            remembered: usize::MAX,
            ..self
        }
    }

    /// A counter for the machine of a TOML description; `None` where it cannot be read.
    pub fn of_text(description: &str, options: Options) -> Option<Self> {
        let description = Description::parse(description, "the recording", None).ok()?;
        Some(Self::new(&description, options))
    }

    /// The machine.
    pub fn machine(&self) -> Machine {
        self.machine
    }

    /// The ledger: contents of the bucket, the truck and the day.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The stored loads, the oldest first.
    pub fn loads(&self) -> impl DoubleEndedIterator<Item = &Load> {
        self.loads.iter()
    }

    /// The loads, the newest first, as the sums of truck and day have them: one that is not booked may weigh otherwise than reported.
    pub fn newest(&self) -> impl Iterator<Item = Load> {
        let unbooked = self.ledger.unbooked();
        let is_it = move |load: &Load| unbooked.is_some_and(|it| it.number == load.number);
        let others = self.loads.iter().rev().filter(move |load| !is_it(load));
        unbooked.into_iter().chain(others.copied())
    }

    /// Whether pressures weigh: their cylinders are described, and samples have them.
    fn has_pressure(&self) -> bool {
        self.is_described && self.pressure.unwrap_or(true)
    }

    /// Text that names the missing signals for weighing, and the remedy.
    pub fn lacks(&self) -> Option<&'static str> {
        match self.machine {
            Machine::Loader => match self.measured {
                [false, false] => Some(
                    "a loader is weighed by its lift pressures or a column `mass`, and the data have neither: map one",
                ),
                [true, false] => self.unused(),
                [_, true] => None,
            },
            Machine::Excavator => match self.measured {
                [false, _] => Some(
                    "only the swing motion weighs: map the boom's pressures to weigh at standstill too",
                ),
                [true, _] => self.unused(),
            },
        }
    }

    /// Text for pressures that are measured but do not weigh, and the remedy.
    pub fn unused(&self) -> Option<&'static str> {
        let is_unused = !self.is_described && self.measured[0];
        is_unused.then_some(match self.machine {
            Machine::Loader => {
                "the data have lift pressures, and the machine file has no `machine.lift_arm`: describe it (--config), its length, pivot and masses, and `cylinder` with base_distance, rod_distance, angle, head_area and rod_area"
            }
            Machine::Excavator => {
                "the data have boom pressures, and the machine file has no `machine.boom_cylinder`: describe it (--config), by base_distance, rod_distance, angle, head_area and rod_area"
            }
        })
    }

    /// Text for emptied buckets of a loader that weigh more than soil does.
    pub fn shown_empty(&self) -> Option<String> {
        let is_loader = self.machine == Machine::Loader;
        is_loader.then(|| shown_empty(self.loads.iter(), self.ledger.rated()))?
    }

    /// Smallest content that counts as a load \[kg\].
    pub fn smallest(&self) -> f64 {
        self.ledger.smallest()
    }

    /// Text for the numbers that the machine file leaves open, see [`guessed`].
    pub fn guessed(&self) -> Option<&str> {
        self.guessed.as_deref()
    }

    /// The times in which a fault of a sensor left no load weighed, one for each reason.
    pub fn outages(&self) -> Vec<Outage> {
        self.outages.all()
    }

    /// Time of all rows \[s\].
    pub fn seconds(&self) -> f64 {
        self.outages.seconds()
    }

    /// Starts another truck.
    pub fn next_truck(&mut self) -> Events {
        let events = self.ledger.next_truck();
        self.note(events)
    }

    /// Sets the target weight of each truck from now on \[kg\].
    pub fn set_target(&mut self, target: Option<f64>) {
        self.ledger.set_target(target);
    }

    /// Ends the recording.
    pub fn finish(&mut self) -> Events {
        let events = self.ledger.finish();
        self.note(events)
    }

    /// Takes a message: samples of the sensors, and estimates of the one process that estimates the payload.
    pub fn see(&mut self, message: &Envelope) -> Events {
        match message {
            Envelope::ExcavatorSensors(m) => self.excavator_sensors(m),
            Envelope::LoaderSensors(m) => self.loader_sensors(m),
            Envelope::ExcavatorEstimate(m) => return self.excavator(m),
            Envelope::LoaderEstimate(m) => return self.loader(m),
            _ => {}
        }
        Events::default()
    }

    fn excavator_sensors(&mut self, sample: &ExcavatorSensors) {
        let has = |bit: u32| sample.valid & bit != 0;
        if has(excavator_bits::BOOM_HEAD_PRESSURE) {
            self.pressed = sample.stamp.time;
            self.measured[0] = true;
        }
        // Pressures may come less often than rows.
        let age = sample.stamp.time - self.pressed;
        self.pressure = Some((0.0..PRESSED).contains(&age));
        self.truck = has(excavator_bits::TRUCK)
            .then_some(sample.truck)
            .or(self.truck);
    }

    fn loader_sensors(&mut self, sample: &LoaderSensors) {
        let has = |bit: u32| sample.valid & bit != 0;
        self.mass = has(loader_bits::MASS).then_some(sample.mass).or(self.mass);
        self.measured[0] |= has(loader_bits::LIFT_HEAD_PRESSURE);
        // The arm continues to weigh through a gap in its pressures.
        self.pressure = Some(self.measured[0]);
        self.measured[1] |= self.mass.is_some();
        self.truck = has(loader_bits::TRUCK)
            .then_some(sample.truck)
            .or(self.truck);
    }

    fn excavator(&mut self, m: &ExcavatorEstimate) -> Events {
        let flag = |bit: u32| m.flags & bit != 0;
        if flag(excavator_bits::REFUSED) {
            return Events::default();
        }
        let payload = Quantity {
            value: m.payload,
            std: m.payload_std,
        };
        let trusted = flag(excavator_bits::TRUSTED);
        let row = Row {
            time: m.stamp.time,
            payload: (m.estimated & excavator_bits::PAYLOAD != 0).then_some(payload),
            common: None,
            speed: m.velocity,
            changing: flag(excavator_bits::CHANGING),
            hangs: m.reason == estimation::excavator::Reason::Hanging as u32,
            trusted,
            why: why(m.reason, m.flags, trusted),
            witness: if self.has_pressure() {
                Witness::Both
            } else {
                Witness::Motion
            },
            truck: self.truck,
        };
        self.row(&row, fault(self.machine, m.reason, m.flags))
    }

    fn loader(&mut self, m: &LoaderEstimate) -> Events {
        if m.flags & loader_bits::REFUSED != 0 {
            return Events::default();
        }
        // A described arm without any pressure gives a payload that is not estimated.
        let estimated = m.estimated & loader_bits::PAYLOAD != 0 && self.has_pressure();
        let weighed = estimated.then_some(Quantity {
            value: m.payload,
            std: m.payload_std,
        });
        let scale = self.scale.step(self.mass.take(), m.stamp.time);
        // Lift pressures have stated tolerances, a scale has none.
        let trusted = match weighed {
            Some(_) => m.flags & loader_bits::TRUSTED_PAYLOAD != 0,
            None => scale.is_some(),
        };
        let row = Row {
            time: m.stamp.time,
            payload: weighed.or(scale.map(|shown| shown.payload)),
            common: scale
                .filter(|_| weighed.is_none())
                .map(|shown| shown.common),
            speed: m.speed,
            changing: match weighed {
                // Also where a broken sensor is the reason: its value before the change belongs to the load before.
                Some(_) => m.flags & loader_bits::CHANGING != 0,
                None => scale.is_some_and(|shown| shown.changing),
            },
            hangs: false,
            trusted,
            why: why(m.reason, m.flags, trusted),
            witness: if weighed.is_some() {
                Witness::Pressure
            } else {
                Witness::Scale
            },
            truck: self.truck,
        };
        self.row(&row, fault(self.machine, m.reason, m.flags))
    }

    fn row(&mut self, row: &Row, fault: Option<u32>) -> Events {
        let events = self.ledger.step(row);
        let dumped = events.load.filter(|load| load.dumped.is_some());
        // A load that nothing weighed shows no working sensor.
        let weighed = dumped.filter(|load| load.witness != Witness::Nothing);
        self.outages.see(&Watched {
            time: row.time,
            moves: row.moves(),
            trusted: row.trusted,
            dumped: weighed.map(|load| load.number),
            fault,
        });
        self.note(events)
    }

    /// Stores the reported load.
    fn note(&mut self, events: Events) -> Events {
        if let Some(load) = events.load {
            // A repeated report concerns the latest load, or the one before.
            let known = self.loads.iter().rposition(|l| l.number == load.number);
            known.and_then(|i| self.loads.remove(i));
            self.loads.push_back(load);
            if self.loads.len() > self.remembered {
                self.loads.pop_front();
            }
        }
        events
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Message, Stamp};

    fn description(text: &str) -> Description {
        Description::parse(text, "test", None).expect("a description")
    }

    #[test]
    fn of_a_recording_every_load_is_remembered_and_live_the_latest() {
        let machine = description("[machine]\nkind = \"loader\"\n");
        let counter = LoadCounter::new(&machine, Options::default());
        let numbers = |mut counter: LoadCounter| -> Vec<u32> {
            // Each is reported once as carried and once as dumped.
            for number in (1..=1001).flat_map(|n| [n, n]) {
                let load = Load {
                    number,
                    ..Load::default()
                };
                counter.note(Events {
                    load: Some(load),
                    ..Events::default()
                });
            }
            counter.loads().map(|load| load.number).collect()
        };
        assert!(
            numbers(counter.clone().remembering_all())
                .into_iter()
                .eq(1..=1001)
        );
        assert!(numbers(counter).into_iter().eq(2..=1001));
    }

    #[test]
    fn pressures_that_weigh_nothing_are_named() {
        let reported = |file: &str, valid: u32| {
            let mut counter = LoadCounter::new(&description(file), Options::default());
            counter.see(&Envelope::ExcavatorSensors(ExcavatorSensors {
                valid,
                ..ExcavatorSensors::default()
            }));
            counter.unused().unwrap_or_default()
        };
        let bare = "[machine]\nkind = \"excavator\"\n";
        let pressures = excavator_bits::BOOM_HEAD_PRESSURE;
        assert!(reported(bare, pressures).contains("head_area"));
        assert_eq!(reported(bare, excavator_bits::BOOM_ANGLE), "");
        let described = format!("{bare}[machine.boom_cylinder]\nhead_area = 0.01\n");
        assert_eq!(reported(&described, pressures), "");
    }

    #[test]
    fn a_loader_with_a_scale_has_loads_whatever_its_described_mass() {
        for described in ["12500.0", "11500.0"] {
            let text = format!("[machine]\nkind = \"loader\"\nmass = {described}\n");
            let mut counter = LoadCounter::new(&description(&text), Options::default());
            let mut reported = Vec::new();
            for i in 0..9000 {
                let phase = i % 3000;
                let load = if (1000..2500).contains(&phase) {
                    3000.0
                } else {
                    0.0
                };
                let time = f64::from(i) * 0.01;
                let stamp = Stamp {
                    time,
                    ..Stamp::default()
                };
                let sensors = LoaderSensors {
                    stamp,
                    mass: 12_000.0 + load,
                    valid: loader_bits::MASS,
                    ..LoaderSensors::default()
                };
                counter.see(&sensors.envelope());
                let estimate = LoaderEstimate {
                    stamp,
                    ..LoaderEstimate::default()
                };
                reported.extend(counter.see(&estimate.envelope()).load);
            }
            reported.extend(counter.finish().load);
            let all: Vec<_> = counter.loads().collect();
            assert_eq!(all.len(), 3, "{described}: {all:?}");
            for load in all {
                assert!(load.weight.quantity().holds(3000.0), "{load:?}");
                assert!(load.delivered().quantity().holds(3000.0), "{load:?}");
                assert_eq!(load.witness, Witness::Scale);
            }
            assert!(
                reported
                    .iter()
                    .any(|l| l.stage == estimation::loads::Stage::Carried)
            );
        }
    }
}
