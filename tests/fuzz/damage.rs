//! Damage: flipped bits, lost, doubled and foreign stretches, tokens exchanged, numbers at their extremes.

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Words that readers stumble over.
pub(crate) const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "1e999",
    "-1e999",
    "1e308",
    "5e-324",
    "1e-300",
    "nan",
    "inf",
    "0x7f",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "1e17",
    "0.1e-1",
    "1/0",
    "1_000",
    "1e",
    "..",
    "-",
    "\"",
    "\"1 m\"",
    "\"1e300 kg\"",
    "\"0 s\"",
    "[]",
    "[0, 0]",
    "{}",
    "true",
];

/// The generator of one input.
pub(crate) fn generator(name: &str, number: u64) -> Pcg64Mcg {
    // FNV-1a: Fowler, Noll and Vo.
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325, step);
    Pcg64Mcg::seed_from_u64(hash ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// One of the seeds with one to four faults; texts have `words` to choose from.
pub(crate) fn damaged(seeds: &[Vec<u8>], words: &[&str], random: &mut impl Rng) -> Vec<u8> {
    let mut bytes = seeds[random.random_range(0..seeds.len())].clone();
    // Many a fault is found only behind the first check: most inputs have few.
    let n_faults = if random.random() { 1 } else { random.random_range(1..=4) };
    for _ in 0..n_faults {
        let n_kinds = if words.is_empty() { 5 } else { 12 };
        match random.random_range(0..n_kinds) {
            0 => flip(&mut bytes, random),
            1 if random.random_range(0..4) == 0 => {
                let (end, _) = stretch(bytes.len(), random);
                bytes.truncate(end);
            }
            1 => {
                let at = random.random_range(0..=bytes.len());
                bytes.insert(at, random.random());
            }
            2 => {
                let (from, to) = stretch(bytes.len(), random);
                bytes.drain(from..to);
            }
            3 => {
                let other = &seeds[random.random_range(0..seeds.len())];
                let (from, to) = stretch(other.len(), random);
                let at = random.random_range(0..=bytes.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            4 => {
                // Eight bytes at once: a length or a number.
                let at = random.random_range(0..=bytes.len());
                let to = (at + 8).min(bytes.len());
                let value: u64 =
                    [0, 1, u64::MAX, i64::MAX as u64, f64::NAN.to_bits(), random.random()]
                        [random.random_range(0..6)];
                bytes.splice(at..to, value.to_le_bytes()[..to - at].iter().copied());
            }
            5..=7 => exchange(&mut bytes, None, random),
            _ => {
                let word = words[random.random_range(0..words.len())];
                exchange(&mut bytes, Some(word), random);
            }
        }
    }
    bytes
}

fn flip(bytes: &mut [u8], random: &mut impl Rng) {
    if !bytes.is_empty() {
        let at = random.random_range(0..bytes.len());
        bytes[at] ^= 1 << random.random_range(0..8);
    }
}

fn stretch(length: usize, random: &mut impl Rng) -> (usize, usize) {
    let from = random.random_range(0..=length);
    let longest = if random.random_range(0..8) == 0 { 2000 } else { 16 };
    (from, (from + random.random_range(0..longest)).min(length))
}

/// Puts `word`, or another token of the text, in the place of a token.
fn exchange(bytes: &mut Vec<u8>, word: Option<&str>, random: &mut impl Rng) {
    let token = |random: &mut dyn FnMut(usize) -> usize| {
        let is_inside = |byte: &u8| byte.is_ascii_alphanumeric() || b"._".contains(byte);
        let at = random(bytes.len() + 1);
        let from = at + bytes[at..].iter().position(is_inside)?;
        let begin = from - bytes[..from].iter().rev().take_while(|byte| is_inside(byte)).count();
        let length = bytes[begin..].iter().take_while(|byte| is_inside(byte)).count();
        Some(begin..begin + length)
    };
    let mut below = |n: usize| random.random_range(0..n);
    let (Some(old), Some(other)) = (token(&mut below), token(&mut below)) else { return };
    let new = word.map_or_else(|| bytes[other].to_vec(), |word| word.as_bytes().to_vec());
    bytes.splice(old, new);
}
