//! A running pipeline that a command attaches to: one of this user, through its channels, or one that another
//! user shows to a group of this one, through its window.

use messages::Machine;
use messages::channels::Channel;
use runtime::{Domain, GroupView, Ports, Sink, Taps};

use crate::failure::Failure;
use crate::plan::Plan;

/// A running pipeline.
pub enum Run {
    /// Of this user.
    Own(Domain),
    /// Of another.
    GroupView(Box<GroupView>),
}

/// The pipeline in the domain of this name, or the only running one. Those of this user come first.
pub fn find(name: Option<&str>) -> Result<Run, Failure> {
    let own = Domain::all()
        .into_iter()
        .filter(Domain::is_alive)
        .map(Run::Own);
    let mut all: Vec<Run> = own.collect();
    let is_wanted = |found: &Run| name.is_none_or(|name| found.name() == name);
    if !all.iter().any(is_wanted) {
        all.extend(
            GroupView::all()
                .into_iter()
                .map(|s| Run::GroupView(Box::new(s))),
        );
    }
    let names: Vec<String> = all.iter().map(Run::words).collect();
    if let Some(name) = name {
        // A text that cannot be a name is another error.
        Domain::new(name)?;
    }
    let mut wanted = all.into_iter().filter(is_wanted);
    match (wanted.next(), wanted.next(), name) {
        (Some(found), None, _) => {
            if let Run::GroupView(_) = found {
                eprintln!("{}", found.words());
            }
            Ok(found)
        }
        (None, _, Some(name)) => Err(Failure::input(
            format!("no pipeline runs in the domain `{name}`"),
            "--domain",
            if names.is_empty() {
                "start one with `heft run excavator`".to_owned()
            } else {
                format!("these are: {}", names.join(", "))
            },
        )),
        (None, _, None) => Err(Failure::input(
            "no pipeline is running",
            "shared memory",
            "start one with `heft run excavator`",
        )),
        (Some(_), Some(_), _) => Err(Failure::input(
            format!("several pipelines are running: {}", names.join(", ")),
            "--domain",
            "name the one to show",
        )),
    }
}

impl Run {
    /// Name of its domain.
    pub fn name(&self) -> &str {
        match self {
            Self::Own(domain) => domain.name(),
            Self::GroupView(shown) => shown.domain(),
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Own(domain) => domain.name().to_owned(),
            Self::GroupView(shown) => format!("{} of user {}", shown.domain(), shown.user),
        }
    }

    /// Its machine.
    pub fn machine(&self) -> Result<Machine, Failure> {
        match self {
            Self::Own(domain) => Ok(Plan::read(domain)?.machine),
            Self::GroupView(shown) => Ok(shown.machine()),
        }
    }

    /// Attaches to `channels`, under the name `reader`.
    pub fn attach<S: Sink + 'static>(
        self,
        reader: &str,
        channels: &[&'static Channel],
    ) -> Result<Attached<S>, Failure> {
        Ok(match self {
            Self::Own(domain) => {
                domain.enter()?;
                let taps = Taps::open(&Ports::new(reader)?, channels)?;
                Attached::Own(domain, taps)
            }
            Self::GroupView(shown) => Attached::GroupView(shown, channels.to_vec()),
        })
    }
}

/// Access of a command to a running pipeline.
pub enum Attached<S: Sink> {
    /// Channels.
    Own(Domain, Taps<S>),
    /// A window.
    GroupView(Box<GroupView>, Vec<&'static Channel>),
}

impl<S: Sink + 'static> Attached<S> {
    /// Hands every waiting message to the sink.
    pub fn drain(&mut self, sink: &mut S) {
        match self {
            Self::Own(_, taps) => drop(taps.drain(sink)),
            Self::GroupView(shown, channels) => shown.drain(channels, sink),
        }
    }

    /// Whether the run goes on.
    pub fn is_alive(&self) -> bool {
        match self {
            Self::Own(domain, _) => domain.is_alive(),
            Self::GroupView(shown, _) => shown.is_alive(),
        }
    }
}
