//! Estimates of many inputs: each result beside its input, a table at the end.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use config::Description;
use evaluate::text::Table;
use serde_json::Value;
use steps::chain::{chain, method};
use view::number;

use super::args::EstimateArgs;
use crate::args::{described, description, is_of_heft};
use crate::failure::Failure;
use crate::many::{self, Job, Outcome};
use crate::results;

/// Identity of the result beside its input: program, method, signal map, description.
pub fn identity(args: &EstimateArgs, description: &Description, map: Option<&Path>) -> String {
    let smooth = if args.smooth { " --smooth" } else { "" };
    let trust = if args.require_trust {
        " --require-trust"
    } else {
        ""
    };
    let map = map.and_then(|map| std::fs::read(map).ok());
    let map = map.map_or_else(String::new, |map| {
        format!(" map {},", recording::sha256(map))
    });
    format!(
        "{} --method {}{smooth}{trust},{map} description {}",
        crate::build::IDENTITY,
        method(description.machine(), args.with.method.as_deref()),
        recording::sha256(description.to_toml())
    )
}

/// Estimates each input in a process of its own.
pub fn estimate(args: &EstimateArgs) -> Result<(), Failure> {
    if let Some(machine) = args.machine {
        // Errors in the arguments are reported once.
        let description = description(Some(machine), &args.with.description)?;
        chain(&description, method(machine, args.with.method.as_deref()))?;
    }
    if let Some(summary) = &args.summary {
        recording::output::check(summary, &[], many::is_summary)?;
    }
    let inputs = many::inputs(&args.files, true)?;
    let tables = many::beside(&inputs, "estimates.csv");
    let summaries = many::beside(&inputs, "estimates.json");
    let jobs = inputs.iter().zip(tables.iter().zip(&summaries));
    let jobs = jobs.map(|(input, (table, summary))| Job {
        input: input.clone(),
        arguments: arguments(args, input, table, summary),
        is_done: !args.many.again && is_done(args, input, table, summary),
    });
    let jobs: Vec<Job> = jobs.collect();
    let ends = many::run(&jobs, args.many.jobs);
    let rows = inputs.iter().zip(&summaries).zip(&ends);
    let rows: Vec<Row> = rows
        .map(|((input, summary), end)| Row::of(input, summary, end))
        .collect();
    let is_one_failure = matches!(ends.as_slice(), [end] if end.is_bad_input());
    if !is_one_failure {
        print!("{}", terminal(&rows));
    }
    if let Some(file) = &args.summary {
        let table = csv(&rows);
        results::text("write the summary", file, &[], many::is_summary, &table)?;
        println!("{} inputs in {}", rows.len(), file.display());
    }
    many::judge(&ends)
}

fn is_done(args: &EstimateArgs, input: &Path, table: &Path, summary: &Path) -> bool {
    // The process of an input reports its errors.
    let Ok(description) = described(args.machine, &args.with.description, input) else {
        return false;
    };
    let map = map(args, input);
    let same = identity(args, &description, map);
    let parts = recording::Reader::open(input)
        .ok()
        .filter(|_| recording::Kind::is_recording(input));
    let mut sources: Vec<&Path> = parts.iter().flat_map(|r| r.files()).collect();
    sources.push(input);
    sources.extend(map);
    // A doubtful result is computed again, so that its doubt is reported again.
    let is_same = read(summary).is_some_and(|s| {
        let made_by = s.get("heft").and_then(Value::as_str);
        let is_doubtful = s.get("doubt").is_some_and(|doubt| !doubt.is_null());
        made_by.is_some_and(|by| by.ends_with(&same)) && !is_doubtful
    });
    many::is_newer(table, &sources) && many::is_newer(summary, &sources) && is_same
}

/// The map of an input; a recording of heft needs none.
fn map<'a>(args: &'a EstimateArgs, input: &Path) -> Option<&'a Path> {
    args.with.map.as_deref().filter(|_| !is_of_heft(input))
}

fn arguments(args: &EstimateArgs, input: &Path, table: &Path, summary: &Path) -> Vec<OsString> {
    let mut all: Vec<OsString> = vec!["estimate".into()];
    if let Some(machine) = args.machine {
        all.extend(["--machine".into(), machine.name().into()]);
    }
    let mut option = |name: &str, value: &Path| all.extend([name.into(), value.into()]);
    option("--output", table);
    option("--json", summary);
    if let Some(map) = map(args, input) {
        option("--map", map);
    }
    all.extend(args.with.description.again());
    let method = args.with.method.iter();
    all.extend(method.map(|method| format!("--method={method}").into()));
    for (name, given) in [
        ("--smooth", args.smooth),
        ("--require-trust", args.require_trust),
    ] {
        all.extend(given.then(|| name.into()));
    }
    all.extend(["--".into(), input.into()]);
    all
}

fn read(summary: &Path) -> Option<Value> {
    serde_json::from_slice(&std::fs::read(summary).ok()?).ok()
}

/// The row of an input in the table.
struct Row {
    input: PathBuf,
    end: String,
    found: Option<Value>,
}

impl Row {
    fn of(input: &Path, summary: &Path, end: &Outcome) -> Self {
        Self {
            input: input.to_owned(),
            end: end.word().into(),
            // Of a failed run the file may be the summary of an earlier run. A run without trust writes a new one.
            found: read(summary).filter(|_| !end.is_bad_input()),
        }
    }

    fn count(&self, key: &str) -> String {
        let count = self.found.as_ref().and_then(|f| f.get(key)?.as_u64());
        count.map_or(String::new(), |c| c.to_string())
    }

    fn quantities(&self) -> &[Value] {
        let all = self
            .found
            .as_ref()
            .and_then(|f| f.get("quantities")?.as_array());
        all.map_or(&[], Vec::as_slice)
    }

    fn labels(&self) -> Vec<&str> {
        let all = self.quantities().iter();
        all.map(|quantity| text(quantity, "label")).collect()
    }
}

fn text<'a>(quantity: &'a Value, key: &str) -> &'a str {
    quantity
        .get(key)
        .and_then(Value::as_str)
        .unwrap_or_default()
}

/// Value and standard deviation of the last trusted estimate, else of the last one.
fn last_value(quantity: &Value) -> (Option<[f64; 2]>, bool) {
    let trusted = quantity.get("last_trusted").filter(|t| !t.is_null());
    let number = |key| trusted.unwrap_or(quantity).get(key)?.as_f64();
    (
        number("value").zip(number("std")).map(Into::into),
        trusted.is_some(),
    )
}

/// A table for each machine; inputs without a result are in the first.
fn terminal(rows: &[Row]) -> String {
    let mut kinds: Vec<Vec<&str>> = Vec::new();
    for row in rows {
        let labels = row.labels();
        if !labels.is_empty() && !kinds.contains(&labels) {
            kinds.push(labels);
        }
    }
    if kinds.is_empty() {
        kinds.push(Vec::new());
    }
    let of = |at: usize, row: &Row| match row.labels() {
        labels if labels.is_empty() => at == 0,
        labels => labels == kinds[at],
    };
    let tables = (0..kinds.len()).map(|at| {
        let rows: Vec<&Row> = rows.iter().filter(|row| of(at, row)).collect();
        terminal_of(&kinds[at], &rows)
    });
    tables.collect::<Vec<_>>().join("\n")
}

fn terminal_of(labels: &[&str], rows: &[&Row]) -> String {
    let mut header = vec!["input", "rows"];
    for label in labels {
        header.extend([*label, "trusted, of the motion"]);
    }
    header.push("result");
    let mut table = Table::new(&header);
    for row in rows {
        let mut cells = vec![row.input.display().to_string(), row.count("rows")];
        for n in 0..labels.len() {
            let Some(quantity) = row.quantities().get(n) else {
                cells.extend([String::new(), String::new()]);
                continue;
            };
            let (value, trusted) = last_value(quantity);
            let doubt = if trusted { "" } else { " (not trusted)" };
            let value = value.map_or(String::new(), |[v, s]| {
                number::with_std(v, s, &number::unit(text(quantity, "unit")))
            });
            let share = quantity
                .get("trusted_share_in_motion")
                .and_then(Value::as_f64);
            cells.extend([
                value + doubt,
                share.map_or(String::new(), |s| format!("{:.0} %", 100.0 * s)),
            ]);
        }
        cells.push(row.end.clone());
        table.row(cells);
    }
    table.to_string()
}

/// One line per input; a quantity has its value, its standard deviation, whether it was trusted at all, and for which share of the
/// motion.
fn csv(rows: &[Row]) -> String {
    let mut keys: Vec<&str> = Vec::new();
    for quantity in rows.iter().flat_map(Row::quantities) {
        let key = text(quantity, "key");
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let columns = keys
        .iter()
        .map(|k| format!(",{k},{k}_std,{k}_trusted,{k}_trusted_share_in_motion"));
    let mut out = format!(
        "{}rows,refused,seconds{}\n",
        many::SUMMARY,
        columns.collect::<String>()
    );
    for row in rows {
        let seconds = row.found.as_ref().and_then(|f| f.get("seconds")?.as_f64());
        let mut cells = vec![
            recording::csv::quoted(&row.input.display().to_string()),
            recording::csv::quoted(&row.end),
            row.count("rows"),
            row.count("refused"),
            shown(seconds),
        ];
        for key in &keys {
            let its = |q: &&Value| text(q, "key") == *key;
            let quantity = row.quantities().iter().find(its);
            let (value, trusted) = quantity.map_or((None, false), last_value);
            let share = quantity.and_then(|q| q.get("trusted_share_in_motion")?.as_f64());
            cells.extend([
                shown(value.map(|v| v[0])),
                shown(value.map(|v| v[1])),
                quantity.map_or(String::new(), |_| u8::from(trusted).to_string()),
                shown(share),
            ]);
        }
        out += &cells.join(",");
        out.push('\n');
    }
    out
}

fn shown(number: Option<f64>) -> String {
    number.map_or(String::new(), |n| n.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, quantities: &[(&str, f64)]) -> Row {
        let quantities = quantities.iter().map(|(key, value)| {
            serde_json::json!({ "key": key, "label": key, "unit": "", "value": value, "std": 0.1 })
        });
        Row {
            input: name.into(),
            end: "done".into(),
            found: Some(serde_json::json!({ "quantities": quantities.collect::<Vec<_>>() })),
        }
    }

    #[test]
    fn quantities_of_two_machines_stand_under_their_own_names() {
        let rows = [
            row("e.csv", &[("inertia", 8000.0)]),
            row("l.csv", &[("cg_ratio", 0.5), ("cg_height", 0.9)]),
        ];
        let table = csv(&rows);
        let lines: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
        let at = |name| {
            lines[0]
                .iter()
                .position(|head| *head == name)
                .expect("a column")
        };
        assert_eq!(lines[1][at("inertia")], "8000");
        assert_eq!(
            [lines[1][at("cg_ratio")], lines[2][at("inertia")]],
            ["", ""]
        );
        assert_eq!(lines[2][at("cg_height")], "0.9");
        let text = terminal(&rows);
        let (first, second) = text.split_once("\n\n").expect("two tables");
        assert!(
            first.contains("inertia") && !first.contains("cg_ratio"),
            "{text}"
        );
        assert!(
            second.contains("cg_ratio") && !second.contains("e.csv"),
            "{text}"
        );
    }
}
