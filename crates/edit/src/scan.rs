//! The structure of a text as TOML, also of one that is being written: headers, keys and values with their paths, and
//! the position of a cursor among them.

use std::ops::Range;

use bksim_model::file::sections;
use toml_parser::Source;
use toml_parser::lexer::{Token, TokenKind};

/// Kind of a place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// `[joints.A]`.
    Header,
    /// `{ … }`.
    Inline,
    /// `[ … ]`.
    Array,
    /// A text with its quotes.
    Text,
    /// A number, true or false.
    Bare,
}

/// A header, or a value with its key if it has one.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Place {
    /// Keys from the root, elements of arrays by their number: `bodies`, `rod`, `points`, `B`, `0`.
    pub path: Vec<String>,
    /// Spans of the last parts of the path, as many as are written here.
    pub keys: Vec<Range<usize>>,
    /// Span of the value, or of the header.
    pub span: Range<usize>,
    /// Kind of the value, or [`Kind::Header`].
    pub kind: Kind,
}

impl Place {
    /// The span of the part of its path with this index, if it is written here.
    pub fn key(&self, idx: usize) -> Option<&Range<usize>> {
        self.keys.get(idx.checked_sub(self.path.len() - self.keys.len())?)
    }

    /// The span of the key of a value; `None` for elements of arrays, and for headers, which hold several keys.
    pub(crate) fn own_key(&self) -> Option<&Range<usize>> {
        self.keys.last().filter(|_| self.kind != Kind::Header)
    }

    /// The first byte of the keys that are written before a value, of `A.angle = 1`, and the index of the first of them
    /// in its path.
    pub(crate) fn first_key(&self) -> Option<(usize, usize)> {
        let first = self.keys.first().filter(|_| self.kind != Kind::Header)?;
        Some((first.start, self.path.len() - self.keys.len()))
    }

    /// True for a text, a number, true or false.
    pub(crate) fn is_value(&self) -> bool {
        matches!(self.kind, Kind::Text | Kind::Bare)
    }

    /// The inside of a text, within its quotes.
    pub fn inside(&self, text: &str) -> Option<Range<usize>> {
        let own = text.get(self.span.clone()).filter(|_| self.kind == Kind::Text)?;
        let n = if own.starts_with("\"\"\"") || own.starts_with("'''") { 3 } else { 1 };
        let end = if is_closed(own) { self.span.end - n } else { self.span.end };
        Some(self.span.start + n..end.max(self.span.start + n))
    }
}

/// The place of a cursor.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Cursor {
    /// Path of the value at the cursor, or of the table whose key is there.
    pub path: Vec<String>,
    /// True if a value stands there, else a key.
    pub is_value: bool,
    /// First byte of the inside of the text around it.
    pub text: Option<usize>,
    /// True if it is in a comment.
    pub is_comment: bool,
    /// True if it is in a header that is not closed.
    pub is_header: bool,
}

/// The places of a text, in its order.
pub fn places(text: &str) -> Vec<Place> {
    let mut scan = Scan::of(text);
    scan.run();
    scan.places
}

/// The place of a byte.
pub fn cursor(text: &str, byte: usize) -> Cursor {
    let mut scan = Scan::of(&text[..byte]);
    scan.run();
    let last = scan.tokens.iter().rfind(|token| token.kind() != TokenKind::Eof);
    let is_comment = last.is_some_and(|token| token.kind() == TokenKind::Comment);
    let open = last.filter(|token| is_text(token.kind()));
    let open = open.map(|token| (token.span().start(), &text[token.span().start()..byte]));
    let open = open.filter(|(_, own)| !is_closed(own));
    let text = open.map(|(start, own)| {
        start + if own.starts_with("\"\"\"") || own.starts_with("'''") { 3 } else { 1 }
    });
    let is_value = scan.takes_value();
    let path = if is_value { scan.path() } else { scan.base() };
    Cursor { path, is_value, text, is_comment, is_header: scan.is_header }
}

/// The `type` of the table that a place is in, if it has one.
pub fn type_of<'t>(all: &[Place], place: &Place, text: &'t str) -> Option<&'t str> {
    own_text(all, place.path.get(..2)?, "type", text)
}

/// The text of a key of a table.
pub fn own_text<'t>(all: &[Place], table: &[String], key: &str, text: &'t str) -> Option<&'t str> {
    let is_own =
        |path: &[String]| path.split_last().is_some_and(|(last, of)| last == key && of == table);
    all.iter().find(|place| is_own(&place.path))?.inside(text).map(|at| &text[at])
}

/// True if a text in quotes has its second quote.
fn is_closed(own: &str) -> bool {
    let quotes = ["\"\"\"", "'''", "\"", "'"];
    let Some(quote) = quotes.into_iter().find(|quote| own.starts_with(quote)) else { return true };
    let Some(inside) = own[quote.len()..].strip_suffix(quote) else { return false };
    // A quote after an odd number of backslashes is a part of the text.
    let n_slashes = inside.len() - inside.trim_end_matches('\\').len();
    quote.starts_with('\'') || n_slashes.is_multiple_of(2)
}

fn is_text(kind: TokenKind) -> bool {
    use TokenKind::{BasicString, LiteralString, MlBasicString, MlLiteralString};
    matches!(kind, BasicString | LiteralString | MlBasicString | MlLiteralString)
}

/// An array or a table in braces that is open.
struct Frame {
    path: Vec<String>,
    /// Number of the element of an array.
    index: Option<usize>,
    /// Index of its place.
    place: usize,
}

struct Scan<'t> {
    text: &'t str,
    tokens: Vec<Token>,
    next: usize,
    section: Vec<String>,
    frames: Vec<Frame>,
    /// The key before the value.
    key: Vec<(String, Range<usize>)>,
    is_after_equals: bool,
    is_header: bool,
    places: Vec<Place>,
}

impl<'t> Scan<'t> {
    fn of(text: &'t str) -> Self {
        Self {
            text,
            tokens: Source::new(text).lex().into_vec(),
            next: 0,
            section: Vec::new(),
            frames: Vec::new(),
            key: Vec::new(),
            is_after_equals: false,
            is_header: false,
            places: Vec::new(),
        }
    }

    /// Path of the table that keys belong to.
    fn base(&self) -> Vec<String> {
        self.frames.last().map_or(&self.section, |frame| &frame.path).clone()
    }

    fn is_in_array(&self) -> bool {
        self.frames.last().is_some_and(|frame| frame.index.is_some())
    }

    fn takes_value(&self) -> bool {
        self.is_after_equals || self.is_in_array()
    }

    /// Path of a value here.
    fn path(&self) -> Vec<String> {
        let mut path = self.base();
        path.extend(self.frames.last().and_then(|frame| frame.index).map(|idx| idx.to_string()));
        path.extend(self.key.iter().map(|(name, _)| name.clone()));
        path
    }

    fn add(&mut self, span: Range<usize>, kind: Kind) {
        let keys = self.key.iter().map(|(_, at)| at.clone()).collect();
        self.places.push(Place { path: self.path(), keys, span, kind });
    }

    fn run(&mut self) {
        let mut begins_line = true;
        while let Some(token) = self.tokens.get(self.next).copied() {
            let (kind, span) = (token.kind(), token.span().start()..token.span().end());
            if begins_line && !matches!(kind, TokenKind::Whitespace | TokenKind::Newline) {
                self.recover(&span);
            }
            let is_header = begins_line && self.frames.is_empty();
            begins_line =
                kind == TokenKind::Newline || begins_line && kind == TokenKind::Whitespace;
            self.next += 1;
            match kind {
                TokenKind::LeftSquareBracket if is_header => self.header(span.start),
                TokenKind::LeftSquareBracket if self.takes_value() => self.open(&span, Some(0)),
                TokenKind::LeftCurlyBracket if self.takes_value() => self.open(&span, None),
                TokenKind::RightSquareBracket => self.close(true, span.end),
                TokenKind::RightCurlyBracket => self.close(false, span.end),
                TokenKind::Equals => self.is_after_equals |= !self.is_in_array(),
                TokenKind::Comma => self.comma(),
                TokenKind::Newline if self.frames.is_empty() => self.end_key(),
                TokenKind::Atom | TokenKind::Dot => self.word(span, Kind::Bare),
                kind if is_text(kind) => self.word(span, Kind::Text),
                _ => (),
            }
        }
    }

    /// A line that cannot go on with what is open ends it: an author writes in the middle of a file.
    fn recover(&mut self, at: &Range<usize>) {
        if self.frames.is_empty() || at.start > 0 && !self.text[..at.start].ends_with('\n') {
            return;
        }
        let line = self.text[at.start..].lines().next().unwrap_or_default();
        let first = line.trim_start_matches('[').split(['.', ']', '=']).next().unwrap_or_default();
        let is_word = first.trim().starts_with(|c: char| c.is_alphabetic());
        let is_section = || sections().iter().any(|section| section.name == first.trim());
        if is_word
            && (line.contains('=') && !line.starts_with('[')
                || line.starts_with('[') && is_section())
        {
            self.frames.clear();
            self.end_key();
        }
    }

    fn end_key(&mut self) {
        self.key.clear();
        self.is_after_equals = false;
    }

    fn comma(&mut self) {
        match self.frames.last_mut() {
            Some(Frame { index: Some(idx), .. }) => *idx += 1,
            Some(_) => self.end_key(),
            None => (),
        }
    }

    /// A header from its bracket on, to the last one of its line.
    fn header(&mut self, start: usize) {
        let mut parts = Vec::new();
        let mut end = start + 1;
        self.is_header = true;
        while let Some(token) = self.tokens.get(self.next).copied() {
            let span = token.span().start()..token.span().end();
            if matches!(token.kind(), TokenKind::Newline | TokenKind::Comment | TokenKind::Eof) {
                break;
            }
            if token.kind() == TokenKind::Atom || is_text(token.kind()) {
                parts.push((self.name(&span), span.clone()));
            }
            self.is_header &= token.kind() != TokenKind::RightSquareBracket;
            if token.kind() != TokenKind::Whitespace {
                end = span.end;
            }
            self.next += 1;
        }
        if self.tokens.get(self.next).is_some_and(|token| token.kind() == TokenKind::Newline) {
            self.is_header = false;
        }
        self.section.clear();
        self.key = parts;
        self.add(start..end, Kind::Header);
        self.section = self.key.drain(..).map(|(name, _)| name).collect();
        self.end_key();
    }

    /// A key without its quotes.
    fn name(&self, span: &Range<usize>) -> String {
        self.text[span.clone()].trim_matches(['"', '\'']).to_owned()
    }

    fn open(&mut self, span: &Range<usize>, index: Option<usize>) {
        self.add(span.clone(), if index.is_some() { Kind::Array } else { Kind::Inline });
        let (path, place) = (self.path(), self.places.len() - 1);
        self.frames.push(Frame { path, index, place });
        self.end_key();
    }

    fn close(&mut self, is_array: bool, end: usize) {
        if self.frames.last().is_some_and(|frame| frame.index.is_some() == is_array)
            && let Some(frame) = self.frames.pop()
        {
            self.places[frame.place].span.end = end;
            // What follows up to a comma or the end of the line belongs to no key.
            self.end_key();
        }
    }

    fn word(&mut self, span: Range<usize>, kind: Kind) {
        if !self.takes_value() {
            if &self.text[span.clone()] != "." {
                self.key.push((self.name(&span), span));
            }
            return;
        }
        // A number with a point is three tokens.
        if let Some(last) = self.places.last_mut()
            && kind == Kind::Bare
            && last.kind == Kind::Bare
            && last.span.end == span.start
        {
            last.span.end = span.end;
            return;
        }
        self.add(span, kind);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_their_paths_and_places() {
        let text = "name = \"x\" # a = 1\n[bodies.rod] # the rod\ncom = [0.5, \"l/2\"]\npoints = { A = [0, 1], \"B\" = [\n  1,\n  2,\n] }\n[initial]\nA.angle = -1e-3\n";
        let found = places(text);
        let path = |of: &Place| of.path.join("/");
        let of = |wanted: &str| found.iter().find(|place| path(place) == wanted).expect(wanted);
        for (wanted, value) in [
            ("name", "\"x\""),
            ("bodies/rod", "[bodies.rod]"),
            ("bodies/rod/com", "[0.5, \"l/2\"]"),
            ("bodies/rod/com/0", "0.5"),
            ("bodies/rod/com/1", "\"l/2\""),
            ("bodies/rod/points/A/1", "1"),
            ("bodies/rod/points/B/1", "2"),
            ("initial/A/angle", "-1e-3"),
        ] {
            assert_eq!(&text[of(wanted).span.clone()], value, "{wanted}");
        }
        assert_eq!(found.len(), 14, "{found:?}");
        let key = of("initial/A/angle").key(1).expect("the name");
        assert_eq!(&text[key.clone()], "A");
        assert_eq!(of("bodies/rod/com/1").inside(text).map(|at| &text[at]), Some("l/2"));
    }

    #[test]
    fn a_cursor_knows_its_place_in_a_text_that_is_being_written() {
        for (text, path, is_value, word) in [
            (
                "[joints.A]\nbetween = [\"ground\", \"arm.|\n[joints.B]\nx = 1\n",
                "joints/A/between/1",
                true,
                Some("arm."),
            ),
            ("[bodies]\nrod = { mass = 1, |", "bodies/rod", false, None),
            ("[bodies.rod]\npoints = { A = [0, 0], B = [|", "bodies/rod/points/B/0", true, None),
            ("[bodies.rod]\npoints = { A = [0,\n[joints.A]\nty|", "joints/A", false, None),
            ("[bodies.rod]\ncom = [0,\nmass = \"1 |", "bodies/rod/mass", true, Some("1 ")),
            ("[initial]\nA.angle = \"3|", "initial/A/angle", true, Some("3")),
            ("[initial]\nA = { angle = 1 }\n|", "initial", false, None),
        ] {
            let byte = text.find('|').expect("a cursor");
            let whole = text.replace('|', "");
            let found = cursor(&whole, byte);
            assert_eq!((found.path.join("/").as_str(), found.is_value), (path, is_value), "{text}");
            assert_eq!(found.text.map(|from| &whole[from..byte]), word, "{text}");
        }
        // Anywhere in a text, whatever is open there.
        let text =
            "é = 'x\n[a.\"b]\nc = { d = [1, \"\"\"\\\" }\n], { = } # µ\n[joints]\nA = {[,\n]}\n\"";
        for (byte, _) in text.char_indices() {
            cursor(text, byte);
            places(&text[byte..]);
        }
        assert!(cursor("[joints.", 8).is_header && !cursor("[joints.A]", 10).is_header);
        assert!(cursor("a = 1 # b", 9).is_comment && !cursor("a = 1 # b\n", 10).is_comment);
        assert!(cursor("a = \"1\"", 7).text.is_none());
    }
}
