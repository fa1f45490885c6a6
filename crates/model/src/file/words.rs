//! Words of messages: the candidates near a misspelt word, and words cut to a readable length.

use super::letters::suggest_plain;
use crate::measure::Measure;
use crate::model::Model;

/// Longer words are not compared: comparing takes quadratic time.
const MAX_WORD: usize = 60;

/// The candidate nearest to a word: equal but for case, else within a few typing errors.
pub fn closest<'c>(word: &str, candidates: &[&'c str]) -> Option<&'c str> {
    let same_letters = candidates.iter().find(|known| known.eq_ignore_ascii_case(word));
    if let Some(known) = same_letters {
        return Some(known);
    }
    // The plural that no letter more makes.
    if word.eq_ignore_ascii_case("body")
        && let Some(known) = candidates.iter().find(|known| **known == "bodies")
    {
        return Some(known);
    }
    if word.len() > MAX_WORD {
        return None;
    }
    let allowed = (word.chars().count().saturating_add(1) / 3).clamp(1, 3);
    candidates
        .iter()
        .filter(|known| known.len().abs_diff(word.len()) <= 4 * allowed)
        .map(|known| (strsim::damerau_levenshtein(word, known), *known))
        .filter(|(distance, known)| *distance <= allowed && *distance < known.chars().count())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, known)| known)
}

/// The help for an unknown word by the nearest candidate, if one is near.
pub fn did_you_mean(word: &str, candidates: &[&str]) -> Option<String> {
    let near = || Some(format!("did you mean `{}`?", closest(word, candidates)?));
    suggest_plain(word, candidates).or_else(near)
}

impl Model {
    /// The help for a name that nothing has: the nearest name of a measure that fits, or of a signal where `None` does,
    /// if one is near.
    pub fn did_you_mean(
        &self,
        name: &str,
        fits: impl Fn(Option<Measure>) -> bool,
    ) -> Option<String> {
        let mut known = Measure::names(self);
        known.retain(|name| fits(Measure::named(self, name)));
        if fits(None) {
            known.extend(self.named_signals.iter().map(|signal| signal.name.clone()));
        }
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        did_you_mean(name, &known)
    }
}

/// The help for an unknown word: the nearest candidate, or a list of them.
pub fn suggest(word: &str, candidates: &[&str]) -> String {
    if let Some(help) = did_you_mean(word, candidates) {
        return help;
    }
    match candidates {
        [] => "there are none yet: define one".to_owned(),
        [one] => format!("write `{one}`"),
        many => {
            let shown: Vec<String> =
                many.iter().take(12).map(|known| format!("`{known}`")).collect();
            let more = if many.len() > 12 { ", …" } else { "" };
            format!("one of {}{more}", shown.join(", "))
        }
    }
}

/// A word for a message: whole when short, cut when long.
pub(super) fn cut(word: &str) -> String {
    if word.chars().count() <= MAX_WORD {
        return word.to_owned();
    }
    word.chars().take(MAX_WORD - 1).chain(['…']).collect()
}
