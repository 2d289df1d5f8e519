//! Place of a number in a frame, and its interpretation.

/// Type of a signal's bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    /// Without a sign.
    Unsigned,
    /// Two's complement.
    Signed,
    /// IEEE 754, 32 bits.
    Float,
    /// IEEE 754, 64 bits.
    Double,
}

/// Place and meaning of a signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    /// Position of the first bit: the lowest of a little-endian signal, the highest of a big-endian one.
    pub start: usize,
    /// Bits, 1 to 64.
    pub length: usize,
    pub little_endian: bool,
    pub number: Number,
    pub scale: f64,
    pub offset: f64,
}

impl Layout {
    /// The bits of the signal; `None` if the frame is too short.
    pub(crate) fn raw(&self, data: &[u8]) -> Option<u64> {
        let mut raw = 0;
        let mut bit = self.start;
        for i in 0..self.length {
            let value = u64::from(*data.get(bit / 8)? >> (bit % 8) & 1);
            if self.little_endian {
                raw |= value << i;
                bit += 1;
            } else {
                // The start is the most significant bit; bits go down within a byte, then continue at
                // the top of the next.
                raw = raw << 1 | value;
                bit = if bit.is_multiple_of(8) {
                    bit + 15
                } else {
                    bit - 1
                };
            }
        }
        Some(raw)
    }

    /// The value in the DBC's unit; not finite if a float contains that.
    pub(crate) fn physical(&self, raw: u64) -> f64 {
        let unused = 64 - self.length as u32;
        let number = match self.number {
            Number::Unsigned => raw as f64,
            Number::Signed => ((raw << unused) as i64 >> unused) as f64,
            Number::Float => f64::from(f32::from_bits(raw as u32)),
            Number::Double => f64::from_bits(raw),
        };
        number * self.scale + self.offset
    }

    /// SAE J1939-71, tables 1 and 2: the largest values mean "error" and "not available". Of whole
    /// bytes all values from 0xFB.. are no measurements, of other lengths above a byte those that begin
    /// with 0xFE or 0xFF, of a few bits the last two values. Signed numbers have no such values.
    pub(crate) fn is_unavailable(&self, raw: u64) -> bool {
        let top = |bits: usize| raw >> (self.length - bits);
        match (self.number, self.length) {
            (Number::Unsigned, 1) => false,
            (Number::Unsigned, 2..8) => raw >= (1 << self.length) - 2,
            (Number::Unsigned, length) if length.is_multiple_of(8) => top(8) >= 0xfb,
            (Number::Unsigned, _) => top(8) >= 0xfe,
            _ => false,
        }
    }
}
