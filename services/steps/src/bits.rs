//! Conditions as bits of a message.

/// The bits whose condition holds.
pub(crate) fn set_bits(bits: &[(u32, bool)]) -> u32 {
    bits.iter()
        .filter(|(_, set)| *set)
        .fold(0, |all, (bit, _)| all | bit)
}
