//! The protobuf schemas of the messages, for programs without heft's code.

use std::collections::BTreeMap;

use messages::channels::{Channel, Visitor};
use messages::{Machine, Message};
use steps::stages::Pipeline;
use zenoh::key_expr::KeyExpr;
use zenoh::query::Query;
use zenoh::{Session, Wait};

use crate::downsample::streams;

struct Describe;

impl Visitor for Describe {
    type Output = (String, Vec<u8>);
    fn visit<M: Message>(self) -> Self::Output {
        (
            recording::payload::name::<M>(),
            recording::payload::schema::<M>(),
        )
    }
}

/// Name of the message that a channel carries: `heft.Health`.
pub fn name(channel: &Channel) -> String {
    channel.payload.visit(Describe).0
}

/// Answers `PREFIX/schema/NAME`, and wild cards, until the returned value is dropped.
///
/// # Errors
/// Zenoh refuses the key.
pub fn serve(session: &Session, prefix: &str) -> zenoh::Result<impl Sized + use<>> {
    let answer = answers(prefix);
    session
        .declare_queryable(format!("{prefix}/schema/*"))
        .callback(move |query| answer(&query))
        .wait()
}

/// Handler of queries for `PREFIX/schema/NAME`; it ignores other queries.
pub fn answers(prefix: &str) -> impl Fn(&Query) + Send + Sync + use<> {
    let machines = Machine::ALL.into_iter().map(Pipeline::of);
    let channels = machines
        .flat_map(|p| streams(p, 1.0, 1.0))
        .map(|s| s.channel);
    let all: BTreeMap<String, Vec<u8>> = channels.map(|c| c.payload.visit(Describe)).collect();
    let own: Vec<(KeyExpr<'static>, Vec<u8>)> = all
        .into_iter()
        .filter_map(|(name, bytes)| {
            Some((KeyExpr::new(format!("{prefix}/schema/{name}")).ok()?, bytes))
        })
        .collect();
    move |query| {
        for (key, schema) in own
            .iter()
            .filter(|(key, _)| query.key_expr().intersects(key))
        {
            // The querier may be gone.
            let _ = query.reply(key.clone(), schema.as_slice()).wait();
        }
    }
}
