//! Which rows are in time.

use crate::time_base::LONGEST;

/// So many rows behind the clock: it was set back.
const SET_BACK: u32 = 5;

/// The time of the last row that was in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Clock {
    time: Option<f64>,
    /// Rows behind it since then.
    behind: u32,
}

/// What a row's time means.
pub(super) enum Tick {
    /// So long after the row before [s].
    Later(f64),
    /// Too late, or no time at all.
    Refused,
    /// The clock was set back: what was seen before is of another time.
    SetBack,
}

impl Clock {
    /// Takes the time of a row.
    pub fn tick(&mut self, time: f64) -> Tick {
        if !time.is_finite() {
            return Tick::Refused;
        }
        let dt = time - self.time.unwrap_or(time);
        let is_behind = self.time.is_some() && dt <= 0.0;
        if is_behind && self.behind + 1 < SET_BACK {
            self.behind += 1;
            return Tick::Refused;
        }
        *self = Self {
            time: Some(time),
            behind: 0,
        };
        if is_behind {
            Tick::SetBack
        } else {
            Tick::Later(dt.min(LONGEST))
        }
    }
}
