//! The texts of the window in the language that is spoken, by the catalogue `docs/vi/window.toml`, and a font for them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use bksim::translation::{Language, spoken, window_text};
use egui::{FontData, FontDefinitions, FontFamily};
use fontdb::{Database, Style, Weight};
use ttf_parser::Face;

/// True if there is a font with the letters of the language.
static HAS_LETTERS: AtomicBool = AtomicBool::new(false);

/// Letters that only Vietnamese has: a font with them has all.
const LETTERS: &str = "ăđơưạảấầẩậắằẳặếềểệịọỏốồổỗộớờởợụủứừửữựỹ";

/// A text of the window in the language that is spoken; English if no font has its letters.
pub(super) fn said(english: &str) -> &str {
    if HAS_LETTERS.load(Relaxed) {
        window_text(english, spoken()).unwrap_or(english)
    } else {
        english
    }
}

/// Gives the window a font with the letters of the language that is spoken: one of the system, since that of the window has
/// those of English alone.
pub(super) fn load_letters(context: &egui::Context) {
    let font = (spoken() == Language::Vietnamese).then(font).flatten();
    HAS_LETTERS.store(font.is_some(), Relaxed);
    let Some((bytes, index)) = font else { return };
    let mut fonts = FontDefinitions::default();
    let name = "letters".to_owned();
    let data = FontData { index, ..FontData::from_owned(bytes) };
    fonts.font_data.insert(name.clone(), Arc::new(data));
    fonts.families.entry(FontFamily::Proportional).or_default().insert(0, name.clone());
    fonts.families.entry(FontFamily::Monospace).or_default().push(name);
    context.set_fonts(fonts);
}

/// The first upright font of the system, proportional ones first, that has the letters, as bytes and the number of its face.
fn font() -> Option<(Vec<u8>, u32)> {
    let mut known = Database::new();
    known.load_system_fonts();
    let mut faces: Vec<_> = known
        .faces()
        .filter(|face| face.style == Style::Normal && face.weight == Weight::NORMAL)
        .collect();
    // A serif and a condensed one only if there is no other.
    let rank =
        |name: &str| usize::from(name.contains("Serif")) + usize::from(name.contains("Condensed"));
    faces.sort_by_key(|face| {
        (face.monospaced, rank(&face.post_script_name), face.post_script_name.clone())
    });
    faces.into_iter().find_map(|face| {
        known.with_face_data(face.id, |bytes, index| {
            let read = Face::parse(bytes, index).ok()?;
            let has_all = LETTERS.chars().all(|letter| read.glyph_index(letter).is_some());
            has_all.then(|| (bytes.to_vec(), index))
        })?
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use bksim::translation::{Language, window_text};

    /// Names of parts of the window, which nobody reads.
    const NAMES: [&str; 14] = [
        "controls",
        "values",
        "curves",
        "help",
        "fault",
        "keys",
        "plot",
        "cursor",
        "now",
        "parameters.",
        "state.",
        "_dot",
        "energy.kinetic",
        "winit-",
    ];

    /// The texts of the window's files without tests: literals with two letters next to each other, without those of errors of
    /// the terminal.
    fn texts(path: &Path, found: &mut Vec<String>) {
        if path.is_dir() {
            for entry in fs::read_dir(path).expect("a folder") {
                texts(&entry.expect("an entry").path(), found);
            }
            return;
        }
        if matches!(
            path.file_name().and_then(|name| name.to_str()),
            Some("report.rs" | "said.rs" | "server.rs" | "source.rs")
        ) {
            return;
        }
        let text = fs::read_to_string(path).expect("a file");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for line in code.lines().map(str::trim) {
            if line.starts_with("//") || line.contains("expect(") || line.contains("reason =") {
                continue;
            }
            let literals = line.split('"').skip(1).step_by(2);
            let has_word = |text: &&str| {
                let bytes = text.as_bytes();
                bytes.windows(2).any(|pair| pair.iter().all(u8::is_ascii_alphabetic))
                    && !text.contains(['{', '(', ')'])
                    || text.contains(" (")
            };
            found.extend(literals.filter(has_word).map(str::to_owned));
        }
    }

    #[test]
    fn every_text_is_translated() {
        let mut found = Vec::new();
        texts(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/window"), &mut found);
        assert!(found.len() > 80, "{} texts", found.len());
        found.retain(|text| !NAMES.contains(&text.as_str()) && !text.starts_with("energy."));
        let missing: Vec<_> =
            found.iter().filter(|text| window_text(text, Language::Vietnamese).is_none()).collect();
        assert!(missing.is_empty(), "docs/vi/window.toml lacks {missing:#?}");
        for view in bksim_scene::StandardView::ALL {
            assert!(window_text(view.word(), Language::Vietnamese).is_some(), "{}", view.word());
        }
    }
}
