//! Names of bits and codes in other languages.

use std::fmt::Write;

use messages::words::SIMULATED_ENTRY;
use messages::{Entry, Shape, Words};

/// The bits or codes of one field of a message.
pub(super) struct Enumeration {
    /// Message and field, `ExcavatorEstimate` and `reason`.
    message: &'static str,
    pub(super) field: &'static str,
    pub(super) is_bits: bool,
    pub(super) entries: Vec<Entry>,
}

impl Enumeration {
    /// Those of a message.
    pub(super) fn all(table: &Shape) -> impl Iterator<Item = Self> + use<> {
        let message = table.name;
        table.words.iter().map(move |(field, words)| {
            let (is_bits, entries) = match words {
                Words::Bits(entries) => (true, entries),
                Words::Codes(entries) => (false, entries),
            };
            let mut entries = entries.to_vec();
            if *field == "flags" {
                entries.push(SIMULATED_ENTRY);
            }
            Self {
                message,
                field,
                is_bits,
                entries,
            }
        })
    }

    /// `ExcavatorEstimateReason`.
    pub(super) fn name(&self) -> String {
        let (first, rest) = self.field.split_at(1);
        format!("{}{}{rest}", self.message, first.to_uppercase())
    }

    /// `EXCAVATOR_ESTIMATE_REASON`.
    fn prefix(&self) -> String {
        let mut out = String::new();
        for (i, c) in self.message.chars().enumerate() {
            if c.is_uppercase() && i > 0 {
                out.push('_');
            }
            out.push(c.to_ascii_uppercase());
        }
        out + "_" + &self.field.to_uppercase()
    }

    pub(super) fn proto(&self) -> String {
        let mut out = format!("\nenum {} {{\n", self.name());
        if self.entries.iter().all(|e| e.number != 0) {
            let _ = writeln!(out, "  {}_NONE = 0;", self.prefix());
        }
        for e in &self.entries {
            // An enum of proto3 holds an int32: the highest bit is its sign.
            let number = e.number.cast_signed();
            let _ = writeln!(
                out,
                "  {}_{} = {number};{}",
                self.prefix(),
                constant(e.name),
                comment("//", e)
            );
        }
        out + "}\n"
    }

    pub(super) fn python(&self) -> String {
        let kind = if self.is_bits { "IntFlag" } else { "IntEnum" };
        let mut out = format!("\n\nclass {}(enum.{kind}):\n", self.name());
        for e in &self.entries {
            let _ = writeln!(
                out,
                "    {} = {:#x}{}",
                constant(e.name),
                e.number,
                comment("  #", e)
            );
        }
        out
    }

    pub(super) fn c(&self) -> String {
        let prefix = self.prefix();
        let mut out = String::from("\n");
        for e in &self.entries {
            let number = match self.is_bits {
                true => format!("{:#x}u", e.number),
                false => format!("{}u", e.number),
            };
            let words = match e.doc {
                "" => String::new(),
                doc => format!(" /* {doc} */"),
            };
            let _ = writeln!(
                out,
                "#define HEFT_{prefix}_{} {number}{words}",
                constant(e.name)
            );
        }
        if !self.is_bits {
            let _ = writeln!(
                out,
                "static inline const char *heft_{}_name(uint32_t code) {{\n    switch (code) {{",
                prefix.to_lowercase()
            );
            for e in &self.entries {
                let _ = writeln!(out, "    case {}: return \"{}\";", e.number, e.name);
            }
            out += "    default: return \"unknown\";\n    }\n}\n";
        }
        out
    }

    pub(super) fn json(&self) -> serde_json::Value {
        let entries = self.entries.iter();
        let entries = entries
            .map(|e| serde_json::json!({ "number": e.number, "name": e.name, "meaning": e.doc }));
        entries.collect()
    }

    pub(super) fn markdown(&self) -> String {
        let kind = if self.is_bits { "bit" } else { "code" };
        let mut out = format!(
            "\n`{}`:\n\n| {kind} | name | meaning |\n|---|---|---|\n",
            self.field
        );
        for e in self.entries.iter().filter(|e| !e.name.is_empty()) {
            let number = match self.is_bits {
                true => format!("1 << {}", e.number.trailing_zeros()),
                false => e.number.to_string(),
            };
            let _ = writeln!(out, "| {number} | `{}` | {} |", e.name, e.doc);
        }
        out
    }
}

fn constant(name: &str) -> String {
    match name {
        "" => "NONE".to_owned(),
        name => name.to_uppercase().replace(['-', ' '], "_"),
    }
}

fn comment(sign: &str, entry: &Entry) -> String {
    match entry.doc {
        "" => String::new(),
        doc => format!(" {sign} {doc}"),
    }
}
