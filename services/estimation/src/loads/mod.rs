//! Loads, as people count them: what was filled, carried and dumped, in kilograms, and what a truck and a day add up to.
//!
//! Knows estimates only (time, payload with its standard deviation, speed, verdict), so it serves every machine and
//! every witness. Constant memory: it hands out each load as it ends and keeps the sums.
//!
//! | file | what |
//! |---|---|
//! | `row` | what it reads: one estimate |
//! | `settings`, `events` | what it is given, and what a row brings about |
//! | `clock` | which rows are in time |
//! | `level` | a content of the bucket that stays: the best estimate of it |
//! | `open` | a content that is not known for a while |
//! | `hook` | a load that hangs: when it is set down |
//! | `content` | what the bucket holds from row to row, and the empty bucket |
//! | `ledger` | from levels to loads: filled, carried, dumped, weighed empty again |
//! | `accounts` | what was dumped, and to which truck and day it goes |
//! | `load` | one load, its weight and what stays in the bucket |
//! | `total` | sums with errors that loads share and errors that they do not |
//! | `book` | trucks and days |
//! | `now` | what the bucket holds now: always a value |
//! | `report` | what other programs hear, in plain numbers |
//!
//! ```
//! use estimation::Quantity;
//! use estimation::loads::{Ledger, Row, Settings};
//!
//! let mut ledger = Ledger::new(Settings::with_rated(1000.0));
//! let row = |time, value, std| Row {
//!     time,
//!     payload: Some(Quantity { value, std }),
//!     trusted: true,
//!     ..Row::default()
//! };
//! let content = |i: u32| if (200..500).contains(&i) { 900.0 } else { 20.0 };
//! for i in 0..800 {
//!     ledger.step(&row(f64::from(i) * 0.01, content(i), 20.0));
//! }
//! let truck = ledger.truck();
//! assert_eq!(truck.total.loads, 1);
//! assert!((truck.total.kg - 880.0).abs() < 30.0, "20 kg stay in the bucket");
//! ```

mod accounts;
mod book;
mod clock;
mod content;
mod events;
mod hook;
mod ledger;
mod level;
mod load;
mod now;
mod open;
mod report;
mod row;
mod settings;
mod total;

pub use book::{Day, Truck};
pub use events::Events;
pub use ledger::Ledger;
pub use load::{Load, Stage, Weight};
pub use now::Now;
pub use report::LoadReport;
pub use row::{Row, Witness};
pub use settings::Settings;
pub use total::Total;
