//! `heft serve`: the estimates of many machines, for a site's computer.

use std::ffi::OsString;
use std::fs::File;
use std::io::{Read, stdin};
use std::num::NonZeroUsize;

use messages::Machine;

use crate::cli::{DescriptionArgs, ServeArgs};
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
    let shards = args.shards.map_or_else(usual_shards, NonZeroUsize::get);
    let arguments = shard_arguments(args.machine, method, &args.description, args.every);
    entry.route(input, map.as_ref(), shards, &arguments)
}

/// What a shard is told.
pub fn shard_arguments(
    machine: Machine,
    method: &str,
    description: &DescriptionArgs,
    every: f64,
) -> Vec<OsString> {
    let fixed = [
        "serve",
        machine.name(),
        "--shard",
        "--method",
        method,
        "--every",
    ];
    let mut all: Vec<OsString> = fixed.map(Into::into).into();
    all.push(every.to_string().into());
    for set in &description.set {
        all.extend(["--set".into(), set.into()]);
    }
    if let Some(config) = &description.config {
        all.extend(["--config".into(), config.into()]);
    }
    all
}

/// As many shards as there are processors.
pub fn usual_shards() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}
