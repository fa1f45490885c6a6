//! Marks in files: a remark, a comment, a box or a member that names the model and has a checksum of all the rest.
//!
//! | format | place |
//! | --- | --- |
//! | PNG, animated PNG | a `tEXt` chunk, the last before the end |
//! | GIF | a comment extension, the last before the trailer |
//! | MP4 | a `free` box, the last of the file |
//! | DXF | a comment (group 999) before the end of the file; of binary DXF none |
//! | JSON | the first member of an object |
//! | NPZ | the comment of the archive |
//! | MAT | the last variable, `made_by` |
//! | SVG, HTML, Markdown, PDF, C, Rust, Python, MATLAB, Modelica, TOML, manual pages, text | the last line |

use std::ffi::OsStr;
use std::ops::Range;
use std::path::Path;

use sha2::{Digest, Sha256};

/// First bytes of a PNG, and its last chunk.
const PNG: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
const PNG_END: [u8; 12] = *b"\0\0\0\0IEND\xaeB\x60\x82";
/// First bytes of the end of an archive, and of a MAT file.
const ZIP_END: [u8; 4] = *b"PK\x05\x06";
const MAT: &[u8] = b"MATLAB 5.0 MAT-file";
/// Trailer of a GIF, and the beginning of a comment in it.
const GIF_END: u8 = 0x3b;
const GIF_COMMENT: [u8; 2] = [0x21, 0xfe];
/// Most bytes of a block of a GIF.
const GIF_BLOCK: usize = 255;
/// The words that a mark begins with.
const WORDS: &str = "made by bksim from the model ";

/// A kind of place for a mark.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Place {
    Png,
    Gif,
    Mp4,
    Dxf,
    Json,
    Npz,
    Mat,
    /// A remark that is the last line, between these two.
    Line([&'static str; 2]),
}

/// A picture, a film, a page, a drawing or a text with a mark that names the model. The content tells the place
/// of the mark where it can, the ending of `path` otherwise; what has no place for one is left as it is.
pub fn stamped(path: &Path, mut bytes: Vec<u8>, model_name: &str) -> Vec<u8> {
    let Some(place) = place_of(path, &bytes) else { return bytes };
    if matches!(place, Place::Line(_)) && bytes.last().is_some_and(|&last| last != b'\n') {
        bytes.push(b'\n');
    }
    let Some(at) = place.position(&bytes) else { return bytes };
    let insert = place.insert(&bytes, &mark(model_name, &bytes));
    bytes.splice(at..at, insert);
    bytes
}

/// True for a file with the mark of this model, and nothing changed since it was set.
pub(super) fn is_stamped(bytes: &[u8], model_name: &str) -> bool {
    let Some((place, found)) = found(bytes) else { return false };
    let content = [&bytes[..found.start], &bytes[found.end..]].concat();
    place.position(&content) == Some(found.start)
        && place.insert(&content, &mark(model_name, &content)) == bytes[found]
}

/// True for a file with a mark, of whichever model.
pub(super) fn is_marked(bytes: &[u8]) -> bool {
    found(bytes).is_some()
}

/// The place of the last mark of a file, and the bytes that it takes.
fn found(bytes: &[u8]) -> Option<(Place, Range<usize>)> {
    let words = bytes.windows(WORDS.len()).rposition(|window| window == WORDS.as_bytes())?;
    let sum = bytes[words..].windows(SUM.len()).position(|window| window == SUM.as_bytes())?;
    let end = words + sum + SUM.len() + 64;
    let mark = bytes.get(words..end)?;
    let places =
        [Place::Png, Place::Gif, Place::Mp4, Place::Dxf, Place::Json, Place::Npz, Place::Mat];
    let lines = LINES.iter().map(|(_, sides)| Place::Line(*sides));
    places.into_iter().chain(lines).find_map(|place| {
        let (before, after) = place.around(bytes, mark);
        let start = words.checked_sub(before.len())?;
        let range = start..end + after.len();
        let is_there = bytes.get(range.clone())? == [&before[..], mark, &after[..]].concat();
        is_there.then_some((place, range))
    })
}

/// Endings of formats with remarks of a line, and what stands around a remark.
const LINES: [(&[&str], [&str; 2]); 6] = [
    (&["svg", "html", "htm", "md"], ["<!-- ", " -->\n"]),
    (&["pdf", "m"], ["% ", "\n"]),
    (&["py", "toml"], ["# ", "\n"]),
    (&["1"], [".\\\" ", "\n"]),
    (&["c", "h", "rs", "mo"], ["// ", "\n"]),
    (&["txt"], ["(", ")\n"]),
];

fn place_of(path: &Path, bytes: &[u8]) -> Option<Place> {
    let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    if bytes.starts_with(&PNG) {
        return Some(Place::Png);
    }
    if bytes.starts_with(b"GIF8") {
        return Some(Place::Gif);
    }
    match ending.as_str() {
        "mp4" => Some(Place::Mp4),
        "dxf" => Some(Place::Dxf),
        "json" => Some(Place::Json),
        "npz" => Some(Place::Npz),
        "mat" => Some(Place::Mat),
        ending => {
            let line = LINES.iter().find(|(endings, _)| endings.contains(&ending));
            line.map(|(_, sides)| Place::Line(*sides))
        }
    }
}

impl Place {
    /// The byte of the content before which a mark stands; `None` where it has no room for one.
    fn position(self, bytes: &[u8]) -> Option<usize> {
        match self {
            Self::Png => bytes.ends_with(&PNG_END).then(|| bytes.len() - PNG_END.len()),
            Self::Gif => (bytes.last() == Some(&GIF_END)).then(|| bytes.len() - 1),
            Self::Mp4 | Self::Line(_) => Some(bytes.len()),
            Self::Dxf => dxf_end(bytes),
            Self::Json => bytes.starts_with(b"{\n").then_some(2),
            // Before the length of the comment, which is zero: these two bytes end the comment then.
            Self::Npz => {
                let end = bytes.len().checked_sub(ZIP_END.len() + 18)?;
                let is_last = bytes[end..].starts_with(&ZIP_END) && bytes.ends_with(&[0, 0]);
                is_last.then(|| bytes.len() - 2)
            }
            Self::Mat => bytes.starts_with(MAT).then_some(bytes.len()),
        }
    }

    /// The bytes of a mark in this content.
    fn insert(self, bytes: &[u8], mark: &str) -> Vec<u8> {
        let (before, after) = self.around(bytes, mark.as_bytes());
        [&before[..], mark.as_bytes(), &after[..]].concat()
    }

    /// The bytes before and after a mark in this content.
    fn around(self, bytes: &[u8], mark: &[u8]) -> (Vec<u8>, Vec<u8>) {
        // Marks are short.
        let length = |n: usize| u32::try_from(n).unwrap_or_default().to_be_bytes();
        match self {
            Self::Png => {
                // The four letters of the type do not count.
                let typed = [b"tEXtComment\0", mark].concat();
                let before = [&length(typed.len() - 4)[..], b"tEXtComment\0"].concat();
                (before, crc32fast::hash(&typed).to_be_bytes().to_vec())
            }
            Self::Gif => {
                let n = u8::try_from(mark.len().min(GIF_BLOCK)).unwrap_or_default();
                ([&GIF_COMMENT[..], &[n]].concat(), vec![0])
            }
            Self::Mp4 => ([&length(mark.len() + 8)[..], b"free"].concat(), Vec::new()),
            Self::Dxf => {
                let line = if bytes.windows(2).any(|pair| pair == b"\r\n") { "\r\n" } else { "\n" };
                (format!("999{line}").into_bytes(), line.as_bytes().to_vec())
            }
            Self::Json => (b"  \"made_by\": \"".to_vec(), b"\",\n".to_vec()),
            Self::Npz => {
                let n = u16::try_from(mark.len() + 2).unwrap_or_default();
                (n.to_le_bytes().to_vec(), Vec::new())
            }
            Self::Mat => mat_variable(mark.len()),
            Self::Line([before, after]) => (before.as_bytes().to_vec(), after.as_bytes().to_vec()),
        }
    }
}

/// The bytes before and after `n` letters that are the value of the variable `made_by` of a MAT file.
fn mat_variable(n: usize) -> (Vec<u8>, Vec<u8>) {
    // Types of data elements, in the words of the format: miINT8, miINT32, miUINT32, miMATRIX, miUTF8; mxCHAR_CLASS.
    let [int8, int32, uint32, matrix, utf8, characters] = [1, 5, 6, 14, 16, 4];
    // Marks are short.
    let length = u32::try_from(n).unwrap_or_default();
    let padded = length.next_multiple_of(8);
    // Flags, shape and name are elements of eight bytes each, after the eight of their type and length.
    let words = [
        [matrix, 3 * 16 + 8 + padded],
        [uint32, 8],
        [characters, 0],
        [int32, 8],
        [1, length],
        [int8, 7],
    ];
    let mut before: Vec<u8> =
        words.as_flattened().iter().flat_map(|word| word.to_le_bytes()).collect();
    before.extend(b"made_by\0");
    before.extend([utf8, length].iter().flat_map(|word| word.to_le_bytes()));
    (before, vec![0; (padded - length) as usize])
}

/// The place of the groups `0`, `EOF` that end a drawing in text.
fn dxf_end(bytes: &[u8]) -> Option<usize> {
    let text = bytes.trim_ascii_end();
    let group = text.strip_suffix(b"EOF")?;
    let code = group.trim_ascii_end().strip_suffix(b"0")?;
    // The code may be indented.
    let line = code.iter().rposition(|&byte| byte == b'\n')? + 1;
    code[line..].iter().all(|&byte| byte == b' ').then_some(line)
}

/// The words before the checksum.
const SUM: &str = ", sha256 ";
/// Most bytes of a name in a mark: a comment of a GIF has 255.
const MOST_NAME: usize = 140;

/// A mark that ends no remark of any format, whatever the model is called. A name that is too long for it is told
/// by its beginning; its checksum is of all of it.
fn mark(model_name: &str, content: &[u8]) -> String {
    let letter = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'.' | b'/' => {
            char::from(byte).to_string()
        }
        byte => format!("%{byte:02x}"),
    };
    let mut name: String = model_name.bytes().map(letter).collect();
    name.truncate(MOST_NAME);
    let hex = |sum: String, byte: &u8| sum + &format!("{byte:02x}");
    let sum = Sha256::new().chain_update(model_name).chain_update([0]).chain_update(content);
    let sum = sum.finalize().iter().fold(String::new(), hex);
    format!("{WORDS}{name}{SUM}{sum}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 6] = ["four-bar", "four-bar-2", "bar", "-->", "a\nb", "Kurbel ä"];
    const DRAWING: &[u8] = b"  0\r\nSECTION\r\n  0\r\nENDSEC\r\n  0\r\nEOF\r\n";

    /// Contents of files, each with room for a mark.
    fn contents() -> Vec<(&'static str, Vec<u8>)> {
        let png = [&PNG[..], b"some chunks", &PNG_END].concat();
        let text = || b"some content".to_vec();
        let texts = [
            "a.svg", "a.html", "a.md", "a.pdf", "a.py", "a.h", "a.rs", "a.toml", "a.1", "a.txt",
            "a.mp4",
        ];
        let mut all: Vec<_> = texts.into_iter().map(|name| (name, text())).collect();
        all.extend([
            ("a.png", png.clone()),
            ("a.apng", png),
            ("a.gif", b"GIF89a some;".to_vec()),
            ("a.dxf", DRAWING.to_vec()),
            ("b.dxf", b"0\nSECTION\n0\nENDSEC\n0\nEOF\n".to_vec()),
            ("a.json", b"{\n  \"some\": 1\n}\n".to_vec()),
            ("a.npz", [&b"PK\x03\x04some"[..], &ZIP_END, &[7; 16], &[0, 0]].concat()),
            ("a.mat", [MAT, b" and some content"].concat()),
        ]);
        all
    }

    #[test]
    fn a_mark_names_one_model_in_every_format() {
        for (file, content) in contents() {
            for name in NAMES {
                let marked = stamped(Path::new(file), content.clone(), name);
                let known: Vec<&str> =
                    NAMES.into_iter().filter(|name| is_stamped(&marked, name)).collect();
                assert_eq!(known, [name], "{file}");
                assert!(is_marked(&marked), "{file}");
            }
        }
    }

    #[test]
    fn what_was_edited_or_never_marked_is_nobodys() {
        for (file, content) in contents() {
            assert!(!is_marked(&content) && !is_stamped(&content, "bar"), "{file}");
            let marked = stamped(Path::new(file), content, "bar");
            for place in 0..marked.len() {
                let mut edited = marked.clone();
                edited[place] ^= 1;
                assert!(!is_stamped(&edited, "bar"), "{file}: byte {place}");
            }
            let longer = [&marked[..], b"\n"].concat();
            assert!(!is_stamped(&longer, "bar"), "{file}");
        }
        assert!(!is_stamped(b"", "bar"));
        // What has no room for a mark is left as it is.
        for (file, content) in [("a.csv", &b"t\n1\n"[..]), ("a.json", b"[]"), ("a.dxf", b"binary")]
        {
            assert_eq!(stamped(Path::new(file), content.to_vec(), "bar"), content, "{file}");
        }
    }

    #[test]
    fn the_last_mark_of_a_drawing_counts() {
        let path = Path::new("a.dxf");
        let twice = stamped(path, stamped(path, DRAWING.to_vec(), "one"), "two");
        assert!(is_stamped(&twice, "two") && !is_stamped(&twice, "one"));
        assert!(twice.ends_with(b"  0\r\nEOF\r\n"));
    }

    #[test]
    fn long_names_differ_by_their_checksums() {
        let [one, two] = ["1", "2"].map(|end| "x".repeat(300) + end);
        let marked = stamped(Path::new("a.gif"), b"GIF89a some;".to_vec(), &one);
        assert!(is_stamped(&marked, &one) && !is_stamped(&marked, &two));
    }
}
