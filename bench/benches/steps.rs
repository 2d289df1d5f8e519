//! The steps for people: `cargo bench -p bench`. Peers and ratios are the business of `cargo run --release -p bench`.

use bench::measure::Contender;
use bench::{groups, real};
use criterion::{Criterion, criterion_group, criterion_main};
use std::time::Duration;

fn quick(criterion: &mut Criterion, name: &str, steps: Vec<Contender>) {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(400));
    for mut step in steps {
        group.bench_function(step.name, |bencher| bencher.iter(|| step.step()));
    }
    group.finish();
}

fn steps(criterion: &mut Criterion) {
    for group in groups::all() {
        let ours = group.contenders.into_iter().zip(group.roles);
        let ours =
            ours.filter(|(_, role)| matches!(role, groups::Role::Ours | groups::Role::Variant));
        quick(
            criterion,
            group.title,
            ours.map(|(contender, _)| contender).collect(),
        );
    }
    quick(
        criterion,
        "The steps of the product",
        real::steps().into_iter().map(|(_, step)| step).collect(),
    );
}

criterion_group!(benches, steps);
criterion_main!(benches);
