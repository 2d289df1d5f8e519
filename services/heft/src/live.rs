//! The live page of a run.

use std::net::SocketAddr;

use messages::Machine;
use steps::stages::Pipeline;
use view::live::{Feed, Server, SharedLoads, serve};

use crate::failure::Failure;

/// Serves the page until the server is dropped.
pub fn start(
    address: SocketAddr,
    machine: Machine,
    loads: SharedLoads,
) -> Result<(Feed, Server), Failure> {
    let names = Pipeline::of(machine)
        .stages
        .iter()
        .map(|p| p.name.to_owned())
        .collect();
    let feed = Feed::new(names).with_loads(loads);
    let server = serve(address, feed.clone()).map_err(|e| {
        Failure::input(
            format!("cannot show the live page: {e}"),
            format!("--view {address}"),
            "choose another address or port, such as --view 127.0.0.1:8441",
        )
    })?;
    eprintln!(
        "live page: http://{0}\nloads: http://{0}/loads",
        server.address()
    );
    Ok((feed, server))
}
