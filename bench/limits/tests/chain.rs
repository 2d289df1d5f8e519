//! Chains of real processes. Each stage is another instance of this program, so it has its own `main`.

use limits::{Options, Primitive, SUBCOMMAND, chain, worker_main};
use std::time::Duration;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if args.first().is_some_and(|first| first == SUBCOMMAND) {
        std::process::exit(worker_main(&args[1..]));
    }
    if args.iter().any(|arg| arg == "--list") {
        println!("chain: test");
        return;
    }
    for kind in Primitive::ALL {
        a_chain_of_four_delivers_every_sample(kind, false);
        a_chain_of_four_delivers_every_sample(kind, true);
    }
    work_is_part_of_a_hop();
    nonsense_is_refused();
    println!("chain: ok");
}

fn a_chain_of_four_delivers_every_sample(kind: Primitive, fifo: bool) {
    let options = Options {
        samples: 500,
        fifo,
        cores: fifo.then(|| vec![0]),
        ..Options::default()
    };
    let outcome = chain(kind, &options).unwrap_or_else(|error| panic!("{kind:?}: {error}"));
    assert_eq!(
        outcome.lost, 0,
        "{kind:?}: nothing is lost or out of order at 1 kHz"
    );
    assert_eq!(outcome.latencies_ns.len(), 500);
    assert_eq!(outcome.per_hop.len(), outcome.stages - 1);
    for (sample, total) in outcome.latencies_ns.iter().enumerate() {
        let hops: u64 = outcome.per_hop.iter().map(|hop| hop[sample]).sum();
        assert_eq!(hops, *total, "the hops of a sample add up");
    }
    let mut sorted = outcome.latencies_ns;
    sorted.sort_unstable();
    println!(
        "{:5} fifo {:5} stages {} p50 {:6.1} us, p99 {:6.1} us, max {:6.1} us",
        kind.name(),
        outcome.fifo,
        outcome.stages,
        sorted[250] as f64 / 1e3,
        sorted[495] as f64 / 1e3,
        sorted[499] as f64 / 1e3
    );
}

fn work_is_part_of_a_hop() {
    let options = Options {
        samples: 100,
        work: Duration::from_micros(100),
        ..Options::default()
    };
    let outcome = chain(Primitive::Futex, &options).expect("a chain with work runs");
    // Two of the three hops begin with 100 us of work, in stages 1 and 2.
    assert!(
        outcome
            .latencies_ns
            .iter()
            .all(|latency| *latency >= 200_000)
    );
}

fn nonsense_is_refused() {
    for options in [
        Options {
            stages: 1,
            ..Options::default()
        },
        Options {
            rate_hz: f64::NAN,
            ..Options::default()
        },
        Options {
            samples: 0,
            ..Options::default()
        },
        Options {
            payload: 5000,
            ..Options::default()
        },
        Options {
            cores: Some(vec![]),
            ..Options::default()
        },
    ] {
        assert!(chain(Primitive::Futex, &options).is_err(), "{options:?}");
    }
    let status = worker_main(&["futex".to_string()]);
    assert_eq!(status, 2, "a worker started by hand says so");
}
