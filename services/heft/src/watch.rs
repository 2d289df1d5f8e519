//! The supervisor's view of a run. Compares every estimate with the truth if there is one,
//! stores the latest messages, shows them on the terminal and passes them to the live page.

mod counts;
mod faults;
mod line;
mod loads_teller;
mod processes;
mod scores;

use std::collections::BTreeMap;
use std::time::Instant;

use estimation::loads::Stage;
use messages::channels::Channel;
use messages::{Carries, Envelope, Machine, Message, Value, Words};
use runtime::{Sink, Teller, Window};
use view::live::{Feed, SharedLoads};

use self::counts::SampleCounts;
use self::faults::Loggers;
pub use self::line::{LIVE, STORY, Show};
use self::loads_teller::LoadsTeller;
pub use self::processes::Processes;
use self::scores::Scores;
use crate::doubts::AnyDoubts;
use crate::fault::Fault;
use crate::state::Memory;
use crate::story::{self, Story};
use crate::tally::Tally;

/// Everything seen of a run.
#[derive(Default)]
pub struct Watch {
    processes: Processes,
    headline: Option<&'static Channel>,
    show: Show,
    /// The loads with their truth, for a program that prints them.
    story: Story,
    feed: Option<Feed>,
    /// For the group of users that may look.
    window: Option<Window>,
    carried: BTreeMap<&'static str, SampleCounts>,
    scores: Scores,
    latest: BTreeMap<&'static str, Envelope>,
    /// Parameters that outlive the run.
    memory: Option<Memory>,
    /// Counts loads.
    loads: Option<SharedLoads>,
    /// Sends the loads to other programs.
    teller: Option<LoadsTeller>,
    /// The sensors are read for the loads: they identify the truck, and a loader's mass.
    counts_sensors: bool,
    /// Checks the samples of a run whose input is measured.
    doubts: Option<Box<dyn AnyDoubts>>,
    /// Reason of the latest headline estimate.
    reason: Option<Value>,
    /// Each with its count: a service may die again and again.
    faults: Vec<(Fault, u32)>,
    loggers: Loggers,
    /// The samples are the simulator's.
    is_simulated: bool,
    shown: Option<Instant>,
    begun: Option<Instant>,
}

impl Watch {
    /// Watches a machine. `headline`: the channel of the headline estimates, those of the method
    /// that was asked for.
    pub fn new(
        machine: Machine,
        headline: Option<&'static Channel>,
        feed: Option<Feed>,
        show: Show,
    ) -> Self {
        Self {
            processes: Processes::of(machine),
            headline,
            show,
            feed,
            begun: Some(Instant::now()),
            ..Self::default()
        }
    }

    /// Shows messages to a group of other users.
    pub fn show_to_group(&mut self, window: Window) {
        self.window = Some(window);
    }

    /// Notes that the source is as fast as its readers.
    pub fn unpaced(&mut self) {
        self.processes.is_unpaced = true;
    }

    /// Counts the loads and reports them as they come; with truck and mass by the sensors if `sensors`.
    pub fn count_loads(&mut self, loads: SharedLoads, sensors: bool) {
        (self.loads, self.counts_sensors) = (Some(loads), sensors);
    }

    /// Sends the loads on their channel.
    pub fn tell_loads(&mut self, teller: Teller) {
        self.teller = Some(LoadsTeller::new(teller));
    }

    /// Checks the samples with these.
    pub fn doubt(&mut self, doubts: Box<dyn AnyDoubts>) {
        self.doubts = Some(doubts);
    }

    /// The checks of the samples.
    pub fn doubts(&self) -> Option<&dyn AnyDoubts> {
        self.doubts.as_deref()
    }

    /// Remembers trusted parameters in this memory.
    pub fn remember(&mut self, memory: Option<Memory>) {
        self.memory = memory;
    }

    /// Whether it reads a channel. Every reader costs the writer time while the next stage waits. So
    /// channels that are only passed on are not read without a live page or a group.
    pub fn reads(&self, channel: &Channel) -> bool {
        let passed_on = match channel.payload.carries() {
            Carries::Sensors | Carries::Between => true,
            Carries::Truth | Carries::Estimate | Carries::Common => false,
        };
        let wanted = self.counts_sensors || self.doubts.is_some();
        let counted = wanted && channel.payload.carries() == Carries::Sensors;
        self.feed.is_some() || self.window.is_some() || counted || !passed_on
    }

    /// Number after that of the latest sample seen.
    pub fn next_sequence(&self) -> u64 {
        self.sent().next
    }

    /// Time of the latest sample seen, by the data \[s\].
    pub fn latest_time(&self) -> f64 {
        self.sent().time
    }

    /// Counts of the source. Every sample has a truth message beside it, possibly an empty one.
    fn sent(&self) -> SampleCounts {
        let truths = self
            .carried
            .iter()
            .filter(|(name, _)| name.ends_with("/truth"));
        truths
            .map(|(_, carried)| *carried)
            .next()
            .unwrap_or_default()
    }

    fn is_headline(&self, channel: &Channel) -> bool {
        self.headline.is_some_and(|it| it.name == channel.name)
    }

    /// Scores of the headline quantities.
    pub fn headline(&self) -> impl Iterator<Item = &Tally> {
        let headline = self.headline.map(|channel| channel.name);
        let tallies = self.tallies().iter();
        tallies.filter(move |s| Some(s.quantity.channel) == headline)
    }

    /// Reports of the processes on themselves.
    pub fn processes(&self) -> &Processes {
        &self.processes
    }

    /// Loads up to now, with their truth.
    pub fn story(&self) -> &Story {
        &self.story
    }

    /// Latest headline estimate.
    pub fn latest_headline(&self) -> Option<&Envelope> {
        self.latest(self.headline?)
    }

    /// Scores of all quantities, in the order of their first estimate.
    pub fn tallies(&self) -> &[Tally] {
        self.scores.tallies()
    }

    /// Latest message of a channel.
    pub fn latest(&self, channel: &Channel) -> Option<&Envelope> {
        self.latest.get(channel.name)
    }

    /// Whether the samples are the simulator's.
    pub fn is_simulated(&self) -> bool {
        self.is_simulated
    }

    /// Shows the state and writes the memory, at limited rates.
    pub fn tick(&mut self) {
        if let Some(memory) = &mut self.memory {
            memory.tick();
        }
        self.draw();
    }

    /// Ends the live line and writes the memory.
    pub fn finish(&mut self) {
        if let Some(memory) = &mut self.memory {
            memory.save();
        }
        if let (Show::Lines, Some(loads)) = (self.show, &self.loads) {
            story::finish(&mut self.story, loads);
        }
        self.end();
    }

    /// Reports a change of the headline estimates' reason.
    fn note_reason<M: Message>(&mut self, message: &M) {
        let reason = message.field("reason");
        if reason != self.reason {
            let words = Words::of_field(M::WORDS, "reason");
            if let (Some(Value::U32(code)), Some(words)) = (reason, words) {
                let t = message.stamp().time;
                tracing::debug!(t, reason = words.name(code), "the reason is another");
            }
            self.reason = reason;
        }
    }

    /// Counts the loads of the headline estimates, and reports their events.
    fn count(&mut self, channel: &Channel, envelope: &Envelope) {
        let Some(loads) = &self.loads else { return };
        let counts = match channel.payload.carries() {
            Carries::Sensors => true,
            Carries::Estimate => self.is_headline(channel),
            Carries::Truth | Carries::Between | Carries::Common => false,
        };
        if !counts {
            return;
        }
        let mut counter = loads.lock();
        let machine = counter.machine();
        let events = counter.see(envelope);
        if let Some(teller) = &mut self.teller {
            if events.load.is_some() || events.truck.is_some() {
                teller.note_change();
            }
            if channel.payload.carries() == Carries::Estimate {
                teller.tell(&counter, envelope.stamp(), self.is_simulated);
            }
        }
        drop(counter);
        let last_load = events
            .load
            .filter(|l| matches!(l.stage, Stage::Carried | Stage::Dumped));
        if let Some(load) = last_load {
            self.say(&view::loads::line(machine, &load));
        }
        if let (Show::Lines, Some(load)) = (self.show, &events.load) {
            let line = self.story.add(machine, load);
            self.show_story(line);
        }
    }
}

impl Sink for Watch {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        self.is_simulated |= message.is_simulated();
        let envelope = message.envelope();
        if let Envelope::Keyframe(piece) = &envelope {
            self.processes.note_state(piece);
            return;
        }
        if let Some(feed) = &self.feed {
            feed.push(channel, message);
        }
        if let Some(window) = &mut self.window {
            window.show(channel, message);
        }
        self.count(channel, &envelope);
        let carried = self.carried.entry(channel.name).or_default();
        carried.add(message.stamp());
        match channel.payload.carries() {
            Carries::Truth => {
                if self.show == Show::Lines {
                    self.story.know(&envelope);
                }
                self.scores.know(message.stamp().sequence, envelope);
            }
            Carries::Estimate => {
                if self.is_headline(channel) {
                    self.note_reason(message);
                    if let Some(doubts) = &mut self.doubts {
                        doubts.see(&envelope);
                    }
                }
                self.scores.add(channel, message);
                if let Some(memory) = &mut self.memory {
                    memory.see(channel, message);
                }
            }
            Carries::Sensors => {
                if let Some(doubts) = &mut self.doubts {
                    doubts.see(&envelope);
                }
            }
            Carries::Between | Carries::Common => {}
        }
        if let Envelope::Health(health) = &envelope {
            let is_logger = self.processes.note_health(health) == Some("logger");
            if is_logger && health.steps > 0 {
                self.loggers.reported();
            }
        }
        self.latest.insert(channel.name, envelope);
    }

    fn overwritten(&mut self, channel: &'static Channel, samples: u64) {
        self.carried.entry(channel.name).or_default().unseen += samples;
    }
}
