//! Linear forms as files of NumPy and MATLAB, read back by the rules of the formats.

use crate::support::Problem;
use bksim_analysis::{About, Channels, Linear, linearize};

fn four_bar() -> Linear {
    let one = |name: &str| vec![name.to_owned()];
    let channels = Channels {
        inputs: one("crank.angle"),
        outputs: vec!["rocker.angle".to_owned(), "rocker.rate".to_owned()],
        states: one("crank.angle"),
    };
    linearize(Problem::load("lti-four-bar").model(), About::Static, &channels).expect("a form")
}

fn number(bytes: &[u8], n: usize) -> usize {
    bytes[..n].iter().rev().fold(0, |sum, &byte| 256 * sum + usize::from(byte))
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|of| f64::from_le_bytes(of.try_into().expect("8 bytes"))).collect()
}

/// Entries of an archive by its central directory: name and content.
fn entries(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let end = &bytes[bytes.len() - 22..];
    assert_eq!(&end[..4], b"PK\x05\x06");
    let (n, size, mut at) = (number(&end[10..], 2), number(&end[12..], 4), number(&end[16..], 4));
    assert_eq!(at + size, bytes.len() - 22);
    let mut found = Vec::new();
    for _ in 0..n {
        let entry = &bytes[at..];
        assert_eq!(&entry[..4], b"PK\x01\x02");
        let (crc, size, n_name) =
            (number(&entry[16..], 4), number(&entry[20..], 4), number(&entry[28..], 2));
        let name = String::from_utf8(entry[46..46 + n_name].to_vec()).expect("a name");
        let local = &bytes[number(&entry[42..], 4)..];
        assert_eq!(&local[..4], b"PK\x03\x04");
        assert_eq!(&local[30..30 + n_name], name.as_bytes());
        let content = local[30 + n_name..30 + n_name + size].to_vec();
        assert_eq!(crc32fast::hash(&content) as usize, crc);
        found.push((name, content));
        at += 46 + n_name;
    }
    found
}

#[test]
fn an_archive_of_numpy_holds_the_matrices_column_by_column() {
    let linear = four_bar();
    let found = entries(&linear.npz());
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        ["A.npy", "B.npy", "C.npy", "D.npy", "states.npy", "inputs.npy", "outputs.npy"]
    );
    let content = &found[2].1;
    assert_eq!(&content[..8], b"\x93NUMPY\x01\x00");
    let head = number(&content[8..], 2);
    assert_eq!((10 + head) % 64, 0);
    let text = std::str::from_utf8(&content[10..10 + head]).expect("a head");
    assert!(
        text.starts_with("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 2), }"),
        "{text}"
    );
    assert_eq!(doubles(&content[10 + head..]), linear.c.as_slice());
}

#[test]
fn a_file_of_matlab_holds_the_matrices_as_elements() {
    let linear = four_bar();
    let bytes = linear.mat();
    assert_eq!(&bytes[124..128], b"\x00\x01IM");
    let (mut at, mut names) = (128, Vec::new());
    while at < bytes.len() {
        assert_eq!(number(&bytes[at..], 4), 14, "an array");
        let size = number(&bytes[at + 4..], 4);
        assert_eq!(size % 8, 0);
        // Flags, shape, name, numbers; each begins at a multiple of eight bytes.
        let mut parts = Vec::new();
        let (mut part, end) = (at + 8, at + 8 + size);
        while part < end {
            let n = number(&bytes[part + 4..], 4);
            parts.push(&bytes[part + 8..part + 8 + n]);
            part = (part + 8 + n).next_multiple_of(8);
        }
        assert_eq!(parts.len(), 4);
        let name = String::from_utf8(parts[2].to_vec()).expect("a name");
        if name == "A" {
            let shape = [number(parts[1], 4), number(&parts[1][4..], 4)];
            assert_eq!(shape, [2, 2]);
            assert_eq!(doubles(parts[3]), linear.a.as_slice());
        }
        names.push(name);
        at = end;
    }
    assert_eq!(names, ["A", "B", "C", "D", "states", "inputs", "outputs"]);
}
