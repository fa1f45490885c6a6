//! Diagnostic codes in another language than English: title, meaning and cure of each; the help of the command line;
//! the texts of the window.
//!
//! The texts are data, `docs/vi/diagnostics.toml`, `docs/vi/help.toml` and `docs/vi/window.toml`. Examples and outputs are those of the English pages,
//! so that a page says the same in both languages.

use std::collections::BTreeMap;
use std::sync::{LazyLock, PoisonError, RwLock};

use crate::explain;

/// The languages of messages.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Language {
    /// English, the language of all messages.
    #[default]
    English,
    /// Vietnamese, next to the English.
    Vietnamese,
}

static SPOKEN: RwLock<Language> = RwLock::new(Language::English);

/// Sets the language of everything that is shown or printed for people from now on.
pub fn speak(language: Language) {
    *SPOKEN.write().unwrap_or_else(PoisonError::into_inner) = language;
}

/// The language of everything that is shown or printed for people.
pub fn spoken() -> Language {
    *SPOKEN.read().unwrap_or_else(PoisonError::into_inner)
}

impl Language {
    /// The language of a POSIX locale such as `vi_VN.UTF-8`; English for all that is not known.
    pub fn of_locale(locale: &str) -> Self {
        let language = locale.split(['_', '.', '@', '-']).next().unwrap_or_default();
        if language.eq_ignore_ascii_case("vi") { Self::Vietnamese } else { Self::English }
    }
}

/// A code in another language.
#[derive(PartialEq, Eq, Debug)]
pub struct Translation {
    /// The subject in a few words.
    pub title: String,
    /// The fault and the reason why it is one.
    pub meaning: String,
    /// The text to write, or the thing to do, instead.
    pub cure: String,
}

static VIETNAMESE: LazyLock<BTreeMap<String, Translation>> =
    LazyLock::new(|| table(include_str!("../docs/vi/diagnostics.toml")));

/// Headings of a page in Vietnamese; other sections keep their own.
const HEADINGS: [(&str, &str); 4] = [
    ("## Fault", "## Ví dụ lỗi"),
    ("## Output", "## Kết quả in ra"),
    ("## Cure", "## Cách sửa"),
    ("## When", "## Cách sửa"),
];

static VIETNAMESE_HELP: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    let text = include_str!("../docs/vi/help.toml");
    toml::from_str(text).expect("a table of the repository, which a test reads")
});

static VIETNAMESE_WINDOW: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    let text = include_str!("../docs/vi/window.toml");
    toml::from_str(text).expect("a table of the repository, which a test reads")
});

/// A text of the window in a language; `None` in English, and for texts that there are not.
pub fn window_text(english: &str, language: Language) -> Option<&'static str> {
    match language {
        Language::English => None,
        Language::Vietnamese => VIETNAMESE_WINDOW.get(english).map(String::as_str),
    }
}

/// A text of the command line's help, in English without the full stop, in a language; `None` in English, and for texts
/// that there are not.
pub fn help_text(english: &str, language: Language) -> Option<&'static str> {
    match language {
        Language::English => None,
        Language::Vietnamese => VIETNAMESE_HELP.get(english).map(String::as_str),
    }
}

/// Reads a table of translations.
fn table(text: &str) -> BTreeMap<String, Translation> {
    let rows: toml::Table = text.parse().expect("a table of the repository, which a test reads");
    let read = |row: &toml::Value, key: &str| {
        let value = row.get(key).and_then(toml::Value::as_str);
        value.expect("a row has title, meaning and cure").to_owned()
    };
    let translation = |row: &toml::Value| Translation {
        title: read(row, "title"),
        meaning: read(row, "meaning"),
        cure: read(row, "cure"),
    };
    rows.iter().map(|(code, row)| (code.clone(), translation(row))).collect()
}

/// The translation of a code such as `M012`; `None` in English, and for codes that there are not.
pub fn translation(code: &str, language: Language) -> Option<&'static Translation> {
    match language {
        Language::English => None,
        Language::Vietnamese => VIETNAMESE.get(&code.trim().to_ascii_uppercase()),
    }
}

/// All translations of a language by their codes; none in English.
pub fn translations(
    language: Language,
) -> impl Iterator<Item = (&'static str, &'static Translation)> {
    let of = (language == Language::Vietnamese).then(|| VIETNAMESE.iter());
    of.into_iter().flatten().map(|(code, words)| (code.as_str(), words))
}

/// The page of a code in a language, as Markdown.
pub fn page(code: &str, language: Language) -> Option<String> {
    let english = explain(code)?;
    Some(match translation(code, language) {
        None => english.text.to_owned(),
        Some(words) => translated_page(english.code.0, english.text, words),
    })
}

/// An English page with its words replaced: the blocks of its examples stay, and so do sections of
/// reference such as tables of units.
fn translated_page(code: &str, english: &str, words: &Translation) -> String {
    let mut page = format!("# {code}: {}\n\n{}\n", words.title, words.meaning);
    let mut section = "";
    let mut is_in_block = false;
    for line in english.lines().skip(1) {
        let is_heading = !is_in_block && line.starts_with("## ");
        let is_fence = line.starts_with("```");
        if is_heading {
            section = line;
            let known = HEADINGS.iter().find(|(heading, _)| *heading == line);
            page.extend(["\n", known.map_or(line, |(_, heading)| heading), "\n"]);
            if matches!(line, "## Cure" | "## When") {
                page.extend(["\n", &words.cure, "\n"]);
            }
        } else if is_in_block || is_fence {
            if is_fence && !is_in_block {
                page.push('\n');
            }
            page.extend([line, "\n"]);
            is_in_block ^= is_fence;
        } else if !section.is_empty() && HEADINGS.iter().all(|(heading, _)| *heading != section) {
            page.extend([line, "\n"]);
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explained_codes;

    #[test]
    fn every_code_is_translated_and_nothing_else() {
        let codes: Vec<_> = explained_codes().map(|page| page.code.0).collect();
        let missing: Vec<_> =
            codes.iter().filter(|code| !VIETNAMESE.contains_key(**code)).collect();
        assert!(missing.is_empty(), "docs/vi/diagnostics.toml lacks {missing:?}");
        let unknown: Vec<_> =
            VIETNAMESE.keys().filter(|code| !codes.contains(&code.as_str())).collect();
        assert!(unknown.is_empty(), "no codes: {unknown:?}");
        for (code, words) in &*VIETNAMESE {
            for text in [&words.title, &words.meaning, &words.cure] {
                assert!(text.trim().len() > 5, "{code}: `{text}`");
            }
            assert!(!words.title.ends_with('.'), "{code}: a title is no sentence");
            assert!(words.meaning.ends_with('.') && words.cure.ends_with(['.', ')']), "{code}");
        }
    }

    #[test]
    fn a_page_keeps_the_blocks_of_the_english_one() {
        for english in explained_codes() {
            let code = english.code.0;
            let page = page(code, Language::Vietnamese).expect("a page");
            assert_eq!(blocks(&page), blocks(english.text), "{code}");
            let words = translation(code, Language::Vietnamese).expect("a translation");
            assert!(page.contains(&words.cure), "{code} has no cure");
        }
    }

    fn blocks(page: &str) -> Vec<&str> {
        page.split("```").skip(1).step_by(2).collect()
    }

    #[test]
    fn locales_name_languages() {
        for locale in ["vi", "vi_VN", "vi_VN.UTF-8", "VI"] {
            assert_eq!(Language::of_locale(locale), Language::Vietnamese);
        }
        for locale in ["", "C", "en_US.UTF-8", "video"] {
            assert_eq!(Language::of_locale(locale), Language::English);
        }
    }
}
