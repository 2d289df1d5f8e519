//! `heft schema`: the messages in other languages, generated from one table.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use messages::{Field, Machine, NumberType, Shape, channels};
use recording::can::Outgoing;

use crate::args::machine;
use crate::failure::Failure;

mod words;
use words::Enumeration;

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
    /// Markdown: every message, bit and code as a table.
    Markdown,
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
        Language::Markdown => page()?,
        language => text(language),
    };
    crate::out::pass(text.as_bytes());
    Ok(())
}

/// The page of messages, and of frames.
fn page() -> Result<String, Failure> {
    let mut page = text(Language::Markdown) + FRAMES_HEAD;
    for machine in Machine::ALL {
        page += &Outgoing::new(machine, None)?.markdown();
    }
    Ok(page)
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
        Language::Markdown => MARKDOWN_HEAD,
        Language::Dbc => "",
    });
    for (n, table) in all.iter().enumerate() {
        out += &match language {
            Language::C => c(table),
            Language::Python => python(table),
            Language::Proto => proto(table),
            Language::Markdown => markdown(table),
            Language::Dbc => String::new(),
            Language::Json => json(table) + if n + 1 < all.len() { ",\n" } else { "\n" },
        };
    }
    out += &match language {
        Language::C => "#endif\n".to_owned(),
        Language::Python => channels("CHANNELS = {", "    \"{c}\": {m},", "}"),
        Language::Markdown => channels(
            "## Channels\n\n| channel | message |\n|---|---|",
            "| `{c}` | {m} |",
            "",
        ),
        Language::Proto | Language::Dbc => String::new(),
        Language::Json => "}}\n".to_owned(),
    };
    out
}

const C_HEAD: &str = "/* The messages of heft's channels: a sample in shared memory is one of these structures.\n   Written by `heft schema --lang c`. SI units; times in ns are of the host's monotonic clock. */\n#ifndef HEFT_MESSAGES_H\n#define HEFT_MESSAGES_H\n#include <stddef.h>\n#include <stdint.h>\n#ifdef __cplusplus\n#define HEFT_ASSERT static_assert\n#else\n#define HEFT_ASSERT _Static_assert\n#endif\n";
const MARKDOWN_HEAD: &str = "# Messages: fields, bits and codes\n\nWritten by `heft schema --lang markdown`; a test holds it. Units are SI. `heft tail`, `heft.read` and `heft.subscribe` add each flag under its name as a\nboolean, and give `reason` and `method` by name. A flag with the name of a field has `_now` behind it.\nA number without its bit in `valid` or `estimated` is 0 in a message. There it is null, NaN or left out, and in `heft export` an empty cell.\nEvery message begins with the same fields; they stand at the first message alone.\n";
const FRAMES_HEAD: &str = "## Frames on a CAN bus\n\n`heft run --output can:IF` sends each of these ten times a second; `--output-map` chooses others ([on the machine](run.md)). The identifier has 29 bits,\nas J1939 has them: priority 6, the group, the source address (0x80 unless another node has it). `heft schema --lang dbc` writes them as a DBC file.\nThe least significant byte is first. All ones are *not available*: the value is not trusted, or nobody knows it. A flag has two bits, 0 for no and 1 for\nyes. `reason` has the codes above.\n";
const PYTHON_HEAD: &str = "\"\"\"The messages of heft's channels, written by `heft schema --lang python`. SI units.\"\"\"\nimport ctypes\nimport enum\n\nu32, u64, f64 = ctypes.c_uint32, ctypes.c_uint64, ctypes.c_double\n";

/// Fields with their offsets: no message has padding.
fn placed(table: &Shape) -> impl Iterator<Item = (usize, &'static Field)> + use<> {
    let mut at = 0;
    table.fields.iter().map(move |field| {
        let offset = at;
        at += size(field.kind);
        (offset, field)
    })
}

fn size(kind: NumberType) -> usize {
    match kind {
        NumberType::U32 => 4,
        NumberType::U64 | NumberType::F64 => 8,
    }
}

fn tables() -> Vec<Shape> {
    let mut tables: Vec<Shape> = Vec::new();
    for table in channels::all().map(|channel| channel.payload.shape()) {
        if tables.iter().all(|t| t.name != table.name) {
            tables.push(table);
        }
    }
    tables
}

fn channels(head: &str, line: &str, tail: &str) -> String {
    let mut out = format!("\n{head}\n");
    for channel in channels::all() {
        let message = channel.payload.shape().name;
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

fn c(table: &Shape) -> String {
    let name = table.name;
    let mut out: String = Enumeration::all(table).map(|e| e.c()).collect();
    let _ = writeln!(out, "\ntypedef struct heft_{name} {{");
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
        "HEFT_ASSERT(sizeof(heft_{name}) == {}, \"size of {name}\");",
        table.size
    );
    for (offset, field) in placed(table) {
        let _ = writeln!(
            out,
            "HEFT_ASSERT(offsetof(heft_{name}, {0}) == {offset}, \"{name}.{0}\");",
            field.name
        );
    }
    out
}

fn python(table: &Shape) -> String {
    let name = table.name;
    let mut out: String = Enumeration::all(table).map(|e| e.python()).collect();
    let _ = writeln!(out, "\n\nclass {name}(ctypes.Structure):\n    _fields_ = [");
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
        "    ]\n\n    @staticmethod\n    def type_name() -> str:\n        return \"{name}\"\n\n"
    );
    let _ = writeln!(out, "assert ctypes.sizeof({name}) == {}", table.size);
    out
}

fn proto(table: &Shape) -> String {
    let mut out: String = Enumeration::all(table).map(|e| e.proto()).collect();
    let _ = writeln!(out, "\nmessage {} {{", table.name);
    for (n, field) in table.fields.iter().enumerate() {
        let codes = Enumeration::all(table).filter(|e| !e.is_bits);
        let named = codes.filter(|e| e.field == field.name).map(|e| e.name());
        let kind = named.last().unwrap_or_else(|| match field.kind {
            NumberType::U32 => "uint32".into(),
            NumberType::U64 => "uint64".into(),
            NumberType::F64 => "double".into(),
        });
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

fn json(table: &Shape) -> String {
    let fields = placed(table).map(|(offset, field)| {
        let mut row = serde_json::json!({
            "name": field.name,
            "type": format!("{:?}", field.kind).to_lowercase(),
            "offset": offset,
            "unit": field.unit,
            "meaning": field.doc.trim(),
        });
        for e in Enumeration::all(table).filter(|e| e.field == field.name) {
            row[if e.is_bits { "bits" } else { "codes" }] = e.json();
        }
        row
    });
    let value = serde_json::json!({ "size": table.size, "fields": fields.collect::<Vec<_>>() });
    format!("\"{}\": {value}", table.name)
}

fn markdown(table: &Shape) -> String {
    let mut out = format!(
        "\n## {}\n\n| field | type | unit | meaning |\n|---|---|---|---|\n",
        table.name
    );
    let is_first = table.name == "ExcavatorSensors";
    let own = if is_first { 0 } else { messages::HEAD };
    for field in table.fields.iter().skip(own) {
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} |",
            field.name,
            format!("{:?}", field.kind).to_lowercase(),
            field.unit,
            field.doc.trim()
        );
    }
    let all = Enumeration::all(table).filter(|e| e.field != "columns");
    out + &all.map(|e| e.markdown()).collect::<String>()
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::process::Command;

    use super::*;

    /// Skipped without such a compiler.
    fn compiles(compiler: &str, standard: &str, file: &str, main: &str) {
        let dir = tempfile::tempdir().expect("a folder");
        let source = dir.path().join(file);
        std::fs::write(&source, text(Language::C) + main).expect("writable");
        let compiled = Command::new(compiler)
            .args([standard, "-Wall", "-Wextra", "-Werror", "-fsyntax-only"])
            .arg(&source)
            .output();
        let Ok(found) = compiled else {
            let _ = writeln!(
                std::io::stderr(),
                "skipped: there is no compiler {compiler}"
            );
            return;
        };
        let said = String::from_utf8_lossy(&found.stderr);
        assert!(found.status.success(), "{said}");
    }

    #[test]
    fn a_c_compiler_agrees_with_every_size_and_offset() {
        compiles("cc", "-std=c11", "heft.c", "int main(void) { return 0; }\n");
    }

    #[test]
    fn a_cpp_compiler_takes_the_header_too() {
        let main = "int main() { return heft_loader_estimate_reason_name(1)[0] == 'm' ? 0 : 1; }\n";
        compiles("c++", "-std=c++17", "heft.cpp", main);
    }

    #[test]
    fn the_page_of_messages_is_current() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/messages.md");
        let page = std::fs::read_to_string(path).expect("docs/messages.md");
        assert!(
            page == super::page().expect("frames"),
            "run `heft schema --lang markdown > docs/messages.md`"
        );
    }

    #[test]
    fn the_json_names_bits_and_codes() {
        let value: serde_json::Value = serde_json::from_str(&text(Language::Json)).expect("JSON");
        let fields = value["messages"]["LoaderEstimate"]["fields"].as_array();
        let field = |name: &str| {
            let found = fields.and_then(|f| f.iter().find(|f| f["name"] == name));
            found.cloned().expect("a field")
        };
        assert_eq!(field("flags")["bits"][8]["name"], "trusted_ratio");
        assert_eq!(field("flags")["bits"][8]["number"], 256);
        assert_eq!(field("reason")["codes"][14]["name"], "slope");
        assert_eq!(field("method")["codes"][0]["name"], "full");
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
