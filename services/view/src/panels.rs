//! The plots of a run, one list for each section of the report.

pub mod error;
pub mod history;
pub mod innovation;
pub mod latency;
pub mod rules;
pub mod sensors;

use crate::plot::Plot;

/// A plot with its place on the page.
#[derive(Debug, Clone)]
pub struct Panel {
    /// The plot.
    pub plot: Plot,
    /// Whether it spans the whole width of the page.
    pub wide: bool,
    /// One sentence on how to read it, or empty.
    pub note: String,
}

impl Panel {
    fn wide(plot: Plot, note: impl Into<String>) -> Self {
        Self {
            plot,
            wide: true,
            note: note.into(),
        }
    }

    pub(crate) fn half(plot: Plot, note: impl Into<String>) -> Self {
        Self {
            plot,
            wide: false,
            note: note.into(),
        }
    }
}

/// Label of the time axis.
pub(crate) const TIME: &str = "Time [s]";

/// Stretches of time in which `holds` is true; each lasts until the next sample.
pub(crate) fn spans<T>(
    rows: &[T],
    time: impl Fn(&T) -> f64,
    holds: impl Fn(&T) -> bool,
) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    let mut open: Option<f64> = None;
    for row in rows {
        let now = time(row);
        match (open, holds(row)) {
            (None, true) => open = Some(now),
            (Some(from), false) => {
                out.push((from, now));
                open = None;
            }
            _ => {}
        }
    }
    if let (Some(from), Some(last)) = (open, rows.last()) {
        out.push((from, time(last)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_begin_and_end_where_the_flag_does() {
        let rows = [
            (0.0, false),
            (1.0, true),
            (2.0, true),
            (3.0, false),
            (4.0, true),
            (5.0, true),
        ];
        assert_eq!(spans(&rows, |r| r.0, |r| r.1), [(1.0, 3.0), (4.0, 5.0)]);
    }
}
