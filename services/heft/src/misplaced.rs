//! Tips for a misplaced file name on the command line, and for options that another command has.

use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use recording::Quoted;

/// Prints the error of the command line and a tip, and exits with its status.
pub fn exit(mut error: clap::Error) -> ! {
    let tip = tip(&error);
    if tip.is_some() {
        // The suggestion of clap would contradict the tip.
        error.remove(ContextKind::Suggested);
        error.remove(ContextKind::SuggestedArg);
    }
    let _ = error.print();
    if let Some(tip) = tip {
        eprintln!("\n  tip: {tip}");
    }
    std::process::exit(error.exit_code())
}

/// The tip for `--machine` on a command without this option.
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

/// The tip for `-o` or `--output` on a command without it.
fn tip_of_output(error: &clap::Error) -> Option<&'static str> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let is_it = word.starts_with("-o") || word == "--output";
    let usage = error.get(ContextKind::Usage)?.to_string();
    let of = |command: &str| usage.split_whitespace().any(|word| word == command);
    match () {
        () if !is_it => None,
        () if of("run") => Some(
            "--out FOLDER says where recording and report go; --output can:can0 sends the estimates to a bus",
        ),
        () if of("serve") || of("tail") => {
            Some("it writes to standard output: end the command with > FILE")
        }
        () if of("check") => {
            Some("--print writes the machine file to standard output: end the command with > FILE")
        }
        () if of("weigh") => Some("--json FILE writes the result to a file"),
        () if of("replay") => Some(
            "it compares and writes no file: heft export writes the recording as tables, heft estimate new estimates",
        ),
        () => None,
    }
}

/// The tip for a misplaced file name or option.
fn tip(error: &clap::Error) -> Option<String> {
    use ContextKind::{InvalidArg, InvalidSubcommand, InvalidValue};
    if let Some(tip) = tip_of_machine(error).or_else(|| tip_of_output(error)) {
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
