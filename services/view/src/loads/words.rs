//! Loads, trucks, sums and times in words.

use std::fmt::Write;

use estimation::loads::{Load, Stage, Total, Truck, Weight};
use messages::Machine;
use steps::loads::why_words;

use crate::number::{interval_95, value_and_std};

/// "1 121 kg, 95 %: 872 to 1 370".
fn weight_words(weight: &Weight) -> String {
    let (kg, _) = value_and_std(weight.kg, weight.std);
    format!("{kg} kg, 95 %: {}", interval_95(weight.kg, weight.std))
}

/// A load in a line.
pub fn line(machine: Machine, load: &Load) -> String {
    let why = why_words(machine, load);
    let doubt = if load.trusted {
        ", trusted".to_owned()
    } else {
        format!(", not trusted: {why}")
    };
    let rest = if load.carry_back_weighed {
        let (kg, _) = value_and_std(load.carry_back.kg, load.carry_back.std);
        format!(", {kg} kg left in the bucket")
    } else {
        String::new()
    };
    // The next weighing is the last that changes it.
    let stage = match load.stage {
        Stage::Settled => "final",
        stage => stage.name(),
    };
    format!(
        "load {} {stage}: {} (by {}){rest}{doubt}",
        load.number,
        weight_words(&load.weight),
        load.witness.name(),
    )
}

/// A truck in a line.
pub fn truck_line(truck: &Truck) -> String {
    let total = &truck.total;
    let mut text = format!("truck {}: {}", truck.number, total_words(total));
    if let Some(missing) = truck.remaining() {
        let (amount, _) = value_and_std(missing.abs(), total.std().max(1.0));
        let what = if missing >= 0.0 {
            "missing"
        } else {
            "too much"
        };
        let _ = write!(text, "; {amount} kg {what}");
    }
    text
}

/// A sum in words.
pub fn total_words(total: &Total) -> String {
    let (kg, _) = value_and_std(total.kg, total.std().max(1.0));
    let plural = if total.loads == 1 { "" } else { "s" };
    let of_them = |n: u32, what: &str| match n {
        0 => String::new(),
        n => format!(", {n} of them not {what}"),
    };
    let doubt = of_them(total.unweighed, "weighed") + &of_them(total.untrusted, "trusted");
    format!(
        "{kg} kg, 95 %: {}, in {} load{plural}{doubt}",
        interval_95(total.kg, total.std().max(1.0)),
        total.loads
    )
}

/// Seconds of a recording for people: "1:02:03", or the time of day in UTC if they count from 1970.
pub fn clock(time: f64) -> String {
    const DAY: f64 = 86_400.0;
    const SINCE_1970: f64 = 1e9;
    if time < 0.0 {
        return format!("-{}", clock(-time));
    }
    // Rounded first, because 24:00:00 does not exist.
    let rounded = (time * 10.0).round();
    let tenths = if time >= SINCE_1970 {
        rounded.rem_euclid(10.0 * DAY)
    } else {
        rounded
    } as i64;
    let (seconds, tenths) = (tenths.div_euclid(10), tenths.rem_euclid(10));
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if time >= SINCE_1970 {
        format!("{hours:02}:{minutes:02}:{seconds:02} UTC")
    } else if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes}:{seconds:02}.{tenths}")
    }
}
