//! Ledger of loads: finds what was filled, carried and dumped in the estimates, and adds it up per truck and per day, in kilograms.
//!
//! Its input is estimates only (time, payload with its standard deviation, speed, verdict), so it serves every machine and
//! every witness. Memory is constant: it returns each load as it ends and stores the sums.
//!
//! | file | what |
//! |---|---|
//! | `row` | its input: one estimate |
//! | `settings`, `events` | settings; events of a row |
//! | `clock` | accepts or refuses rows by their time |
//! | `level` | a constant content of the bucket and its best estimate |
//! | `open` | a content that may have changed |
//! | `hook` | a suspended load: when it is set down |
//! | `content` | content of the bucket from row to row, and the empty bucket |
//! | `ledger` | from levels to loads: filled, carried, dumped, weighed empty again |
//! | `accounts` | dumped loads, assigned to trucks and days |
//! | `load` | one load, its weight and what stays in the bucket |
//! | `total` | sums with common and independent errors of the loads |
//! | `book` | trucks and days |
//! | `now` | the present content of the bucket: always a value |
//! | `report` | plain numbers for other programs |
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
