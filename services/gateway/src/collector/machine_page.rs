//! The page of one machine: a report of its latest messages, by the code that reports a run.

use std::collections::BTreeMap;
use std::path::Path;

use messages::{Envelope, Machine, Message};
use rusqlite::params;
use steps::stages::Pipeline;
use view::estimate::Estimate;
use view::plot::escape;
use view::{Estimator, MachineRun, Parts, Run};

use super::intake::decode;
use super::live;
use super::query::open;
use super::shown;
use crate::key::{MachineId, SITE_ESTIMATE};

/// Messages of a stream that are drawn: an hour at one a second.
const DRAWN: i64 = 3600;

/// The facts above the plots.
pub struct Head {
    kind: String,
    html: String,
    metadata: Vec<(String, String)>,
}

impl Head {
    /// The facts of the machine in its present state.
    pub fn of(id: &MachineId, machine: &live::Machine) -> Self {
        let mut metadata = vec![
            ("machine".to_owned(), machine.kind.clone()),
            ("site and machine".to_owned(), id.to_string()),
            ("heft.version".to_owned(), machine.version.clone()),
        ];
        if let Some(status) = &machine.status {
            let c = status.counts;
            let counts = format!(
                "{} sent, {} dropped before Zenoh, {} overwritten in the channels, {} sent again, {} asked for and no longer recorded",
                c.sent, c.dropped, c.overwritten, c.served, c.lost
            );
            metadata.push(("gateway".to_owned(), counts));
            if c.samples_sent + c.samples_lost > 0 {
                let samples = format!(
                    "{} sent, {} lost before Zenoh",
                    c.samples_sent, c.samples_lost
                );
                metadata.push(("samples for the site".to_owned(), samples));
            }
            let clock = format!("{} ms against the collector's", machine.clock_ms);
            metadata.push(("clock".to_owned(), clock));
        }
        let account = machine.account;
        let refused: u64 = machine.refused.values().sum();
        let is_complete = account == live::Account::default() && refused == 0;
        let history = format!(
            "{}{} messages lost, {} streams with a gap, {} runs not received, {refused} messages refused",
            if is_complete {
                "complete: "
            } else {
                "not complete: "
            },
            account.lost,
            account.gaps,
            account.unheard
        );
        metadata.push(("history".to_owned(), history));
        for (why, times) in &machine.refused {
            metadata.push((format!("refused: {why}"), times.to_string()));
        }
        let alarms: String = machine
            .alarms
            .on
            .values()
            .map(|text| format!("<p class=\"badge\">{}</p>", escape(text)))
            .collect();
        let words = |kind| machine.main(kind).map(|(_, e)| shown::verdict(e));
        let mut said = words("estimate").unwrap_or_default();
        if let Some(site) = words(SITE_ESTIMATE) {
            said += " At the site, from its samples (the last of two lines of one name): ";
            said += &site;
        }
        let here = if machine.is_here() { "here" } else { "away" };
        let html = format!(
            "<p class=\"facts\"><a href=\"/\">all machines</a> · {here}</p>{alarms}<p class=\"other\">{}</p>",
            escape(&said)
        );
        Self {
            kind: machine.kind.clone(),
            html,
            metadata,
        }
    }
}

/// The page; `None` if nothing can be read of the machine.
pub fn page(db: &Path, id: &MachineId, head: &Head) -> Option<String> {
    let sql = open(db).ok()?;
    let mut query = sql
        .prepare(
            "SELECT name, payload FROM (
               SELECT s.name, e.number, e.payload, row_number() OVER (PARTITION BY s.id ORDER BY e.number DESC) AS place
               FROM machine m JOIN stream s ON s.machine = m.id JOIN message e ON e.stream = s.id
               WHERE m.site = ?1 AND m.name = ?2 AND (s.name LIKE 'estimate/%' OR s.name LIKE 'site/%' OR s.name LIKE 'health/%')
                 AND s.run = (SELECT run FROM run WHERE machine = m.id ORDER BY id DESC LIMIT 1))
             WHERE place <= ?3 ORDER BY name, number",
        )
        .ok()?;
    let mut rows = query.query(params![id.site, id.machine, DRAWN]).ok()?;
    let mut streams: BTreeMap<String, Vec<Envelope>> = BTreeMap::new();
    while let Ok(Some(row)) = rows.next() {
        let (name, payload): (String, Vec<u8>) = (row.get(0).ok()?, row.get(1).ok()?);
        if let Some(message) = decode(&name, &payload) {
            streams.entry(name).or_default().push(message);
        }
    }
    let machine = Machine::from_name(&head.kind)?;
    let stages = Pipeline::of(machine).stages;
    let health = streams
        .iter()
        .filter(|(name, _)| name.starts_with("health/"));
    let run = Run {
        metadata: head.metadata.clone(),
        parts: Parts {
            excavator: part(&streams),
            loader: part(&streams),
        },
        health: health
            .filter_map(|(_, all)| messages::Health::inside(all.last()?).copied())
            .collect(),
        processes: stages.iter().map(|s| s.name.to_owned()).collect(),
        ..Run::default()
    };
    let page = view::report(&run);
    Some(page.replacen("<main>", &format!("<main>{}", head.html), 1))
}

fn part<E: Estimate>(streams: &BTreeMap<String, Vec<Envelope>>) -> MachineRun<E> {
    let estimator = |(name, all): (&String, &Vec<Envelope>)| {
        let estimates: Vec<E> = all.iter().filter_map(|e| E::inside(e).copied()).collect();
        let channel = match name.split_once('/')? {
            ("estimate", name) => format!("{}/{name}", E::MACHINE),
            // Sorts after the machine's own estimates.
            (SITE_ESTIMATE, name) => format!("{}/{name} at the site", E::MACHINE),
            _ => return None,
        };
        (!estimates.is_empty()).then_some(Estimator {
            channel,
            estimates,
            extremes: Default::default(),
        })
    };
    MachineRun {
        estimators: streams.iter().filter_map(estimator).collect(),
        truth: Vec::new(),
    }
}
