//! The format of a file, recognised by its first bytes.

use bksim_model::diagnostic::Diagnostic;

use crate::codes;

/// The first bytes of a binary DXF drawing.
pub const SENTINEL: &[u8] = b"AutoCAD Binary DXF\r\n\x1a\0";

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const SAVE_AS_DXF: &str = "open it in a CAD program and save it as DXF, any version from R12 on";

/// The format of a drawing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Container {
    /// DXF as lines of text.
    Text {
        /// The byte of the first line, after a byte order mark.
        start: usize,
    },
    /// Binary DXF.
    Binary {
        /// Group codes take two bytes; one before R13.
        has_wide_codes: bool,
    },
    /// DWG; the release that wrote it.
    Dwg(&'static str),
}

/// DWG versions that are read: the tag at the start of the file and the release.
const DWG_VERSIONS: &[(&[u8], &str)] = &[
    (b"AC1009", "R12"),
    (b"AC1012", "R13"),
    (b"AC1014", "R14"),
    (b"AC1015", "R2000"),
    (b"AC1018", "R2004"),
    (b"AC1021", "R2007"),
    (b"AC1024", "R2010"),
    (b"AC1027", "R2013"),
    (b"AC1032", "R2018"),
];

/// The first bytes of other files, and names for these.
const OTHER_FILES: &[(&[u8], &str)] = &[
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x89MCAP", "a log of a run"),
    (b"ISO-10303-21", "a STEP file"),
    (b"<svg", "an SVG picture"),
    (b"<?xml", "an XML file"),
    (b"<!DOCTYPE", "an HTML page"),
    (b"{", "a JSON file"),
    (b"\xff\xfe", "text in UTF-16"),
    (b"\xfe\xff", "text in UTF-16"),
    (b"\x1f\x8b", "a gzip archive"),
];

/// Recognises the format of a drawing.
///
/// # Errors
/// `D001` with the format that the file seems to have and a way out.
pub fn recognise(bytes: &[u8]) -> Result<Container, Diagnostic> {
    if bytes.starts_with(SENTINEL) {
        // The first code is 0, in one or two bytes, and SECTION or a comment follows.
        let has_wide_codes = bytes.get(SENTINEL.len() + 1) == Some(&0)
            || bytes.get(SENTINEL.len()..SENTINEL.len() + 2) == Some(&[0xe7, 0x03]);
        return Ok(Container::Binary { has_wide_codes });
    }
    if let Some((_, release)) = DWG_VERSIONS.iter().find(|(tag, _)| bytes.starts_with(tag)) {
        return Ok(Container::Dwg(release));
    }
    let start = if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    if begins_with_a_group_code(&bytes[start..]) {
        return Ok(Container::Text { start });
    }
    Err(not_a_drawing(bytes))
}

/// True if a file is meant as a drawing, so that a broken one is reported as one.
pub fn is_drawing(bytes: &[u8]) -> bool {
    bytes.starts_with(b"AC10") || recognise(bytes).is_ok()
}

/// Line ends of old programs, a carriage return alone, as line feeds, byte for byte; none of any other file.
pub fn with_line_feeds(bytes: &[u8]) -> Option<Vec<u8>> {
    let is_old = matches!(recognise(bytes), Ok(Container::Text { .. })) && !bytes.contains(&b'\n');
    let line_feed = |&byte: &u8| if byte == b'\r' { b'\n' } else { byte };
    is_old.then(|| bytes.iter().map(line_feed).collect())
}

fn begins_with_a_group_code(text: &[u8]) -> bool {
    let mut lines = text.split(|byte| matches!(byte, b'\n' | b'\r'));
    let code = lines.next().and_then(|line| std::str::from_utf8(line).ok());
    lines.next().is_some() && code.is_some_and(|line| line.trim().parse::<i16>().is_ok())
}

fn not_a_drawing(bytes: &[u8]) -> Diagnostic {
    let fault = |what: &str| Diagnostic::error(codes::NOT_A_DRAWING, what);
    let text = bytes.trim_ascii_start();
    if text.is_empty() {
        return fault("not a drawing: the file is empty").help(SAVE_AS_DXF);
    }
    if bytes.starts_with(b"AC1") || bytes.starts_with(b"AC2.") || bytes.starts_with(b"MC0.0") {
        let tag = String::from_utf8_lossy(&bytes[..bytes.len().min(6)]).into_owned();
        return fault(&format!("a DWG drawing of the version `{}`", tag.escape_debug()))
            .note("of DWG, R12 to R2018 can be read")
            .help(SAVE_AS_DXF);
    }
    let known = OTHER_FILES.iter().find(|(tag, _)| text.starts_with(tag));
    if let Some((_, name)) = known {
        return fault(&format!("not a drawing: the file looks like {name}")).help(SAVE_AS_DXF);
    }
    match std::str::from_utf8(text) {
        Ok(text) if text.starts_with('[') || text.contains('=') => {
            fault("not a drawing: the file looks like a model in TOML")
                .help("give the model where a model file is expected, and a DXF drawing here")
        }
        Ok(_) => fault("not a drawing: the first line of the text is not a group code of DXF")
            .help(SAVE_AS_DXF),
        Err(_) => fault("not a drawing: the bytes are neither DXF nor DWG").help(SAVE_AS_DXF),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawings_are_known_by_their_first_bytes() {
        let wide = [SENTINEL, b"\0\0SECTION\0"].concat();
        let narrow = [SENTINEL, b"\0SECTION\0"].concat();
        let cases: [(&[u8], Container); 6] = [
            (b"0\nSECTION\n", Container::Text { start: 0 }),
            (b"\xef\xbb\xbf999\r\nby hand\r\n", Container::Text { start: 3 }),
            (b"  0\r\nSECTION\r\n", Container::Text { start: 0 }),
            (&wide, Container::Binary { has_wide_codes: true }),
            (&narrow, Container::Binary { has_wide_codes: false }),
            (b"AC1032\0\0", Container::Dwg("R2018")),
        ];
        for (bytes, expected) in cases {
            assert_eq!(recognise(bytes), Ok(expected));
        }
    }

    #[test]
    fn other_files_are_called_by_their_names() {
        let cases: [(&[u8], &str); 7] = [
            (b"", "empty"),
            (b" \n", "empty"),
            (b"AC1006\0", "DWG drawing of the version `AC1006`"),
            (b"%PDF-1.4", "PDF"),
            (b"[bodies.crank]\nmass = 1\n", "TOML"),
            (b"hello\nthere", "first line"),
            (b"\x00\xff\x80", "neither"),
        ];
        for (bytes, expected) in cases {
            let message = recognise(bytes).expect_err("not a drawing").message;
            assert!(message.contains(expected), "`{message}` does not say `{expected}`");
        }
    }
}
