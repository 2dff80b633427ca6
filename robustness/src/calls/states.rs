//! Serialized states, and corrupted ones.

use fastrand::Rng;
use fmi_export::abi::{Component, SavedState};
use sha2::{Digest, Sha256};

use super::arguments::{number, one_in, pick};
use crate::functions::Functions;

/// Bytes of the checksum in a serialized state.
const CHECKSUM: usize = 8;

/// End of the GUID within a serialized state: after the line that names the format, and the braces.
fn end_of_guid(bytes: &[u8]) -> Option<usize> {
    bytes.iter().position(|byte| *byte == b'}').map(|index| index + 1)
}

/// The state of an instance as bytes; `None` for an invalid handle.
pub fn serialized(f: &Functions, component: Component) -> Option<Vec<u8>> {
    let mut state: SavedState = std::ptr::null_mut();
    if (f.fmi2GetFMUstate)(component, &raw mut state) != 0 {
        return None;
    }
    let mut size = 0;
    assert_eq!((f.fmi2SerializedFMUstateSize)(component, state, &raw mut size), 0);
    let mut bytes = vec![0_u8; size];
    assert_eq!((f.fmi2SerializeFMUstate)(component, state, bytes.as_mut_ptr().cast(), size), 0);
    assert_eq!((f.fmi2FreeFMUstate)(component, &raw mut state), 0);
    Some(bytes)
}

/// The same bytes, or corrupted ones: changed, cut, extended, or changed with a valid checksum.
pub fn disturbed(rng: &mut Rng, mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.is_empty() || one_in(rng, 3) {
        return bytes;
    }
    match rng.u8(..8) {
        0 => bytes.truncate(rng.usize(..bytes.len())),
        1 => bytes.extend((0..rng.usize(1..50)).map(|_| rng.u8(..))),
        2 => {
            let place = rng.usize(..bytes.len());
            bytes[place] ^= rng.u8(1..);
        }
        _ => with_right_checksum(rng, &mut bytes),
    }
    bytes
}

/// Changes the content, and updates the checksum.
fn with_right_checksum(rng: &mut Rng, bytes: &mut Vec<u8>) {
    let Some(start) = end_of_guid(bytes).map(|end| end + CHECKSUM).filter(|start| *start < bytes.len()) else { return };
    for _ in 0..rng.usize(1..4) {
        let place = rng.usize(start..bytes.len());
        match rng.u8(..6) {
            0 => bytes[place] ^= 1 << rng.u8(..8),
            1 => bytes[place] = pick(rng, &[0, 1, 2, 0x7f, 0x80, 0xff]),
            2 => bytes.truncate((place + 1).max(start + 1)),
            3 => bytes.insert(place, rng.u8(..)),
            // Numbers may be at any offset, since lengths before them vary.
            _ if place + 8 <= bytes.len() => bytes[place..place + 8].copy_from_slice(&number(rng).to_le_bytes()),
            _ => {}
        }
    }
    let sum = Sha256::digest(&bytes[start..]);
    bytes[start - CHECKSUM..start].copy_from_slice(&sum[..CHECKSUM]);
}
