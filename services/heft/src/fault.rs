//! Faults of a run: their text in the summary, and whether they change the exit status.
//!
//! The table in `docs/reliability.md` states the same; a test compares them.

use std::time::Duration;

/// Something that went wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// A service died and was started again.
    Died {
        /// Which.
        service: &'static str,
        /// Exit status in the system's words.
        how: String,
    },
    /// A service died while the run was ending, and was left dead.
    DiedAtEnd {
        /// Which.
        service: &'static str,
        /// Exit status in the system's words.
        how: String,
    },
    /// A service gave no sign of life and was ended.
    Hung {
        /// Which.
        service: &'static str,
        /// For how long.
        silence: Duration,
        /// Whether it was started again: not while the run ends.
        again: bool,
    },
    /// A service was asked to end and did not.
    DidNotEnd {
        /// Which.
        service: &'static str,
    },
    /// Samples that were due but never measured: the source was away.
    Unmeasured {
        /// How many.
        samples: u64,
    },
    /// Frames of a bus that were not read in time.
    Dropped {
        /// How many.
        frames: u64,
    },
    /// Samples that were measured and never answered.
    Unanswered {
        /// By which service.
        service: &'static str,
        /// How many.
        samples: u64,
        /// Number of measured samples.
        of: u64,
    },
    /// The logger found gaps in the channels, or was away.
    Unrecorded {
        /// Least number of samples.
        samples: u64,
    },
    /// The disk was full for the recording.
    Disk,
    /// The parts of the recording could not be joined.
    NotJoined {
        /// Why.
        why: String,
    },
    /// What was learnt is not in the file of `--state`.
    NotStored {
        /// Why.
        why: String,
    },
    /// Samples came to a service later than a period.
    Late {
        /// To which.
        service: &'static str,
        /// How many.
        samples: u64,
    },
}

impl Fault {
    /// Text for the summary.
    pub fn words(&self) -> String {
        match self {
            Self::Died { service, how } => format!("{service} died ({how}); it was started again"),
            Self::DiedAtEnd { service, how } => {
                format!("{service} died ({how}) while the run was ending")
            }
            Self::Hung {
                service,
                silence,
                again,
            } => format!(
                "{service} hung: no sign of life for {:.1} s; it was ended{}",
                silence.as_secs_f64(),
                if *again { " and started again" } else { "" }
            ),
            Self::DidNotEnd { service } => format!("{service} did not end and was killed"),
            Self::Unmeasured { samples } => {
                let were = counted(*samples, "sample was", "samples were");
                format!("{were} not measured: the source was away")
            }
            Self::Dropped { frames } => {
                let were = counted(*frames, "frame was", "frames were");
                format!("{were} dropped by the kernel: the source came too late")
            }
            Self::Unanswered {
                service,
                samples,
                of,
            } => format!("{samples} of {of} samples were not answered by {service}"),
            Self::Unrecorded { samples: 0 } => {
                "the recording may have a gap: the logger was away".into()
            }
            Self::Unrecorded { samples } => {
                let messages = counted(*samples, "message", "messages");
                format!("the recording has gaps of {messages}")
            }
            Self::Disk => {
                "the recording is incomplete: the disk took no more, or a file of it was deleted"
                    .into()
            }
            Self::NotJoined { why } => format!("the recording stays in parts: {why}"),
            Self::NotStored { why } => format!("the learnt state was not stored: {why}"),
            Self::Late { service, samples } => {
                let came = counted(*samples, "sample", "samples");
                format!("{came} came to {service} later than a period")
            }
        }
    }

    /// Whether the run ends with status 1: samples, the recording or the state were lost, or may be.
    pub fn costs_the_status(&self) -> bool {
        !matches!(self, Self::Died { .. } | Self::Late { .. })
    }
}

/// A number with its noun.
pub fn counted(number: u64, one: &str, more: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { more })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_no_samples() {
        let said = Fault::Unmeasured { samples: 1 }.words();
        assert!(said.starts_with("1 sample was not measured"), "{said}");
    }

    #[test]
    fn the_table_of_the_documentation_says_the_same_words_and_status() {
        let text = include_str!("../../../docs/reliability.md");
        let killed = || "signal: 9 (SIGKILL)".to_owned();
        let faults = [
            Fault::Died {
                service: "kalman",
                how: killed(),
            },
            Fault::DiedAtEnd {
                service: "logger",
                how: killed(),
            },
            Fault::Hung {
                service: "ukf",
                silence: Duration::from_millis(800),
                again: true,
            },
            Fault::DidNotEnd { service: "logger" },
            Fault::Unmeasured { samples: 12 },
            Fault::Dropped { frames: 40 },
            Fault::Unanswered {
                service: "rls",
                samples: 3,
                of: 301,
            },
            Fault::Unrecorded { samples: 6 },
            Fault::Disk,
            Fault::NotJoined {
                why: "no room".into(),
            },
            Fault::NotStored {
                why: "cannot write the file: No space left on device (os error 28)".into(),
            },
            Fault::Late {
                service: "ukf",
                samples: 4,
            },
        ];
        for fault in &faults {
            let status = u8::from(fault.costs_the_status());
            let row = format!("| {} | {status} |", fault.words());
            assert!(text.contains(&row), "{row}");
        }
        let rows = text
            .lines()
            .filter(|l| l.ends_with("| 0 |") || l.ends_with("| 1 |"));
        assert_eq!(rows.count(), faults.len(), "no row without a fault");
    }
}
