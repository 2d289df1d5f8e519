//! The estimators as FMI 3.0 co-simulation units, one per machine, from one library.
//!
//! Inputs are the sensors, outputs the estimate, its standard deviations and the verdict, parameters the keys
//! of the settings. Each communication step takes one row: the inputs, at the time at which the
//! step begins.
//!
//! | file | idea |
//! |---|---|
//! | `model` | one machine as variables |
//! | `description` | modelDescription.xml of those variables |
//! | `fmi` | the functions that an importer calls: all the unsafe code |
//! | `zip` | the zip archive of an FMU |

pub mod description;
mod fmi;
pub mod model;
pub mod zip;
