//! A saved state as bytes: format identification, GUID of the model, checksum, state. All are checked on reading.

use serde::{Serialize, de::DeserializeOwned};
use sha2::{Digest, Sha256};

use crate::error::{Error, Result};

/// Identification of the format; its number changes with the layout of the state.
fn format_identification(identifier: &str) -> Vec<u8> {
    format!("{identifier} state 3\n").into_bytes()
}

const CHECKSUM: usize = 8;

pub(crate) fn to_bytes<T: Serialize>(state: &T, identifier: &str, guid: &str) -> Result<Vec<u8>> {
    let body = postcard::to_allocvec(state)
        .map_err(|error| Error::new("FMU state", error.to_string(), "a state that can be written"))?;
    Ok([&format_identification(identifier), guid.as_bytes(), &checksum(&body), &body].concat())
}

pub(crate) fn from_bytes<T: DeserializeOwned>(bytes: &[u8], identifier: &str, guid: &str) -> Result<T> {
    let refuse = |found: &str| {
        Error::new(
            "serialized FMU state",
            found,
            "the bytes written by fmi2SerializeFMUstate of this model and version",
        )
    };
    let rest = bytes
        .strip_prefix(&*format_identification(identifier))
        .ok_or_else(|| refuse(&format!("{} bytes without this format's mark", bytes.len())))?;
    let rest = rest.strip_prefix(guid.as_bytes()).ok_or_else(|| refuse("the state of another model"))?;
    let (sum, body) = rest.split_at_checked(CHECKSUM).ok_or_else(|| refuse("a truncated state"))?;
    if sum != checksum(body) {
        return Err(refuse("a wrong checksum: bytes were changed or cut off"));
    }
    let (state, left) = postcard::take_from_bytes(body).map_err(|error| refuse(&error.to_string()))?;
    if left.is_empty() { Ok(state) } else { Err(refuse(&format!("{} bytes too many", left.len()))) }
}

fn checksum(body: &[u8]) -> [u8; CHECKSUM] {
    let hash = Sha256::digest(body);
    std::array::from_fn(|index| hash[index])
}
