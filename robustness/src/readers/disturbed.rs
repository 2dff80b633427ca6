//! Corrupted files: valid ones, changed in bytes, numbers, words or length, compressed, or all of these.

use std::io::Write as _;

use fastrand::Rng;
use flate2::{Compression, write::GzEncoder};

/// Edge cases of readers.
const TEXTS: [&str; 40] = [
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e309",
    "-1e309",
    "5e-324",
    "1e-400",
    "-0",
    "0x10",
    "1_000",
    "1,5",
    "1.5.5",
    "",
    " ",
    "\"",
    "\"\"",
    "'",
    "\r\n",
    "\n",
    "\r",
    "\t",
    ";",
    "#",
    "\u{feff}",
    "\u{202e}",
    "time",
    "command",
    "[",
    "]",
    "{",
    "}",
    "=",
    "[[record]]",
    "[effects.x]",
    "12:00:00",
    "2024-02-30T25:61:61Z",
    "../../etc/passwd",
    "%s%n",
    "99999999999999999999999999",
];

/// A file drawn from these.
pub fn file(rng: &mut Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[rng.usize(..seeds.len())].clone();
    if rng.u8(..20) == 0 {
        bytes = (0..rng.usize(..2000)).map(|_| rng.u8(..)).collect();
    }
    for _ in 0..rng.usize(..5) {
        disturb(rng, &mut bytes, seeds);
    }
    if rng.u8(..16) == 0 {
        bytes = compressed(&bytes);
        if rng.bool() {
            disturb(rng, &mut bytes, seeds);
        }
    }
    bytes
}

fn place(rng: &mut Rng, bytes: &[u8]) -> usize {
    rng.usize(..=bytes.len())
}

fn disturb(rng: &mut Rng, bytes: &mut Vec<u8>, seeds: &[Vec<u8>]) {
    let at = place(rng, bytes);
    match rng.u8(..12) {
        0 => bytes.truncate(at),
        1 => bytes.insert(at, rng.u8(..)),
        2 | 3 if at < bytes.len() => bytes[at] ^= 1 << rng.u8(..8),
        4 if at < bytes.len() => bytes[at] = [0, 0xff, 0x7f, b'\n', b'"', b','][rng.usize(..6)],
        5 => drop(bytes.drain(at..(at + rng.usize(..100)).min(bytes.len()))),
        6 => {
            // A part repeated, up to many times.
            let part = bytes[at..(at + rng.usize(..200)).min(bytes.len())].to_vec();
            let times = if rng.u8(..50) == 0 { 2000 } else { rng.usize(..4) };
            bytes.splice(at..at, part.repeat(times));
        }
        7 => {
            // The beginning of this and the end of another.
            let other = &seeds[rng.usize(..seeds.len())];
            bytes.truncate(at);
            bytes.extend(&other[place(rng, other)..]);
        }
        8 if rng.u8(..20) == 0 => {
            // Deep nesting, or a length without end.
            let deep = ["[", "{a=", "<a>", "\"", "1", ",", "\n"][rng.usize(..7)].repeat(rng.usize(..100_000));
            bytes.splice(at..at, deep.into_bytes());
        }
        _ => number_or_word(rng, bytes, at),
    }
}

/// Replaces the number or word there.
fn number_or_word(rng: &mut Rng, bytes: &mut Vec<u8>, at: usize) {
    let is_inside = |byte: &u8| byte.is_ascii_alphanumeric() || b"._+-".contains(byte);
    let start = bytes[..at].iter().rposition(|byte| !is_inside(byte)).map_or(0, |index| index + 1);
    let end = bytes[at..].iter().position(|byte| !is_inside(byte)).map_or(bytes.len(), |index| at + index);
    let text = match rng.u8(..4) {
        0 => format!("{}", f64::from_bits(rng.u64(..))),
        1 => format!("{}", rng.i64(..)),
        _ => TEXTS[rng.usize(..TEXTS.len())].to_owned(),
    };
    bytes.splice(start..end, text.into_bytes());
}

/// By gzip.
pub fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

/// A resource location.
pub fn location(rng: &mut Rng) -> Vec<u8> {
    const PARTS: [&str; 18] = [
        "file:",
        "file://",
        "file:///",
        "/",
        "//",
        "localhost",
        "%20",
        "%",
        "%zz",
        "%00",
        "..",
        "C:",
        "\\",
        "tmp",
        "dev/zero",
        "http://",
        "ä",
        "\u{ff}",
    ];
    let mut text: Vec<u8> = (0..rng.usize(..8)).flat_map(|_| PARTS[rng.usize(..PARTS.len())].bytes()).collect();
    if rng.u8(..4) == 0 {
        text.insert(rng.usize(..=text.len()), rng.u8(1..));
    }
    if rng.u8(..100) == 0 {
        text = text.repeat(1000);
    }
    text
}
