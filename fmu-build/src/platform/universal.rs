//! One file for both kinds of Mac: a universal binary, which contains a library for each processor after a table of them.
//!
//! All numbers of the table are big-endian (`mach-o/fat.h`): the magic, the count, then for each library processor,
//! sub-type, offset, size and the alignment of the offset as a power of two.

/// `FAT_MAGIC`.
const MAGIC: u32 = 0xcafe_babe;
/// Pages of Macs with an ARM processor, 16 kB, as the power of two.
const ALIGNMENT: u32 = 14;
/// Offset of the processor in a library, little-endian, after the magic number.
const PROCESSOR_OFFSET: usize = 4;
const HEADER_SIZE: usize = 8;
const ENTRY_SIZE: usize = 20;

/// The universal binary of these libraries; `None` if one of them is too short to be a library, or too long for the table.
pub(crate) fn join(libraries: &[Vec<u8>]) -> Option<Vec<u8>> {
    let aligned = |size: usize| size.next_multiple_of(1 << ALIGNMENT);
    let mut header = Vec::new();
    header.extend(MAGIC.to_be_bytes());
    header.extend(u32::try_from(libraries.len()).ok()?.to_be_bytes());
    let mut offset = aligned(HEADER_SIZE + ENTRY_SIZE * libraries.len());
    let mut body: Vec<(usize, &[u8])> = Vec::new();
    for library in libraries {
        for part in 0..2 {
            let start = PROCESSOR_OFFSET + 4 * part; // processor, then its sub-type
            let word = library.get(start..)?.first_chunk()?;
            header.extend(u32::from_le_bytes(*word).to_be_bytes());
        }
        for number in [offset, library.len()] {
            header.extend(u32::try_from(number).ok()?.to_be_bytes());
        }
        header.extend(ALIGNMENT.to_be_bytes());
        body.push((offset, library));
        offset = aligned(offset + library.len());
    }
    let mut file = header;
    for (offset, library) in body {
        file.resize(offset, 0);
        file.extend(library);
    }
    Some(file)
}

/// `CPU_TYPE_ARM64`.
const ARM64: u32 = 0x0100_000c;

/// The library for Macs with an ARM processor: a part of a universal binary, or a whole other one; `None` if there is none.
pub(crate) fn for_arm(binary: &[u8]) -> Option<&[u8]> {
    let number = |at: usize| binary.get(at..)?.first_chunk().map(|word| u32::from_be_bytes(*word));
    let size = |at: usize| usize::try_from(number(at)?).ok();
    if number(0)? != MAGIC {
        let word = binary.get(PROCESSOR_OFFSET..)?.first_chunk()?;
        return (u32::from_le_bytes(*word) == ARM64).then_some(binary);
    }
    let entries = (0..size(4)?).map(|index| HEADER_SIZE + ENTRY_SIZE * index);
    let entry = entries.take_while(|at| number(*at).is_some()).find(|at| number(*at) == Some(ARM64))?;
    binary.get(size(entry + 8)?..)?.get(..size(entry + 12)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn library(processor: u32, size: usize) -> Vec<u8> {
        let mut bytes = vec![0xcf, 0xfa, 0xed, 0xfe];
        bytes.extend(processor.to_le_bytes());
        bytes.extend(3_u32.to_le_bytes());
        bytes.resize(size, 7);
        bytes
    }

    #[test]
    fn each_library_lies_where_the_table_says() {
        let libraries = [library(0x0100_0007, 20_000), library(0x0100_000c, 100)];
        let file = join(&libraries).unwrap();
        assert!(crate::platform::Platform::Darwin64.recognises(&file));
        let number = |at: usize| u32::from_be_bytes(*file[at..].first_chunk().unwrap()) as usize;
        assert_eq!(number(4), 2);
        for (index, library) in libraries.iter().enumerate() {
            let entry = HEADER_SIZE + ENTRY_SIZE * index;
            let (offset, size) = (number(entry + 8), number(entry + 12));
            assert_eq!(offset % (1 << number(entry + 16)), 0);
            assert_eq!(&file[offset..offset + size], &library[..]);
            assert_eq!(number(entry), [0x0100_0007, 0x0100_000c][index]);
        }
    }

    #[test]
    fn the_library_for_arm_is_found_again() {
        let (intel, arm) = (library(0x0100_0007, 20_000), library(ARM64, 100));
        assert_eq!(for_arm(&join(&[intel.clone(), arm.clone()]).unwrap()), Some(&arm[..]));
        assert_eq!(for_arm(&arm), Some(&arm[..]));
        assert_eq!(for_arm(&intel), None);
        assert_eq!(for_arm(&join(&[intel]).unwrap()), None);
        assert_eq!(for_arm(&MAGIC.to_be_bytes()), None);
    }

    #[test]
    fn what_is_too_short_is_refused() {
        assert_eq!(join(&[vec![0xcf, 0xfa, 0xed, 0xfe]]), None);
    }
}
