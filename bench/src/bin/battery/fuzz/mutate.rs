//! Small changes to an input.

use crate::attack::Rng;

/// Words that are critical for parsers.
const WORDS: [&[u8]; 24] = [
    b"nan",
    b"-inf",
    b"1e308",
    b"1e-320",
    b"-0",
    b"0",
    b"-1",
    b"4294967296",
    b"18446744073709551616",
    b"9223372036854775807",
    b"0.1",
    b"\"",
    b"'",
    b",",
    b";",
    b"\t",
    b"\n",
    b"\r\n",
    b"\0",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"[",
    b"=",
    b"1e999999999",
];

/// Mutates `input` in one to six places; `others` are sources of fragments.
pub fn mutate(input: &mut Vec<u8>, others: &[Vec<u8>], rng: &mut Rng) {
    for _ in 0..rng.between(1, 7) {
        let at = rng.between(0, input.len() as u64 + 1) as usize;
        let rest = input.len() - at;
        let length = (rng.between(1, 64) as usize).min(rest);
        match rng.between(0, 9) {
            0 if rest > 0 => input[at] ^= 1 << rng.between(0, 8),
            1 if rest > 0 => input[at] = rng.between(0, 256) as u8,
            2 => input.truncate(at),
            3 => drop(input.drain(at..at + length)),
            4 => {
                let copy = input[at..at + length].to_vec();
                input.splice(at..at, copy);
            }
            5 => {
                let word = rng.one(&WORDS);
                let replaced = if rng.between(0, 2) == 0 {
                    word.len().min(rest)
                } else {
                    0
                };
                input.splice(at..at + replaced, word.iter().copied());
            }
            6 => {
                // A binary number: a length, a count, a time.
                let number = rng.one(&[
                    0,
                    1,
                    0x7f,
                    0x80,
                    0xffff,
                    1 << 31,
                    u64::from(u32::MAX),
                    1 << 48,
                    u64::MAX,
                ]);
                let width = rng.one(&[1, 2, 4, 8]).min(rest);
                input[at..at + width].copy_from_slice(&number.to_le_bytes()[..width]);
            }
            7 => {
                let other = &others[rng.between(0, others.len() as u64) as usize];
                let from = rng.between(0, other.len() as u64 + 1) as usize;
                let part = &other[from..other.len().min(from + 16 * length)];
                input.splice(at..at + length, part.iter().copied());
            }
            _ => number_in_text(input, at, rng),
        }
    }
}

/// Replaces the first number in text after `at`.
fn number_in_text(input: &mut Vec<u8>, at: usize, rng: &mut Rng) {
    let digits = |b: &u8| b.is_ascii_digit() || *b == b'.';
    let Some(from) = input[at..].iter().position(digits).map(|i| at + i) else {
        return;
    };
    let length = input[from..].iter().take_while(|b| digits(b)).count();
    let word = rng.one(&WORDS[..10]);
    input.splice(from..from + length, word.iter().copied());
}
