//! Parses TOML text to a description, by the table of keys alone.

use toml_edit::Item;

use messages::Machine;

use crate::class::mass_key;
use crate::entries::{Entry, OF_A_MAP, all_keys, document, entries, find, table_names};
use crate::renamed::{is_retired, today};
use crate::toml_error::line_of;
use crate::{
    Error, Errors, Form, Keyed, Numbers, Range, Table, Value, known, nearest, print, stated,
};

/// Parses a text. `class`: mass of the machine where the text states none \[kg\].
pub(crate) fn parse<M: Keyed>(text: &str, file: &str, class: Option<f64>) -> Result<M, Errors> {
    let document = document(text, file)?;
    let mut machine = M::default();
    let (mut entries, mut errors) = entries::<M>(&document, text, file);
    leave_out_what_was_printed::<M>(&mut entries);
    let mass = mass_key(M::MACHINE);
    let class = class.filter(|_| !states::<M>(text, mass));
    for entry in &entries {
        let outcome = value_of(entry.item)
            .map_err(Defect::Form)
            .and_then(|value| assign(&mut machine, &entry.path, &value));
        if let Err(defect) = outcome {
            errors.push(explain::<M>(defect, &entry.path, file, entry.line));
        }
    }
    if errors.is_empty() {
        // If all of the reference machine is printed, none of it is stated.
        if is_reference::<M>(&entries) {
            entries.iter().for_each(|e| machine.note(&e.path, false));
        }
        let set_class = |machine: &mut M| match class {
            Some(class) => assign(machine, mass, &Value::Number(class))
                .map_err(|defect| explain::<M>(defect, mass, file, None)),
            None => Ok(()),
        };
        set_class(&mut machine)?;
        machine = machine.of_its_size();
        for entry in &entries {
            // Each value has been accepted above.
            let _ = value_of(entry.item).map(|value| set_value(&mut machine, &entry.path, &value));
        }
        set_class(&mut machine)?;
        errors = machine.contradictions();
        for error in &mut errors {
            error.file = file.into();
            error.line = entries
                .iter()
                .find(|e| e.path == error.key)
                .and_then(|e| e.line);
        }
    }
    if errors.is_empty() {
        Ok(machine)
    } else {
        errors.sort_by_key(|e| e.line);
        Err(Errors(errors))
    }
}

/// Ratio of masses above which, or below whose inverse, a machine is another one than the reference machine.
const ANOTHER: f64 = 1.5;

/// Leaves out printed defaults. A file with all keys of the reference machine's size and another mass was printed by heft, and edited
/// where values were known. Its keys that are still at their default are not stated.
fn leave_out_what_was_printed<M: Keyed>(entries: &mut Vec<Entry<'_>>) {
    let (_, reference) = M::REFERENCE;
    let mass = entries.iter().find(|e| e.path == mass_key(M::MACHINE));
    let is_another = match mass.map(|entry| value_of(entry.item)) {
        Some(Ok(Value::Number(mass))) => (mass / reference).max(reference / mass) > ANOTHER,
        _ => false,
    };
    if is_another && is_reference::<M>(entries) {
        entries.retain(|entry| !is_default::<M>(entry));
    }
}

/// Whether a file states a key at its default.
fn is_default<M: Keyed>(entry: &Entry<'_>) -> bool {
    let value = value_of(entry.item).ok();
    value.is_some_and(|value| default_of::<M>(&entry.path) == Some(value))
}

/// The default of a key.
fn default_of<M: Keyed>(path: &str) -> Option<Value<'static>> {
    let machine = M::default();
    let (table, index) = machine.place(path)?;
    machine.tables()[table].get(index)
}

/// Applies `--set` options in their order; only the result must be free of contradictions.
pub(crate) fn set_all<M: Keyed>(
    machine: &mut M,
    assignments: &[impl AsRef<str>],
) -> Result<(), Error> {
    let mut changed = machine.clone();
    for assignment in assignments {
        set_one(&mut changed, assignment.as_ref())?;
    }
    if follow(machine, &mut changed) {
        for assignment in assignments {
            set_one(&mut changed, assignment.as_ref())?;
        }
    }
    if let Some(mut error) = changed.contradictions().into_iter().next() {
        let options = assignments.iter().map(|a| format!("--set {}", a.as_ref()));
        error.file = options.collect::<Vec<_>>().join(" ");
        return Err(error);
    }
    *machine = changed;
    Ok(())
}

/// Sets keys that are not stated, and so have the value of the machine's size `before`, to that of the size `changed`. Returns whether
/// there are any.
fn follow<M: Keyed>(before: &M, changed: &mut M) -> bool {
    let plain = M::default();
    let places = stated::places(before).into_iter();
    let unstated: Vec<_> = places
        .filter(|place| !place.1)
        .map(|place| place.0)
        .collect();
    let mut open = changed.clone();
    for &(at, index) in &unstated {
        if open.tables()[at].get(index) == before.tables()[at].get(index) {
            copy(&plain, &mut open, (at, index));
        }
    }
    let sized = open.of_its_size();
    let mut any = false;
    for place in unstated {
        any |= copy(&sized, changed, place);
    }
    any
}

/// Copies one value, given by its table and index; true if it differs.
fn copy<M: Keyed>(from: &M, to: &mut M, (at, index): (usize, usize)) -> bool {
    let tables = from.tables();
    let Some(value) = tables[at].get(index) else {
        return false;
    };
    let mut tables = to.tables_mut();
    if tables[at].get(index) == Some(value) {
        return false;
    }
    tables[at].set(index, &value)
}

fn set_one<M: Keyed>(machine: &mut M, assignment: &str) -> Result<(), Error> {
    let file = format!("--set {assignment}");
    let Some((path, text)) = assignment.split_once('=') else {
        return Err(Error {
            what: "no = between key and value".into(),
            file,
            line: None,
            key: String::new(),
            remedy: "write it like --set sensors.rate=100".into(),
        });
    };
    let (path, text) = (today(path.trim()), text.trim());
    if is_retired(M::MACHINE, path) {
        return Ok(());
    }
    let item = match text.parse::<toml_edit::Value>() {
        Ok(value) => Item::Value(value),
        Err(_) => numbers::<M>(path, text).unwrap_or_else(|| toml_edit::value(text)), // a word without its quotes
    };
    value_of(&item)
        .map_err(Defect::Form)
        .and_then(|value| assign(machine, path, &value))
        .map_err(|defect| explain::<M>(defect, path, &file, None))
}

/// Numbers in forms that TOML does not accept (`.05`, `5.`, `007`), for a key that takes some.
fn numbers<M: Keyed>(path: &str, text: &str) -> Option<Item> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    match find::<M>(path)?.form {
        Form::Number | Form::OptionalNumber | Form::Count => number(text).map(toml_edit::value),
        Form::List(_) | Form::Numbers => {
            let items = text.strip_prefix('[').and_then(|t| t.strip_suffix(']'));
            let items = items.unwrap_or(text).split(',').map(number);
            let list: toml_edit::Array = items.collect::<Option<Vec<f64>>>()?.into_iter().collect();
            Some(toml_edit::value(list))
        }
        Form::Flag | Form::Choice(_) => None,
    }
}

/// The machine that the text names, or else the one with more of its keys in the text. `None` if it
/// names none and both have the same number.
pub(crate) fn machine(text: &str, file: &str) -> Result<Option<Machine>, Errors> {
    let document = document(text, file)?;
    let named = document.get("machine").and_then(|m| m.get("kind"));
    let named = named.or_else(|| document.get("kind"));
    if let Some(kind) = named {
        let machine = kind.as_str().and_then(Machine::from_name);
        return match machine {
            Some(machine) => Ok(Some(machine)),
            None => Err(no_machine(kind, text, file).into()),
        };
    }
    let mut known = Machine::ALL.map(|machine| {
        let keys = known::known_keys(machine, &document, text, file);
        (keys, machine)
    });
    known.sort();
    Ok(match known {
        [.., (second, _), (most, machine)] if most > second => Some(machine),
        _ => None,
    })
}

/// Whether a text states a key, at any value. A printed description of the reference machine states none.
pub(crate) fn states<M: Keyed>(text: &str, key: &str) -> bool {
    let Ok(document) = document(text, "") else {
        return false;
    };
    let (entries, _) = entries::<M>(&document, text, "");
    let is_none = |entry: &Entry| value_of(entry.item) == Ok(Value::None);
    let entry = entries.iter().find(|e| e.path == key && !is_none(e));
    entry.is_some_and(|entry| !(is_default::<M>(entry) && is_reference::<M>(&entries)))
}

/// Whether a file has all keys of the reference machine's size at their defaults.
fn is_reference<M: Keyed>(entries: &[Entry<'_>]) -> bool {
    let of = |key: &str| entries.iter().find(|entry| entry.path == key);
    let mut keys = M::REFERENCE.0.iter();
    keys.all(|key| of(key).is_some_and(is_default::<M>))
}

/// Error for a key or table that is nearly one of this machine's, or for a table of a signal map.
pub(crate) fn misspelt<M: Keyed>(text: &str, file: &str) -> Option<Error> {
    let document = document(text, file).ok()?;
    let (entries, errors) = entries::<M>(&document, text, file);
    let is_near = |remedy: &str| remedy.starts_with("did you mean") || remedy == OF_A_MAP;
    let table = errors.into_iter().find(|error| is_near(&error.remedy));
    table.or_else(|| {
        let mut all = entries.iter().filter(|e| find::<M>(&e.path).is_none());
        all.find_map(|e| {
            let error = explain::<M>(Defect::Unknown, &e.path, file, e.line);
            is_near(&error.remedy).then_some(error)
        })
    })
}

/// Error for a machine that heft does not know.
fn no_machine(kind: &Item, text: &str, file: &str) -> Error {
    let kinds = Machine::ALL.map(|m| format!("kind = \"{m}\"")).join(" or ");
    let span = kind.span();
    let written = span.clone().and_then(|span| text.get(span));
    Error {
        what: format!("there is no machine {}", written.unwrap_or("of this kind")),
        file: file.into(),
        line: span.map(|span| line_of(text, &span)),
        key: "machine.kind".into(),
        remedy: format!("write {kinds}"),
    }
}

/// The value of an item, or its kind if it has none.
fn value_of(item: &Item) -> Result<Value<'_>, &'static str> {
    use toml_edit::Value as Toml;
    match item.as_value() {
        Some(Toml::String(s)) if s.value() == "none" => Ok(Value::None),
        Some(Toml::String(s)) => Ok(Value::Word(s.value())),
        Some(Toml::Integer(i)) => Ok(Value::Number(*i.value() as f64)),
        Some(Toml::Float(x)) => Ok(Value::Number(*x.value())),
        Some(Toml::Boolean(b)) => Ok(Value::Flag(*b.value())),
        Some(Toml::Array(list)) => list
            .iter()
            .map(|v| v.as_float().or(v.as_integer().map(|i| i as f64)))
            .collect::<Option<Vec<f64>>>()
            .ok_or("a list with something else than numbers")
            .and_then(|list| Numbers::new(&list).ok_or("a list of more than eight numbers"))
            .map(Value::Numbers),
        Some(Toml::Datetime(_)) => Err("a date"),
        Some(Toml::InlineTable(_)) | None => Err("a table"),
    }
}

/// Why a value was not accepted.
enum Defect {
    /// There is no such key.
    Unknown,
    /// It does not have the key's form; the text is its kind.
    Form(&'static str),
    /// This number is outside the range.
    Outside(f64),
    /// The description is for another machine.
    OtherMachine,
}

fn assign<M: Keyed>(machine: &mut M, path: &str, value: &Value) -> Result<(), Defect> {
    set_value(machine, path, value)?;
    machine.note(path, default_of::<M>(path) == Some(*value));
    Ok(())
}

fn set_value<M: Keyed>(machine: &mut M, path: &str, value: &Value) -> Result<(), Defect> {
    if path == "machine.kind" {
        let same = *value == Value::Word(M::MACHINE.name());
        return if same {
            Ok(())
        } else {
            Err(Defect::OtherMachine)
        };
    }
    let (table, index) = machine.place(path).ok_or(Defect::Unknown)?;
    store(machine.tables_mut().swap_remove(table), index, value)
}

fn store(table: &mut dyn Table, index: usize, value: &Value) -> Result<(), Defect> {
    let outside = table.keys()[index].range.and_then(|r| value.outside(r));
    if let Some(number) = outside {
        return Err(Defect::Outside(number));
    }
    if table.set(index, value) {
        Ok(())
    } else {
        Err(Defect::Form(match value {
            Value::Number(_) => "a number",
            Value::None => "\"none\"",
            Value::Flag(_) => "true or false",
            Value::Word(_) => "a word",
            Value::Numbers(_) => "a list of numbers",
        }))
    }
}

fn explain<M: Keyed>(defect: Defect, path: &str, file: &str, line: Option<usize>) -> Error {
    let key = find::<M>(path);
    let (what, remedy) = match (defect, key) {
        (Defect::OtherMachine, _) => (
            format!(
                "machine.kind is not \"{}\", for which the machine file is read",
                M::MACHINE
            ),
            format!(
                "write kind = \"{}\" or use the machine file with the other machine",
                M::MACHINE
            ),
        ),
        (Defect::Outside(number), Some(key)) if Range::is_tiny(number) => (
            format!(
                "{path} is {}: nearer to 0 than anything of a machine is",
                print::with_unit(number, key.unit)
            ),
            format!("give {}", print::expected(&key)),
        ),
        (Defect::Outside(number), Some(key)) => (
            format!(
                "{path} is {}, outside {}",
                print::with_unit(number, key.unit),
                print::limits(&key)
            ),
            format!("give {}", print::expected(&key)),
        ),
        (Defect::Form(found), Some(key)) => (
            format!("{path} is {found}; it takes {}", print::expected(&key)),
            format!("write it like {} = {}", key.name, print::example::<M>(path)),
        ),
        (_, _) => (
            format!("the {} has no key {path}", M::MACHINE),
            suggestion::<M>(path),
        ),
    };
    Error {
        what,
        file: file.into(),
        line,
        key: path.into(),
        remedy,
    }
}

fn suggestion<M: Keyed>(path: &str) -> String {
    if path == "kind" {
        return "the key is machine.kind: put it under [machine]".into();
    }
    let name = path.rsplit('.').next().unwrap_or(path);
    let keys = all_keys::<M>();
    let elsewhere = keys.iter().find(|k| k.rsplit('.').next() == Some(name));
    let similar = nearest(path, keys.iter().copied()).or_else(|| {
        let last = keys.iter().filter_map(|k| k.rsplit('.').next());
        let close = nearest(name, last)?;
        let full = keys.iter().find(|k| k.rsplit('.').next() == Some(close))?;
        Some(*full)
    });
    let belongs = |other: &Machine| {
        let keys = known::keys(*other);
        let is_its = |key: &&str| *key == path || key.rsplit('.').next() == Some(path);
        *other != M::MACHINE && keys.iter().any(is_its)
    };
    let other = Machine::ALL.into_iter().find(belongs);
    match (elsewhere, other, similar) {
        (Some(full), ..) => format!("the key is {full}: put it under [{}]", table_of(full)),
        (None, Some(other), _) => {
            format!("{path} belongs to the {other}; leave it out here")
        }
        (None, None, Some(full)) => format!("did you mean {full}?"),
        (None, None, None) => match keys_of::<M>(table_of(path)) {
            Some(names) => format!("the keys of [{}] are {names}", table_of(path)),
            None => format!("the tables are [{}]", table_names::<M>().join("], [")),
        },
    }
}

fn keys_of<M: Keyed>(table: &str) -> Option<String> {
    let machine = M::default();
    let tables = machine.tables();
    let table = tables.iter().find(|t| t.name() == table)?;
    let names: Vec<&str> = table.keys().iter().map(|k| k.name).collect();
    Some(names.join(", "))
}

fn table_of(path: &str) -> &str {
    path.rsplit_once('.').map_or(path, |(table, _)| table)
}
