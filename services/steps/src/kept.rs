//! Step states that outlive their process: as bytes, and the verdict after a restart.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Writes a state; see [`runtime::Step::save`].
pub(crate) fn save<T: Serialize>(state: &T, into: &mut [u8]) -> Option<usize> {
    postcard::to_slice(state, into)
        .ok()
        .map(|bytes| bytes.len())
}

/// Replaces a state by a written one; see [`runtime::Step::restore`].
pub(crate) fn restore<T: DeserializeOwned>(state: &mut T, bytes: &[u8]) -> bool {
    match postcard::take_from_bytes(bytes) {
        Ok((written, [])) => {
            *state = written;
            true
        }
        _ => false,
    }
}

/// The three functions of [`runtime::Step`] that preserve a state; the last one only where answers have a verdict.
macro_rules! keeps_its_state {
    () => {
        fn save(&self, into: &mut [u8]) -> Option<usize> {
            $crate::kept::save(self, into)
        }

        fn restore(&mut self, state: &[u8]) -> bool {
            $crate::kept::restore(self, state)
        }
    };
    ($restart:ident) => {
        $crate::kept::keeps_its_state!();

        fn resume(&mut self) {
            self.$restart.begin();
        }
    };
}
pub(crate) use keeps_its_state;

/// Duration after a restart in which an estimate is not fresh, because samples are missing [s].
const STALE: f64 = 0.5;

/// Flags of a restart, until the estimate is trusted again.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Restart {
    restarted: bool,
    /// Time of the first sample after the restart [s].
    since: Option<f64>,
}

/// Bits of a verdict that a restart changes.
pub(crate) struct Bits {
    pub restarted: u32,
    pub fresh: u32,
    /// Trusted bits of every quantity.
    pub trusted: u32,
    /// Code of the reason.
    pub reason: u32,
}

impl Restart {
    /// Notes that the process was restarted.
    pub fn begin(&mut self) {
        *self = Self {
            restarted: true,
            since: None,
        };
    }

    /// Marks a verdict as restarted, until it is trusted.
    pub fn mark(&mut self, bits: &Bits, time: f64, flags: &mut u32, reason: &mut u32) {
        if !self.restarted {
            return;
        }
        self.since = self.since.or(Some(time).filter(|t| t.is_finite()));
        // After a set-back clock the time since the restart is unknown.
        let is_new = |since| (since..since + STALE).contains(&time);
        if self.since.is_none_or(is_new) {
            *flags &= !(bits.fresh | bits.trusted);
        }
        self.restarted = *flags & bits.trusted == 0;
        if self.restarted {
            *flags |= bits.restarted;
            if *reason == 0 {
                *reason = bits.reason;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BITS: Bits = Bits {
        restarted: 1,
        fresh: 2,
        trusted: 4,
        reason: 9,
    };

    #[test]
    fn an_answer_is_restarted_until_it_is_trusted_and_is_not_at_once() {
        let mut restart = Restart::default();
        let after = |restart: &mut Restart, time, mut flags| {
            let mut reason = 0;
            restart.mark(&BITS, time, &mut flags, &mut reason);
            (flags, reason)
        };
        assert_eq!(after(&mut restart, 1.0, 6), (6, 0), "never restarted");
        restart.begin();
        assert_eq!(after(&mut restart, 2.0, 6), (1, 9), "not at once");
        assert_eq!(after(&mut restart, 2.4, 6), (1, 9));
        assert_eq!(after(&mut restart, 2.6, 2), (3, 9), "not trusted by itself");
        assert_eq!(after(&mut restart, 2.7, 6), (6, 0));
        assert_eq!(after(&mut restart, 2.8, 2), (2, 0), "over");
    }

    #[test]
    fn foreign_bytes_are_refused_and_change_nothing() {
        let mut state = (1.5_f64, [true; 3]);
        for bytes in [&[][..], &[1, 2, 3], &[7; 11], &[0; 12]] {
            assert!(!restore(&mut state, bytes), "{bytes:?}");
            assert_eq!(state, (1.5, [true; 3]));
        }
    }
}
