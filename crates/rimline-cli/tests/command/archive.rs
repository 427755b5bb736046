//! ZIP and .npy by hand, apart from the code under test.

use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("archive::what_is_written_is_read", written_is_read)];

/// An entry of a ZIP archive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) flags: u16,
    pub(crate) method: u16,
    /// DOS time and date.
    pub(crate) time: [u16; 2],
    pub(crate) bytes: Vec<u8>,
}

/// 1 January 1980, midnight.
pub(crate) const FIRST_DAY: [u16; 2] = [0, 1 << 5 | 1];

fn u16_at(bytes: &[u8], at: usize) -> Result<u16, String> {
    let bytes = bytes.get(at..at + 2).ok_or("cut short")?;
    Ok(u16::from_le_bytes([bytes[0], bytes[1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> Result<u32, String> {
    Ok(u32::from(u16_at(bytes, at)?) | u32::from(u16_at(bytes, at + 2)?) << 16)
}

/// The stored entries of an archive in the order of their bytes; the central directory must list the same.
pub(crate) fn read_zip(zip: &[u8]) -> Result<Vec<Entry>, String> {
    let mut entries = Vec::new();
    let mut offsets = Vec::new();
    let mut at = 0;
    while u32_at(zip, at)? == 0x0403_4b50 {
        offsets.push(at as u32);
        let (size, name) = (u32_at(zip, at + 22)? as usize, u16_at(zip, at + 26)? as usize);
        let begin = at + 30 + name + u16_at(zip, at + 28)? as usize;
        let bytes = zip.get(begin..begin + size).ok_or("an entry is cut short")?.to_vec();
        ensure!(u32_at(zip, at + 14)? == checksum(&bytes), "the checksum of an entry is wrong");
        ensure!(u32_at(zip, at + 18)? as usize == size, "an entry is compressed");
        entries.push(Entry {
            name: String::from_utf8_lossy(&zip[at + 30..at + 30 + name]).into_owned(),
            flags: u16_at(zip, at + 6)?,
            method: u16_at(zip, at + 8)?,
            time: [u16_at(zip, at + 10)?, u16_at(zip, at + 12)?],
            bytes,
        });
        at = begin + size;
    }
    for (entry, offset) in entries.iter().zip(offsets) {
        ensure!(u32_at(zip, at)? == 0x0201_4b50, "the central directory is short");
        ensure!(u32_at(zip, at + 42)? == offset, "{} lies elsewhere", entry.name);
        ensure!(u32_at(zip, at + 16)? == checksum(&entry.bytes), "{}: checksum", entry.name);
        let lengths = [28, 30, 32].map(|field| u16_at(zip, at + field));
        for length in lengths {
            at += usize::from(length?);
        }
        at += 46;
    }
    ensure!(u32_at(zip, at)? == 0x0605_4b50, "the archive's end is not where it should be");
    ensure!(zip.len() == at + 22, "something follows the archive");
    Ok(entries)
}

/// The two 16-bit fields for `time`, then an archive of these entries; `Entry::method` 8 is deflated here.
pub(crate) fn write_zip(entries: &[Entry]) -> Vec<u8> {
    let mut zip = Vec::new();
    let mut directory = Vec::new();
    for entry in entries {
        let packed = if entry.method == 8 { deflate(&entry.bytes) } else { entry.bytes.clone() };
        let mut common = Vec::new();
        for field in [20, entry.flags, entry.method, entry.time[0], entry.time[1]] {
            common.extend(field.to_le_bytes());
        }
        for field in [checksum(&entry.bytes), packed.len() as u32, entry.bytes.len() as u32] {
            common.extend(field.to_le_bytes());
        }
        common.extend((entry.name.len() as u16).to_le_bytes());
        common.extend(0_u16.to_le_bytes());
        directory.extend(*b"PK\x01\x02\x14\x00");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend((zip.len() as u32).to_le_bytes());
        directory.extend(entry.name.bytes());
        zip.extend(*b"PK\x03\x04");
        zip.extend(&common);
        zip.extend(entry.name.bytes());
        zip.extend(packed);
    }
    let (start, count) = (zip.len() as u32, entries.len() as u16);
    zip.extend(&directory);
    zip.extend(*b"PK\x05\x06\x00\x00\x00\x00");
    zip.extend(count.to_le_bytes());
    zip.extend(count.to_le_bytes());
    zip.extend((directory.len() as u32).to_le_bytes());
    zip.extend(start.to_le_bytes());
    zip.extend([0; 2]);
    zip
}

/// RFC 1951: one block with fixed codes, literals only.
fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut bits: Vec<bool> = vec![true, true, false];
    let mut code = |value: u32, length: u32| bits.extend((0..length).rev().map(|bit| value >> bit & 1 == 1));
    for &byte in bytes {
        match u32::from(byte) {
            low @ 0..144 => code(0x30 + low, 8),
            high => code(0x190 + high - 144, 9),
        }
    }
    code(0, 7);
    bits.chunks(8).map(|chunk| (0..).zip(chunk).map(|(bit, &set)| u8::from(set) << bit).sum()).collect()
}

fn checksum(bytes: &[u8]) -> u32 {
    let step = |crc: u32| crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 };
    let table: Vec<u32> = (0..256).map(|byte| (0..8).fold(byte, |crc, _| step(crc))).collect();
    !bytes.iter().fold(!0, |crc, &byte| crc >> 8 ^ table[(crc as u8 ^ byte) as usize])
}

/// A .npy array as an entry.
pub(crate) fn array(name: &str, descr: &str, fortran_order: &str, shape: &str, data: &[u8]) -> Entry {
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': {fortran_order}, 'shape': {shape}, }}");
    while (text.len() + 11) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes.extend(data);
    Entry { name: format!("{name}.npy"), flags: 0, method: 0, time: FIRST_DAY, bytes }
}

/// The array of an archive of this name.
pub(crate) fn entry(archive: &[u8], name: &str) -> Result<Entry, String> {
    let name = format!("{name}.npy");
    read_zip(archive)?.into_iter().find(|entry| entry.name == name).ok_or_else(|| format!("there is no {name}"))
}

fn written_is_read() -> Outcome {
    let entries = [
        array("first", "<u4", "False", "(2,)", &[1, 0, 0, 0, 2, 0, 0, 0]),
        array("second", "|u1", "False", "(1, 3)", &[7, 8, 9]),
    ];
    let mut zip = write_zip(&entries);
    ensure!(read_zip(&zip)? == entries, "the entries changed");
    let middle = zip.len() / 3;
    zip[middle] ^= 1;
    ensure!(read_zip(&zip).is_err(), "damage went unnoticed");
    Ok(())
}
