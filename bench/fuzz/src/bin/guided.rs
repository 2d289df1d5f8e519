//! A target under libFuzzer, which looks at what each input reaches. `bench/fuzz/guided` builds and starts it.

#![no_main]

use std::fs;
use std::sync::OnceLock;

use fuzz::{Limited, Target, limited, target};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static ALLOCATOR: Limited = Limited;

/// The target that the environment names; its corpus is in the folder `corpus` from then on.
fn chosen() -> &'static Target {
    static CHOSEN: OnceLock<&'static Target> = OnceLock::new();
    CHOSEN.get_or_init(|| {
        let name = std::env::var("HEFT_FUZZ_TARGET").unwrap_or_default();
        let target = target(&name).expect("HEFT_FUZZ_TARGET names a target");
        for (n, input) in target.corpus().iter().enumerate() {
            fs::write(format!("corpus/seed-{n}"), input).expect("a folder `corpus`");
        }
        target
    })
}

fuzz_target!(init: drop(chosen()), |input: &[u8]| {
    limited(|| (chosen().run)(input)).expect("all memory is given back");
});
