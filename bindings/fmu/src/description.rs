//! modelDescription.xml, from the tables of the machine, of the messages and of the keys.

use std::f64::consts::PI;
use std::fmt::Write;

use estimation::keys::Form;
use heft_c::settings::{places, write};
use heft_c::{Excavator, Loader, Machine};
use messages::{ExcavatorEstimate, ExcavatorSensors, LoaderEstimate, LoaderSensors, Message};

use crate::model::reference::{
    ESTIMATED, FLAG, HAS, INPUT, KEY, METHOD, METHOD_USED, REASON, STATED, TIME, VALUE,
};
use crate::model::{default_columns, unstated};

/// Messages with the meanings, units and ranges of a machine's variables.
pub trait Words: Machine {
    /// Message of its sensors.
    type Sensors: Message;
    /// Message of its estimates.
    type Answer: Message;
}

impl Words for Excavator {
    type Sensors = ExcavatorSensors;
    type Answer = ExcavatorEstimate;
}

impl Words for Loader {
    type Sensors = LoaderSensors;
    type Answer = LoaderEstimate;
}

/// Name of the FMU and of the library inside.
#[must_use]
pub fn identifier<M: Machine>() -> String {
    format!("heft_{}", M::NAME)
}

/// Identifies the machine, and that library and description belong together.
#[must_use]
pub fn token<M: Machine>() -> String {
    format!("heft-{}-{}", M::NAME, env!("CARGO_PKG_VERSION"))
}

/// One variable.
struct Variable {
    kind: &'static str,
    name: String,
    reference: u32,
    causality: &'static str,
    text: String,
    /// Further attributes, each after a space.
    more: String,
}

/// The page that an importer shows: usage, every input and output. Parameters have their words in its dialog.
#[must_use]
pub fn page<M: Words>() -> String {
    let mut rows = String::new();
    for v in variables::<M>()
        .iter()
        .filter(|v| ["input", "output"].contains(&v.causality))
    {
        let _ = writeln!(
            rows,
            "<tr><td>{}</td><td><code>{}</code></td><td>{}</td></tr>",
            v.causality,
            v.name,
            marked(&v.text)
        );
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>heft: {name}</title></head><body>\n\
         <h1>heft: mass properties of the {name}</h1>\n\
         <p>Each communication step takes in one row: the inputs, at the time at which the step begins. Units are SI; a missing sample is NaN.</p>\n\
         <p>Set <code>has.SIGNAL = true</code> for each input that is connected. An importer gives 0 to the others, and a torque of 0 is not a missing torque.</p>\n\
         <p>Parameters are the keys of a machine file. One whose default is \"none\" counts where <code>stated.KEY = true</code>.</p>\n\
         <p>Use a value where its <code>verdict.trusted...</code> is set. Elsewhere <code>estimate.reason</code> says why not.</p>\n\
         <table><tr><th></th><th>variable</th><th>meaning</th></tr>\n{rows}</table></body></html>\n",
        name = M::NAME
    )
}

/// The whole description.
#[must_use]
pub fn xml<M: Words>() -> String {
    let variables = variables::<M>();
    let (name, identifier, token) = (M::NAME, identifier::<M>(), token::<M>());
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"3.0\" modelName=\"{identifier}\" instantiationToken=\"{token}\" \
         description=\"heft: mass properties of the {name}, estimated while it works\" \
         version=\"{}\" license=\"MIT OR Apache-2.0\" generationTool=\"heft\" variableNamingConvention=\"structured\">\n  \
         <CoSimulation modelIdentifier=\"{identifier}\" canHandleVariableCommunicationStepSize=\"true\" \
         canGetAndSetFMUState=\"true\"/>\n",
        env!("CARGO_PKG_VERSION")
    );
    units::<M>(&mut out);
    out += "  <TypeDefinitions>\n    <EnumerationType name=\"Method\">\n";
    for (i, method) in M::METHODS.iter().enumerate() {
        let _ = writeln!(out, "      <Item name=\"{method}\" value=\"{i}\"/>");
    }
    out += "    </EnumerationType>\n    <EnumerationType name=\"Reason\">\n";
    for e in reasons::<M::Answer>() {
        let name = if e.name.is_empty() { "none" } else { e.name };
        let _ = writeln!(
            out,
            "      <Item name=\"{name}\" value=\"{}\" description=\"{}\"/>",
            e.number,
            escape(e.doc)
        );
    }
    out += "    </EnumerationType>\n  </TypeDefinitions>\n";
    out += "  <LogCategories>\n    <Category name=\"logStatusError\"/>\n    <Category name=\"logStatusWarning\"/>\n  </LogCategories>\n";
    out += "  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"0.01\"/>\n  <ModelVariables>\n";
    for v in &variables {
        let _ = writeln!(
            out,
            "    <{} name=\"{}\" valueReference=\"{}\" causality=\"{}\"{} description=\"{}\"/>",
            v.kind,
            v.name,
            v.reference,
            v.causality,
            v.more,
            escape(&v.text)
        );
    }
    out += "  </ModelVariables>\n  <ModelStructure>\n";
    for element in ["Output", "InitialUnknown"] {
        for output in variables.iter().filter(|v| v.causality == "output") {
            let _ = writeln!(
                out,
                "    <{element} valueReference=\"{}\"/>",
                output.reference
            );
        }
    }
    out += "  </ModelStructure>\n</fmiModelDescription>\n";
    out
}

fn variables<M: Words>() -> Vec<Variable> {
    let mut all = vec![Variable {
        kind: "Float64",
        name: "time".to_owned(),
        reference: TIME,
        causality: "independent",
        text: "Time.".to_owned(),
        more: " variability=\"continuous\" unit=\"s\"".to_owned(),
    }];
    inputs::<M>(&mut all);
    parameters::<M>(&mut all);
    stated::<M>(&mut all);
    outputs::<M>(&mut all);
    all
}

fn inputs<M: Words>(all: &mut Vec<Variable>) {
    for (i, signal) in M::SIGNALS.iter().enumerate().skip(1) {
        let (unit, doc) = words::<M::Sensors>(signal.name);
        all.push(Variable {
            kind: "Float64",
            name: signal.name.to_owned(),
            reference: INPUT + i as u32,
            causality: "input",
            text: format!("{doc} NaN where a sample is missing."),
            more: format!(
                " variability=\"discrete\" start=\"0\"{}",
                unit_attribute(unit)
            ),
        });
    }
    for (i, signal) in M::SIGNALS.iter().enumerate().skip(1) {
        let start = default_columns::<M>() & (1 << (i - 1)) != 0;
        all.push(Variable {
            kind: "Boolean",
            name: format!("has.{}", signal.name),
            reference: HAS + i as u32,
            causality: "parameter",
            text: format!("The input {} is connected and may be used.", signal.name),
            more: format!(" variability=\"fixed\" start=\"{start}\""),
        });
    }
}

fn parameters<M: Words>(all: &mut Vec<Variable>) {
    all.push(Variable {
        kind: "Enumeration",
        name: "method".to_owned(),
        reference: METHOD,
        causality: "parameter",
        text: "Method of estimation.".to_owned(),
        more: " variability=\"fixed\" start=\"0\" declaredType=\"Method\"".to_owned(),
    });
    let settings = M::Settings::default();
    let mut starts = Vec::new();
    write(&settings, |_, number| starts.push(number));
    let unstated = unstated(&settings);
    for key in &unstated {
        starts[key.at] = key.start;
    }
    for place in places(&settings) {
        let key = place.key;
        let mut text = key.doc.trim().to_owned();
        let mut range = key.range.map_or(String::new(), |r| {
            format!(" min=\"{:?}\" max=\"{:?}\"", r.low, r.high)
        });
        if let Form::Choice(choices) = key.form {
            let choices = choices.iter().enumerate();
            let choices: Vec<String> = choices.map(|(i, word)| format!("{i} {word}")).collect();
            let _ = write!(text, " ({})", choices.join(", "));
            range.clear();
        }
        for i in 0..place.width() {
            let start = starts[place.first + i];
            // NaN marks the end of a list.
            if start.is_nan() {
                continue;
            }
            let index = if place.width() > 1 {
                format!("[{}]", i + 1)
            } else {
                String::new()
            };
            all.push(Variable {
                kind: "Float64",
                name: format!("{}.{}{index}", place.table, key.name),
                reference: KEY + (place.first + i) as u32,
                causality: "parameter",
                text: text.clone(),
                more: format!(
                    " variability=\"fixed\"{}{range} start=\"{start:?}\"",
                    unit_attribute(key.unit)
                ),
            });
        }
    }
}

/// Flags of the keys with default "none", whether they count.
fn stated<M: Words>(all: &mut Vec<Variable>) {
    for (i, key) in unstated(&M::Settings::default()).iter().enumerate() {
        all.push(Variable {
            kind: "Boolean",
            name: format!("stated.{}", key.path),
            reference: STATED + i as u32,
            causality: "parameter",
            text: format!("{} counts; else it is \"none\".", key.path),
            more: " variability=\"fixed\" start=\"false\"".to_owned(),
        });
    }
}

fn outputs<M: Words>(all: &mut Vec<Variable>) {
    let output = |kind, name: String, reference, text: String, unit: String| Variable {
        kind,
        name,
        reference,
        causality: "output",
        text,
        more: format!(" variability=\"discrete\" initial=\"calculated\"{unit}"),
    };
    for (i, value) in M::VALUES.iter().enumerate().skip(1) {
        let (unit, doc) = words::<M::Answer>(value.name);
        let name = format!("estimate.{}", value.name);
        all.push(output(
            "Float64",
            name,
            VALUE + i as u32,
            doc.to_owned(),
            unit_attribute(unit),
        ));
    }
    for (i, flag) in M::FLAGS.iter().enumerate() {
        let text = meaning::<M::Answer>("flags", i);
        let name = format!("verdict.{}", flag.name);
        all.push(output(
            "Boolean",
            name,
            FLAG + i as u32,
            text,
            String::new(),
        ));
    }
    for (i, bit) in M::ESTIMATED.iter().enumerate() {
        let text = format!("The method has an opinion on: {}.", bit.name);
        let name = format!("estimated.{}", bit.name);
        all.push(output(
            "Boolean",
            name,
            ESTIMATED + i as u32,
            text,
            String::new(),
        ));
    }
    let declared = " declaredType=\"Method\"".to_owned();
    let text = "Method at work.".to_owned();
    all.push(output(
        "Enumeration",
        "estimate.method".to_owned(),
        METHOD_USED,
        text,
        declared,
    ));
    all.push(output(
        "Enumeration",
        "estimate.reason".to_owned(),
        REASON,
        "Why it is not trusted, or what the machine does that its machine file does not say."
            .to_owned(),
        " declaredType=\"Reason\"".to_owned(),
    ));
}

/// The reasons of a machine's estimates.
fn reasons<M: Message>() -> &'static [messages::Entry] {
    match messages::Words::of_field(M::WORDS, "reason") {
        Some(messages::Words::Codes(entries)) => entries,
        _ => &[],
    }
}

/// Meaning of a bit in a word of an estimate.
fn meaning<M: Message>(word: &str, bit: usize) -> String {
    let entries = match messages::Words::of_field(M::WORDS, word) {
        Some(messages::Words::Bits(entries)) => *entries,
        _ => &[],
    };
    let found = entries.iter().find(|e| e.number == 1 << bit);
    found.map_or_else(|| "Bit of the verdict.".to_owned(), |e| e.doc.to_owned())
}

/// Unit and meaning of a signal or a value; those that are only a bit of the messages have no field.
fn words<M: Message>(name: &str) -> (&'static str, &'static str) {
    let field = M::FIELDS.iter().find(|field| field.name == name);
    field.map_or(("", "Above 0 while it is so."), |f| (f.unit, f.doc.trim()))
}

/// Display units: the SI unit, the display unit, and the number of display units per SI unit.
const SHOWN: [(&str, &str, f64); 5] = [
    ("rad", "deg", 180.0 / PI),
    ("rad/s", "deg/s", 180.0 / PI),
    ("rad/s^2", "deg/s^2", 180.0 / PI),
    ("Pa", "bar", 1e-5),
    ("kg", "t", 1e-3),
];

/// Attributes for the unit of a variable and its display unit.
fn unit_attribute(unit: &str) -> String {
    if unit.is_empty() {
        return String::new();
    }
    let shown = SHOWN.iter().find(|(si, ..)| *si == unit);
    // A mass is shown in kg unless the user chooses.
    let shown = shown.filter(|_| unit != "kg");
    let shown = shown.map_or(String::new(), |(_, other, _)| {
        format!(" displayUnit=\"{other}\"")
    });
    format!(" unit=\"{unit}\"{shown}")
}

/// Definitions of all units of the variables.
fn units<M: Words>(out: &mut String) {
    let settings = M::Settings::default();
    let keys = places(&settings).map(|place| place.key.unit);
    let sensors = M::Sensors::FIELDS
        .iter()
        .chain(M::Answer::FIELDS)
        .map(|f| f.unit);
    let mut units: Vec<&str> = keys
        .chain(sensors)
        .filter(|u| !u.is_empty() && *u != "ns")
        .collect();
    units.sort_unstable();
    units.dedup();
    out.push_str("  <UnitDefinitions>\n");
    for unit in units {
        let base = exponents(unit).map_or(String::new(), |base| {
            let names = ["kg", "m", "s", "rad"];
            let set = names.iter().zip(base).filter(|(_, n)| *n != 0);
            let set: String = set.map(|(name, n)| format!(" {name}=\"{n}\"")).collect();
            format!("<BaseUnit{set}/>")
        });
        let shown = SHOWN.iter().filter(|(si, ..)| *si == unit);
        let shown: String = shown
            .map(|(_, other, factor)| {
                format!("<DisplayUnit name=\"{other}\" factor=\"{factor:?}\"/>")
            })
            .collect();
        let _ = writeln!(out, "    <Unit name=\"{unit}\">{base}{shown}</Unit>");
    }
    out.push_str("  </UnitDefinitions>\n");
}

/// Exponents of kg, m, s and rad in a unit such as `N m s/rad`; none if it contains an unknown symbol.
fn exponents(unit: &str) -> Option<[i32; 4]> {
    let mut sum = [0; 4];
    for (part, sign) in unit.split('/').zip([1, -1, -1]) {
        for symbol in part.split_whitespace().filter(|s| *s != "1") {
            let (root, power) = match symbol.split_once('^') {
                Some((root, power)) => (root, power.parse::<i32>().ok()?),
                None => (symbol, 1),
            };
            let of = match root {
                "kg" => [1, 0, 0, 0],
                "m" => [0, 1, 0, 0],
                "s" => [0, 0, 1, 0],
                "rad" => [0, 0, 0, 1],
                "Hz" => [0, 0, -1, 0],
                "N" => [1, 1, -2, 0],
                "W" => [1, 2, -3, 0],
                "Pa" => [1, -1, -2, 0],
                _ => return None,
            };
            for (sum, of) in sum.iter_mut().zip(of) {
                *sum += sign * power * of;
            }
        }
    }
    Some(sum)
}

/// A text of the page, with the names in it as code.
fn marked(text: &str) -> String {
    let parts = text.split('`').zip([false, true].into_iter().cycle());
    let parts = parts.map(|(part, is_name)| match is_name {
        true => format!("<code>{}</code>", escape(part)),
        false => escape(part),
    });
    parts.collect()
}

/// A text as an attribute or content of XML; an importer shows it as it is, without marks.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_has_its_own_words_and_angles_are_shown_in_degrees() {
        let flags = (0..Excavator::FLAGS.len()).map(|i| meaning::<ExcavatorEstimate>("flags", i));
        let flags: std::collections::BTreeSet<String> = flags.collect();
        assert_eq!(flags.len(), Excavator::FLAGS.len());
        let description = xml::<Excavator>();
        let unit = "<Unit name=\"rad\"><BaseUnit rad=\"1\"/><DisplayUnit name=\"deg\" factor=\"57.29577951308232\"/></Unit>";
        assert!(description.contains(unit), "{description}");
        let page = page::<Excavator>();
        assert!(page.contains("deviation of <code>inertia</code>"), "{page}");
        assert!(!page.contains('`') && !description.contains('`'));
        let angle = description
            .lines()
            .find(|line| line.contains("name=\"boom_angle\""));
        assert!(angle.is_some_and(|line| line.contains("unit=\"rad\" displayUnit=\"deg\"")));
    }

    #[test]
    fn units_are_taken_apart() {
        assert_eq!(exponents("N m s/rad"), Some([1, 2, -1, -1]));
        assert_eq!(exponents("rad^2/s^5"), Some([0, 0, -5, 2]));
        assert_eq!(exponents("1/s"), Some([0, 0, -1, 0]));
        assert_eq!(exponents("furlong"), None);
    }
}
