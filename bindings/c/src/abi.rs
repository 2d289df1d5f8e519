//! A checksum of everything that a program compiles in from the header: another header gives another number.

use core::mem::size_of;

use estimation::loads::LoadReport;

use crate::loads::LoadsRow;
use crate::settings::places;
use crate::table::{Bit, Machine};
use crate::{Excavator, Loader};

/// `HEFT_ABI` of the header of this library.
#[must_use]
pub fn sum() -> u32 {
    let sum = machine::<Loader>(machine::<Excavator>(0x811c_9dc5));
    let loads = [size_of::<LoadsRow>() as u8, size_of::<LoadReport>() as u8];
    add(sum, &loads)
}

/// FNV-1a; each text is terminated by a byte that occurs in no text.
fn add(sum: u32, text: &[u8]) -> u32 {
    text.iter().chain(&[0xff]).fold(sum, |sum, byte| {
        (sum ^ u32::from(*byte)).wrapping_mul(0x0100_0193)
    })
}

fn bits<E>(sum: u32, bits: &[Bit<E>]) -> u32 {
    bits.iter()
        .fold(sum, |sum, bit| add(sum, bit.name.as_bytes()))
}

fn machine<M: Machine>(sum: u32) -> u32 {
    let signals = M::SIGNALS.iter().map(|signal| signal.name);
    let values = M::VALUES.iter().map(|value| value.name);
    let names = signals.chain(values).chain(M::METHODS.iter().copied());
    let sum = names.fold(sum, |sum, name| add(sum, name.as_bytes()));
    let sum = bits(bits(sum, M::FLAGS), M::ESTIMATED);
    places(&M::Settings::default()).fold(sum, |sum, place| {
        let sum = add(add(sum, place.table.as_bytes()), place.key.name.as_bytes());
        add(sum, &[place.width() as u8])
    })
}
