//! Loads as a message: what other programs hear of the ledger.

use estimation::loads::{Load, Now, Truck};
use messages::channels::{Channel, EXCAVATOR_LOADS, LOADER_LOADS};
use messages::{
    Envelope, ExcavatorLoads, LoaderLoads, Machine, Message, Stamp, loads_bits as bits,
};
use sheet::loads::NEVER;

use super::LoadCounter;

/// The message of a machine's loads.
macro_rules! told {
    ($message:ident, $counter:ident, $stamp:ident) => {{
        let (now, truck) = ($counter.ledger().now(), $counter.ledger().truck());
        let carried = $counter.ledger().carried();
        let load = carried.or($counter.loads().next_back().copied());
        let flags = flags(load.as_ref(), &now, &truck);
        let load = load.unwrap_or_default();
        let delivered = load.delivered();
        $message {
            stamp: *$stamp,
            payload: now.kg,
            payload_std: now.std,
            payload_age: now.age.unwrap_or(NEVER),
            mass: load.weight.kg,
            mass_std: load.weight.std,
            common_std: load.weight.common_std,
            carry_back: load.carry_back.kg,
            carry_back_std: load.carry_back.std,
            delivered: delivered.kg,
            delivered_std: delivered.std,
            filled: load.filled,
            dumped: load.dumped.unwrap_or_default(),
            truck_mass: truck.total.kg,
            truck_mass_std: truck.total.std(),
            target: truck.target.unwrap_or_default(),
            remaining: truck.remaining().unwrap_or_default(),
            load: load.number,
            truck: truck.number,
            truck_loads: truck.total.loads,
            truck_untrusted: truck.total.untrusted,
            stage: load.stage.code(),
            witness: load.witness.code(),
            reason: load.why & 0xff,
            flags,
            ..$message::default()
        }
        .envelope()
    }};
}

/// What is known of the bucket, the latest load and its truck, as a message beside the estimate of this stamp.
#[must_use]
pub fn message(counter: &LoadCounter, stamp: &Stamp) -> Envelope {
    match counter.machine() {
        Machine::Excavator => told!(ExcavatorLoads, counter, stamp),
        Machine::Loader => told!(LoaderLoads, counter, stamp),
    }
}

/// Bits of the message.
fn flags(load: Option<&Load>, now: &Now, truck: &Truck) -> u32 {
    let is = |yes: bool, bit: u32| if yes { bit } else { 0 };
    let of_load = load.map_or(0, |load| {
        is(load.trusted, bits::TRUSTED)
            | is(load.dumped.is_none(), bits::CARRIED)
            | is(load.dumped.is_some(), bits::FINAL)
            | is(load.carry_back_weighed, bits::CARRY_BACK_WEIGHED)
    });
    let total = &truck.total;
    of_load
        | is(now.age.is_some(), bits::WEIGHED)
        | is(total.loads > 0 && total.untrusted == 0, bits::TRUCK_TRUSTED)
        | is(truck.target.is_some(), bits::HAS_TARGET)
}

/// The channel of a machine's loads.
#[must_use]
pub fn channel(machine: Machine) -> &'static Channel {
    match machine {
        Machine::Excavator => EXCAVATOR_LOADS.any(),
        Machine::Loader => LOADER_LOADS.any(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimation::loads::{Stage, Witness};
    use sheet::loads::{STAGES, WITNESSES};

    #[test]
    fn codes_of_stages_and_witnesses_are_those_of_the_sheet() {
        for stage in Stage::ALL {
            assert_eq!(STAGES[stage.code() as usize].name, stage.name());
        }
        for witness in Witness::ALL {
            assert_eq!(WITNESSES[witness.code() as usize].name, witness.name());
        }
        assert_eq!((STAGES.len(), WITNESSES.len()), (Stage::ALL.len(), Witness::ALL.len()));
    }
}
