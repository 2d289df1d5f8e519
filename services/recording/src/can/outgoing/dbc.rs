//! The DBC of the frames.

use std::fmt::Write;

use messages::{Carries, Machine};

use super::{Content, Kind, LARGEST, NOT_AVAILABLE, Outgoing};
use crate::machines;

/// Attributes that mark extended frames as J1939.
const ATTRIBUTES: &str = r#"
BA_DEF_ "ProtocolType" STRING ;
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BU_ "NmStationAddress" INT 0 253;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_DEF_DEF_ "NmStationAddress" 128;
BA_DEF_DEF_ "ProtocolType" "";
BA_DEF_DEF_ "VFrameFormat" "J1939PG";
BA_ "ProtocolType" "J1939";
"#;
/// Values of the two bits of a flag.
const WORDS: &str = r#"0 "no" 1 "yes" 2 "error" 3 "not available""#;

impl Outgoing {
    /// The DBC of the frames of one machine, or of several.
    pub fn dbc(all: &[Self]) -> String {
        let mut out = String::from("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: heft\n");
        let kinds = || {
            all.iter()
                .flat_map(|o| o.kinds.iter().map(move |kind| (o.machine, kind)))
        };
        for (machine, kind) in kinds() {
            let (id, name) = (kind.dbc_id(), kind.name);
            let _ = write!(out, "\nBO_ {id} heft_{machine}_{name}: 8 heft\n");
            kind.signals(&mut out);
        }
        out.push_str(ATTRIBUTES);
        for (_, kind) in kinds() {
            let format = if kind.extended { 3 } else { 0 };
            let _ = writeln!(out, "BA_ \"VFrameFormat\" BO_ {} {format};", kind.dbc_id());
        }
        for outgoing in all {
            let cycle = (outgoing.period * 1000.0).round().max(1.0);
            for kind in &outgoing.kinds {
                let id = kind.dbc_id();
                let _ = writeln!(out, "BA_ \"GenMsgCycleTime\" BO_ {id} {cycle};");
            }
        }
        if let Some(first) = all.first() {
            let _ = writeln!(out, "BA_ \"NmStationAddress\" BU_ heft {};", first.source);
        }
        for (machine, kind) in kinds() {
            kind.comments(machine, &mut out);
        }
        for (machine, kind) in kinds() {
            kind.words(machine, &mut out);
        }
        out
    }
}

/// Number of reason codes that fit a byte of J1939.
const MOST_REASONS: usize = 0xfb;

impl Kind {
    /// Subject of its flags.
    fn transmitted(&self) -> &'static str {
        match self.channel.payload.carries() {
            Carries::Estimate => "the estimates",
            _ => "the loads",
        }
    }

    /// Comments on frame and signals.
    fn comments(&self, machine: Machine, out: &mut String) {
        let id = self.dbc_id();
        match &self.content {
            Content::Quantity(_, row) => {
                let when = match row.trusted {
                    0 => "the last known value; its deviation covers what may have changed",
                    _ => "not available unless trusted",
                };
                let _ = writeln!(
                    out,
                    "CM_ BO_ {id} \"{} of the {machine}; {when}\";",
                    row.name
                );
                let std = "standard deviation; the 95 % interval is the value +- 1.96 of it";
                let _ = writeln!(out, "CM_ SG_ {id} {} \"{std}\";", row.std_field);
            }
            Content::Flags(_, numbers) => {
                let what = format!(
                    "whether {} of the {machine} may be believed, and why not",
                    self.transmitted()
                );
                let _ = writeln!(out, "CM_ BO_ {id} \"{what}\";");
                for (_, number) in numbers.iter().filter(|(_, n)| !n.doc.is_empty()) {
                    let _ = writeln!(out, "CM_ SG_ {id} {} \"{}\";", number.field, number.doc);
                }
            }
        }
    }

    /// Names of single values.
    fn words(&self, machine: Machine, out: &mut String) {
        let id = self.dbc_id();
        match &self.content {
            Content::Quantity(_, row) => {
                for signal in [row.field, row.std_field] {
                    let _ = writeln!(
                        out,
                        "VAL_ {id} {signal} {NOT_AVAILABLE} \"not available\" ;"
                    );
                }
            }
            Content::Flags(flags, numbers) => {
                for (_, number) in numbers.iter().filter(|(_, n)| !n.doc.is_empty()) {
                    let none = (1_u64 << number.bits) - 1;
                    let _ = writeln!(out, "VAL_ {id} {} {none} \"not available\" ;", number.field);
                }
                for (flag, _) in *flags {
                    let _ = writeln!(out, "VAL_ {id} {flag} {WORDS} ;");
                }
                let _ = write!(out, "VAL_ {id} reason");
                let reasons = machines::of(machine).reasons.iter().enumerate();
                for (code, (name, _)) in reasons.take(MOST_REASONS) {
                    let name = if name.is_empty() { "none" } else { name };
                    let _ = write!(out, " {code} \"{name}\"");
                }
                out.push_str(" 255 \"not available\" ;\n");
            }
        }
    }

    fn signals(&self, out: &mut String) {
        match &self.content {
            Content::Quantity(_, row) => {
                for (signal, start, offset) in
                    [(row.field, 0, row.offset), (row.std_field, 32, 0.0)]
                {
                    let (scale, unit) = (row.scale, row.unit);
                    let top = LARGEST * scale + offset;
                    let _ = writeln!(
                        out,
                        " SG_ {signal} : {start}|32@1+ ({scale},{offset}) [{offset}|{top}] \"{unit}\" Vector__XXX"
                    );
                }
            }
            Content::Flags(flags, numbers) => {
                for (_, number) in numbers {
                    let (name, at, bits) = (number.field, number.at, number.bits);
                    let (top, unit) = (number.largest(), number.unit);
                    let _ = writeln!(
                        out,
                        " SG_ {name} : {at}|{bits}@1+ (1,0) [0|{top}] \"{unit}\" Vector__XXX"
                    );
                }
                for (i, (flag, _)) in flags.iter().enumerate() {
                    let start = 2 * i;
                    let _ = writeln!(
                        out,
                        " SG_ {flag} : {start}|2@1+ (1,0) [0|1] \"\" Vector__XXX"
                    );
                }
            }
        }
    }
}
