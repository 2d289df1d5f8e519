//! The keys of a TOML text, against the tables of a machine.

use messages::Machine;
use toml_edit::{Document, Item, TableLike};

use crate::renamed::{is_retired, today};
use crate::toml_error::{line_of, toml_error, toml_remedy};
use crate::{Error, Errors, Key, Keyed, nearest};

/// One `key = value` of a file.
pub(crate) struct Entry<'a> {
    /// The present name of the key.
    pub(crate) path: String,
    pub(crate) item: &'a Item,
    pub(crate) line: Option<usize>,
}

pub(crate) fn document(text: &str, file: &str) -> Result<Document<String>, Errors> {
    Document::parse(text.to_owned()).map_err(|error| {
        let (line, what) = toml_error(text, &error);
        Errors::from(Error {
            what,
            file: file.into(),
            line,
            key: String::new(),
            remedy: toml_remedy(text, line),
        })
    })
}

/// All leaves of the document, and errors for tables that the machine does not have.
pub(crate) fn entries<'a, M: Keyed>(
    document: &'a Document<String>,
    text: &str,
    file: &str,
) -> (Vec<Entry<'a>>, Vec<Error>) {
    let tables = table_names::<M>();
    let mut walk = Walk {
        machine: M::MACHINE,
        text,
        file,
        tables,
        entries: Vec::new(),
        errors: Vec::new(),
    };
    walk.visit("", document.as_table());
    (walk.entries, walk.errors)
}

struct Walk<'a, 't> {
    machine: Machine,
    text: &'t str,
    file: &'t str,
    tables: Vec<&'static str>,
    entries: Vec<Entry<'a>>,
    errors: Vec<Error>,
}

impl<'a> Walk<'a, '_> {
    fn visit(&mut self, prefix: &str, table: &'a dyn TableLike) {
        for (name, item) in table.iter() {
            let path = if prefix.is_empty() {
                name.to_owned()
            } else {
                format!("{prefix}.{name}")
            };
            let span = table.get_key_value(name).and_then(|(key, _)| key.span());
            let line = span.or_else(|| item.span()).map(|s| line_of(self.text, &s));
            match item.as_table_like() {
                _ if is_retired(self.machine, &path) => {}
                Some(inner) if self.tables.contains(&path.as_str()) => self.visit(&path, inner),
                Some(inner) => self.foreign(path, inner, line),
                None => self.key(today(&path), item, line),
            }
        }
    }

    fn key(&mut self, path: &str, item: &'a Item, line: Option<usize>) {
        let path = path.to_owned();
        if self.entries.iter().any(|entry| entry.path == path) {
            self.errors.push(Error {
                what: format!("{path} is stated twice, once by its old name"),
                file: self.file.into(),
                line,
                key: path,
                remedy: "keep one of them".into(),
            });
            return;
        }
        self.entries.push(Entry { path, item, line });
    }

    fn foreign(&mut self, path: String, inner: &dyn TableLike, line: Option<usize>) {
        let first = inner.iter().next().and_then(|(name, item)| {
            let span = inner.get_key_value(name).and_then(|(key, _)| key.span());
            span.or_else(|| item.span()).map(|s| line_of(self.text, &s))
        });
        let inner_of = |table: &&&str| table.rsplit('.').next() == Some(&path);
        let meant = self.tables.iter().find(inner_of).copied();
        let remedy = match meant.or_else(|| nearest(&path, self.tables.iter().copied())) {
            _ if ["columns", "can", "topics"].contains(&path.as_str()) => OF_A_MAP.into(),
            Some(table) => format!("did you mean [{table}]?"),
            None => format!("the tables are [{}]", self.tables.join("], [")),
        };
        self.errors.push(Error {
            what: format!("there is no table [{path}]"),
            file: self.file.into(),
            line: line.or(first),
            key: path,
            remedy,
        });
    }
}

/// Remedy for a table that belongs to another file.
pub(crate) const OF_A_MAP: &str = "this is of a signal map: give that with --map";

pub(crate) fn find<M: Keyed>(path: &str) -> Option<Key> {
    let machine = M::default();
    let (table, index) = machine.place(path)?;
    Some(machine.tables()[table].keys()[index])
}

pub(crate) fn table_names<M: Keyed>() -> Vec<&'static str> {
    M::default().tables().iter().map(|t| t.name()).collect()
}

/// Whether this is the last part of a key, without its tables.
fn is_without_table<M: Keyed>(path: &str) -> bool {
    let keys = all_keys::<M>();
    keys.iter().any(|key| key.rsplit('.').next() == Some(path))
}

pub(crate) fn known_keys<M: Keyed>(document: &Document<String>, text: &str, file: &str) -> usize {
    let (entries, _) = entries::<M>(document, text, file);
    entries
        .iter()
        .filter(|e| find::<M>(&e.path).is_some() || is_without_table::<M>(&e.path))
        .count()
}

pub(crate) fn all_keys<M: Keyed>() -> Vec<&'static str> {
    let machine = M::default();
    let keys = machine.tables().into_iter().flat_map(|t| t.keys());
    keys.map(|key| key.path).collect()
}
