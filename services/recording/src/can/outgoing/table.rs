//! The frames of a machine, from the rows of its sheet.

use messages::channels::Channel;
use messages::{Machine, SIMULATED};
use sheet::{Flag, VerdictFrame, count_framed, count_framed_flags, loads};

/// A quantity with its standard deviation.
#[derive(Clone, Copy)]
pub(crate) struct Quantity {
    pub name: &'static str,
    /// Names of its signals in the DBC and of their fields in the message.
    pub field: &'static str,
    pub std_field: &'static str,
    pub unit: &'static str,
    /// Value of one bit.
    pub scale: f64,
    /// Value of the raw number 0.
    pub offset: f64,
    /// Bits that must be set: the method estimates the quantity; it is trusted. 0: always.
    pub estimated: u32,
    pub trusted: u32,
    /// Its default parameter group.
    pub group: u16,
}

impl std::fmt::Debug for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// The frames of one machine.
pub(crate) struct FrameTable {
    pub machine: Machine,
    /// Its channels of estimates, the main one first.
    pub channels: &'static [&'static Channel],
    pub quantities: &'static [Quantity],
    /// Flags of the verdict, in the order of their places.
    pub flags: &'static [(&'static str, u32)],
    /// Default parameter group of the verdict.
    pub verdict: u16,
    /// The channel of its loads.
    pub loads: &'static Channel,
    /// First default parameter group of their frames.
    pub loads_group: u16,
}

/// Quantities of loads, the same for every machine; groups count from the machine's first one.
pub(crate) const LOADS: &[Quantity] =
    &quantities::<{ count_framed(loads::QUANTITIES) }>(loads::QUANTITIES);

/// Flags of loads, each at its place.
pub(crate) const LOADS_FLAGS: &[(&str, u32)] = &flags::<{ count_framed_flags(loads::FLAGS) }>(
    loads::FLAGS,
    VerdictFrame {
        group: loads::STATUS_GROUP,
        simulated: loads::SIMULATED_PLACE,
    },
);

/// A whole number in a frame of flags.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Number {
    /// Name of its signal in the DBC and of its field in the message.
    pub field: &'static str,
    /// First bit, and number of bits.
    pub at: u32,
    pub bits: u32,
    pub unit: &'static str,
    /// Its meaning; empty if its values have names.
    pub doc: &'static str,
}

impl Number {
    /// Largest valid number (J1939-71): the larger ones mean "error" and "not available".
    pub(crate) const fn largest(&self) -> u64 {
        (0xfa << (self.bits - 8)) | ((1 << (self.bits - 8)) - 1)
    }
}

/// Code of the reason, in the last byte of every frame of flags.
const REASON: Number = number("reason", 56, 8, "", "");

/// The numbers beside the flags of a verdict.
pub(crate) const VERDICT_NUMBERS: &[Number] = &[REASON];

/// The numbers beside the flags of loads.
pub(crate) const LOADS_NUMBERS: &[Number] = &[
    number("load", 16, 16, "", "number of the latest load"),
    number(
        "truck",
        32,
        16,
        "",
        "number of the truck that is being loaded",
    ),
    number(
        "payload_age",
        48,
        8,
        "s",
        "time since the bucket was weighed",
    ),
    REASON,
];

const fn number(
    field: &'static str,
    at: u32,
    bits: u32,
    unit: &'static str,
    doc: &'static str,
) -> Number {
    Number {
        field,
        at,
        bits,
        unit,
        doc,
    }
}

/// The `N` quantities that have a frame, in the order of their groups.
pub(crate) const fn quantities<const N: usize>(all: &[sheet::Quantity]) -> [Quantity; N] {
    let mut framed = [Quantity {
        name: "",
        field: "",
        std_field: "",
        unit: "",
        scale: 1.0,
        offset: 0.0,
        estimated: 0,
        trusted: 0,
        group: u16::MAX,
    }; N];
    let (mut count, mut i) = (0, 0);
    while i < all.len() {
        if let (Some(frame), Some(std_field)) = (all[i].frame, all[i].std) {
            let mut place = count;
            while place > 0 && framed[place - 1].group > frame.group {
                framed[place] = framed[place - 1];
                place -= 1;
            }
            framed[place] = Quantity {
                name: frame.name,
                field: all[i].name,
                std_field,
                unit: all[i].unit,
                scale: frame.scale,
                offset: frame.offset,
                estimated: all[i].estimated,
                trusted: all[i].trusted,
                group: frame.group,
            };
            count += 1;
        }
        i += 1;
    }
    assert!(count == N, "N is the number of quantities with a frame");
    framed
}

/// The `N` flags of the verdict's frame, each at its place.
pub(crate) const fn flags<const N: usize>(
    all: &[Flag],
    verdict: VerdictFrame,
) -> [(&'static str, u32); N] {
    let mut framed = [("", 0); N];
    framed[verdict.simulated as usize] = ("simulated", SIMULATED);
    let mut i = 0;
    while i < all.len() {
        if let Some(place) = all[i].frame {
            framed[place as usize] = (all[i].entry.name, all[i].entry.number);
        }
        i += 1;
    }
    framed
}
