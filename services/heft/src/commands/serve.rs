//! `heft serve`: the estimates of many machines, for a site's computer.

use std::ffi::OsString;
use std::fs::File;
use std::io::{Read, stdin};
use std::num::NonZeroUsize;

use crate::cli::ServeArgs;
use crate::commands::estimate::{method, way};
use crate::commands::run::{description, tell_idle_keys};
use crate::failure::Failure;
use crate::{machines, sources};

/// `heft serve`
pub fn serve(args: &ServeArgs) -> Result<(), Failure> {
    let description = description(args.machine, &args.description)?;
    let method = method(args.machine, args.method.as_deref());
    let entry = machines::entry(args.machine);
    if args.shard {
        return entry.serve_shard(&description, method, args.every);
    }
    // What cannot work is said once, here.
    way(&description, method)?;
    tell_idle_keys(&description, &[method]);
    let map = sources::map(args.map.as_deref())?;
    let input: Box<dyn Read> = match &args.file {
        Some(file) => Box::new(File::open(file).map_err(|e| Failure::file("read", file, &e))?),
        None => Box::new(stdin().lock()),
    };
    let processors = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let shards = args.shards.map_or(processors, NonZeroUsize::get);
    entry.route(input, map.as_ref(), shards, &shard_arguments(args, method))
}

fn shard_arguments(args: &ServeArgs, method: &str) -> Vec<OsString> {
    let fixed = [
        "serve",
        args.machine.name(),
        "--shard",
        "--method",
        method,
        "--every",
    ];
    let mut all: Vec<OsString> = fixed.map(Into::into).into();
    all.push(args.every.to_string().into());
    for set in &args.description.set {
        all.extend(["--set".into(), set.into()]);
    }
    if let Some(config) = &args.description.config {
        all.extend(["--config".into(), config.into()]);
    }
    all
}
