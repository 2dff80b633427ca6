//! Detects from the first bytes whether a file is a binary for a platform.
//!
//! A library compiled for another machine can be packaged and fails months later in some importer, with a message such as "invalid ELF
//! header". Three file formats, read as far as the field of the processor:
//!
//! - ELF: magic, then at byte 18 the machine, 16 bits little-endian (System V ABI, figure 4-3);
//! - PE: at byte 0x3c the offset of `PE\0\0`, followed by the machine (Microsoft PE format, section 3.3);
//! - Mach-O: the 64-bit or the universal magic (`mach-o/loader.h`, `mach-o/fat.h`).
//!
//! Our own, since the crate `object` parses sections and symbols, whereas only one number at a known place is needed here.

use super::Platform;

const ELF_MAGIC: &[u8] = b"\x7fELF";
const ELF_MACHINE_OFFSET: usize = 18;
const ELF_X86: u16 = 3;
const ELF_X86_64: u16 = 62;
const ELF_AARCH64: u16 = 183;

const PE_OFFSET_OFFSET: usize = 0x3c;
const PE_MAGIC: &[u8] = b"PE\0\0";
const PE_X86: u16 = 0x14c;
const PE_X86_64: u16 = 0x8664;

const MACHO_64: &[u8] = &[0xcf, 0xfa, 0xed, 0xfe];
const MACHO_UNIVERSAL: &[u8] = &[0xca, 0xfe, 0xba, 0xbe];

impl Platform {
    /// Whether these bytes begin like a binary for this platform.
    #[must_use]
    pub fn recognises(self, binary: &[u8]) -> bool {
        match self {
            Self::Linux64 => elf_machine(binary) == Some(ELF_X86_64),
            Self::Linux32 => elf_machine(binary) == Some(ELF_X86),
            Self::Aarch64Linux => elf_machine(binary) == Some(ELF_AARCH64),
            Self::Win64 => pe_machine(binary) == Some(PE_X86_64),
            Self::Win32 => pe_machine(binary) == Some(PE_X86),
            Self::Darwin64 => binary.starts_with(MACHO_64) || binary.starts_with(MACHO_UNIVERSAL),
        }
    }
}

fn elf_machine(binary: &[u8]) -> Option<u16> {
    binary.starts_with(ELF_MAGIC).then_some(())?;
    read_u16(binary, ELF_MACHINE_OFFSET)
}

fn pe_machine(binary: &[u8]) -> Option<u16> {
    let offset_bytes = binary.get(PE_OFFSET_OFFSET..)?.first_chunk()?;
    let offset = usize::try_from(u32::from_le_bytes(*offset_bytes)).ok()?;
    binary.get(offset..)?.starts_with(PE_MAGIC).then_some(())?;
    read_u16(binary, offset.checked_add(PE_MAGIC.len())?)
}

fn read_u16(bytes: &[u8], offset: usize) -> Option<u16> {
    bytes.get(offset..)?.first_chunk().map(|chunk| u16::from_le_bytes(*chunk))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elf(machine: u16) -> Vec<u8> {
        let mut bytes = ELF_MAGIC.to_vec();
        bytes.resize(ELF_MACHINE_OFFSET, 0);
        bytes.extend(machine.to_le_bytes());
        bytes
    }

    fn pe(machine: u16) -> Vec<u8> {
        let mut bytes = b"MZ".to_vec();
        bytes.resize(PE_OFFSET_OFFSET, 0);
        bytes.extend(0x80_u32.to_le_bytes());
        bytes.resize(0x80, 0);
        bytes.extend(PE_MAGIC);
        bytes.extend(machine.to_le_bytes());
        bytes
    }

    #[test]
    fn each_binary_is_recognised_by_its_own_platform_only() {
        let binaries = [
            (Platform::Linux64, elf(ELF_X86_64)),
            (Platform::Win64, pe(PE_X86_64)),
            (Platform::Darwin64, MACHO_64.to_vec()),
            (Platform::Linux32, elf(ELF_X86)),
            (Platform::Win32, pe(PE_X86)),
            (Platform::Aarch64Linux, elf(ELF_AARCH64)),
        ];
        for (owner, binary) in &binaries {
            for platform in Platform::ALL {
                assert_eq!(platform.recognises(binary), platform == *owner, "{platform} on a binary of {owner}");
            }
        }
    }

    #[test]
    fn truncated_and_hostile_bytes_are_recognised_by_none() {
        let mut far_away = pe(PE_X86_64);
        far_away[PE_OFFSET_OFFSET..PE_OFFSET_OFFSET + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        for bytes in [&b""[..], b"\x7fELF", b"MZ", &elf(ELF_X86_64)[..19], &far_away] {
            assert!(Platform::ALL.iter().all(|platform| !platform.recognises(bytes)), "{bytes:?}");
        }
    }

    #[test]
    fn this_very_test_is_a_binary_for_this_computer() {
        let bytes = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert!(Platform::host().unwrap().recognises(&bytes));
    }
}
