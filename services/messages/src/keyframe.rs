//! The complete state of a step, from which its further output follows without earlier samples: for a restarted process, and for
//! a replay after a gap of the recording.

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::Stamp;
use crate::fnv::fnv64;
use crate::message::message;

message! {
    /// A piece of the complete state of a step. The stamp is that of the last sample that the state has seen.
    pub struct Keyframe, "Keyframe", size 288 {
        /// Position of the process in the table of processes.
        process: u32, "";
        /// Restarts of the process before this.
        restarts: u32, "";
        /// What the state fits: build, process, method and description, as one number.
        identity: u64, "";
        /// Check sum of the whole state (FNV-1a).
        sum: u64, "";
        /// Length of the whole state in bytes.
        length: u32, "";
        /// Where this piece begins in it.
        offset: u32, "";
        /// Bytes 0 to 7 of the piece, little-endian.
        w0: u64, "";
        /// The next 8 bytes.
        w1: u64, "";
        /// The next 8 bytes.
        w2: u64, "";
        /// The next 8 bytes.
        w3: u64, "";
        /// The next 8 bytes.
        w4: u64, "";
        /// The next 8 bytes.
        w5: u64, "";
        /// The next 8 bytes.
        w6: u64, "";
        /// The next 8 bytes.
        w7: u64, "";
        /// The next 8 bytes.
        w8: u64, "";
        /// The next 8 bytes.
        w9: u64, "";
        /// The next 8 bytes.
        w10: u64, "";
        /// The next 8 bytes.
        w11: u64, "";
        /// The next 8 bytes.
        w12: u64, "";
        /// The next 8 bytes.
        w13: u64, "";
        /// The next 8 bytes.
        w14: u64, "";
        /// The next 8 bytes.
        w15: u64, "";
        /// The next 8 bytes.
        w16: u64, "";
        /// The next 8 bytes.
        w17: u64, "";
        /// The next 8 bytes.
        w18: u64, "";
        /// The next 8 bytes.
        w19: u64, "";
        /// The next 8 bytes.
        w20: u64, "";
        /// The next 8 bytes.
        w21: u64, "";
        /// The next 8 bytes.
        w22: u64, "";
        /// The next 8 bytes.
        w23: u64, "";
    }
}

/// Bytes of a state in one message.
pub const PIECE: usize = 192;
/// Longest state \[bytes\]; a longer one is damaged.
pub const LONGEST: usize = 1 << 16;

/// The words of a piece, each of them once.
macro_rules! words {
    ($piece:expr) => {
        [
            &mut $piece.w0,
            &mut $piece.w1,
            &mut $piece.w2,
            &mut $piece.w3,
            &mut $piece.w4,
            &mut $piece.w5,
            &mut $piece.w6,
            &mut $piece.w7,
            &mut $piece.w8,
            &mut $piece.w9,
            &mut $piece.w10,
            &mut $piece.w11,
            &mut $piece.w12,
            &mut $piece.w13,
            &mut $piece.w14,
            &mut $piece.w15,
            &mut $piece.w16,
            &mut $piece.w17,
            &mut $piece.w18,
            &mut $piece.w19,
            &mut $piece.w20,
            &mut $piece.w21,
            &mut $piece.w22,
            &mut $piece.w23,
        ]
    };
}

/// Owner of a state.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Owner {
    /// Position of the process in the table of processes.
    pub process: u32,
    /// Restarts of the process before this.
    pub restarts: u32,
    /// Number of the build, process, method and description that the state requires.
    pub identity: u64,
}

/// The messages that carry a state, without allocation; none for a state longer than [`LONGEST`].
pub fn pieces<'a>(
    owner: Owner,
    stamp: &'a Stamp,
    state: &'a [u8],
) -> impl Iterator<Item = Keyframe> + use<'a> {
    let (sum, length) = (fnv64(state), state.len() as u32);
    let whole = if state.len() <= LONGEST { state } else { &[] };
    whole.chunks(PIECE).zip(0..).map(move |(bytes, n)| {
        let mut piece = Keyframe {
            stamp: *stamp,
            process: owner.process,
            restarts: owner.restarts,
            identity: owner.identity,
            sum,
            length,
            offset: n * PIECE as u32,
            ..Keyframe::default()
        };
        for (word, bytes) in words!(piece).into_iter().zip(bytes.chunks(8)) {
            let mut eight = [0; 8];
            eight[..bytes.len()].copy_from_slice(bytes);
            *word = u64::from_le_bytes(eight);
        }
        piece
    })
}

/// A whole state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Snapshot {
    /// Its owner.
    pub owner: Owner,
    /// Stamp of the last sample that it includes.
    pub stamp: Stamp,
    /// The state as serialised by the step.
    pub bytes: Vec<u8>,
}

/// Joins the pieces of one process.
#[derive(Debug, Clone, Default)]
pub struct Collector {
    next: Snapshot,
    sum: u64,
    length: usize,
}

impl Collector {
    /// Takes a piece; returns the state with its last piece. A state with a missing or damaged piece is never returned.
    pub fn take(&mut self, piece: &Keyframe) -> Option<Snapshot> {
        let owner = Owner {
            process: piece.process,
            restarts: piece.restarts,
            identity: piece.identity,
        };
        if piece.offset == 0 {
            self.next = Snapshot {
                owner,
                stamp: piece.stamp,
                bytes: Vec::new(),
            };
            (self.sum, self.length) = (piece.sum, piece.length as usize);
        }
        let (offset, missing) = (self.next.bytes.len(), self.length - self.next.bytes.len());
        let fits = owner == self.next.owner
            && piece.stamp == self.next.stamp
            && piece.sum == self.sum
            && piece.offset as usize == offset
            && self.length <= LONGEST;
        if !fits {
            *self = Self::default();
            return None;
        }
        let mut copy = *piece;
        let bytes = words!(copy).map(|word| word.to_le_bytes());
        let bytes = bytes.as_flattened();
        self.next.bytes.extend(&bytes[..missing.min(PIECE)]);
        if missing > PIECE || missing == 0 {
            return None;
        }
        let whole = core::mem::take(self);
        (fnv64(&whole.next.bytes) == whole.sum).then_some(whole.next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owner() -> Owner {
        Owner {
            process: 3,
            restarts: 2,
            identity: 99,
        }
    }

    fn split(state: &[u8], sequence: u64) -> Vec<Keyframe> {
        let stamp = Stamp {
            sequence,
            ..Stamp::default()
        };
        pieces(owner(), &stamp, state).collect()
    }

    fn join(pieces: &[Keyframe]) -> Vec<Snapshot> {
        let mut collector = Collector::default();
        pieces.iter().filter_map(|p| collector.take(p)).collect()
    }

    #[test]
    fn a_state_of_any_length_comes_through_in_pieces() {
        for length in [1, 7, 191, 192, 193, 5000, LONGEST] {
            let state: Vec<u8> = (0..length).map(|i| (i * 7 + i / 255) as u8).collect();
            let found = join(&split(&state, 5));
            assert_eq!(found.len(), 1, "{length}");
            assert_eq!((found[0].owner, found[0].stamp.sequence), (owner(), 5));
            assert_eq!(found[0].bytes, state);
        }
        assert_eq!(split(&vec![0; LONGEST + 1], 5), []);
    }

    #[test]
    fn a_state_with_a_missing_or_damaged_piece_never_comes_out_and_the_next_one_does() {
        let (state, next) = (vec![1; 1000], split(&[2; 1000], 6));
        for at in 0..6 {
            let mut missing = split(&state, 5);
            missing.remove(at);
            missing.extend(&next);
            assert_eq!(join(&missing).len(), 1, "without {at}");
            let mut damaged = split(&state, 5);
            damaged[at].w3 ^= 1 << 40;
            damaged.extend(&next);
            assert_eq!(join(&damaged).len(), 1, "damaged {at}");
            let mut length = split(&state, 5);
            length[at].length = u32::MAX;
            length[at].offset ^= 64;
            length.extend(&next);
            assert_eq!(join(&length).len(), 1, "length of {at}");
        }
    }
}
