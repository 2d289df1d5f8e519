//! The story of a run: a line for each swing or drive as it ends, and a table of them at the end.

use std::fmt::Write;

use estimation::HALF_WIDTH_95;
use evaluate::text::Table;
use messages::{Envelope, Machine, Message, Receiver, Value};
use view::number;

/// A pause shorter than this does not end a stretch of motion [s].
const PAUSE: f64 = 0.3;
/// A shorter motion is none [s].
const SHORTEST: f64 = 1.0;

/// What the story of a machine is about.
struct Subject {
    /// What a stretch of motion is called.
    stretch: &'static str,
    /// Field of the speed, and the least speed of a machine that moves [rad/s, m/s].
    speed: (&'static str, f64),
    /// What the quantity is called.
    label: &'static str,
    /// Unit as printed, and how many of it one SI unit is.
    unit: (&'static str, f64),
    /// Field of the estimate and of the truth; the standard deviation has `_std` behind it.
    field: &'static str,
    /// Bit of `flags` that says that it is trusted.
    trusted: u32,
}

fn subject(machine: Machine) -> &'static Subject {
    match machine {
        Machine::Excavator => &Subject {
            stretch: "swing",
            speed: ("velocity", 0.05),
            label: "load",
            unit: ("kg", 1.0),
            field: "payload",
            trusted: messages::excavator_bits::TRUSTED,
        },
        Machine::Loader => &Subject {
            stretch: "drive",
            speed: ("speed", 0.3),
            label: "front axle carries",
            unit: ("%", 100.0),
            field: "cg_ratio",
            trusted: messages::loader_bits::TRUSTED_RATIO,
        },
    }
}

/// An estimate of what the story is about, in the unit that is printed.
#[derive(Debug, Clone, PartialEq)]
struct Told {
    time: f64,
    value: f64,
    std: f64,
    truth: Option<f64>,
    trusted: bool,
    /// What would bring trust; empty where it is trusted.
    advice: String,
}

impl Told {
    fn half_width(&self) -> f64 {
        HALF_WIDTH_95 * self.std
    }

    fn holds(&self) -> Option<bool> {
        Some((self.value - self.truth?).abs() <= self.half_width())
    }

    fn verdict(&self) -> String {
        if self.trusted {
            "trusted".into()
        } else {
            format!("not trusted yet: {}", self.advice)
        }
    }
}

/// A stretch of motion.
#[derive(Debug, Clone)]
struct Stretch {
    start: f64,
    last_motion: f64,
    /// The last trusted estimate, else the narrowest.
    told: Told,
}

/// Swings or drives of one machine, as they happen.
#[derive(Debug)]
pub struct Story {
    machine: Machine,
    open: Option<Stretch>,
    ended: Vec<Stretch>,
    latest: Option<Told>,
}

impl Story {
    /// Nothing has happened yet.
    pub fn new(machine: Machine) -> Self {
        Self {
            machine,
            open: None,
            ended: Vec::new(),
            latest: None,
        }
    }

    /// Takes an estimate with the truth behind it; a line where a stretch of motion has ended.
    pub fn add(&mut self, estimate: &Envelope, truth: Option<&Envelope>) -> Option<String> {
        let subject = subject(self.machine);
        let flags = number_in(estimate, "flags")? as u32;
        let speed = number_in(estimate, subject.speed.0)?.abs();
        let time = number_in(estimate, "t").or_else(|| number_in(estimate, "time"))?;
        let factor = subject.unit.1;
        let told = Told {
            time,
            value: factor * number_in(estimate, subject.field)?,
            std: factor * number_in(estimate, &format!("{}_std", subject.field))?,
            truth: truth
                .and_then(|t| number_in(t, subject.field))
                .map(|t| factor * t),
            trusted: flags & subject.trusted != 0,
            advice: view::words::advice(estimate).unwrap_or_default().into(),
        };
        self.latest = Some(told.clone());
        if speed >= subject.speed.1 {
            match &mut self.open {
                Some(open) => open.go_on(told),
                None => {
                    self.open = Some(Stretch {
                        start: time,
                        last_motion: time,
                        told,
                    });
                }
            }
            return None;
        }
        let is_over = |s: &mut Stretch| time - s.last_motion >= PAUSE;
        self.open.take_if(is_over).and_then(|s| self.end(s))
    }

    /// The run is over: the line of a stretch that was still going on.
    pub fn finish(&mut self) -> Option<String> {
        self.open.take().and_then(|s| self.end(s))
    }

    fn end(&mut self, stretch: Stretch) -> Option<String> {
        if stretch.last_motion - stretch.start < SHORTEST {
            return None;
        }
        self.ended.push(stretch.clone());
        let subject = subject(self.machine);
        let number = self.ended.len();
        Some(format!(
            "{:5.1} s  {} {number}  {}",
            stretch.last_motion,
            subject.stretch,
            self.sentence(&stretch.told)
        ))
    }

    /// What is known now, in a line.
    pub fn now(&self) -> Option<String> {
        let told = self.latest.as_ref()?;
        Some(format!("{:5.1} s  {}", told.time, self.sentence(told)))
    }

    fn sentence(&self, told: &Told) -> String {
        let Subject { label, unit, .. } = subject(self.machine);
        let (value, width) = number::value_and_std(told.value, told.half_width());
        let truth = told.truth.map_or(String::new(), |t| {
            let decimals = number::decimals(told.half_width());
            format!(" (true {})", number::grouped(t, decimals.max(0)))
        });
        let (unit, verdict) = (unit.0, told.verdict());
        format!("{label} {value} ± {width} {unit}{truth}  {verdict}")
    }

    /// The stretches as a table, with a line above it; empty without one.
    pub fn table(&self) -> String {
        let subject = subject(self.machine);
        if self.ended.is_empty() {
            return format!("no {} was seen\n", subject.stretch);
        }
        let mut table = Table::new(&[
            subject.stretch,
            "until",
            subject.label,
            "95 % interval",
            "truth",
            "trusted",
        ]);
        for (i, stretch) in self.ended.iter().enumerate() {
            let told = &stretch.told;
            let text = |x: f64| number::grouped(x, number::decimals(told.half_width()).max(0));
            let unit = subject.unit.0;
            let [low, high] = [-1.0, 1.0].map(|side| text(told.value + side * told.half_width()));
            table.row(vec![
                (i + 1).to_string(),
                format!("{:.1} s", stretch.last_motion),
                format!("{} {unit}", text(told.value)),
                format!("{low} to {high} {unit}"),
                told.truth
                    .map_or(String::new(), |t| format!("{} {unit}", text(t))),
                if told.trusted { "yes" } else { "not yet" }.into(),
            ]);
        }
        let mut out = String::new();
        let all = self.ended.len();
        let trusted: Vec<&Stretch> = self.ended.iter().filter(|s| s.told.trusted).collect();
        let _ = write!(
            out,
            "{} of {all} {}s trusted",
            trusted.len(),
            subject.stretch
        );
        if trusted.iter().any(|s| s.told.truth.is_some()) {
            let held = trusted.iter().filter(|s| s.told.holds() == Some(true));
            let held = held.count();
            let _ = write!(
                out,
                "; the truth lies inside {held} of {} intervals",
                trusted.len()
            );
        }
        out + "\n" + &table.to_string()
    }

    /// What would bring trust, where the last stretch was not trusted.
    pub fn advice(&self) -> Option<&str> {
        let last = self.ended.last().map(|s| &s.told)?;
        (!last.trusted).then_some(last.advice.as_str())
    }
}

impl Stretch {
    fn go_on(&mut self, told: Told) {
        self.last_motion = told.time;
        let narrower = !self.told.trusted && told.std <= self.told.std;
        if told.trusted || narrower {
            self.told = told;
        }
    }
}

/// The number in a field of a message; of a truth, if it is known.
fn number_in(message: &Envelope, field: &str) -> Option<f64> {
    struct Field<'a>(&'a str);

    impl Receiver for Field<'_> {
        type Output = Option<f64>;

        fn receive<M: Message>(self, message: &M) -> Option<f64> {
            if self.0 == "t" {
                return Some(message.stamp().time);
            }
            let index = M::index(self.0)?;
            if let Some(Value::U32(known)) = M::index("known").and_then(|i| message.get(i)) {
                let own = index.checked_sub(messages::HEAD)?;
                if known & (1 << own) == 0 {
                    return None;
                }
            }
            message.get(index).map(Value::as_f64)
        }
    }

    message.open(Field(field))
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ExcavatorEstimate, ExcavatorTruth, Stamp, excavator_bits as bits};

    /// A swing from 1 to 4 s with a pause of 0.2 s; trusted from 3 s on; then it stands.
    fn tell(truth: Option<f64>) -> (Story, Vec<String>) {
        let mut story = Story::new(Machine::Excavator);
        let mut lines = Vec::new();
        for i in 0..60 {
            let time = f64::from(i) * 0.1;
            let moves = (10..20).contains(&i) || (22..40).contains(&i);
            let estimate = ExcavatorEstimate {
                stamp: Stamp {
                    time,
                    ..Stamp::default()
                },
                velocity: if moves { -0.5 } else { 0.0 },
                payload: 437.0,
                payload_std: if i < 30 { 100.0 } else { 21.0 },
                flags: if (30..40).contains(&i) {
                    bits::TRUSTED
                } else {
                    0
                },
                ..ExcavatorEstimate::default()
            };
            let truth = truth.map(|payload| {
                Envelope::ExcavatorTruth(ExcavatorTruth {
                    payload,
                    known: 1 << 6,
                    ..ExcavatorTruth::default()
                })
            });
            lines.extend(story.add(&Envelope::ExcavatorEstimate(estimate), truth.as_ref()));
        }
        (story, lines)
    }

    #[test]
    fn a_swing_has_one_line_with_its_load_its_interval_and_the_truth() {
        let (_, lines) = tell(Some(423.0));
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].contains("swing 1  load 437 ± 41 kg (true 423)  trusted"));
    }

    #[test]
    fn the_table_says_how_many_intervals_hold_the_truth() {
        let held = tell(Some(423.0)).0.table();
        assert!(
            held.contains("truth lies inside 1 of 1 intervals"),
            "{held}"
        );
        assert!(held.contains("396 to 478 kg") && held.contains("423 kg"));
        let missed = tell(Some(300.0)).0.table();
        assert!(missed.contains("truth lies inside 0 of 1"), "{missed}");
    }

    #[test]
    fn without_a_truth_none_is_told() {
        let (story, lines) = tell(None);
        assert!(!lines[0].contains("true") && !story.table().contains("lies inside"));
    }
}
