//! UTF-16 text, as written by Windows programs, read as UTF-8.

use std::{
    char::REPLACEMENT_CHARACTER,
    io::{Cursor, Read, Result},
    mem,
};

use super::source::Source;

/// Byte order of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Low byte first.
    Little,
    /// High byte first.
    Big,
}

impl ByteOrder {
    /// Byte order of a UTF-16 text, detected from its mark, or from two ASCII letters at its start; `None` if it is not UTF-16.
    #[must_use]
    pub fn of(beginning: &[u8]) -> Option<Self> {
        match beginning {
            // A mark of UTF-32.
            [0xff, 0xfe, 0, 0, ..] => None,
            [0xff, 0xfe, ..] => Some(Self::Little),
            [0xfe, 0xff, ..] => Some(Self::Big),
            [1..=0x7f, 0, 1..=0x7f, 0, ..] => Some(Self::Little),
            [0, 1..=0x7f, 0, 1..=0x7f, ..] => Some(Self::Big),
            _ => None,
        }
    }

    fn unit(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Little => u16::from_le_bytes(bytes),
            Self::Big => u16::from_be_bytes(bytes),
        }
    }
}

/// Reads UTF-16 text as UTF-8; invalid units become U+FFFD.
pub struct Utf16<R> {
    bytes: R,
    order: ByteOrder,
    /// Bytes not decoded yet: the beginning, later half of a character.
    pending: Vec<u8>,
    text: Cursor<Vec<u8>>,
}

/// Buffer size in bytes: even, so that a unit is only split at the end.
const CHUNK_BYTES: u64 = 1 << 16;

impl<R: Read> Utf16<R> {
    /// Continues with `bytes` after a beginning with an even number of bytes, unless they end there.
    pub fn new(beginning: Vec<u8>, bytes: R, order: ByteOrder) -> Self {
        Self { bytes, order, pending: beginning, text: Cursor::default() }
    }

    fn refill(&mut self) -> Result<()> {
        let mut bytes = mem::take(&mut self.pending);
        let ended = (self.bytes.by_ref().take(CHUNK_BYTES).read_to_end(&mut bytes)? as u64) < CHUNK_BYTES;
        let (units, rest) = bytes.as_chunks();
        let mut units: Vec<u16> = units.iter().map(|unit| self.order.unit(*unit)).collect();
        let is_half = |unit: &mut u16| !ended && (0xd800..0xdc00).contains(unit);
        if units.pop_if(is_half).is_some() {
            self.pending = bytes[2 * units.len()..].to_vec();
        }
        let odd = (!rest.is_empty()).then_some(REPLACEMENT_CHARACTER);
        let letters = char::decode_utf16(units).map(|letter| letter.unwrap_or(REPLACEMENT_CHARACTER));
        self.text = Cursor::new(letters.chain(odd).collect::<String>().into_bytes());
        Ok(())
    }
}

/// A text as UTF-8, whether it is UTF-16 or not.
///
/// # Errors
/// Those of the reader.
pub fn as_utf8<'a>(mut text: impl Read + 'a) -> Result<Box<dyn Read + 'a>> {
    let mut beginning = Vec::new();
    text.by_ref().take(4).read_to_end(&mut beginning)?;
    Ok(match ByteOrder::of(&beginning) {
        Some(order) => Box::new(Utf16::new(beginning, text, order)),
        None => Box::new(Cursor::new(beginning).chain(text)),
    })
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.text.position() == self.text.get_ref().len() as u64 {
            self.refill()?;
        }
        self.text.read(buffer)
    }
}

impl Source for Utf16<Box<dyn Source>> {
    fn sha256(&self) -> String {
        self.bytes.sha256()
    }

    fn size(&self) -> Option<u64> {
        self.bytes.size().map(|size| size / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One byte at a time, like a very slow pipe.
    struct Slow<'a>(&'a [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
            let count = buffer.len().min(1);
            self.0.read(&mut buffer[..count])
        }
    }

    fn read(bytes: &[u8]) -> String {
        let (beginning, rest) = bytes.split_at(bytes.len().min(4));
        let mut text = String::new();
        let order = ByteOrder::of(beginning).unwrap();
        Utf16::new(beginning.to_vec(), Slow(rest), order).read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn letters_are_read_in_both_orders_wherever_a_chunk_ends() {
        // RFC 2781, 3: U+12345 is D808 DF45.
        assert_eq!(read(b"\xfe\xff\xd8\x08\xdf\x45\x00=\x00R"), "\u{feff}\u{12345}=R");
        assert_eq!(read(b"\xff\xfe\x08\xd8\x45\xdf=\x00R\x00"), "\u{feff}\u{12345}=R");
        for before in 0..4 {
            let text = format!("time{}{}", " ".repeat(before), "\u{12345}".repeat(40_000));
            let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
            assert!(read(&little) == text && read(&big) == text, "{before}");
        }
    }

    #[test]
    fn what_is_cut_off_is_no_letter() {
        assert_eq!(read(b"a\0b\0c"), "ab\u{fffd}");
        assert_eq!(read(b"a\0b\0\x08\xd8"), "ab\u{fffd}");
        assert_eq!(read(b"a\0b\0\x08\xd8c\0"), "ab\u{fffd}c");
    }

    #[test]
    fn other_text_is_not_taken_for_it() {
        for text in
            [b"time".as_slice(), b"\xef\xbb\xbftime", b"ti\0me", b"\xff\xfe\0\0t\0\0\0", b"t\0\0\0i\0\0\0", b"", b"t"]
        {
            assert_eq!(ByteOrder::of(text), None, "{text:?}");
        }
    }
}
