//! Protocol between supervisor and worker, over the worker's standard input.
//!
//! | from | word | meaning |
//! |---|---|---|
//! | supervisor | `state` and numbers, a line, bytes | the last state of the process before it died, if there is one |
//! | supervisor | `bells`, with file descriptors | the worker's own bell, then those of its readers, next stage first |
//! | supervisor | `bells+input`, with one more | the same, and the standard input of the run |
//! | worker | `ready` | all ports are open |
//! | supervisor | `go N T L` | begin; a source begins with sample N, sample 0 was due at T ns, and the latest has the time L ns |
//! | worker | `ended` | the source has no more samples |
//! | worker | `refused E` | the source cannot use its input; E is the error in its three lines |
//! | supervisor | `seen N` | the supervisor has received N samples in every channel; a lossless source stays within a window of them |
//! | supervisor | `drain` | answer all waiting messages, then confirm |
//! | worker | `drained` | no message is waiting |
//! | supervisor | `exit` | end |
//!
//! The socket closes when either side dies: a worker whose supervisor is gone ends by itself.

use std::io::{IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::Duration;

use messages::keyframe::{LONGEST, Owner};
use messages::{Snapshot, Stamp};
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, SocketFlags, SocketType, recvmsg, sendmsg, socketpair,
};

use crate::bell::comes;
use crate::{Bell, Error};

/// Most file descriptors of a word: a worker's bell, those of at most seven readers, and an input.
const MAX_DESCRIPTORS: usize = 9;
/// Longest word [bytes]: an error with its place.
const MAX_WORD: usize = 2048;

/// Resources that a supervisor hands to a worker.
#[derive(Debug)]
pub struct Handed {
    /// The worker's own bell.
    pub bell: Bell,
    /// The bells of its readers, next stage first.
    pub readers: Vec<Bell>,
    /// Last state of the process before it died, if there is one.
    pub before: Option<Snapshot>,
    /// Standard input of the run, if this worker reads it.
    pub input: Option<OwnedFd>,
}

/// First word to a worker that reads an input.
const WITH_INPUT: &[u8] = b"bells+input";

/// One end of the control socket.
#[derive(Debug)]
pub struct Control(OwnedFd);

impl Control {
    /// Both ends: the supervisor's, and the one that becomes a worker's standard input.
    ///
    /// # Errors
    /// The limit of open files is reached.
    pub fn pair() -> Result<(Self, OwnedFd), Error> {
        let (mine, theirs) = socketpair(
            AddressFamily::UNIX,
            SocketType::SEQPACKET,
            SocketFlags::CLOEXEC,
            None,
        )
        .map_err(|e| Error::os("make a control socket", "limit of open files", e))?;
        Ok((Self(mine), theirs))
    }

    /// The worker's end: standard input.
    ///
    /// # Errors
    /// Standard input is closed.
    pub fn of_worker() -> Result<Self, Error> {
        let fd = rustix::io::dup(rustix::stdio::stdin())
            .map_err(|e| Error::os("read the control socket", "standard input", e))?;
        Ok(Self(fd))
    }

    /// Sends a word; false if the other side is gone.
    pub fn say(&self, word: &str) -> bool {
        rustix::net::send(&self.0, word.as_bytes(), SendFlags::NOSIGNAL).is_ok()
    }

    /// Hands over the last state of the process, if there is one, the bells, and the input to the worker that
    /// reads it.
    ///
    /// # Errors
    /// The worker is gone.
    pub fn hand_over(
        &self,
        bells: &[&Bell],
        before: Option<&Snapshot>,
        input: Option<BorrowedFd>,
    ) -> Result<(), Error> {
        if let Some(before) = before {
            // If it cannot be sent the worker starts without it.
            let _ = rustix::net::send(&self.0, &state_word(before), SendFlags::NOSIGNAL);
        }
        let bells = bells.iter().map(|b| b.as_fd());
        let fds: Vec<_> = bells.chain(input).collect();
        let word: &[u8] = if input.is_some() {
            WITH_INPUT
        } else {
            b"bells"
        };
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_DESCRIPTORS))];
        let mut ancillary = SendAncillaryBuffer::new(&mut space);
        ancillary.push(SendAncillaryMessage::ScmRights(&fds));
        sendmsg(
            &self.0,
            &[IoSlice::new(word)],
            &mut ancillary,
            SendFlags::NOSIGNAL,
        )
        .map_err(|e| Error::os("hand over the bells", "control socket", e))?;
        Ok(())
    }

    /// Receives the bells, and the input if there is one; before them the last state of the process, if
    /// there is one.
    ///
    /// # Errors
    /// The first word is not `bells`: this process was not started by a supervisor.
    pub fn receive_bells(&self) -> Result<Handed, Error> {
        let not_ours = |detail: String| {
            Error::new(
                format!("this process has no supervisor ({detail})"),
                "heft service",
                "start the pipeline with `heft run`; it starts the services itself",
            )
        };
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_DESCRIPTORS))];
        let mut ancillary = RecvAncillaryBuffer::new(&mut space);
        let mut word = vec![0u8; LONGEST + 256];
        let mut before = None;
        let has_input = loop {
            let got = recvmsg(
                &self.0,
                &mut [IoSliceMut::new(&mut word)],
                &mut ancillary,
                RecvFlags::CMSG_CLOEXEC,
            )
            .map_err(|e| not_ours(e.to_string()))?;
            match state_of(&word[..got.bytes]) {
                Some(state) => before = Some(state),
                None => break &word[..got.bytes] == WITH_INPUT,
            }
        };
        let mut handed = Vec::new();
        for message in ancillary.drain() {
            if let RecvAncillaryMessage::ScmRights(fds) = message {
                handed.extend(fds);
            }
        }
        let input = if has_input { handed.pop() } else { None };
        let mut bells = handed.into_iter().map(Bell::from_fd);
        let bell = bells.next();
        let bell = bell.ok_or_else(|| not_ours("no bells on standard input".into()))?;
        Ok(Handed {
            bell,
            readers: bells.collect(),
            before,
            input,
        })
    }

    /// The next word within `timeout_ms`; `ControlWord::Nothing` on time-out, `ControlWord::Gone` if the
    /// other side has died.
    pub fn hear(&self, timeout_ms: u32) -> ControlWord {
        if !comes(&self.0, Duration::from_millis(timeout_ms.into())) {
            return ControlWord::Nothing;
        }
        let mut buffer = [0u8; MAX_WORD];
        match rustix::net::recv(&self.0, &mut buffer, RecvFlags::empty()) {
            Ok((n, _)) if n > 0 => {
                ControlWord::Word(String::from_utf8_lossy(&buffer[..n]).into_owned())
            }
            Err(rustix::io::Errno::INTR) => ControlWord::Nothing,
            _ => ControlWord::Gone,
        }
    }
}

/// The worker's end of a pair, for a worker that is a thread.
impl From<OwnedFd> for Control {
    fn from(fd: OwnedFd) -> Self {
        Self(fd)
    }
}

/// First word of a state.
const STATE: &str = "state";

/// A state as one word.
fn state_word(state: &Snapshot) -> Vec<u8> {
    let (owner, stamp) = (state.owner, state.stamp);
    let numbers = format!(
        "{STATE} {} {} {} {} {} {}\n",
        owner.process,
        owner.restarts,
        owner.identity,
        stamp.epoch,
        stamp.sequence,
        stamp.time.to_bits()
    );
    [numbers.as_bytes(), &state.bytes].concat()
}

/// The state in a word, if it is one.
fn state_of(word: &[u8]) -> Option<Snapshot> {
    let end = word.iter().position(|byte| *byte == b'\n')?;
    let line = std::str::from_utf8(&word[..end]).ok()?;
    let numbers = line.strip_prefix(STATE)?.split_whitespace();
    let numbers: Vec<u64> = numbers.map_while(|n| n.parse().ok()).collect();
    let [process, restarts, identity, epoch, sequence, time] = numbers[..] else {
        return None;
    };
    Some(Snapshot {
        owner: Owner {
            process: u32::try_from(process).ok()?,
            restarts: u32::try_from(restarts).ok()?,
            identity,
        },
        stamp: Stamp {
            epoch: u32::try_from(epoch).ok()?,
            sequence,
            time: f64::from_bits(time),
            ..Stamp::default()
        },
        bytes: word[end + 1..].to_vec(),
    })
}

impl AsFd for Control {
    fn as_fd(&self) -> std::os::fd::BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Result of waiting for a word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ControlWord {
    /// A word.
    Word(String),
    /// Nothing so far.
    Nothing,
    /// The other side has died.
    Gone,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bells_pass_through_the_socket_and_ring_on_the_other_side() {
        let (supervisor, worker) = Control::pair().unwrap();
        let (own, reader) = (Bell::new().unwrap(), Bell::new().unwrap());
        let mut before = Snapshot {
            bytes: (0..LONGEST).map(|i| i as u8).collect(),
            ..Snapshot::default()
        };
        (before.owner.identity, before.stamp.sequence) = (7, 1 << 40);
        supervisor
            .hand_over(&[&own, &reader], Some(&before), None)
            .unwrap();
        let worker = Control(worker);
        let handed = worker.receive_bells().unwrap();
        assert_eq!((handed.readers.len(), handed.before), (1, Some(before)));
        assert!(handed.input.is_none());
        handed.readers[0].ring();
        reader.wait();
        own.ring();
        handed.bell.wait();
    }

    #[test]
    fn an_input_passes_beside_the_bells() {
        use std::io::{Read, Seek, Write};
        let (supervisor, worker) = Control::pair().unwrap();
        let bell = Bell::new().unwrap();
        let mut input = tempfile::tempfile().unwrap();
        input.write_all(b"a line").unwrap();
        input.rewind().unwrap();
        supervisor
            .hand_over(&[&bell], None, Some(input.as_fd()))
            .unwrap();
        let handed = Control(worker).receive_bells().unwrap();
        assert!(handed.readers.is_empty());
        let mut text = String::new();
        let mut file = std::fs::File::from(handed.input.unwrap());
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "a line");
    }

    #[test]
    fn a_worker_notices_that_its_supervisor_died() {
        let (supervisor, worker) = Control::pair().unwrap();
        let worker = Control(worker);
        assert!(supervisor.say("go 7"));
        assert_eq!(worker.hear(100), ControlWord::Word("go 7".into()));
        assert_eq!(worker.hear(1), ControlWord::Nothing);
        drop(supervisor);
        assert_eq!(worker.hear(100), ControlWord::Gone);
        assert!(!worker.say("ready"));
    }
}
