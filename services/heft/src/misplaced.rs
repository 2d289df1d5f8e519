//! A file where the command line takes none: the place where it belongs.

use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use recording::Quoted;

/// Says what is wrong with the command line, and ends with its status.
pub fn exit(error: &clap::Error) -> ! {
    let _ = error.print();
    if let Some(tip) = tip(error) {
        eprintln!("\n  tip: {tip}");
    }
    std::process::exit(error.exit_code())
}

/// Where a machine belongs whose option the command does not have.
fn tip_of_machine(error: &clap::Error) -> Option<&'static str> {
    let is_it = |value: Option<&ContextValue>| matches!(value, Some(ContextValue::String(word)) if word == "--machine");
    if !is_it(error.get(ContextKind::InvalidArg)) {
        return None;
    }
    let usage = error.get(ContextKind::Usage)?.to_string();
    Some(match usage.contains("<MACHINE>") {
        true => "this command takes the machine as a word of its own, such as heft run excavator",
        false => "leave it out: this command needs no machine, or its input says which one it is",
    })
}

/// Where a file belongs that stands elsewhere.
fn tip(error: &clap::Error) -> Option<String> {
    use ContextKind::{InvalidArg, InvalidSubcommand, InvalidValue};
    if let Some(tip) = tip_of_machine(error) {
        return Some(tip.into());
    }
    let (kind, advice) = match error.kind() {
        ErrorKind::InvalidSubcommand => (
            InvalidSubcommand,
            "the command comes before it, such as heft estimate",
        ),
        ErrorKind::InvalidValue => (InvalidValue, "the machine comes before it"),
        ErrorKind::UnknownArgument => (InvalidArg, "heft run takes one by --input"),
        _ => return None,
    };
    let Some(ContextValue::String(word)) = error.get(kind) else {
        return None;
    };
    let file = Quoted(word);
    let is_there = Path::new(word).is_file();
    is_there.then(|| format!("{file} is a file: {advice}"))
}
