//! One file per command.

pub mod calibrate;
pub mod check;
pub mod demo;
pub mod doctor;
pub mod estimate;
pub mod evaluate;
pub mod export;
pub mod latency;
pub mod map;
pub mod package;
pub mod recover;
pub mod replay;
pub mod report;
pub mod run;
pub mod schema;
pub mod serve;
pub mod tail;
pub mod top;
pub mod weigh;
