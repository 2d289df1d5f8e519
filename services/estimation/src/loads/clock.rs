//! Accepts or refuses rows by their time.

use crate::time_base::LONGEST;

/// Number of consecutive rows behind the clock at which it counts as set back.
const SET_BACK: u32 = 5;

/// The time of the last row that was in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Clock {
    time: Option<f64>,
    /// Number of rows behind it since then.
    behind: u32,
}

/// Meaning of a row's time.
pub(super) enum Tick {
    /// Time since the previous row [s].
    Later(f64),
    /// Not later than the previous row, or not finite.
    Refused,
    /// The clock was set back: earlier rows belong to another time.
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
