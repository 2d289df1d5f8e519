//! The frames of a machine, from the rows of its sheet.

use messages::channels::Channel;
use messages::{Machine, SIMULATED};
use sheet::{Flag, VerdictFrame};

/// A quantity with its standard deviation.
#[derive(Clone, Copy)]
pub(crate) struct Quantity {
    pub name: &'static str,
    /// Names of its signals in the DBC and of their fields in the message.
    pub field: &'static str,
    pub std_field: &'static str,
    pub unit: &'static str,
    /// Of one bit.
    pub scale: f64,
    /// Of the value 0.
    pub offset: f64,
    /// Bits that say that the method estimates it, and that it may be believed.
    pub estimated: u32,
    pub trusted: u32,
    /// Its usual parameter group.
    pub group: u16,
}

impl std::fmt::Debug for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What the frames of one machine are.
pub(crate) struct FrameTable {
    pub machine: Machine,
    /// Its channels of estimates, the main one first.
    pub channels: &'static [&'static Channel],
    pub quantities: &'static [Quantity],
    /// Flags of the verdict, in the order of their places.
    pub flags: &'static [(&'static str, u32)],
    /// Usual parameter group of the verdict.
    pub verdict: u16,
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
