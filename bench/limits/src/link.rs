//! One hop of a chain, seen from its two ends.

use crate::Primitive;
use crate::shared::{Ring, Shared};
use rustix::io::Errno;
use rustix::thread::futex;
use std::io;
use std::os::fd::OwnedFd;
use std::sync::atomic::Ordering;

/// The end a stage writes to.
pub enum Output<'a> {
    /// A ring and a futex wake.
    Futex(Ring<'a>),
    /// A ring that its reader watches.
    Spin(Ring<'a>),
    /// A pipe.
    Pipe(OwnedFd),
}

impl Output<'_> {
    /// Sends one sample on.
    pub fn send(&self, sample: &[u64]) -> io::Result<()> {
        match self {
            Output::Futex(ring) => {
                ring.push(sample);
                wake(ring)
            }
            Output::Spin(ring) => {
                ring.push(sample);
                Ok(())
            }
            Output::Pipe(pipe) => write_all(pipe, sample),
        }
    }

    /// Marks the end of the samples. A pipe marks it by being closed.
    pub fn finish(self) -> io::Result<()> {
        match self {
            Output::Futex(ring) => {
                ring.finish();
                wake(&ring)
            }
            Output::Spin(ring) => {
                ring.finish();
                Ok(())
            }
            Output::Pipe(_) => Ok(()),
        }
    }
}

fn wake(ring: &Ring) -> io::Result<()> {
    futex::wake(ring.word, futex::Flags::empty(), 1)?;
    Ok(())
}

fn write_all(pipe: &OwnedFd, sample: &[u64]) -> io::Result<()> {
    let mut bytes = [0; 4096];
    let bytes = &mut bytes[..8 * sample.len()];
    for (chunk, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(sample) {
        *chunk = word.to_ne_bytes();
    }
    let mut rest = &*bytes;
    while !rest.is_empty() {
        match rustix::io::write(pipe, rest) {
            Ok(written) => rest = &rest[written..],
            Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// The end a stage reads from.
pub struct Input<'a> {
    source: Source<'a>,
    /// Samples read so far.
    count: u32,
}

enum Source<'a> {
    Futex(Ring<'a>),
    Spin(Ring<'a>),
    Pipe(OwnedFd),
}

impl<'a> Input<'a> {
    /// The reading end of hop `hop`; `pipe` is used by [`Primitive::Pipe`] only.
    pub fn new(
        kind: Primitive,
        shared: &'a Shared,
        hop: usize,
        pipe: Option<OwnedFd>,
    ) -> Option<Self> {
        let source = match kind {
            Primitive::Futex => Source::Futex(shared.ring(hop)),
            Primitive::Spin => Source::Spin(shared.ring(hop)),
            Primitive::Pipe => Source::Pipe(pipe?),
        };
        Some(Self { source, count: 0 })
    }

    /// Waits for the next sample; `false` when no more will come.
    pub fn receive(&mut self, sample: &mut [u64]) -> io::Result<bool> {
        match &self.source {
            Source::Futex(ring) => {
                from_ring(ring, &mut self.count, sample, |seen| {
                    match futex::wait(ring.word, futex::Flags::empty(), seen, None) {
                        Ok(()) | Err(Errno::AGAIN | Errno::INTR) => Ok(()),
                        Err(error) => Err(error.into()),
                    }
                })
            }
            Source::Spin(ring) => from_ring(ring, &mut self.count, sample, |_| {
                std::hint::spin_loop();
                Ok(())
            }),
            Source::Pipe(pipe) => read_exact(pipe, sample),
        }
    }
}

/// The writing end of hop `hop`; `pipe` is used by [`Primitive::Pipe`] only.
pub fn output<'a>(
    kind: Primitive,
    shared: &'a Shared,
    hop: usize,
    pipe: Option<OwnedFd>,
) -> Option<Output<'a>> {
    Some(match kind {
        Primitive::Futex => Output::Futex(shared.ring(hop)),
        Primitive::Spin => Output::Spin(shared.ring(hop)),
        Primitive::Pipe => Output::Pipe(pipe?),
    })
}

/// The next sample of a ring that was not overwritten while it was read; what is skipped counts as lost.
fn from_ring(
    ring: &Ring,
    count: &mut u32,
    sample: &mut [u64],
    wait: impl Fn(u32) -> io::Result<()>,
) -> io::Result<bool> {
    loop {
        let seen = ring.word.load(Ordering::Acquire);
        if ring.read(*count, seen, sample) {
            *count += 1;
            if !ring.overtaken(*count - 1) {
                return Ok(true);
            }
        } else if Ring::finished(seen) {
            return Ok(false);
        } else {
            wait(seen)?;
        }
    }
}

fn read_exact(pipe: &OwnedFd, sample: &mut [u64]) -> io::Result<bool> {
    let mut bytes = [0; 4096];
    let bytes = &mut bytes[..8 * sample.len()];
    let mut filled = 0;
    while filled < bytes.len() {
        match rustix::io::read(pipe, &mut bytes[filled..]) {
            Ok(0) => return Ok(false),
            Ok(read) => filled += read,
            Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
    for (word, chunk) in sample.iter_mut().zip(bytes.as_chunks::<8>().0) {
        *word = u64::from_ne_bytes(*chunk);
    }
    Ok(true)
}
