//! Loads as a table.

use estimation::loads::Load;
use messages::Machine;
use steps::loads::why_words;

use super::Account;

/// First columns of a table of loads.
const FIRST: &str = "recording,load,truck,day,";

/// Header of the table.
const HEADER: &str = "recording,load,truck,day,filled,dumped,kg,kg_std,kg_low,kg_high,carry_back,carry_back_std,\
    carry_back_weighed,delivered,delivered_std,common_std,witness,trusted,reason,stage";

/// A line of the table.
fn csv_line(name: &str, machine: Machine, load: &Load) -> String {
    let [low, high] = load.weight.interval();
    let delivered = load.delivered();
    let dumped = load.dumped.map_or(String::new(), |t| format!("{t:.2}"));
    format!(
        "{},{},{},{},{:.2},{dumped},{:.1},{:.1},{low:.1},{high:.1},{:.1},{:.1},{},{:.1},{:.1},{:.1},{},{},{},{}",
        recording::csv::quoted(name),
        load.number,
        load.truck,
        load.day,
        load.filled,
        load.weight.kg,
        load.weight.std,
        load.carry_back.kg,
        load.carry_back.std,
        u8::from(load.carry_back_weighed),
        delivered.kg,
        delivered.std,
        load.weight.common_std,
        load.witness.name(),
        u8::from(load.trusted),
        recording::csv::quoted(why_words(machine, load)),
        load.stage.name(),
    )
}

/// The table of all accounts.
pub fn csv(accounts: &[Account]) -> String {
    let mut out = format!("{HEADER}\n");
    for account in accounts {
        let all = account.loads.iter().chain(&account.carried);
        for load in all {
            out += &csv_line(&account.name, account.machine, load);
            out.push('\n');
        }
    }
    out
}

/// Whether a file with this beginning is such a table.
pub fn is_csv(head: &[u8]) -> bool {
    head.starts_with(FIRST.as_bytes())
}
