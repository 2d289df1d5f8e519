//! All keys of a machine file can be set in C.

use config::{Excavator, Keyed, Loader};
use heft_c::settings::{Settings, places};

fn is_complete<M: Keyed + Settings>() {
    let machine = M::default();
    let ours: Vec<&str> = places(&machine).map(|place| place.key.path).collect();
    let tables = machine.tables();
    let theirs = tables.iter().flat_map(|table| table.keys());
    let missing: Vec<&str> = theirs
        .map(|key| key.path)
        .filter(|path| !ours.contains(path))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn every_key_of_a_machine_file_is_a_setting() {
    is_complete::<Excavator>();
    is_complete::<Loader>();
}
