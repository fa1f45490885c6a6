//! An archive of files as ZIP, the same bytes for the same files: fixed times, no attributes.

use std::io::Write;

use flate2::Compression;
use flate2::write::DeflateEncoder;

/// The first day that the format knows, 1980-01-01.
const DATE: u16 = 0x21;
/// Version of the format that deflated files need, in tenths.
const VERSION: u16 = 20;
/// Method: deflated.
const DEFLATED: u16 = 8;

/// The archive of files, each with its path.
///
/// # Panics
/// If the files are larger than the format holds, 4 GiB.
pub fn archive(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (path, bytes) in files {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
        let packed = packed.expect("memory takes every byte");
        let offset = size(out.len());
        // What the local header and the directory share.
        let mut shared = Vec::new();
        for word in [VERSION, 0, DEFLATED, 0, DATE] {
            shared.extend(word.to_le_bytes());
        }
        for long in [crc32fast::hash(bytes), size(packed.len()), size(bytes.len())] {
            shared.extend(long.to_le_bytes());
        }
        let length = u16::try_from(path.len()).expect("paths are short");
        shared.extend(length.to_le_bytes());
        shared.extend(0u16.to_le_bytes());
        out.extend(0x0403_4b50_u32.to_le_bytes());
        out.extend(&shared);
        out.extend(path.bytes());
        out.extend(packed);
        directory.extend(0x0201_4b50_u32.to_le_bytes());
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&shared);
        // No comment, first disk, no attributes.
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(path.bytes());
    }
    let (offset, length) = (size(out.len()), size(directory.len()));
    let count = u16::try_from(files.len()).expect("few files");
    out.extend(directory);
    out.extend(0x0605_4b50_u32.to_le_bytes());
    for word in [0, 0, count, count] {
        out.extend(word.to_le_bytes());
    }
    out.extend(length.to_le_bytes());
    out.extend(offset.to_le_bytes());
    out.extend(0u16.to_le_bytes());
    out
}

fn size(bytes: usize) -> u32 {
    u32::try_from(bytes).expect("files of less than 4 GiB")
}
