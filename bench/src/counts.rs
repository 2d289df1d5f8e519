//! Instructions a step, counted by valgrind's callgrind: the same on a busy machine as on an idle one, so they can gate a change.
//!
//! The program starts itself under valgrind with the hidden command `block KEY PASSES`; only [`crate::measure`]'s block of steps is
//! counted.

use crate::groups::{self, Role};
use crate::problem::SAMPLES;
use std::io;
use std::process::{Command, Stdio};

/// The hidden command that runs one contender.
pub const SUBCOMMAND: &str = "block";

/// Highest allowed number of instructions a step, by group and contender.
pub const BUDGETS: [(&str, usize, u64); 5] = [
    ("kf_2_1", 0, 30),
    ("rls_3", 0, 40),
    ("rls_3", 1, 60),
    ("srukf_6_3", 0, 7500),
    ("ekf_6_3", 0, 1300),
];

/// Passes over the data that are counted.
const PASSES: usize = 4;

/// Whether valgrind can be started.
pub fn available() -> bool {
    Command::new("valgrind")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|s| s.success())
}

/// Runs some passes of contender `index` of group `key`: what valgrind looks at. `false` if there is none such.
pub fn run_block(key: &str, index: usize, passes: usize) -> bool {
    let Some(mut group) = groups::all().into_iter().find(|group| group.key == key) else {
        return false;
    };
    let Some(contender) = group.contenders.get_mut(index) else {
        return false;
    };
    for _ in 0..passes {
        contender.pass();
    }
    true
}

/// Instructions a step of contender `index` of group `key`.
pub fn count(key: &str, index: usize) -> io::Result<f64> {
    let output = Command::new("valgrind")
        .args([
            "--tool=callgrind",
            "--callgrind-out-file=/dev/null",
            "--toggle-collect=bench::measure::run*",
        ])
        .arg(std::env::current_exe()?)
        .args([SUBCOMMAND, key, &index.to_string(), &PASSES.to_string()])
        .stdout(Stdio::null())
        .output()?;
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text
        .lines()
        .find_map(|line| line.split_once("Collected :")?.1.trim().parse::<f64>().ok());
    match collected {
        Some(instructions) if instructions > 0.0 => Ok(instructions / (PASSES * SAMPLES) as f64),
        _ => Err(io::Error::other(format!(
            "valgrind counted nothing:\n{text}"
        ))),
    }
}

/// Counts every budgeted step, prints a table, and says whether all keep their budget.
pub fn check() -> io::Result<bool> {
    let mut kept = true;
    println!("{:14} {:30} {:>12} {:>8}", "", "", "instructions", "budget");
    for group in groups::all() {
        for (index, contender) in group.contenders.iter().enumerate() {
            let budget = BUDGETS
                .iter()
                .find(|(key, i, _)| *key == group.key && *i == index)
                .map(|(_, _, budget)| *budget);
            if group.roles[index] == Role::Other && budget.is_none() {
                continue;
            }
            let counted = count(group.key, index)?;
            let verdict = match budget {
                Some(budget) if counted > budget as f64 => "OVER",
                Some(_) => "kept",
                None => "",
            };
            kept &= verdict != "OVER";
            let budget = budget.map_or(String::new(), |budget| budget.to_string());
            println!(
                "{:14} {:34} {counted:8.1} {budget:>8} {verdict}",
                group.key, contender.name
            );
        }
    }
    Ok(kept)
}
