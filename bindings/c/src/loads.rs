//! Loads (filled, carried, dumped) from the estimates of either machine.

use estimation::Quantity;
use estimation::excavator::Reason;
use estimation::loads::{Ledger, Load, LoadReport, Row, Settings, Witness};

use crate::table::present;

/// An estimate as the caller passes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct LoadsRow {
    t: f64,
    payload: f64,
    payload_std: f64,
    speed: f64,
    truck: f64,
    trusted: u32,
    changing: u32,
    reason: u32,
    witness: u32,
}

/// Whether this is a valid target of a truck: none, or a mass \[kg\].
pub(crate) fn can_be_target(target: Option<f64>) -> bool {
    target.is_none_or(|kg| kg.is_finite() && kg > 0.0)
}

/// Counts the loads of one machine.
pub(crate) struct Loads {
    ledger: Ledger,
    last: Option<Load>,
}

impl Loads {
    /// For a machine with the values `usual`. None if the payload of a full bucket is no valid mass.
    pub(crate) fn new(usual: Settings, target: f64, pause: f64) -> Option<Self> {
        let settings = Settings {
            target: present(target),
            pause: present(pause).unwrap_or(usual.pause),
            ..usual
        };
        let [least, most] = Settings::RATED;
        let fits = (least..=most).contains(&usual.rated);
        let fits = fits && can_be_target(settings.target);
        let fits = fits && settings.pause >= 0.0 && settings.pause.is_finite();
        fits.then(|| Self {
            ledger: Ledger::new(settings),
            last: None,
        })
    }

    pub(crate) fn step(&mut self, row: &LoadsRow) -> LoadReport {
        let payload = present(row.payload).zip(present(row.payload_std));
        let witness = usize::try_from(row.witness).ok();
        let witness = witness.and_then(|i| Witness::ALL.get(i).copied());
        let witness = witness.unwrap_or_default();
        // Reason codes belong to a machine; only an excavator's load is weighed by its own motion.
        let is_excavator = matches!(witness, Witness::Motion | Witness::Both);
        let events = self.ledger.step(&Row {
            time: row.t,
            payload: payload.map(|(value, std)| Quantity { value, std }),
            common: None,
            speed: present(row.speed).unwrap_or_default(),
            changing: row.changing != 0,
            hangs: is_excavator && row.reason == Reason::Hanging as u32,
            trusted: row.trusted != 0,
            why: row.reason,
            witness,
            truck: present(row.truck),
        });
        self.last = events.load.or(self.last);
        self.report()
    }

    pub(crate) fn next_truck(&mut self) -> LoadReport {
        self.last = self.ledger.next_truck().load.or(self.last);
        self.report()
    }

    pub(crate) fn set_target(&mut self, target: Option<f64>) -> LoadReport {
        self.ledger.set_target(target);
        self.report()
    }

    fn report(&self) -> LoadReport {
        LoadReport::of(&self.ledger, self.last.as_ref())
    }
}
