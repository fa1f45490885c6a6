//! Bytes as letters of a page: two of 91 letters for 13 bits, or 14 where these fit, a fifth fewer than base64 has more.
//!
//! The scheme is that of basE91 (J. Henke, 2005) with other letters: those of ASCII that can be seen, but `<`, `&` and `\`,
//! which would end or change what is around them.

/// Letters, and values of a pair of them: 91² = 8281 holds all 13 bits and some of 14.
const BASE: u32 = 91;
/// Values below it, of 13 bits, take a fourteenth.
const SPARE: u32 = BASE * BASE - (1 << 13);

/// The letter of a number below [`BASE`].
fn letter(number: u32) -> char {
    // From `!` on, without `&`, `<` and `\`.
    let code = [0x26, 0x3c, 0x5c]
        .iter()
        .fold(0x21 + number, |code, left_out| code + u32::from(code >= *left_out));
    char::from_u32(code).expect("a letter of ASCII")
}

/// Bytes in letters.
pub(crate) fn encoded(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() * 5 / 4 + 2);
    let (mut waiting, mut n_bits) = (0_u32, 0);
    for &byte in bytes {
        waiting |= u32::from(byte) << n_bits;
        n_bits += 8;
        if n_bits > 13 {
            let low = waiting & 0x1fff;
            let (value, n_taken) = if low < SPARE { (waiting & 0x3fff, 14) } else { (low, 13) };
            waiting >>= n_taken;
            n_bits -= n_taken;
            text.extend([letter(value % BASE), letter(value / BASE)]);
        }
    }
    if n_bits > 0 {
        text.push(letter(waiting % BASE));
        if n_bits > 7 || waiting >= BASE {
            text.push(letter(waiting / BASE));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes of letters, as the script of a page reads them.
    fn decoded(text: &str) -> Vec<u8> {
        let numbers: Vec<u32> =
            text.chars().map(|c| (0..BASE).find(|k| letter(*k) == c).expect("a letter")).collect();
        let mut bytes = Vec::new();
        let (mut waiting, mut n_bits) = (0_u32, 0);
        let mut drained = |waiting: &mut u32, n_bits: &mut u32| {
            while *n_bits > 7 {
                bytes.push(waiting.to_le_bytes()[0]);
                *waiting >>= 8;
                *n_bits -= 8;
            }
        };
        for pair in numbers.chunks(2) {
            let (value, n) = match *pair {
                [low, high] => {
                    let value = low + BASE * high;
                    (value, if value & 0x1fff < SPARE { 14 } else { 13 })
                }
                [last] => (last, 8 - n_bits % 8),
                _ => continue,
            };
            waiting |= value << n_bits;
            n_bits += n;
            drained(&mut waiting, &mut n_bits);
        }
        bytes
    }

    #[test]
    fn letters_are_91_and_end_nothing() {
        let all: String = (0..BASE).map(letter).collect();
        assert_eq!(all.len(), 91);
        assert!(all.starts_with('!') && all.ends_with('~') && !all.contains(['<', '&', '\\']));
    }

    #[test]
    fn bytes_come_back() {
        let mut state = 1_u32;
        for n in (0..40).chain([1000, 4099]) {
            let bytes: Vec<u8> = (0..n)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    state.to_be_bytes()[0]
                })
                .collect();
            let text = encoded(&bytes);
            assert_eq!(decoded(&text), bytes, "{n} bytes");
            assert!(100 * text.len() <= 124 * bytes.len() + 200, "{n}: {}", text.len());
        }
    }
}
