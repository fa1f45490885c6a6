//! Matrices as files of other programs: NumPy's `.npz` and MATLAB's `.mat` of version 5.
//!
//! Sources: *NEP 1, a simple file format for NumPy arrays*; PKWARE, *.ZIP File Format Specification* (APPNOTE 6.3.10),
//! stored entries alone; MathWorks, *MAT-File Format*, level 5. Both need no compression, so that each is a header before the
//! numbers.

use nalgebra::DMatrix;

use crate::linear::Linear;

impl Linear {
    /// A, B, C, D as float64, and the names of states, inputs and outputs, as an archive that `numpy.load` reads.
    pub fn npz(&self) -> Vec<u8> {
        let mut archive = Archive::default();
        for (name, matrix) in self.matrices() {
            archive.add(&format!("{name}.npy"), &npy_of_numbers(matrix));
        }
        for (name, words) in self.names() {
            archive.add(&format!("{name}.npy"), &npy_of_words(&words));
        }
        archive.finish()
    }

    /// A, B, C, D as doubles, and the names of states, inputs and outputs as rows of characters, as `load` of MATLAB and
    /// Octave and `scipy.io.loadmat` read them.
    pub fn mat(&self) -> Vec<u8> {
        let mut text = b"MATLAB 5.0 MAT-file, by bksim".to_vec();
        text.resize(124, b' ');
        let mut bytes = text;
        // Version 1.0 of the format, in the order of bytes that "MI" read as such tells.
        bytes.extend([0x00, 0x01, b'I', b'M']);
        for (name, matrix) in self.matrices() {
            bytes.extend(mat_of_numbers(name, matrix));
        }
        for (name, words) in self.names() {
            bytes.extend(mat_of_words(name, &words));
        }
        bytes
    }

    fn matrices(&self) -> [(&'static str, &DMatrix<f64>); 4] {
        [("A", &self.a), ("B", &self.b), ("C", &self.c), ("D", &self.d)]
    }

    fn names(&self) -> [(&'static str, Vec<String>); 3] {
        let of =
            |columns: &[crate::table::Column]| columns.iter().map(|c| c.name.clone()).collect();
        [
            ("states", of(&self.states)),
            ("inputs", self.inputs.clone()),
            ("outputs", of(&self.outputs)),
        ]
    }
}

/// A length as the 32 bits that both formats have for it.
fn length(n: usize) -> [u8; 4] {
    u32::try_from(n).expect("a linear form takes less than 4 GiB").to_le_bytes()
}

/// An array with this description of its elements and shape, and its bytes.
fn npy(description: &str, shape: &str, is_fortran: bool, content: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let mut head =
        format!("{{'descr': '{description}', 'fortran_order': {order}, 'shape': {shape}, }}");
    // Magic, version, length and head are a multiple of 64 bytes.
    while (10 + head.len() + 1) % 64 != 0 {
        head.push(' ');
    }
    head.push('\n');
    let n = u16::try_from(head.len()).expect("the head of an array is short");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(n.to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend(content);
    bytes
}

fn npy_of_numbers(matrix: &DMatrix<f64>) -> Vec<u8> {
    let content: Vec<u8> = matrix.iter().flat_map(|x| x.to_le_bytes()).collect();
    npy("<f8", &format!("({}, {})", matrix.nrows(), matrix.ncols()), true, &content)
}

/// Words as characters of four bytes, each word filled up to the longest.
fn npy_of_words(words: &[String]) -> Vec<u8> {
    let longest = words.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1);
    let padded = |word: &String| {
        let own: Vec<u32> = word.chars().map(u32::from).collect();
        (0..longest).map(move |k| own.get(k).copied().unwrap_or(0)).collect::<Vec<_>>()
    };
    let content: Vec<u8> = words.iter().flat_map(padded).flat_map(u32::to_le_bytes).collect();
    npy(&format!("<U{longest}"), &format!("({},)", words.len()), false, &content)
}

/// A ZIP archive of entries that are stored as they are.
#[derive(Default)]
struct Archive {
    bytes: Vec<u8>,
    /// Entries of the central directory.
    directory: Vec<u8>,
    n: u16,
}

impl Archive {
    fn add(&mut self, name: &str, content: &[u8]) {
        let place = length(self.bytes.len());
        let n_name = u16::try_from(name.len()).expect("names of entries are short").to_le_bytes();
        let (crc, size) = (crc32fast::hash(content).to_le_bytes(), length(content.len()));
        // Version 2.0, no flags, stored, 1 January 1980 at midnight, so that equal forms are equal files.
        let common =
            [&[20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0][..], &crc, &size, &size, &n_name, &[0, 0]]
                .concat();
        self.bytes.extend([&b"PK\x03\x04"[..], &common, name.as_bytes(), content].concat());
        let rest = [&[0; 10][..], &place].concat();
        self.directory
            .extend([&b"PK\x01\x02\x14\x00"[..], &common, &rest, name.as_bytes()].concat());
        self.n += 1;
    }

    fn finish(mut self) -> Vec<u8> {
        let (place, size) = (length(self.bytes.len()), length(self.directory.len()));
        let n = self.n.to_le_bytes();
        self.bytes.extend(&self.directory);
        self.bytes
            .extend([&b"PK\x05\x06\x00\x00\x00\x00"[..], &n, &n, &size, &place, &[0, 0]].concat());
        self.bytes
    }
}

/// A data element: its type, its length, its content filled up to eight bytes.
fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let mut bytes = [&kind.to_le_bytes()[..], &length(content.len()), content].concat();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// Types of data elements, and classes of arrays.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const CHARACTERS: u32 = 4;
const DOUBLES: u32 = 6;

/// An array of a class, column by column.
fn mat(name: &str, class: u32, [rows, columns]: [usize; 2], values: &[u8]) -> Vec<u8> {
    let flags = [class.to_le_bytes(), [0; 4]].concat();
    let shape = [length(rows), length(columns)].concat();
    let parts = [element(UINT32, &flags), element(INT32, &shape), element(INT8, name.as_bytes())];
    element(MATRIX, &[parts.concat(), values.to_vec()].concat())
}

fn mat_of_numbers(name: &str, matrix: &DMatrix<f64>) -> Vec<u8> {
    let content: Vec<u8> = matrix.iter().flat_map(|x| x.to_le_bytes()).collect();
    mat(name, DOUBLES, [matrix.nrows(), matrix.ncols()], &element(DOUBLE, &content))
}

/// Words as rows of characters, filled up with spaces.
fn mat_of_words(name: &str, words: &[String]) -> Vec<u8> {
    let rows: Vec<Vec<u16>> = words.iter().map(|word| word.encode_utf16().collect()).collect();
    let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
    let space = u16::from(b' ');
    let column = |k: usize| rows.iter().map(move |row| row.get(k).copied().unwrap_or(space));
    let content: Vec<u8> = (0..longest).flat_map(column).flat_map(u16::to_le_bytes).collect();
    mat(name, CHARACTERS, [words.len(), longest], &element(UINT16, &content))
}
