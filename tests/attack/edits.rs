//! What happens to the bytes of a file, as data.

use fastrand::Rng;

/// Numbers that are none, or that a file should not hold.
const NUMBERS: [&str; 14] =
    ["NaN", "inf", "-inf", "1e39", "-1e39", "1e400", "0", "-0.0", "-1", "4294967296", "1e-45", "null", "\"x\"", "[1,2]"];
/// What stands between things.
const SIGNS: [&str; 16] = ["(", ")", "[", "]", "{", "}", ",", ":", "\"", "'", "/*", "//", "\u{0}", "é", "r#\"", "Some("];

/// One change.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Another bit.
    Flip(u32, u8),
    /// Another byte.
    Set(u32, u8),
    /// Bytes that come in.
    Insert(u32, String),
    /// So many bytes that go out.
    Delete(u32, u8),
    /// So many bytes that are there twice.
    Double(u32, u8),
    /// Everything behind it goes out.
    Cut(u32),
    /// Another number in the place of one.
    Number(u32, &'static str),
}

/// Changes of a seed.
pub fn edits(rng: &mut Rng) -> Vec<Edit> {
    (0..rng.u32(1..7)).map(|_| edit(rng)).collect()
}

fn edit(rng: &mut Rng) -> Edit {
    let at = rng.u32(..);
    match rng.u32(0..12) {
        0 => Edit::Flip(at, rng.u8(0..8)),
        1 => Edit::Set(at, rng.u8(..)),
        2 => Edit::Insert(at, SIGNS[rng.usize(0..SIGNS.len())].repeat(if rng.u32(0..20) == 0 { 5000 } else { 1 })),
        3 => Edit::Delete(at, rng.u8(1..20)),
        4 => Edit::Double(at, rng.u8(1..60)),
        5 if rng.u32(0..4) == 0 => Edit::Cut(at),
        _ => Edit::Number(at, NUMBERS[rng.usize(0..NUMBERS.len())]),
    }
}

/// Makes a change.
pub fn apply(bytes: &mut Vec<u8>, edit: &Edit) {
    let len = bytes.len();
    if len == 0 {
        return;
    }
    let place = |at: u32| at as usize % len;
    let span = |at: u32, count: u8| place(at)..(place(at) + usize::from(count)).min(len);
    match edit {
        Edit::Flip(at, bit) => bytes[place(*at)] ^= 1 << bit,
        Edit::Set(at, byte) => bytes[place(*at)] = *byte,
        Edit::Insert(at, text) => {
            bytes.splice(place(*at)..place(*at), text.bytes());
        }
        Edit::Delete(at, count) => {
            bytes.drain(span(*at, *count));
        }
        Edit::Double(at, count) => {
            let twice = bytes[span(*at, *count)].to_vec();
            bytes.splice(place(*at)..place(*at), twice);
        }
        Edit::Cut(at) => bytes.truncate(place(*at)),
        Edit::Number(at, text) => {
            let numbers = numbers(bytes);
            if !numbers.is_empty() {
                let number = numbers[*at as usize % numbers.len()].clone();
                bytes.splice(number, text.bytes());
            }
        }
    }
}

/// Where numbers are.
fn numbers(bytes: &[u8]) -> Vec<core::ops::Range<usize>> {
    let mut numbers = Vec::new();
    let mut start = None;
    for (i, byte) in bytes.iter().chain(b" ").enumerate() {
        let is_part = byte.is_ascii_digit() || (start.is_some() && b".eE+-".contains(byte));
        let after_word = start.is_none() && i > 0 && (bytes[i - 1].is_ascii_alphabetic() || bytes[i - 1] == b'_');
        match start {
            None if is_part && !after_word => start = Some(i),
            Some(begin) if !is_part => {
                numbers.push(begin..i);
                start = None;
            }
            _ => {}
        }
    }
    numbers
}
