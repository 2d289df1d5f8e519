//! The frames as a table in Markdown.

use std::fmt::Write;

use super::{Content, Kind, Outgoing};

impl Outgoing {
    /// A row per frame, in Markdown: parameter group, name, content of its bytes and bits.
    pub fn markdown(&self) -> String {
        let mut out = format!(
            "\n### Frames of the {}\n\n| group | frame | content |\n|---|---|---|\n",
            self.machine
        );
        let grouped = self.kinds.iter().filter_map(|k| Some((k.group()?, k)));
        let mut grouped: Vec<_> = grouped.collect();
        grouped.sort_by_key(|(group, _)| *group);
        for (group, kind) in grouped {
            let _ = writeln!(out, "| 0x{group:x} | `{}` | {} |", kind.name, kind.layout());
        }
        out
    }
}

impl Kind {
    fn layout(&self) -> String {
        match &self.content {
            Content::Quantity(_, row) => {
                let from = match row.offset {
                    0.0 => String::new(),
                    offset => format!(", value from {offset}"),
                };
                let resolution = format!("{} {}", row.scale, row.unit);
                format!(
                    "bytes 0-3 `{}`, 4-7 `{}`; one bit is {}{from}",
                    row.field,
                    row.std_field,
                    resolution.trim_end()
                )
            }
            Content::Flags(flags, numbers) => {
                let flags = flags.iter().map(|(flag, _)| format!("`{flag}`"));
                let numbers = numbers
                    .iter()
                    .map(|(_, n)| format!("{}-{} `{}`", n.at, n.at + n.bits - 1, n.field));
                format!(
                    "flags from bit 0 on: {}. Bits {}",
                    flags.collect::<Vec<_>>().join(", "),
                    numbers.collect::<Vec<_>>().join(", ")
                )
            }
        }
    }
}
