//! What the supervisor sees of a run: tallies every estimate against the truth where there is one,
//! keeps the latest of everything, shows it on the terminal and hands it to the live page.

mod counts;
mod line;
mod loads_teller;

use std::collections::{BTreeMap, VecDeque};
use std::time::Instant;

use estimation::loads::Stage;
use messages::channels::Channel;
use messages::keyframe::Collector;
use messages::{Carries, Envelope, Health, Machine, Message, Snapshot, Value, Words, fault};
use runtime::{Sink, Teller, Window};
use steps::stages::Pipeline;
use view::live::{Feed, SharedLoads};

use self::counts::{Counts, SampleCounts};
pub use self::line::{LIVE, STORY, Show};
use self::loads_teller::LoadsTeller;
use crate::fault::Fault;
use crate::quantity::{self, Quantity};
use crate::state::Memory;
use crate::story::{self, Story};
use crate::tally::Tally;

/// Truths that may wait for their estimates.
const TRUTHS: usize = 2048;

/// Everything seen of a run.
#[derive(Default)]
pub struct Watch {
    pipeline: Option<&'static Pipeline>,
    headline: Option<&'static Channel>,
    show: Show,
    /// The loads with their truth, for a program that tells the story.
    story: Story,
    feed: Option<Feed>,
    /// For a group of other users.
    window: Option<Window>,
    carried: BTreeMap<&'static str, SampleCounts>,
    truths: VecDeque<(u64, Envelope)>,
    tallies: Vec<Tally>,
    latest: BTreeMap<&'static str, Envelope>,
    health: BTreeMap<u32, Health>,
    /// Counts of processes that died.
    before: BTreeMap<u32, Counts>,
    /// Pieces of the states of processes, and their latest whole ones.
    collectors: BTreeMap<u32, Collector>,
    states: BTreeMap<u32, Snapshot>,
    /// What outlives the run.
    memory: Option<Memory>,
    /// Counts loads.
    loads: Option<SharedLoads>,
    /// Sends them to other programs.
    teller: Option<LoadsTeller>,
    /// The sensors are read for them: they tell the truck, and a loader's mass.
    counts_sensors: bool,
    /// That of the latest headline estimate.
    reason: Option<Value>,
    faults: Vec<Fault>,
    /// The samples are the simulator's.
    is_simulated: bool,
    /// The source is as fast as its readers: no sample is due at any time, and none is late.
    is_unpaced: bool,
    /// The logger died, and is not back. One that comes back counts what it could not be handed.
    logger_is_away: bool,
    /// It has reported its counts since it came.
    logger_has_reported: bool,
    /// A logger died before it reported its counts.
    may_lack: bool,
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
            pipeline: Some(Pipeline::of(machine)),
            headline,
            show,
            feed,
            begun: Some(Instant::now()),
            ..Self::default()
        }
    }

    /// Has messages shown to a group of other users.
    pub fn show_to_group(&mut self, window: Window) {
        self.window = Some(window);
    }

    /// Is notified that the source is as fast as its readers.
    pub fn unpaced(&mut self) {
        self.is_unpaced = true;
    }

    /// Has the loads counted, reported as they come; with what the sensors tell of truck and mass if `sensors`.
    pub fn count_loads(&mut self, loads: SharedLoads, sensors: bool) {
        (self.loads, self.counts_sensors) = (Some(loads), sensors);
    }

    /// Has them sent on their channel.
    pub fn tell_loads(&mut self, teller: Teller) {
        self.teller = Some(LoadsTeller::new(teller));
    }

    /// Has what is trusted remembered.
    pub fn remember(&mut self, memory: Option<Memory>) {
        self.memory = memory;
    }

    /// Whether it reads a channel. Every reader costs the writer time while the next stage waits, so
    /// what is only passed on, to the live page or a group, is not read without one.
    pub fn reads(&self, channel: &Channel) -> bool {
        let passed_on = match channel.payload.carries() {
            Carries::Sensors | Carries::Between => true,
            Carries::Truth | Carries::Estimate | Carries::Common => false,
        };
        let counted = self.counts_sensors && channel.payload.carries() == Carries::Sensors;
        self.feed.is_some() || self.window.is_some() || counted || !passed_on
    }

    /// Number after that of the latest sample seen.
    pub fn next_sequence(&self) -> u64 {
        self.sent().next
    }

    /// Time of the latest sample seen, as the data tell it \[s\].
    pub fn latest_time(&self) -> f64 {
        self.sent().time
    }

    /// What the source sent. Every sample has a truth beside it, if an empty one.
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

    /// Scores of the headline quantities.
    pub fn headline(&self) -> impl Iterator<Item = &Tally> {
        let headline = self.headline.map(|channel| channel.name);
        let tallies = self.tallies.iter();
        tallies.filter(move |s| Some(s.quantity.channel) == headline)
    }

    /// Loads so far, with their truth.
    pub fn story(&self) -> &Story {
        &self.story
    }

    /// Latest headline estimate.
    pub fn latest_headline(&self) -> Option<&Envelope> {
        self.latest(self.headline?)
    }

    /// Scores of all quantities, in the order of their first estimate.
    pub fn tallies(&self) -> &[Tally] {
        &self.tallies
    }

    /// Latest message of a channel.
    pub fn latest(&self, channel: &Channel) -> Option<&Envelope> {
        self.latest.get(channel.name)
    }

    /// Latest health of the process called `name`.
    pub fn health(&self, name: &str) -> Option<&Health> {
        self.all_health()
            .find(|(process, _)| *process == name)
            .map(|(_, health)| health)
    }

    /// Latest whole state of the process called `name`.
    pub fn state(&self, name: &str) -> Option<&Snapshot> {
        let mut states = self.states.iter();
        states.find_map(|(index, state)| {
            (self.pipeline?.process_name(*index) == name).then_some(state)
        })
    }

    /// Health of all processes, by name.
    pub fn all_health(&self) -> impl Iterator<Item = (&'static str, &Health)> {
        self.health.iter().filter_map(|(index, health)| {
            let pipeline = self.pipeline?;
            Some((pipeline.process_name(*index), health))
        })
    }

    /// Counts of all processes, by name.
    fn counts(&self) -> impl Iterator<Item = (&'static str, Counts)> {
        self.health.iter().filter_map(|(index, health)| {
            let mut counts = self.before.get(index).copied().unwrap_or_default();
            counts.add(health);
            counts.late = if self.is_unpaced { 0 } else { counts.late };
            Some((self.pipeline?.process_name(*index), counts))
        })
    }

    /// Counts of the process called `service`.
    pub fn counts_of(&self, service: &str) -> Counts {
        let found = self.counts().find(|(name, _)| *name == service);
        found.map_or(Counts::default(), |(_, counts)| counts)
    }

    /// Whether the samples are the simulator's.
    pub fn is_simulated(&self) -> bool {
        self.is_simulated
    }

    /// Samples lost before any process.
    pub fn lost(&self) -> u64 {
        self.counts().map(|(_, counts)| counts.lost).sum()
    }

    /// Notes what went wrong.
    pub fn note(&mut self, fault: Fault) {
        let logger_is_away = matches!(fault, Fault::Died { service, .. } | Fault::Hung { service, .. } if service == "logger");
        if logger_is_away {
            let was_there = !self.logger_is_away && self.next_sequence() > 0;
            self.may_lack |= was_there && !self.logger_has_reported;
            self.logger_is_away = true;
        }
        self.faults.push(fault);
    }

    /// Is notified that a service is there, perhaps again.
    pub fn is_there(&mut self, service: &str) {
        if service == "logger" {
            (self.logger_is_away, self.logger_has_reported) = (false, false);
        }
    }

    /// Everything that went wrong: what was noted, and what the channels and processes tell.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = self.faults.clone();
        let sent = self.sent();
        let unmeasured = sent.next.saturating_sub(sent.samples + sent.unseen);
        if unmeasured > 0 {
            faults.push(Fault::Unmeasured {
                samples: unmeasured,
            });
        }
        let frames = self.counts_of("sensor").lost;
        if frames > 0 {
            faults.push(Fault::Dropped { frames });
        }
        faults.extend(self.unanswered(sent));
        let logger = self.counts_of("logger");
        let may_lack = self.may_lack || self.logger_is_away && sent.next > 0;
        if logger.lost > 0 || may_lack {
            faults.push(Fault::Unrecorded {
                samples: logger.lost,
            });
        }
        if self
            .health("logger")
            .is_some_and(|h| h.fault == fault::DISK)
        {
            faults.push(Fault::Disk);
        }
        let late = self.counts().filter(|(_, counts)| counts.late > 0);
        faults.extend(late.map(|(service, counts)| Fault::Late {
            service,
            samples: counts.late,
        }));
        faults
    }

    /// Samples that were measured and have no answer, by service.
    fn unanswered(&self, sent: SampleCounts) -> Vec<Fault> {
        let Some(pipeline) = self.pipeline else {
            return Vec::new();
        };
        let known = sent.samples + sent.unseen;
        let fault = |channel: &'static Channel| {
            let answers = self.carried.get(channel.name).copied().unwrap_or_default();
            let samples = known.saturating_sub(answers.samples + answers.unseen);
            (samples > 0).then_some(Fault::Unanswered {
                service: pipeline.writer(channel)?.name,
                samples,
                of: known,
            })
        };
        pipeline.estimates().filter_map(fault).collect()
    }

    /// Shows the state, and writes what outlives the run, not too often.
    pub fn tick(&mut self) {
        if let Some(memory) = &mut self.memory {
            memory.tick();
        }
        self.draw();
    }

    /// Ends the live line, and writes what outlives the run.
    pub fn finish(&mut self) {
        if let Some(memory) = &mut self.memory {
            memory.save();
        }
        if let (Show::Lines, Some(loads)) = (self.show, &self.loads) {
            story::finish(&mut self.story, loads);
        }
        self.end();
    }

    /// Says when the reason of the headline estimates becomes another.
    fn note_reason<M: Message>(&mut self, message: &M) {
        let reason = M::index("reason").and_then(|i| message.get(i));
        if reason != self.reason {
            let words = Words::of_field(M::WORDS, "reason");
            if let (Some(Value::U32(code)), Some(words)) = (reason, words) {
                let t = message.stamp().time;
                tracing::debug!(t, reason = words.name(code), "the reason is another");
            }
            self.reason = reason;
        }
    }

    fn note_estimate<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        let sequence = message.stamp().sequence;
        if self
            .headline
            .is_some_and(|headline| headline.name == channel.name)
        {
            self.note_reason(message);
        }
        for quantity in quantity::of_channel(channel.name) {
            let number = |name: &str| {
                M::index(name)
                    .and_then(|i| message.get(i))
                    .map(Value::as_f64)
            };
            let (Some(value), Some(std), Some(flags)) = (
                number(quantity.row.name),
                number(quantity.std),
                number("flags"),
            ) else {
                continue;
            };
            let truth = self.truth(sequence, &quantity);
            let trusted = (flags as u32) & quantity.row.trusted != 0;
            let tally = match self.tallies.iter_mut().position(|s| s.quantity == quantity) {
                Some(i) => &mut self.tallies[i],
                None => {
                    self.tallies.push(Tally::new(quantity));
                    let last = self.tallies.len() - 1;
                    &mut self.tallies[last]
                }
            };
            tally.add(message.stamp().time, value, std, trusted, truth);
        }
    }

    /// Counts loads of the headline estimates, and says what happens to them.
    fn count(&mut self, channel: &Channel, envelope: &Envelope) {
        let Some(loads) = &self.loads else { return };
        let is_headline = match channel.payload.carries() {
            Carries::Sensors => true,
            Carries::Estimate => self
                .headline
                .is_some_and(|headline| headline.name == channel.name),
            Carries::Truth | Carries::Between | Carries::Common => false,
        };
        if !is_headline {
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

    fn truth(&self, sequence: u64, quantity: &Quantity) -> Option<f64> {
        let at = self
            .truths
            .binary_search_by_key(&sequence, |(s, _)| *s)
            .ok()?;
        quantity.truth(&self.truths[at].1)
    }
}

impl Sink for Watch {
    fn accept<M: Message>(&mut self, channel: &'static Channel, message: &M) {
        self.is_simulated |= message.is_simulated();
        let envelope = message.envelope();
        if let Envelope::Keyframe(piece) = &envelope {
            let collector = self.collectors.entry(piece.process).or_default();
            if let Some(state) = collector.take(piece) {
                self.states.insert(piece.process, state);
            }
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
                if self.truths.len() == TRUTHS {
                    self.truths.pop_front();
                }
                self.truths.push_back((message.stamp().sequence, envelope));
            }
            Carries::Estimate => {
                self.note_estimate(channel, message);
                if let Some(memory) = &mut self.memory {
                    memory.see(channel, message);
                }
            }
            Carries::Sensors | Carries::Between | Carries::Common => {}
        }
        if let Envelope::Health(health) = &envelope {
            let process = self.pipeline.map(|p| p.process_name(health.process));
            self.logger_has_reported |= process == Some("logger") && health.steps > 0;
            let before = self.health.insert(health.process, *health);
            if let Some(before) = before.filter(|b| b.pid != health.pid) {
                self.before.entry(health.process).or_default().add(&before);
            }
        }
        self.latest.insert(channel.name, envelope);
    }

    fn overwritten(&mut self, channel: &'static Channel, samples: u64) {
        self.carried.entry(channel.name).or_default().unseen += samples;
    }

    fn has_room(&self) -> bool {
        true
    }

    fn fault(&self) -> u32 {
        fault::NONE
    }

    fn drain(&mut self) {}
}

#[cfg(test)]
mod tests {
    use messages::ExcavatorTruth;
    use messages::channels::{EXCAVATOR_TRUTH, HEALTH};

    use super::*;

    #[test]
    fn what_may_lack_in_the_recording_is_reported_unless_the_logger_has_counted_it() {
        let (dies, comes, is_back, tells) = (1, 2, 3, 4);
        let lost = |story: &[u32]| {
            let mut watch = Watch::new(Machine::Excavator, None, None, Show::Nothing);
            for &event in story {
                if event == dies {
                    let (service, how) = ("logger", "killed".to_owned());
                    watch.note(Fault::Died { service, how });
                } else if event == comes {
                    watch.accept(&EXCAVATOR_TRUTH, &ExcavatorTruth::default());
                } else if event == is_back {
                    watch.is_there("logger");
                } else {
                    let names = Pipeline::of(Machine::Excavator);
                    let process = (0..).find(|i| names.process_name(*i) == "logger");
                    let mut health = Health::default();
                    (health.process, health.steps) = (process.expect("a row"), 1);
                    watch.accept(&HEALTH, &health);
                }
            }
            watch.finish();
            let faults = watch.faults();
            faults.iter().any(|f| matches!(f, Fault::Unrecorded { .. }))
        };
        assert!(lost(&[is_back, comes, tells, dies, comes]));
        assert!(!lost(&[is_back, dies]), "nothing came");
        let whole = [is_back, comes, tells, dies, comes, is_back, comes];
        assert!(!lost(&whole), "it counts by itself what it lacks");
        let silent = [&whole[..], &[dies, is_back, tells]].concat();
        assert!(lost(&silent), "what the second one lacked is not known");
        let reported = [&whole[..], &[tells, dies, is_back, tells]].concat();
        assert!(!lost(&reported));
    }

    #[test]
    fn a_sample_is_late_only_where_it_was_due_at_a_time() {
        let mut watch = Watch::new(Machine::Excavator, None, None, Show::Nothing);
        let health = Health {
            late: 3,
            ..Health::default()
        };
        watch.accept(&HEALTH, &health);
        let late = |watch: &Watch| {
            watch
                .faults()
                .iter()
                .any(|f| matches!(f, Fault::Late { .. }))
        };
        assert!(late(&watch));
        watch.unpaced();
        assert!(!late(&watch));
    }
}
