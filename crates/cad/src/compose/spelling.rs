//! Names of a drawing in the letters of a model file.
//!
//! A drawing is written in any script; a model file has names of the letters a–z, digits and `_`, which
//! can stand in expressions. Names of other letters are spelled in these, `rod-1` as `rod_1`, `ω` as
//! `omega`, `thanh truyền` as `thanh_truyen`, wherever the text of the model has them; messages have the
//! author's own.

use std::collections::{BTreeMap, BTreeSet};

use any_ascii::any_ascii_char;
use toml_edit::{DocumentMut, InlineTable, Item, Key, Table, TableLike, Value};

/// Sections whose keys are names, with the letter that a name without any letter begins with.
const NAMED: [(&str, char); 13] = [
    ("parameters", 'p'),
    ("tables", 't'),
    ("curves", 'c'),
    ("bodies", 'b'),
    ("joints", 'j'),
    ("couplings", 'c'),
    ("states", 's'),
    ("clocks", 'c'),
    ("signals", 's'),
    ("use", 'u'),
    ("loads", 'l'),
    ("drives", 'd'),
    ("initial", 'c'),
];

/// Keys whose values are names, `body.point` among them, and no expressions.
const REFERENCES: [&str; 13] = [
    "between",
    "on",
    "joint",
    "about",
    "coordinate",
    "coordinates",
    "from",
    "curve",
    "second_curve",
    "law",
    "clock",
    "carrier",
    "coupling",
];

/// Sections and keys without names.
const PLAIN: [&str; 4] = ["units", "solve", "type", "name"];

/// Signs with which a name reads as an expression.
const OPERATORS: [char; 8] = ['+', '-', '*', '/', '^', '(', ')', ','];

/// Greek letters by the names that equations print as these letters.
#[rustfmt::skip]
const GREEK: [(char, &str); 36] = [
    ('α', "alpha"), ('β', "beta"), ('γ', "gamma"), ('δ', "delta"), ('ε', "epsilon"), ('ζ', "zeta"),
    ('η', "eta"), ('θ', "theta"), ('ι', "iota"), ('κ', "kappa"), ('λ', "lambda"), ('μ', "mu"),
    ('µ', "mu"), ('ν', "nu"), ('ξ', "xi"), ('ο', "o"), ('π', "pi"), ('ρ', "rho"), ('σ', "sigma"),
    ('ς', "sigma"), ('τ', "tau"), ('υ', "upsilon"), ('φ', "phi"), ('ϕ', "phi"), ('χ', "chi"),
    ('ψ', "psi"), ('ω', "omega"), ('Γ', "Gamma"), ('Δ', "Delta"), ('Θ', "Theta"), ('Λ', "Lambda"),
    ('Ξ', "Xi"), ('Π', "Pi"), ('Σ', "Sigma"), ('Φ', "Phi"), ('Ω', "Omega"),
];

/// The spellings of all names that need one.
#[derive(Clone, Debug, Default)]
pub(super) struct Spellings {
    /// By the name in the drawing.
    list: BTreeMap<String, String>,
}

impl Spellings {
    /// Of the names of a drawn model.
    pub(super) fn of(drawn: &DocumentMut) -> Self {
        let names = names(drawn);
        let mut taken: BTreeSet<String> =
            names.iter().map(|(name, _)| name).filter(|name| is_usable(name)).cloned().collect();
        let mut list = BTreeMap::new();
        for (name, letter) in names.into_iter().filter(|(name, _)| !is_usable(name)) {
            if list.contains_key(&name) {
                continue;
            }
            let plain = spelled(&name, letter);
            let numbered = (2..).map(|number: u64| format!("{plain}_{number}"));
            let mut candidates = std::iter::once(plain.clone()).chain(numbered);
            let free = candidates.find(|it| it != "ground" && !taken.contains(it));
            let free = free.expect("fewer names are taken than there are numbers");
            taken.insert(free.clone());
            list.insert(name, free);
        }
        Self { list }
    }

    /// True if all names are usable as they are.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Names of the drawing with their spellings.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.list.iter().map(|(name, spelling)| (name.as_str(), spelling.as_str()))
    }

    /// A name as the model has it.
    pub(super) fn name<'n>(&'n self, name: &'n str) -> &'n str {
        self.list.get(name).map_or(name, String::as_str)
    }

    /// A path of keys as the model has it.
    pub(super) fn path(&self, path: &[String]) -> Vec<String> {
        let has_names = path.len() > 1 && !PLAIN.contains(&path[0].as_str());
        let part =
            |part: &String| if has_names { self.name(part).to_owned() } else { part.clone() };
        path.iter().map(part).collect()
    }

    /// Spells the names in a document, those of keys and those in texts.
    pub(super) fn spell(&self, document: &mut DocumentMut) {
        if self.is_empty() {
            return;
        }
        for (section, item) in document.iter_mut() {
            let section = section.get().to_owned();
            if PLAIN.contains(&section.as_str()) {
                continue;
            }
            let has_names = NAMED.iter().any(|(name, _)| *name == section);
            self.spell_item(item, &section, has_names);
        }
    }

    /// Spells what is below a key; `has_names` where the keys of a table are names.
    fn spell_item(&self, item: &mut Item, key: &str, has_names: bool) {
        match item {
            Item::Value(value) => self.spell_value(value, key, has_names),
            Item::Table(table) => {
                if has_names {
                    self.spell_keys(table);
                }
                for (key, item) in table.iter_mut() {
                    let key = key.get().to_owned();
                    if has_names || !PLAIN.contains(&key.as_str()) {
                        self.spell_item(item, &key, key == "points");
                    }
                }
            }
            Item::ArrayOfTables(_) | Item::None => (),
        }
    }

    fn spell_value(&self, value: &mut Value, key: &str, has_names: bool) {
        match value {
            Value::String(text) => {
                let spelled = self.spell_text(text.value(), REFERENCES.contains(&key));
                if spelled != *text.value() {
                    let decor = text.decor().clone();
                    let mut new = toml_edit::Formatted::new(spelled);
                    *new.decor_mut() = decor;
                    *text = new;
                }
            }
            Value::Array(array) => {
                for value in array.iter_mut() {
                    self.spell_value(value, key, false);
                }
            }
            Value::InlineTable(table) => {
                if has_names {
                    self.spell_inline_keys(table);
                }
                for (key, value) in table.iter_mut() {
                    let key = key.get().to_owned();
                    if has_names || !PLAIN.contains(&key.as_str()) {
                        self.spell_value(value, &key, key == "points");
                    }
                }
            }
            _ => (),
        }
    }

    /// The keys keep their order: each is taken out and put in again.
    fn spell_keys(&self, table: &mut Table) {
        let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
        for key in keys {
            let (old, item) = table.remove_entry(&key).expect("the keys are those of the table");
            table.insert_formatted(&self.key(&old), item);
        }
    }

    fn spell_inline_keys(&self, table: &mut InlineTable) {
        let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
        for key in keys {
            let (old, item) = table.remove_entry(&key).expect("the keys are those of the table");
            table.insert_formatted(&self.key(&old), item);
        }
    }

    fn key(&self, old: &Key) -> Key {
        match self.list.get(old.get()) {
            Some(spelling) => Key::new(spelling).with_leaf_decor(old.leaf_decor().clone()),
            None => old.clone(),
        }
    }

    /// A text with its names spelled: a name or `body.point`, or an expression.
    fn spell_text(&self, text: &str, is_reference: bool) -> String {
        let trimmed = text.trim();
        if let Some(spelling) = self.list.get(trimmed) {
            // A number is no name where an expression may stand.
            let is_number = trimmed.parse::<f64>().is_ok();
            if is_reference || !is_number {
                return spelling.clone();
            }
        }
        if is_reference {
            let halves = trimmed.match_indices('.').map(|(at, _)| trimmed.split_at(at));
            let known = |name: &str| self.list.contains_key(name);
            let found = halves
                .map(|(body, point)| (body, &point[1..]))
                .find(|(body, point)| known(body) || known(point));
            return found.map_or_else(
                || text.to_owned(),
                |(body, point)| format!("{}.{}", self.name(body), self.name(point)),
            );
        }
        let mut text = text.to_owned();
        let mut names: Vec<(&str, &str)> = self.pairs().collect();
        names.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
        for (name, spelling) in names {
            // Of signs that an expression may have, a name is sure before the point of a measure alone.
            text = replaced(&text, name, spelling, name.contains(OPERATORS));
        }
        text
    }

    /// A message about the model in the words of the drawing: names in backticks.
    pub(super) fn drawn(&self, message: &str) -> String {
        let mut parts: Vec<String> = message.split('`').map(str::to_owned).collect();
        for part in parts.iter_mut().skip(1).step_by(2) {
            for (name, spelling) in self.pairs() {
                *part = replaced(part, spelling, name, false);
            }
        }
        parts.join("`")
    }
}

/// The text with a name replaced where it stands by itself; only before a point where `is_measured`.
fn replaced(text: &str, name: &str, by: &str, is_measured: bool) -> String {
    let is_letter = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(name) {
        let (before, after) = (&rest[..at], &rest[at + name.len()..]);
        let follows = out.chars().chain(before.chars()).next_back();
        let is_apart = !follows.is_some_and(|c| is_letter(c) || c == '.')
            && !after.starts_with(is_letter)
            && (!is_measured || after.starts_with('.'))
            && !name.starts_with(|c: char| c.is_ascii_digit());
        out.push_str(before);
        out.push_str(if is_apart { by } else { name });
        rest = after;
    }
    out + rest
}

/// The names of a model in their order, each with the letter that it may begin with.
fn names(document: &DocumentMut) -> Vec<(String, char)> {
    // Points are called after joints and loads: these say which letter a number gets.
    let (mut names, mut points) = (Vec::new(), Vec::new());
    let table = |item: &Item| -> Vec<(String, Item)> {
        let table = item.as_table_like().into_iter().flat_map(TableLike::iter);
        table.map(|(key, item)| (key.to_owned(), item.clone())).collect()
    };
    for (section, letter) in NAMED {
        for (name, item) in document.get(section).map_or_else(Vec::new, table) {
            names.push((name, letter));
            points.extend(item.get("points").map_or_else(Vec::new, table));
            let coordinates = item.get("coordinate").and_then(Item::as_value);
            names.extend(coordinates.into_iter().flat_map(texts).map(|name| (name, 'c')));
        }
    }
    let ground = document.get("ground").and_then(|ground| ground.get("points"));
    points.extend(ground.map_or_else(Vec::new, table));
    names.extend(points.into_iter().map(|(name, _)| (name, 'p')));
    names
}

fn texts(value: &Value) -> Vec<String> {
    match value {
        Value::Array(array) => array.iter().flat_map(texts).collect(),
        value => value.as_str().map(str::to_owned).into_iter().collect(),
    }
}

/// True if a model file takes a name as it is.
fn is_usable(name: &str) -> bool {
    let has_letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    has_letters && !name.is_empty() && !name.starts_with(|c: char| c.is_ascii_digit())
}

/// The name of a body as a model file next to the drawing may spell it, too.
pub(super) fn spelled_body(name: &str) -> String {
    if is_usable(name) { name.to_owned() } else { spelled(name, 'b') }
}

/// A name in the letters of a model file; `letter` is put before one that would begin with a digit.
fn spelled(name: &str, letter: char) -> String {
    let letters: Vec<char> = name.chars().collect();
    let mut out = String::new();
    for (idx, &c) in letters.iter().enumerate() {
        let [before, after] = [idx.checked_sub(1), Some(idx + 1)]
            .map(|idx| idx.and_then(|idx| letters.get(idx)).copied());
        match c {
            c if c.is_ascii_alphanumeric() => out.push(c),
            '\'' | '′' | '’' => out.push_str("_prime"),
            c => {
                let word = symbol(c, before, after).unwrap_or_else(|| any_ascii_char(c).to_owned());
                let plain = |it: char| if it.is_ascii_alphanumeric() { it } else { '_' };
                out.extend(word.chars().map(plain));
            }
        }
    }
    let words: Vec<&str> = out.split('_').filter(|word| !word.is_empty()).collect();
    let joined = words.join("_");
    if is_usable(&joined) { joined } else { format!("{letter}{joined}") }
}

/// The name of a Greek letter that stands for itself, as in `ω1`; in a Greek word it is a letter.
fn symbol(c: char, before: Option<char>, after: Option<char>) -> Option<String> {
    let is_greek = |c: Option<char>| c.is_some_and(|c| ('\u{370}'..='\u{3ff}').contains(&c));
    let (_, word) = GREEK.iter().find(|(letter, _)| *letter == c)?;
    if is_greek(before) || is_greek(after) {
        return None;
    }
    let goes_on = after.is_some_and(|c| c.is_ascii_alphabetic());
    Some(if goes_on { format!("{word}_") } else { (*word).to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_any_script_are_spelled_in_plain_letters() {
        for (name, expected) in [
            ("rod-1", "rod_1"),
            ("thanh truyền", "thanh_truyen"),
            ("ω", "omega"),
            ("φ₁", "phi1"),
            ("Δl", "Delta_l"),
            ("στρόφαλος", "strofalos"),
            ("连杆", "LianGan"),
            ("A'", "A_prime"),
            ("1", "j1"),
            ("Kurbel (links)", "Kurbel_links"),
        ] {
            assert_eq!(spelled(name, 'j'), expected, "{name}");
        }
    }

    #[test]
    fn keys_references_and_expressions_are_spelled_alike() {
        let text = "[parameters]\n\"ω\" = \"60 rpm\"\n\n[bodies.\"rod-1\"]\npoints = { \"A'\" = [0, 0] }\n\
                    [joints.1]\nbetween = [\"ground.A'\", \"rod-1.A'\"]\n[joints.j1]\nx = \"2*ω*t + 1 + rod-1.angle\"\n";
        let mut document: DocumentMut = text.parse().expect("a document");
        Spellings::of(&document).spell(&mut document);
        let expected = "[parameters]\nomega = \"60 rpm\"\n\n[bodies.rod_1]\npoints = { A_prime = [0, 0] }\n\
                        [joints.j1_2]\nbetween = [\"ground.A_prime\", \"rod_1.A_prime\"]\n\
                        [joints.j1]\nx = \"2*omega*t + 1 + rod_1.angle\"\n";
        assert_eq!(document.to_string(), expected);
    }

    #[test]
    fn messages_have_the_words_of_the_drawing() {
        let document: DocumentMut = "[bodies.\"rod-1\"]\n".parse().expect("a document");
        let spellings = Spellings::of(&document);
        let message = "body `rod_1` has rod_1 points, `rod_1.A` and `rod_12`";
        let drawn = "body `rod-1` has rod_1 points, `rod-1.A` and `rod_12`";
        assert_eq!(spellings.drawn(message), drawn);
    }
}
