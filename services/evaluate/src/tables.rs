//! The tables of a machine: the requested one, or all of them.

use serde_json::json;

use crate::{Error, Options, Report};

/// A table by its name.
pub struct NamedTable {
    name: &'static str,
    evaluate: fn(&Options) -> Result<Report, Error>,
    /// Divisor of the number of seeds in an evaluation of all tables.
    part: usize,
}

impl NamedTable {
    /// A table that runs every seed.
    pub const fn new(name: &'static str, evaluate: fn(&Options) -> Result<Report, Error>) -> Self {
        Self {
            name,
            evaluate,
            part: 1,
        }
    }

    /// A long table: in an evaluation of all tables its number of seeds is divided by `part`.
    pub const fn one_of(self, part: usize) -> Self {
        Self { part, ..self }
    }
}

/// The requested table, or all of them: then the JSON has one key per table.
///
/// # Errors
/// The table is unknown, or the estimators refuse their settings.
pub fn evaluate(tables: &[NamedTable], options: &Options) -> Result<Report, Error> {
    let Some(name) = &options.table else {
        return everything(tables, options);
    };
    match tables.iter().find(|table| table.name == name) {
        Some(table) => (table.evaluate)(options),
        None => Err(Error::UnknownTable {
            name: name.clone(),
            known: tables.iter().map(|table| table.name).collect(),
        }),
    }
}

fn everything(tables: &[NamedTable], options: &Options) -> Result<Report, Error> {
    let mut all = Report {
        text: String::new(),
        json: json!({}),
        met: true,
    };
    for table in tables {
        let report = (table.evaluate)(&options.one_of(table.part))?;
        all.text += &report.text;
        all.text.push('\n');
        all.json[table.name] = report.json;
        all.met &= report.met;
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seeds(options: &Options) -> Result<Report, Error> {
        Ok(Report {
            text: format!("{} seeds", options.seeds),
            json: json!(options.seeds),
            met: true,
        })
    }

    #[test]
    fn all_tables_have_their_keys_and_a_long_one_runs_fewer_seeds() {
        let tables = [
            NamedTable::new("short", seeds),
            NamedTable::new("long", seeds).one_of(20),
        ];
        let all = evaluate(&tables, &Options::default()).expect("tables");
        assert_eq!(all.json, json!({ "short": 100, "long": 5 }));
        assert!(all.met);
    }

    #[test]
    fn an_unknown_table_is_an_error_that_names_the_known_ones() {
        let options = Options {
            table: Some("weight".to_owned()),
            ..Options::default()
        };
        let refused = evaluate(&[NamedTable::new("conditions", seeds)], &options);
        let message = refused.expect_err("no such table").to_string();
        assert!(message.contains("weight") && message.contains("conditions"));
    }
}
