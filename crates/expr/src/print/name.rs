//! Identifiers as letters with dots and subscripts: `theta1_dot` is θ with one dot and index 1.

/// Greek letters by name; each notation but text writes them as such.
const GREEK: [(&str, char); 35] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("epsilon", 'ε'),
    ("zeta", 'ζ'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("iota", 'ι'),
    ("kappa", 'κ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("xi", 'ξ'),
    ("pi", 'π'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("tau", 'τ'),
    ("upsilon", 'υ'),
    ("phi", 'φ'),
    ("chi", 'χ'),
    ("psi", 'ψ'),
    ("omega", 'ω'),
    ("Gamma", 'Γ'),
    ("Delta", 'Δ'),
    ("Theta", 'Θ'),
    ("Lambda", 'Λ'),
    ("Xi", 'Ξ'),
    ("Pi", 'Π'),
    ("Sigma", 'Σ'),
    ("Upsilon", 'Υ'),
    ("Phi", 'Φ'),
    ("Psi", 'Ψ'),
    ("Omega", 'Ω'),
    // Other codes of the same letter.
    ("mu", 'µ'),
];

/// A letter or a word of a name.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Word<'a> {
    /// Name and character.
    Greek(&'static str, char),
    /// One letter, set in italics.
    Letter(char),
    /// Several letters, set upright.
    Text(&'a str),
    /// Digits.
    Digits(&'a str),
}

/// An identifier taken apart.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Name<'a> {
    pub(super) letter: Word<'a>,
    /// Number of time derivatives.
    pub(super) n_dots: usize,
    pub(super) subscripts: Vec<Word<'a>>,
}

impl<'a> Name<'a> {
    /// `x2_dot` is x, one dot, index 2; `crank.x` is x of `crank`; `k_spring` is k of `spring`.
    pub(super) fn of(name: &'a str) -> Self {
        let (name, n_dots) = match (name.strip_suffix("_ddot"), name.strip_suffix("_dot")) {
            (Some(stem), _) if !stem.is_empty() => (stem, 2),
            (_, Some(stem)) if !stem.is_empty() => (stem, 1),
            _ => (name, 0),
        };
        let (path, last) = name.rsplit_once('.').unwrap_or(("", name));
        let stem_end = last.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (stem, digits) = last.split_at(if stem_end == 0 { last.len() } else { stem_end });
        // Underscores at the end are kept where nothing follows: `ld1_` is not `ld1`.
        let trimmed = if digits.is_empty() { stem } else { stem.trim_end_matches('_') };
        let (stem, word) = match trimmed.split_once('_') {
            Some((stem, word)) if !stem.is_empty() && !word.trim_matches('_').is_empty() => {
                (stem, word)
            }
            _ => (trimmed, ""),
        };
        let words = [word, digits, path].into_iter().filter(|word| !word.is_empty());
        Self { letter: Word::of(stem), n_dots, subscripts: words.map(Word::of).collect() }
    }
}

impl<'a> Word<'a> {
    fn of(text: &'a str) -> Self {
        let mut chars = text.chars();
        let single = chars.next().filter(|_| chars.next().is_none());
        let greek = |&&(name, c): &&(&str, char)| name == text || single == Some(c);
        if let Some(&(name, c)) = GREEK.iter().find(greek) {
            return Self::Greek(name, c);
        }
        match single {
            Some(c) if c.is_alphabetic() => Self::Letter(c),
            _ if text.bytes().all(|b| b.is_ascii_digit()) => Self::Digits(text),
            _ => Self::Text(text),
        }
    }

    /// Widths of its characters, ems.
    pub(super) fn ems(self) -> f64 {
        match self {
            Self::Greek(..) | Self::Letter(_) => 0.6,
            Self::Text(text) | Self::Digits(text) => 0.48 * text.chars().count() as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_become_letters_with_dots_and_subscripts() {
        use Word::{Digits, Greek, Letter, Text as Upright};
        let theta = Greek("theta", 'θ');
        for (text, letter, n_dots, subscripts) in [
            ("theta1", theta, 0, vec![Digits("1")]),
            ("θ1", theta, 0, vec![Digits("1")]),
            ("x2_dot", Letter('x'), 1, vec![Digits("2")]),
            ("x2_ddot", Letter('x'), 2, vec![Digits("2")]),
            ("ld1", Upright("ld"), 0, vec![Digits("1")]),
            ("m", Letter('m'), 0, vec![]),
            ("crank.x", Letter('x'), 0, vec![Upright("crank")]),
            ("k_spring", Letter('k'), 0, vec![Upright("spring")]),
            ("k_spring2", Letter('k'), 0, vec![Upright("spring"), Digits("2")]),
            ("q_12", Letter('q'), 0, vec![Digits("12")]),
            ("_dot", Upright("_dot"), 0, vec![]),
            ("ld1_", Upright("ld1_"), 0, vec![]),
            ("A_angle_dot", Letter('A'), 1, vec![Upright("angle")]),
            ("q_theta", Letter('q'), 0, vec![theta]),
        ] {
            assert_eq!(Name::of(text), Name { letter, n_dots, subscripts }, "{text}");
        }
    }
}
