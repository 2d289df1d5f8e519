//! The table of processes: inputs, outputs, wake-ups, methods and constructors.
//! Each machine has its rows in a file of its own.
//!
//! ```
//! use messages::Machine;
//! use steps::stages::Pipeline;
//!
//! let pipeline = Pipeline::of(Machine::Excavator);
//! let names: Vec<&str> = pipeline.stages.iter().map(|s| s.name).collect();
//! assert_eq!(names, ["sensor", "kalman", "rls", "ukf", "logger", "probe", "sender"]);
//! assert_eq!(pipeline.with_method("svf-rls").map(|s| s.name), Some("rls"));
//! ```

use config::Description;
use messages::channels::{Channel, ChannelOf};
use messages::{Envelope, Hop, Machine, Message};
use runtime::{Step, Worker, answer, run_stage};

use crate::Error;

/// The processes of a machine.
#[derive(Debug)]
pub struct Pipeline {
    /// The machine.
    pub machine: Machine,
    /// Estimated quantities, for help texts.
    pub about: &'static str,
    /// Its processes, upstream first; a `health` message names one by its index.
    pub stages: &'static [Stage],
    /// The process of the headline estimate; it is the one meant by a `--method` that
    /// no other process offers.
    pub main: &'static str,
}

/// A process of a pipeline.
#[derive(Debug)]
pub struct Stage {
    /// Name of the process.
    pub name: &'static str,
    /// Processes whose bell it rings, next stage first.
    pub wakes: &'static [&'static str],
    /// SCHED_FIFO priority under `--rt`, rising downstream; 0: normal, off the path.
    pub priority: u8,
    /// Its work.
    pub role: Role,
}

/// Work of a process.
#[derive(Debug)]
pub enum Role {
    /// Produces the samples and, where it is known, the truth.
    Source {
        /// Channel of the samples.
        sensors: &'static Channel,
        /// Channel of the truth.
        truth: &'static Channel,
    },
    /// Answers each message.
    Step(&'static dyn Row),
    /// Takes every message of the machine.
    Sink,
    /// Records the arrival times of the messages of this channel.
    Probe(&'static Channel),
    /// Sends estimates to other programs; only in a run that has an output.
    Sender,
}

/// A stage that answers messages, with its types erased.
pub trait Row: Sync + std::fmt::Debug {
    /// Channel that it reads.
    fn input(&self) -> &'static Channel;
    /// Channel that it writes.
    fn output(&self) -> &'static Channel;
    /// The hop that it marks.
    fn hop(&self) -> Hop;
    /// Methods that it offers, the default first; none where there is no choice.
    fn methods(&self) -> &'static [&'static str];
    /// Constructs the step for a description; `method` is ignored where there is no choice.
    ///
    /// # Errors
    /// The method is unknown, or the description has a value that the method cannot use.
    fn start(&self, description: &Description, method: &str) -> Result<Box<dyn AnyStep>, Error>;
    /// The same as a process that only waits for its worker. `fits`: a number that a state must
    /// match to be restored into this step.
    ///
    /// # Errors
    /// As [`Self::start`].
    fn prepare(&self, description: &Description, method: &str, fits: u64)
    -> Result<Process, Error>;
}

/// Runs a stage in the worker that it is given, until the supervisor ends it.
pub type Process = Box<dyn FnOnce(Worker) -> Result<(), runtime::Error>>;

/// A step with its types erased, to run it on recorded data.
pub trait AnyStep: Send + Sync {
    /// The answer with the identity of the input; `None` for a message of another type.
    fn answer(&mut self, input: &Envelope) -> Option<Envelope>;
    /// Writes its complete state and returns its length in bytes, see [`Step::save`].
    fn save(&self, into: &mut [u8]) -> Option<usize>;
    /// Restores a written state; false, and unchanged, if the state is not one of this step.
    fn restore(&mut self, state: &[u8]) -> bool;
    /// An independent copy.
    fn fork(&self) -> Box<dyn AnyStep>;
}

impl<S: Step + Clone + Send + Sync + 'static> AnyStep for S {
    fn answer(&mut self, input: &Envelope) -> Option<Envelope> {
        S::Input::inside(input).map(|message| answer(self, message).envelope())
    }

    fn save(&self, into: &mut [u8]) -> Option<usize> {
        S::save(self, into)
    }

    fn restore(&mut self, state: &[u8]) -> bool {
        S::restore(self, state)
    }

    fn fork(&self) -> Box<dyn AnyStep> {
        Box::new(self.clone())
    }
}

/// A row of the table. Its channels must have the types of its step, or it does not compile.
///
/// ```compile_fail
/// use messages::{Hop, channels::{EXCAVATOR_MOTION, EXCAVATOR_SENSORS}};
/// use steps::stages::RowOf;
///
/// // The filter reads sensors, not motion.
/// let row = RowOf {
///     input: &EXCAVATOR_MOTION,
///     output: &EXCAVATOR_MOTION,
///     hop: Hop::Filter,
///     methods: &[],
///     new: |_, _| steps::excavator::FilterStep::new(&config::Excavator::default()),
/// };
/// ```
#[derive(Debug)]
pub struct RowOf<S: Step> {
    /// Channel that it reads.
    pub input: &'static ChannelOf<S::Input>,
    /// Channel that it writes.
    pub output: &'static ChannelOf<S::Output>,
    /// The hop that it marks.
    pub hop: Hop,
    /// Methods that it offers, the default first; none where there is no choice.
    pub methods: &'static [&'static str],
    /// Constructs the step.
    pub new: fn(&Description, &str) -> Result<S, Error>,
}

impl<S: Step + Clone + Send + Sync + std::fmt::Debug + 'static> Row for RowOf<S> {
    fn input(&self) -> &'static Channel {
        self.input
    }

    fn output(&self) -> &'static Channel {
        self.output
    }

    fn hop(&self) -> Hop {
        self.hop
    }

    fn methods(&self) -> &'static [&'static str] {
        self.methods
    }

    fn start(&self, description: &Description, method: &str) -> Result<Box<dyn AnyStep>, Error> {
        Ok(Box::new((self.new)(description, method)?))
    }

    fn prepare(
        &self,
        description: &Description,
        method: &str,
        fits: u64,
    ) -> Result<Process, Error> {
        let step = (self.new)(description, method)?;
        let (input, output, hop) = (self.input, self.output, self.hop);
        Ok(Box::new(move |worker| {
            run_stage(worker, input, output, hop, fits, step)
        }))
    }
}

impl Stage {
    /// The row that answers messages here, if there is one.
    pub fn row(&self) -> Option<&'static dyn Row> {
        match self.role {
            Role::Step(row) => Some(row),
            Role::Source { .. } | Role::Sink | Role::Probe(_) | Role::Sender => None,
        }
    }

    /// Channel that it reads; the source reads none, the sink all.
    pub fn input(&self) -> Option<&'static Channel> {
        match self.role {
            Role::Step(row) => Some(row.input()),
            Role::Probe(channel) => Some(channel),
            Role::Source { .. } | Role::Sink | Role::Sender => None,
        }
    }

    /// Channel that it writes.
    pub fn output(&self) -> Option<&'static Channel> {
        match self.role {
            Role::Step(row) => Some(row.output()),
            Role::Source { sensors, .. } => Some(sensors),
            Role::Sink | Role::Probe(_) | Role::Sender => None,
        }
    }

    /// Methods that it offers, the default first; none where there is no choice.
    pub fn methods(&self) -> &'static [&'static str] {
        self.row().map_or(&[], Row::methods)
    }
}

macro_rules! pipelines {
    ($( $machine:ident, $module:ident, $sensors:ident, $truth:ident, $estimate:ident, $others:tt; )*) => {
        impl Pipeline {
            /// The pipeline of a machine.
            pub fn of(machine: Machine) -> &'static Self {
                match machine {
                    $( Machine::$machine => &crate::$module::PIPELINE, )*
                }
            }
        }
    };
}

messages::machines!(pipelines);

impl Pipeline {
    /// The process of that name.
    pub fn stage(&self, process: &str) -> Option<&'static Stage> {
        self.stages.iter().find(|s| s.name == process)
    }

    /// The process that offers this method.
    pub fn with_method(&self, method: &str) -> Option<&'static Stage> {
        self.stages.iter().find(|s| s.methods().contains(&method))
    }

    /// The channel of its sensors.
    pub fn sensors(&self) -> Option<&'static Channel> {
        self.stages.iter().find_map(|s| match s.role {
            Role::Source { sensors, .. } => Some(sensors),
            Role::Step(_) | Role::Sink | Role::Probe(_) | Role::Sender => None,
        })
    }

    /// The process that writes this channel.
    pub fn writer(&self, channel: &Channel) -> Option<&'static Stage> {
        let writes = |s: &&Stage| s.output().is_some_and(|o| o.name == channel.name);
        self.stages.iter().find(writes)
    }

    /// The stages that answer messages, upstream first.
    pub fn rows(&self) -> impl Iterator<Item = (&'static Stage, &'static dyn Row)> {
        self.stages.iter().filter_map(|s| Some((s, s.row()?)))
    }

    /// The channels of estimates, upstream first.
    pub fn estimates(&self) -> impl Iterator<Item = &'static Channel> {
        self.rows()
            .filter(|(_, row)| row.hop() == Hop::Estimate)
            .map(|(_, row)| row.output())
    }

    /// The channel of the headline estimate.
    pub fn main_output(&self) -> Option<&'static Channel> {
        self.stage(self.main)?.output()
    }

    /// Rows that a sample passes up to the output of a stage, that stage last.
    pub fn path_to(&self, stage: &'static Stage) -> Vec<&'static dyn Row> {
        let Some(row) = stage.row() else {
            return Vec::new();
        };
        let writer = self.writer(row.input());
        let mut path = writer.map_or_else(Vec::new, |writer| self.path_to(writer));
        path.push(row);
        path
    }

    /// Number of hops from the source to this stage.
    pub fn hops_before(&self, stage: &Stage) -> usize {
        let writer = stage.input().and_then(|input| self.writer(input));
        writer.map_or(0, |writer| 1 + self.hops_before(writer))
    }

    /// Name of the process with this `index` in `health` messages.
    pub fn process_name(&self, index: u32) -> &'static str {
        let index = usize::try_from(index).ok();
        index
            .and_then(|i| self.stages.get(i))
            .map_or("?", |s| s.name)
    }

    /// The method of each process that has a choice: the default, or `asked` in the process
    /// that offers it.
    ///
    /// # Errors
    /// No process of this machine offers it.
    pub fn methods(&self, asked: Option<&str>) -> Result<Vec<(&'static str, String)>, Error> {
        let chosen = match asked {
            None => None,
            Some(name) => Some((
                self.with_method(name).ok_or_else(|| self.unknown(name))?,
                name,
            )),
        };
        let of = |stage: &'static Stage| {
            let default = *stage.methods().first()?;
            let asked = chosen.filter(|(s, _)| s.name == stage.name);
            Some((
                stage.name,
                asked.map_or(default, |(_, name)| name).to_owned(),
            ))
        };
        Ok(self.stages.iter().filter_map(of).collect())
    }

    /// Error for a method that no process offers.
    pub fn unknown(&self, name: &str) -> Error {
        let known = self.stages.iter().flat_map(|s| s.methods()).copied();
        Error::UnknownMethod {
            machine: self.machine.name(),
            name: name.to_owned(),
            known: known.collect(),
        }
    }
}

/// Sends estimates to other programs. It wakes by itself: no estimator waits for it.
pub(crate) const SENDER: Stage = Stage {
    name: "sender",
    wakes: &[],
    priority: 0,
    role: Role::Sender,
};

/// Takes every message and, where the source waits for it, reports its progress.
pub(crate) const LOGGER: Stage = Stage {
    name: "logger",
    wakes: &["sensor"],
    priority: 0,
    role: Role::Sink,
};
