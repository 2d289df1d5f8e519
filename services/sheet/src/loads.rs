//! Tables of the message of loads: fields, bits, codes and CAN frames, the same for every machine.

use crate::{Entry, Flag, Quantity, entry, frame};

/// Bits of `flags`.
pub mod bits {
    /// The mass of the load may be believed.
    pub const TRUSTED: u32 = 1;
    /// The load is in the bucket.
    pub const CARRIED: u32 = 1 << 1;
    /// The load was dumped: its mass does not change any more.
    pub const FINAL: u32 = 1 << 2;
    /// What stayed in the bucket was weighed after this load; else it is the mean of earlier ones.
    pub const CARRY_BACK_WEIGHED: u32 = 1 << 3;
    /// The bucket was weighed at least once, `payload_age` ago.
    pub const WEIGHED: u32 = 1 << 4;
    /// The truck has loads, and each of them may be believed.
    pub const TRUCK_TRUSTED: u32 = 1 << 5;
    /// Somebody said what the truck shall hold.
    pub const HAS_TARGET: u32 = 1 << 6;
    /// Loads may be missing in the sums; set by a run, not by the ledger.
    pub const OUTAGE: u32 = 1 << 7;
}

const fn flag(bit: u32, name: &'static str, place: u32, doc: &'static str) -> Flag {
    Flag {
        entry: entry(bit, name, doc),
        frame: Some(place),
        ..Flag::NONE
    }
}

/// Flags with their places in the frame.
pub const FLAGS: &[Flag] = &[
    flag(
        bits::TRUSTED,
        "trusted",
        0,
        "The mass of the load may be believed.",
    ),
    flag(bits::CARRIED, "carried", 1, "The load is in the bucket."),
    flag(
        bits::FINAL,
        "final",
        2,
        "The load was dumped: its mass does not change any more.",
    ),
    flag(
        bits::CARRY_BACK_WEIGHED,
        "carry_back_weighed",
        3,
        "What stayed in the bucket was weighed after this load; else it is the mean of earlier ones.",
    ),
    flag(
        bits::WEIGHED,
        "weighed",
        4,
        "The bucket was weighed at least once, `payload_age` ago.",
    ),
    flag(
        bits::TRUCK_TRUSTED,
        "truck_trusted",
        5,
        "The truck has loads, and each of them may be believed.",
    ),
    flag(
        bits::HAS_TARGET,
        "has_target",
        6,
        "Somebody said what the truck shall hold.",
    ),
    Flag {
        entry: entry(
            bits::OUTAGE,
            "outage",
            "A fault of a sensor left no load weighed for more than a tenth of the run: loads may be missing in the sums.",
        ),
        ..Flag::NONE
    },
];

/// Place of the flag of simulated samples in the frame.
pub const SIMULATED_PLACE: u32 = 7;

/// Stages of a load.
pub const STAGES: &[Entry] = &[
    entry(0, "carried", "In the bucket; its mass becomes better."),
    entry(
        1,
        "dumped",
        "Its mass is final, what stays in the bucket is not weighed yet.",
    ),
    entry(2, "settled", "What stays in the bucket is final too."),
];

/// Source of the mass of a load.
pub const WITNESSES: &[Entry] = &[
    entry(0, "motion", "How the machine accelerates."),
    entry(1, "pressure", "Cylinder pressures."),
    entry(2, "motion and pressure", "Both, in one state."),
    entry(3, "scale", "A scale on the machine: its mass is measured."),
    entry(
        4,
        "nothing",
        "Nothing: the bucket was seen to open, and the mass is what a load may be.",
    ),
];

/// Passes the fields of the message to the macro `$then`: name, place in the ledger, unit, meaning.
/// `codes` are whole numbers, codes and bits.
#[macro_export]
macro_rules! loads_fields {
    ($then:ident) => {
        $then! {
            numbers {
                payload (now.kg) "kg" "What the bucket holds now: always a value, the last known one where nothing weighs it.";
                payload_std (now.std) "kg" "Its standard deviation, which grows with time and by what may have changed.";
                payload_age (now.age.unwrap_or($crate::loads::NEVER)) "s" "Time since it was last weighed; 1e9 if it never was.";
                mass (load.weight.kg) "kg" "The latest load: what was in the bucket.";
                mass_std (load.weight.std) "kg" "Its standard deviation.";
                common_std (load.weight.common_std) "kg" "The part of `mass_std` that all loads share: it does not average out.";
                carry_back (load.carry_back.kg) "kg" "What stayed in the bucket.";
                carry_back_std (load.carry_back.std) "kg" "Its standard deviation.";
                delivered (delivered.kg) "kg" "What the truck got of this load.";
                delivered_std (delivered.std) "kg" "Its standard deviation.";
                filled (load.filled) "s" "Since when the bucket is known to hold the load.";
                dumped (load.dumped.unwrap_or_default()) "s" "When it began to leave; 0 while it is carried.";
                truck_mass (truck.total.kg) "kg" "What the truck holds.";
                truck_mass_std (truck.total.std()) "kg" "Its standard deviation.";
                target (truck.target.unwrap_or_default()) "kg" "What the truck shall hold; 0 if nobody said.";
                remaining (truck.remaining().unwrap_or_default()) "kg" "What is missing to the target, negative where there is too much; 0 without a target.";
            }
            codes {
                load (load.number) "Number of the latest load, from 1; 0 before the first one.";
                truck (truck.number) "Number of the truck that is being loaded, from 1.";
                truck_loads (truck.total.loads) "Loads that it holds.";
                truck_untrusted (truck.total.untrusted) "Of them those that may not be believed.";
                stage (load.stage.code()) "Code of how far the load has come.";
                witness (load.witness.code()) "Code of the source of its mass.";
                reason (load.why) "Code of the reason why it is not trusted.";
                flags (flags) "Bits of this message.";
            }
        }
    };
}

/// The age of a payload that was never weighed \[s\].
pub const NEVER: f64 = 1e9;

/// Quantities with a CAN frame; groups are relative to the first one of the machine.
pub const QUANTITIES: &[Quantity] = &[
    // Always sent: a controller gets the last known value, with a standard deviation that covers possible changes since.
    mass("payload", "payload_std", "bucket", 0, 0),
    mass("mass", "mass_std", "load", 1, bits::TRUSTED),
    mass(
        "truck_mass",
        "truck_mass_std",
        "truck",
        2,
        bits::TRUCK_TRUSTED,
    ),
    mass(
        "remaining",
        "truck_mass_std",
        "remaining",
        3,
        bits::TRUCK_TRUSTED | bits::HAS_TARGET,
    ),
];

/// Group of the frame with flags and numbers, relative to the same one.
pub const STATUS_GROUP: u16 = 4;

const fn mass(
    name: &'static str,
    std: &'static str,
    framed: &'static str,
    group: u16,
    trusted: u32,
) -> Quantity {
    Quantity {
        name,
        std: Some(std),
        unit: "kg",
        trusted,
        // 10 g to 41 946 t.
        frame: frame(framed, group, 0.01, -1e6),
        ..Quantity::NONE
    }
}
