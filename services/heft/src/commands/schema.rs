//! `heft schema`: the messages in other languages, from their one table.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use messages::channels::{self, Visitor};
use messages::{Field, Machine, Message, NumberType};
use recording::can::Outgoing;

use crate::cli::machine;
use crate::failure::Failure;

/// A language.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// C11, with assertions on sizes and offsets.
    C,
    /// Python: ctypes structures, as iceoryx2 takes them.
    Python,
    /// Protocol Buffers, as in the recording.
    Proto,
    /// JSON: every field with its offset, unit and meaning.
    Json,
    /// DBC: the frames of `heft run --output can:IF`.
    Dbc,
}

/// `heft schema`
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// The language
    #[arg(long, value_enum)]
    pub lang: Language,
    /// With --lang dbc: the machine; every machine if absent
    #[arg(long, value_parser = machine())]
    pub machine: Option<Machine>,
    /// With --lang dbc: the output map of that machine
    #[arg(long, requires = "machine", value_name = "FILE")]
    pub output_map: Option<PathBuf>,
}

/// `heft schema`
pub fn schema(args: &SchemaArgs) -> Result<(), Failure> {
    let text = match args.lang {
        Language::Dbc => dbc(args.machine, args.output_map.as_deref())?,
        language => text(language),
    };
    crate::out::pass(text.as_bytes());
    Ok(())
}

/// The frames of a machine, or of all.
fn dbc(machine: Option<Machine>, map: Option<&Path>) -> Result<String, Failure> {
    let machines = machine.map_or(Machine::ALL.to_vec(), |m| vec![m]);
    let all = machines.iter().map(|m| Outgoing::new(*m, map));
    Ok(Outgoing::dbc(&all.collect::<Result<Vec<_>, _>>()?))
}

fn text(language: Language) -> String {
    let all = tables();
    let mut out = String::from(match language {
        Language::C => C_HEAD,
        Language::Python => PYTHON_HEAD,
        Language::Proto => "syntax = \"proto3\";\npackage heft;\n",
        Language::Json => "{\"messages\": {\n",
        Language::Dbc => "",
    });
    for (n, table) in all.iter().enumerate() {
        out += &match language {
            Language::C => c(table),
            Language::Python => python(table),
            Language::Proto => proto(table),
            Language::Dbc => String::new(),
            Language::Json => json(table) + if n + 1 < all.len() { ",\n" } else { "\n" },
        };
    }
    out += &match language {
        Language::C => "#endif\n".to_owned(),
        Language::Python => channels("CHANNELS = {", "    \"{c}\": {m},", "}"),
        Language::Proto | Language::Dbc => String::new(),
        Language::Json => "}}\n".to_owned(),
    };
    out
}

const C_HEAD: &str = "/* The messages of heft's channels: a sample in shared memory is one of these structures.\n   Written by `heft schema --lang c`. SI units; times in ns are of the host's monotonic clock. */\n#ifndef HEFT_MESSAGES_H\n#define HEFT_MESSAGES_H\n#include <stddef.h>\n#include <stdint.h>\n";
const PYTHON_HEAD: &str = "\"\"\"The messages of heft's channels, written by `heft schema --lang python`. SI units.\"\"\"\nimport ctypes\n\nu32, u64, f64 = ctypes.c_uint32, ctypes.c_uint64, ctypes.c_double\n";

/// A message as other languages see it.
struct Table {
    name: &'static str,
    size: usize,
    fields: &'static [Field],
}

impl Table {
    /// Fields with their offsets: no message has padding.
    fn placed(&self) -> impl Iterator<Item = (usize, &'static Field)> {
        let mut at = 0;
        self.fields.iter().map(move |field| {
            let offset = at;
            at += size(field.kind);
            (offset, field)
        })
    }
}

fn size(kind: NumberType) -> usize {
    match kind {
        NumberType::U32 => 4,
        NumberType::U64 | NumberType::F64 => 8,
    }
}

fn tables() -> Vec<Table> {
    struct Describe;
    impl Visitor for Describe {
        type Output = Table;
        fn visit<M: Message>(self) -> Table {
            Table {
                name: M::NAME,
                size: size_of::<M>(),
                fields: M::FIELDS,
            }
        }
    }
    let mut tables: Vec<Table> = Vec::new();
    for channel in channels::all() {
        let table = channel.payload.visit(Describe);
        if tables.iter().all(|t| t.name != table.name) {
            tables.push(table);
        }
    }
    tables
}

fn channels(head: &str, line: &str, tail: &str) -> String {
    struct Name;
    impl Visitor for Name {
        type Output = &'static str;
        fn visit<M: Message>(self) -> &'static str {
            M::NAME
        }
    }
    let mut out = format!("\n{head}\n");
    for channel in channels::all() {
        let message = channel.payload.visit(Name);
        let line = line.replace("{c}", channel.name).replace("{m}", message);
        let _ = writeln!(out, "{line}");
    }
    out + tail + "\n"
}

/// A field's meaning with its unit.
fn meaning(field: &Field) -> String {
    let doc = field.doc.trim();
    match field.unit {
        "" => doc.to_owned(),
        unit => format!("{doc} [{unit}]"),
    }
}

fn c(table: &Table) -> String {
    let name = table.name;
    let mut out = format!("\ntypedef struct heft_{name} {{\n");
    for field in table.fields {
        let kind = match field.kind {
            NumberType::U32 => "uint32_t",
            NumberType::U64 => "uint64_t",
            NumberType::F64 => "double",
        };
        let _ = writeln!(out, "    {kind} {}; /* {} */", field.name, meaning(field));
    }
    let _ = writeln!(out, "}} heft_{name};");
    let _ = writeln!(
        out,
        "_Static_assert(sizeof(heft_{name}) == {}, \"size of {name}\");",
        table.size
    );
    for (offset, field) in table.placed() {
        let _ = writeln!(
            out,
            "_Static_assert(offsetof(heft_{name}, {0}) == {offset}, \"{name}.{0}\");",
            field.name
        );
    }
    out
}

fn python(table: &Table) -> String {
    let name = table.name;
    let mut out = format!("\n\nclass {name}(ctypes.Structure):\n    _fields_ = [\n");
    for field in table.fields {
        let kind = match field.kind {
            NumberType::U32 => "u32",
            NumberType::U64 => "u64",
            NumberType::F64 => "f64",
        };
        let _ = writeln!(
            out,
            "        (\"{}\", {kind}),  # {}",
            field.name,
            meaning(field)
        );
    }
    let _ = writeln!(
        out,
        "    ]\n\n    @staticmethod\n    def type_name():\n        return \"{name}\"\n\n"
    );
    let _ = writeln!(out, "assert ctypes.sizeof({name}) == {}", table.size);
    out
}

fn proto(table: &Table) -> String {
    let mut out = format!("\nmessage {} {{\n", table.name);
    for (n, field) in table.fields.iter().enumerate() {
        let kind = match field.kind {
            NumberType::U32 => "uint32",
            NumberType::U64 => "uint64",
            NumberType::F64 => "double",
        };
        let _ = writeln!(
            out,
            "  {kind} {} = {}; // {}",
            field.name,
            n + 1,
            meaning(field)
        );
    }
    out + "}\n"
}

fn json(table: &Table) -> String {
    let fields = table.placed().map(|(offset, field)| {
        serde_json::json!({
            "name": field.name,
            "type": format!("{:?}", field.kind).to_lowercase(),
            "offset": offset,
            "unit": field.unit,
            "meaning": field.doc.trim(),
        })
    });
    let value = serde_json::json!({ "size": table.size, "fields": fields.collect::<Vec<_>>() });
    format!("\"{}\": {value}", table.name)
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn a_c_compiler_agrees_with_every_size_and_offset() {
        let dir = tempfile::tempdir().expect("a folder");
        let source = dir.path().join("heft.c");
        let program = text(Language::C) + "int main(void) { return 0; }\n";
        std::fs::write(&source, program).expect("writable");
        let compiler = Command::new("cc")
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"])
            .arg(&source)
            .output();
        let Ok(found) = compiler else {
            println!("skipped: there is no C compiler (cc)");
            return;
        };
        assert!(
            found.status.success(),
            "{}",
            String::from_utf8_lossy(&found.stderr)
        );
    }

    #[test]
    fn no_message_has_padding() {
        for table in tables() {
            let sum: usize = table.fields.iter().map(|f| size(f.kind)).sum();
            assert_eq!(sum, table.size, "{}", table.name);
        }
    }

    #[test]
    fn the_json_is_json() {
        let value: serde_json::Value = serde_json::from_str(&text(Language::Json)).expect("JSON");
        assert_eq!(
            value["messages"]["ExcavatorEstimate"]["fields"][2]["offset"],
            8
        );
    }
}
