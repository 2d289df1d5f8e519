//! The memory all stages share: control words, a ring per hop, and the table of results.
//!
//! Everything is an atomic word, so a writer that overtakes a reader makes a sample wrong, which the reader notices, and never undefined.
#![allow(unsafe_code)]

use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Slots of a ring: 1.6 s at 10 kHz.
const DEPTH: usize = 16_384;
/// Words between two control words: each has a pair of cache lines for itself, as the hardware fetches lines in pairs.
const APART: usize = 16;
/// Set in a ring's word once its writer has sent everything.
const DONE: u32 = 1 << 31;

const READY: usize = 0;
const GO: usize = APART;
const START: usize = 2 * APART;
const NOT_FIFO: usize = 3 * APART;
const FIRST_RING: usize = 4 * APART;

/// The shared mapping, and the file behind it.
pub struct Shared {
    file: OwnedFd,
    base: *mut AtomicU64,
    words: usize,
    stages: usize,
    samples: usize,
    slot_words: usize,
}

impl Shared {
    /// Makes the memory for a chain; `payload` is in bytes and a multiple of 8.
    pub fn create(stages: usize, samples: usize, payload: usize) -> io::Result<Self> {
        let file = memfd_create("heft-limits", MemfdFlags::CLOEXEC)?;
        let bytes = 8 * words(stages, samples, payload / 8);
        ftruncate(&file, bytes as u64)?;
        Self::open(file, stages, samples, payload)
    }

    /// Maps memory that another process made with the same sizes.
    pub fn open(file: OwnedFd, stages: usize, samples: usize, payload: usize) -> io::Result<Self> {
        let words = words(stages, samples, payload / 8);
        let found = rustix::fs::fstat(&file)?.st_size;
        if found != (8 * words) as i64 {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "the shared memory has another size",
            ));
        }
        // SAFETY: a new mapping at an address of the kernel's choice; it overlaps nothing of ours.
        let base = unsafe {
            mmap(
                std::ptr::null_mut(),
                8 * words,
                ProtFlags::READ | ProtFlags::WRITE,
                MapFlags::SHARED | MapFlags::POPULATE,
                file.as_fd(),
                0,
            )?
        };
        Ok(Self {
            file,
            base: base.cast(),
            words,
            stages,
            samples,
            slot_words: payload / 8,
        })
    }

    /// The file to hand to the stages.
    pub fn file(&self) -> &OwnedFd {
        &self.file
    }

    fn data(&self) -> &[AtomicU64] {
        // SAFETY: `base` is the start of a live, page-aligned mapping of `words` words, unmapped only when self is dropped. All bit
        // patterns are valid, and every access of every process is atomic.
        unsafe { std::slice::from_raw_parts(self.base, self.words) }
    }

    /// A futex word: the low half (or the high one, on a big-endian machine) of a word used for nothing else.
    fn futex(&self, word: usize) -> &AtomicU32 {
        let whole: *const AtomicU64 = &self.data()[word];
        // SAFETY: in bounds and aligned, as the word is; these words are only ever used through this 32-bit view.
        unsafe { &*whole.cast::<AtomicU32>() }
    }

    /// Counts the stages that are ready; the starter waits on it.
    pub fn ready(&self) -> &AtomicU32 {
        self.futex(READY)
    }

    /// Becomes 1 when the chain may start; the stages wait on it.
    pub fn go(&self) -> &AtomicU32 {
        self.futex(GO)
    }

    /// When the first sample is due, CLOCK_MONOTONIC [ns].
    pub fn start_ns(&self) -> &AtomicU64 {
        &self.data()[START]
    }

    /// Notes that a stage does not run under SCHED_FIFO.
    pub fn note_not_fifo(&self) {
        self.data()[NOT_FIFO].store(1, Ordering::Release);
    }

    /// Whether all stages run under SCHED_FIFO.
    pub fn all_fifo(&self) -> bool {
        self.data()[NOT_FIFO].load(Ordering::Acquire) == 0
    }

    /// The ring of hop `hop`, from stage `hop` to stage `hop + 1`.
    pub fn ring(&self, hop: usize) -> Ring<'_> {
        let first = rings_start(self.stages) + hop * DEPTH * self.slot_words;
        Ring {
            word: self.futex(FIRST_RING + hop * APART),
            slots: &self.data()[first..first + DEPTH * self.slot_words],
            slot_words: self.slot_words,
        }
    }

    fn result_row(&self, index: usize) -> &[AtomicU64] {
        let first = rings_start(self.stages) + (self.stages - 1) * DEPTH * self.slot_words;
        &self.data()[first + index * self.stages..first + (index + 1) * self.stages]
    }

    /// Records the stamps of sample `index` [ns], one for each stage; an index out of range is no sample of this chain.
    pub fn record(&self, index: u64, stamps: &[u64]) {
        if index < self.samples as u64 {
            for (word, stamp) in self.result_row(index as usize).iter().zip(stamps) {
                word.store(*stamp, Ordering::Release);
            }
        }
    }

    /// The stamps of sample `index` [ns]; zeros if it never arrived.
    pub fn result(&self, index: usize) -> Vec<u64> {
        self.result_row(index)
            .iter()
            .map(|word| word.load(Ordering::Acquire))
            .collect()
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: the mapping made in `open`; nothing borrowed from it outlives self. A failure leaves a mapping behind, no more.
        let _ = unsafe { munmap(self.base.cast(), 8 * self.words) };
    }
}

fn rings_start(stages: usize) -> usize {
    (FIRST_RING + stages * APART).next_multiple_of(512)
}

fn words(stages: usize, samples: usize, slot_words: usize) -> usize {
    rings_start(stages) + (stages - 1) * DEPTH * slot_words + samples * stages
}

/// One hop's ring: a single writer, a single reader, the oldest overwritten.
pub struct Ring<'a> {
    /// Samples written so far (31 bits) and [`DONE`]; what the reader waits on.
    pub word: &'a AtomicU32,
    slots: &'a [AtomicU64],
    slot_words: usize,
}

impl Ring<'_> {
    fn slot(&self, count: u32) -> &[AtomicU64] {
        let first = (count as usize % DEPTH) * self.slot_words;
        &self.slots[first..first + self.slot_words]
    }

    /// Writes one sample and makes it visible. Waking the reader is the caller's business.
    pub fn push(&self, sample: &[u64]) {
        let count = self.word.load(Ordering::Relaxed) & !DONE;
        for (word, value) in self.slot(count).iter().zip(sample) {
            word.store(*value, Ordering::Relaxed);
        }
        self.word.store((count + 1) & !DONE, Ordering::Release);
    }

    /// Marks the end of the samples.
    pub fn finish(&self) {
        self.word.fetch_or(DONE, Ordering::Release);
    }

    /// Reads sample number `count` if it is there; `seen` is the word as last loaded.
    pub fn read(&self, count: u32, seen: u32, sample: &mut [u64]) -> bool {
        if count == seen & !DONE {
            return false;
        }
        for (value, word) in sample.iter_mut().zip(self.slot(count)) {
            *value = word.load(Ordering::Relaxed);
        }
        true
    }

    /// Whether the writer has finished, by the word as last loaded.
    pub fn finished(seen: u32) -> bool {
        seen & DONE != 0
    }

    /// Whether the writer may have written over sample `count` while it was read.
    pub fn overtaken(&self, count: u32) -> bool {
        std::sync::atomic::fence(Ordering::Acquire);
        let written = self.word.load(Ordering::Relaxed) & !DONE;
        written.wrapping_sub(count) as usize >= DEPTH
    }
}
