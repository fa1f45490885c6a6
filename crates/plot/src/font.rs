//! The font of all figures, and the widths of texts in it.

use std::sync::OnceLock;

use ttf_parser::Face;

/// The font files: Ubuntu Light; then Hack, for the few letters that the first does not have.
pub(crate) const FONTS: [&[u8]; 2] =
    [epaint_default_fonts::UBUNTU_LIGHT, epaint_default_fonts::HACK_REGULAR];

/// Width of a text, in the unit of `size`; without kerning, which makes it narrower.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    // A letter that no font has is shown as a box, about this wide.
    let advance = |letter: char| faces().iter().find_map(|face| advance(face, letter));
    size * text.chars().map(|letter| advance(letter).unwrap_or(0.6)).sum::<f64>()
}

/// True of a letter that the built-in fonts have, and of line ends.
pub(crate) fn has(letter: char) -> bool {
    letter.is_ascii_control() || faces().iter().any(|face| advance(face, letter).is_some())
}

fn faces() -> &'static [Face<'static>] {
    static FACES: OnceLock<Vec<Face<'static>>> = OnceLock::new();
    let face = |bytes: &&'static [u8]| Face::parse(bytes, 0).expect("the fonts built in are valid");
    FACES.get_or_init(|| FONTS.iter().map(face).collect())
}

/// Width of a letter in a font, relative to the font size.
fn advance(face: &Face<'_>, letter: char) -> Option<f64> {
    let units = face.glyph_hor_advance(face.glyph_index(letter)?)?;
    Some(f64::from(units) / f64::from(face.units_per_em()))
}

/// The text, its middle replaced by `…` if it is wider than `room`.
pub(crate) fn fitted(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    // A bound on the number of measurements of a very long text.
    let mut n_kept = letters.len().min(400);
    while n_kept > 1 {
        n_kept -= 1;
        let (head, tail) = (n_kept.div_ceil(2), n_kept / 2);
        let ends = letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]);
        let short: String = ends.collect();
        if width(&short, size) <= room {
            return short;
        }
    }
    "…".to_owned()
}

/// The text, or as much of its beginning as fits into `room`.
pub(crate) fn begun(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().take(400).collect();
    let short = |n: usize| letters[..n].iter().chain(&['…']).collect::<String>();
    let found = (1..letters.len()).rev().map(short).find(|short| width(short, size) <= room);
    found.unwrap_or_else(|| "…".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fonts_have_the_letters_of_labels() {
        assert_eq!(faces().len(), 2);
        let letters = "abcXYZ019 ().,/_·×−⁻⁰¹²³⁴⁵⁶⁷⁸⁹…αβγθλμπφωąćęłńóśźżÄÖÜäöüß";
        let missing: String =
            letters.chars().filter(|&l| faces().iter().all(|f| advance(f, l).is_none())).collect();
        assert_eq!(missing, "");
    }

    #[test]
    fn widths_add_up_and_long_texts_are_cut() {
        assert!((width("angle", 20.0) - 2.0 * width("angle", 10.0)).abs() < 1e-12);
        assert!(width("mmm", 10.0) > width("iii", 10.0));
        let text = "reactions.a_joint_of_a_very_long_name.fx";
        let short = fitted(text, 13.0, 120.0);
        assert!(width(&short, 13.0) <= 120.0 && width(&short, 13.0) > 100.0, "{short}");
        assert!(short.starts_with("react") && short.ends_with("fx"));
        assert_eq!(fitted(text, 13.0, 0.0), "…");
        assert_eq!(fitted("fx", 13.0, 100.0), "fx");
    }
}
