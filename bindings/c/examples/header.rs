//! Writes `include/heft.h` from the tables of the machines; meanings and units come from the table of
//! messages and from the keys: `cargo run -p heft_c --example header`.

use std::fmt::Write;

use estimation::keys::Form;
use heft_c::settings::places;
use heft_c::{Bit, Code, Excavator, Loader, Machine, SIZE_MAX, abi};
use messages::{
    ExcavatorEstimate, ExcavatorLoads, ExcavatorSensors, Field, HEAD, LoaderEstimate,
    LoaderSensors, Message, NumberType, Words,
};
use sheet::loads::{STAGES, WITNESSES};

/// Path of the header.
pub const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/include/heft.h");

#[allow(dead_code, reason = "the test of the header includes this file")]
fn main() -> std::io::Result<()> {
    std::fs::write(FILE, header())
}

const TOP: &str = r#"/* heft: mass properties of construction machines, estimated while they work.
 *
 * The caller gives the memory, then one row after the other:
 *
 *     static uint64_t memory[HEFT_SIZE_MAX / 8];
 *     heft_excavator_init(memory, sizeof memory, NULL, HEFT_EXCAVATOR_METHOD_AUTO,
 *                         HEFT_EXCAVATOR_COLUMN_SWING_VELOCITY);
 *     heft_excavator_step(memory, &sample, &estimate);
 *
 * Units are SI. A sample that is missing is NAN (do not compile the caller with -ffast-math). A row
 * without one of its signals, or with an impossible one, is answered all the same; no number of an
 * estimate is ever NAN or infinite. A quantity that the method does not estimate is 0 without its
 * bit in `estimated`. Believe an estimate where its TRUSTED flag is set; its interval of 95 % is the
 * value +- 1.96 standard deviations.
 *
 * A method of a loader other than full-ekf may be left out of the library (feature every-method).
 *
 * No function allocates, blocks, opens a file or reads a clock. One memory belongs to one thread at
 * a time; different memories are independent. Nothing has to be freed.
 *
 * Written by `cargo run -p heft_c --example header`; do not edit.
 */
#ifndef HEFT_H
#define HEFT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

"#;

/// The whole header.
pub fn header() -> String {
    let mut out = TOP.to_owned();
    version(&mut out);
    let _ = writeln!(out, "/* What a function returns. */");
    for (code, name, what) in Code::ALL {
        define(&mut out, name, &format!("({})", code as i32), what);
    }
    out += "\n/* Enough memory for either machine on every platform; heft_..._size() tells the exact size. */\n";
    let _ = writeln!(out, "#define HEFT_SIZE_MAX {SIZE_MAX}");
    machine::<Excavator, ExcavatorSensors, ExcavatorEstimate>(&mut out);
    machine::<Loader, LoaderSensors, LoaderEstimate>(&mut out);
    loads(&mut out);
    out += "\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n";
    out
}

/// Version of the header.
fn version(out: &mut String) {
    let number = env!("CARGO_PKG_VERSION");
    let parts = number
        .split('.')
        .map(|part| part.parse::<u32>().unwrap_or(0));
    let ordered = parts.fold(0, |all, part| 100 * all + part);
    let _ = write!(
        out,
        "/* Version of this header; HEFT_VERSION_NUMBER is 10000 major + 100 minor + patch. */\n\
         #define HEFT_VERSION \"{number}\"\n\
         #define HEFT_VERSION_NUMBER {ordered}\n\n\
         /* Version of the library that the program runs with. */\n\
         const char *heft_version(void);\n\n\
         /* What a program compiles in: structures, bits, methods. A library of another header answers `init` with\n \
         * HEFT_OTHER_HEADER. */\n\
         #define HEFT_ABI 0x{:08x}u\n\n\
         /* HEFT_ABI of the header that belongs to the library. */\n\
         uint32_t heft_abi(void);\n\n",
        abi::sum()
    );
}

fn define(out: &mut String, name: &str, value: &str, doc: &str) {
    let _ = writeln!(out, "#define {name} {value} /* {doc} */");
}

fn machine<M, S, E>(out: &mut String)
where
    M: Machine,
    S: Message,
    E: Message,
{
    let name = M::NAME;
    let upper = name.to_uppercase();
    let _ = writeln!(out, "\n/* ---- {name} ---- */\n\n/* Methods. */");
    for (i, method) in M::METHODS.iter().enumerate() {
        let _ = writeln!(out, "#define HEFT_{upper}_METHOD_{} {i}", constant(method));
    }
    reasons(out, name, &upper, E::WORDS);
    let _ = writeln!(
        out,
        "\n/* Sensors that the machine has, for `columns` of heft_{name}_init; each needs its bit to be used. */"
    );
    for (i, signal) in M::SIGNALS.iter().skip(1).enumerate() {
        let _ = writeln!(
            out,
            "#define HEFT_{upper}_COLUMN_{} (1u << {i})",
            constant(signal.name)
        );
    }
    bits(
        out,
        &format!("HEFT_{upper}_FLAG"),
        "`flags` of an estimate",
        M::FLAGS,
    );
    bits(
        out,
        &format!("HEFT_{upper}_ESTIMATED"),
        "`estimated` of an estimate: which quantities the method has an opinion on",
        M::ESTIMATED,
    );

    let _ = writeln!(
        out,
        "\n/* A row of sensors; NAN where a sample is missing. */\ntypedef struct {{"
    );
    for signal in M::SIGNALS {
        row(out, signal.name, field::<S>(signal.name), "");
    }
    let _ = writeln!(out, "}} heft_{name}_sample;");

    let _ = writeln!(out, "\n/* The answer to a row. */\ntypedef struct {{");
    for value in M::VALUES {
        row(out, value.name, field::<E>(value.name), "");
    }
    out.push_str(&format!(
        "  uint64_t refused; /* Rows refused so far. */\n  \
         uint32_t flags; /* HEFT_{upper}_FLAG_... */\n  \
         uint32_t estimated; /* HEFT_{upper}_ESTIMATED_... */\n  \
         uint32_t method; /* HEFT_{upper}_METHOD_..., the one at work. */\n  \
         uint32_t reason; /* HEFT_{upper}_REASON_...: why it is not trusted, or what the machine does beside its description; 0 for none. */\n}} heft_{name}_estimate;\n"
    ));

    settings::<M>(out);
    functions(out, name);
}

/// Codes of the reasons, and their names.
fn reasons(out: &mut String, name: &str, upper: &str, words: &[(&str, Words)]) {
    let codes = words.iter().find_map(|(field, words)| match words {
        Words::Codes(entries) if *field == "reason" => Some(*entries),
        _ => None,
    });
    let entries = codes.unwrap_or_default();
    out.push_str("\n/* Reasons: why an estimate is not trusted, or what the machine does beside its description. */\n");
    for e in entries {
        let constant = if e.name.is_empty() {
            "NONE".to_owned()
        } else {
            constant(e.name)
        };
        let doc = if e.doc.is_empty() {
            "nothing to say"
        } else {
            e.doc
        };
        define(
            out,
            &format!("HEFT_{upper}_REASON_{constant}"),
            &e.number.to_string(),
            doc,
        );
    }
    let _ = writeln!(
        out,
        "\n/* Name of a reason; empty for none. */\n\
         static inline const char *heft_{name}_reason(uint32_t code) {{\n  switch (code) {{"
    );
    for e in entries {
        let _ = writeln!(out, "    case {}: return \"{}\";", e.number, e.name);
    }
    out.push_str("    default: return \"unknown\";\n  }\n}\n");
}

fn bits<E>(out: &mut String, prefix: &str, what: &str, bits: &[Bit<E>]) {
    let _ = writeln!(out, "\n/* Bits of {what}. */");
    for (i, bit) in bits.iter().enumerate() {
        let _ = writeln!(out, "#define {prefix}_{} (1u << {i})", constant(bit.name));
    }
}

fn settings<M: Machine>(out: &mut String) {
    let name = M::NAME;
    let _ = writeln!(
        out,
        "\n/* Settings, as in a description; flags are 0 or 1, choices count from 0, NAN is \"none\" and ends a list. */\ntypedef struct {{"
    );
    let mut table = "";
    for place in places(&M::Settings::default()) {
        if place.table != table {
            close(out, table);
            out.push_str("  struct {\n");
            table = place.table;
        }
        let mut doc = place.key.doc.trim().to_owned();
        if let Form::Choice(words) = place.key.form {
            let words = words.iter().enumerate();
            let words: Vec<String> = words.map(|(i, word)| format!("{i} {word}")).collect();
            let _ = write!(doc, " ({})", words.join(", "));
        }
        let field = match place.key.form {
            Form::List(_) | Form::Numbers => format!("{}[{}]", place.key.name, place.width()),
            _ => place.key.name.to_owned(),
        };
        row(out, &field, (place.key.unit, &doc), "  ");
    }
    close(out, table);
    let _ = writeln!(out, "}} heft_{name}_settings;");
}

fn close(out: &mut String, table: &str) {
    if let Some(last) = table.rsplit('.').next().filter(|last| !last.is_empty()) {
        let _ = writeln!(out, "  }} {last};");
    }
}

/// Unit and meaning of a signal or a value; the boom's motion and the brakes are bits of the messages.
fn field<M: Message>(name: &str) -> (&'static str, &'static str) {
    let found = M::FIELDS.iter().find(|field: &&Field| field.name == name);
    match found {
        Some(field) => (field.unit, field.doc.trim()),
        None if name == "boom_moving" => ("", "Above 0 while the boom moves; 0 or NAN: it rests."),
        None if name == "brake" => (
            "",
            "Above 0 while friction brakes act; 0 or NAN: they do not.",
        ),
        None => panic!("the message {} has no field {name}", M::NAME),
    }
}

fn row(out: &mut String, name: &str, (unit, doc): (&str, &str), indent: &str) {
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" [{unit}]")
    };
    let _ = writeln!(out, "{indent}  double {name}; /* {doc}{unit} */");
}

fn functions(out: &mut String, name: &str) {
    let text = r#"
/* Bytes that heft_NAME_init needs. */
size_t heft_NAME_size(void);

/* Fills in the settings of the reference machine. */
int32_t heft_NAME_defaults(heft_NAME_settings *settings);

/* Sets one key by its name, such as "sensors.rate"; HEFT_NO_SUCH_KEY if there is none, HEFT_REFUSED (and nothing is
 * set) if the key cannot take the value. */
int32_t heft_NAME_set(heft_NAME_settings *settings, const char *key, double value);

/* Gives each key that still has the reference machine's value that of a machine of the stated size (SIZES), as
 * a machine file does. Call it once, when all keys that you know are set. HEFT_REFUSED where a key cannot have its value:
 * then nothing is changed. */
int32_t heft_NAME_complete(heft_NAME_settings *settings);

/* What heft_NAME_init calls; other languages give `abi`, HEFT_ABI of the header whose structures they use. */
int32_t heft_NAME_init_as(void *memory, size_t size, const heft_NAME_settings *settings,
                          uint32_t method, uint32_t columns, uint32_t abi);

/* Makes an estimator in the caller's memory (aligned to 8 bytes). `settings` may be NULL for those of
 * the reference machine; they are copied. HEFT_REFUSED: heft_NAME_error tells what is wrong. */
static inline int32_t heft_NAME_init(void *memory, size_t size, const heft_NAME_settings *settings,
                                     uint32_t method, uint32_t columns) {
  return heft_NAME_init_as(memory, size, settings, method, columns, HEFT_ABI);
}

/* Sets all signals of a row to "missing"; then write those that there are. */
int32_t heft_NAME_clear(heft_NAME_sample *sample);

/* Takes one row and answers. A row whose time does not increase is refused: it changes nothing, and the
 * answer has the flag REFUSED. The memory must have been given to heft_NAME_init. */
int32_t heft_NAME_step(void *memory, const heft_NAME_sample *sample, heft_NAME_estimate *estimate);

/* Why the last heft_NAME_init on this memory returned HEFT_REFUSED; "" if it did not. */
const char *heft_NAME_error(const void *memory);

/* Bytes that heft_NAME_save needs. */
size_t heft_NAME_state_size(void);

/* Writes the whole state, settings and method included, to `state`, which may lie anywhere. Between two rows the
 * memory may also be moved by memcpy to another place that is aligned to 8 bytes. */
int32_t heft_NAME_save(const void *memory, void *state, size_t size);

/* Goes on from a saved state, bit for bit; `memory` as for heft_NAME_init, which need not be called. HEFT_REFUSED, and
 * `memory` is as it was: the state is damaged, of another machine, or of another build of the library. */
int32_t heft_NAME_restore(void *memory, size_t size, const void *state, size_t state_size);
"#;
    // Keys that determine the size of a machine.
    let sizes = match name {
        "excavator" => {
            "machine.operating_mass, rated_payload and swing_torque, lengths of boom and arm"
        }
        _ => "machine.mass, wheel_radius, prior.cg_height",
    };
    out.push_str(&text.replace("NAME", name).replace("SIZES", sizes));
}

/// The function that makes a ledger for a machine, after the part common to all machines.
fn book(out: &mut String, name: &str) {
    let text = r#"
/* What heft_NAME_loads_init calls. */
int32_t heft_NAME_loads_init_as(void *memory, size_t size, const heft_NAME_settings *settings, double target,
                                double pause, uint32_t abi);

/* heft_loads_init for the machine of these settings, those that heft_NAME_init was given: the payload of a full bucket, and
 * what all of its loads are off together, follow from them. `settings` may be NULL for the reference machine.
 * HEFT_REFUSED: a setting, `target` or `pause` is impossible. */
static inline int32_t heft_NAME_loads_init(void *memory, size_t size, const heft_NAME_settings *settings, double target,
                                           double pause) {
  return heft_NAME_loads_init_as(memory, size, settings, target, pause, HEFT_ABI);
}
"#;
    out.push_str(&text.replace("NAME", name));
}

/// Loads: the part common to all machines.
fn loads(out: &mut String) {
    out.push_str("\n/* ---- loads of either machine ---- */\n\n/* Bits of `flags`. */\n");
    for flag in sheet::loads::FLAGS {
        let e = flag.entry;
        let name = format!("HEFT_LOADS_FLAG_{}", constant(e.name));
        define(out, &name, &format!("{}u", e.number), e.doc);
    }
    for (field, entries) in [("stage", STAGES), ("witness", WITNESSES)] {
        let _ = writeln!(out, "\n/* Codes of `{field}`. */");
        for e in entries {
            let name = format!("HEFT_LOADS_{}_{}", constant(field), constant(e.name));
            define(out, &name, &e.number.to_string(), e.doc);
        }
    }
    out.push_str(LOADS_ROW);
    out.push_str("\n/* What is known after it. */\ntypedef struct {\n");
    for field in ExcavatorLoads::FIELDS.iter().skip(HEAD) {
        let kind = match field.kind {
            NumberType::F64 => "double",
            NumberType::U32 => "uint32_t",
            NumberType::U64 => "uint64_t",
        };
        let unit = match field.unit {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        let (name, doc) = (field.name, field.doc.trim());
        let _ = writeln!(out, "  {kind} {name}; /* {doc}{unit} */");
    }
    out.push_str(LOADS_FUNCTIONS);
    book(out, Excavator::NAME);
    book(out, Loader::NAME);
}

const LOADS_ROW: &str = r#"
/* A row: an estimate of either machine, each of them once. */
typedef struct {
  double t; /* Time of the estimate; rows must increase [s] */
  double payload; /* NAN where nothing estimates it [kg] */
  double payload_std; /* Its standard deviation [kg] */
  double speed; /* Swing rate [rad/s] or driving speed [m/s], of any sign; NAN: not known */
  double truck; /* Which truck is loaded: another value begins another truck; NAN: not known */
  uint32_t trusted; /* 1: the payload may be believed */
  uint32_t changing; /* 1: the content is changing */
  uint32_t reason; /* Why it is not trusted, in the machine's codes: carried along */
  uint32_t witness; /* HEFT_LOADS_WITNESS_... */
} heft_loads_row;
"#;

const LOADS_FUNCTIONS: &str = r#"} heft_loads;

/* Bytes that heft_loads_init needs. */
size_t heft_loads_size(void);

/* What heft_loads_init calls. */
int32_t heft_loads_init_as(void *memory, size_t size, double rated, double target, double pause, uint32_t abi);

/* Makes an empty book in the caller's memory (aligned to 8 bytes). `rated`: payload of a full bucket, roughly [kg];
 * `target`: what a truck shall hold, NAN if nobody says [kg]; `pause`: a load this long after the one before goes to
 * another truck, 0 never, NAN: 300 [s]. HEFT_REFUSED: one of them is impossible. Nothing is known of what all loads are off
 * together: their sums look better than they are. heft_excavator_loads_init and heft_loader_loads_init know it. */
static inline int32_t heft_loads_init(void *memory, size_t size, double rated, double target, double pause) {
  return heft_loads_init_as(memory, size, rated, target, pause, HEFT_ABI);
}

/* Takes an estimate. `payload` of the answer is always a value: the last known one, with a deviation that grows. */
int32_t heft_loads_step(void *memory, const heft_loads_row *row, heft_loads *loads);

/* Begins another truck: what is dumped from now on goes there. */
int32_t heft_loads_next_truck(void *memory, heft_loads *loads);

/* What this truck and the next ones shall hold from now on [kg]; NAN: nobody says. HEFT_REFUSED: no weight, and nothing
 * changes. */
int32_t heft_loads_set_target(void *memory, double target, heft_loads *loads);
"#;

/// `posture-torque` as in the name of a constant.
fn constant(name: &str) -> String {
    name.replace(['-', ' '], "_").to_uppercase()
}
