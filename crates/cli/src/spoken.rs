//! The language of what is printed for people.

use std::sync::{PoisonError, RwLock};

use bksim::translation::Language;

static LANGUAGE: RwLock<Language> = RwLock::new(Language::English);

/// Sets the language in which diagnostics and answers are printed from now on.
pub(crate) fn speak(language: Language) {
    *LANGUAGE.write().unwrap_or_else(PoisonError::into_inner) = language;
}

/// The language in which diagnostics and answers are printed.
pub(crate) fn language() -> Language {
    *LANGUAGE.read().unwrap_or_else(PoisonError::into_inner)
}
