//! The length of an ELF file.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// A segment that is loaded.
const LOADED: u32 = 1;

/// Bytes `file` should have at least and bytes it has, if it is a shared library of a 64-bit Linux that is cut short.
///
/// The loader maps what its header says, and a process that touches what is not there is ended by the system (SIGBUS).
pub(crate) fn cut_short(file: &Path) -> Option<(u64, u64)> {
    let mut file = File::open(file).ok()?;
    let len = file.metadata().ok()?.len();
    let mut header = [0; 64];
    file.read_exact(&mut header).ok()?;
    // 64 bits, little endian.
    if header[..6] != *b"\x7fELF\x02\x01" {
        return None;
    }
    let (table, entry, entries) = (word(&header, 32)?, half(&header, 54)?, half(&header, 56)?);
    let mut segments = Vec::new();
    file.seek(SeekFrom::Start(table)).ok()?;
    file.take(u64::from(entry) * u64::from(entries)).read_to_end(&mut segments).ok()?;
    let end = |segment: &[u8]| {
        let loaded = segment.get(..4)? == LOADED.to_le_bytes();
        loaded.then_some(word(segment, 8)?.saturating_add(word(segment, 32)?))
    };
    let needed = segments.chunks_exact(usize::from(entry).max(1)).filter_map(end).max();
    needed.filter(|needed| *needed > len).map(|needed| (needed, len))
}

fn word(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?))
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}
