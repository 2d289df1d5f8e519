//! Prints a description: the whole table of keys with comments.

use std::fmt::Write;

use crate::{Form, Key, Keyed, Numbers, Range, Value};

pub(crate) fn print<M: Keyed>(machine: &M) -> String {
    let mut out = String::new();
    for (i, table) in machine.tables().iter().enumerate() {
        let gap = if i == 0 { "" } else { "\n" };
        let _ = writeln!(out, "{gap}[{}]", table.name());
        if i == 0 {
            let _ = writeln!(out, "# Which machine.\nkind = \"{}\"", M::MACHINE);
        }
        for (index, key) in table.keys().iter().enumerate() {
            if let Some(value) = table.get(index) {
                let _ = writeln!(out, "{}\n{} = {}", comment(key), key.name, toml(&value));
            }
        }
    }
    out
}

fn comment(key: &Key) -> String {
    let takes = match key.form {
        Form::Flag => String::new(),
        _ => format!(" [{}]", expected(key)),
    };
    format!("#{}{takes}", key.doc)
}

/// A value in TOML; a number with the fewest digits that restore it to the last bit.
pub(crate) fn toml(value: &Value) -> String {
    match value {
        Value::Number(x) => number(*x),
        Value::None => "\"none\"".into(),
        Value::Flag(x) => x.to_string(),
        Value::Word(word) => format!("\"{word}\""),
        Value::Numbers(list) => {
            let items: Vec<String> = list.iter().map(|x| number(*x)).collect();
            format!("[{}]", items.join(", "))
        }
    }
}

fn number(x: f64) -> String {
    format!("{x:?}")
}

/// Form and range of a key's value, as text.
pub(crate) fn expected(key: &Key) -> String {
    match key.form {
        Form::Number => format!("a number {}", limits(key)),
        Form::OptionalNumber => format!("a number {}, or \"none\"", limits(key)),
        Form::Count => format!("a whole number {}", limits(key)),
        Form::Flag => "true or false".into(),
        Form::Choice(words) => format!("\"{}\"", words.join("\" or \"")),
        Form::List(n) => format!("a list of {n} numbers {}", limits(key)),
        Form::Numbers => {
            format!(
                "a list of at most {} numbers {}",
                Numbers::MOST,
                limits(key)
            )
        }
    }
}

/// The range of a key with its unit.
pub(crate) fn limits(key: &Key) -> String {
    match key.range {
        Some(Range { low, high }) => {
            let high = with_unit(high, key.unit);
            format!("from {} to {high}", short(low))
        }
        None => key.unit.into(),
    }
}

/// A number with its unit.
pub(crate) fn with_unit(x: f64, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    format!("{}{space}{unit}", short(x))
}

fn short(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e6 {
        format!("{x:.0}")
    } else if x.abs() >= 1e6 {
        format!("{x:e}")
    } else {
        format!("{x:?}")
    }
}

/// A number of one digit within a range, in the middle of its orders of magnitude.
fn within(Range { low, high }: Range) -> f64 {
    let middle = if low > 0.0 {
        (low * high).sqrt()
    } else {
        0.5 * (low + high)
    };
    let digit = 10_f64.powf(middle.abs().max(f64::MIN_POSITIVE).log10().floor());
    let round = (middle / digit).round() * digit;
    if (low..=high).contains(&round) {
        round
    } else {
        middle
    }
}

/// The default of a key, as an example of its form; a number within its range where it has none.
pub(crate) fn example<M: Keyed>(path: &str) -> String {
    let machine = M::default();
    let Some((table, index)) = machine.place(path) else {
        return String::new();
    };
    let table = machine.tables()[table];
    match (table.get(index), table.keys()[index].range) {
        (Some(Value::None), Some(range)) => short(within(range)),
        (value, _) => value.map_or_else(String::new, |v| toml(&v)),
    }
}
