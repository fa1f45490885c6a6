//! Names in a file: which sections give them, which texts are none, and what a name may be.

/// Sections whose keys are names that formulas may use.
pub const NAMED: [&str; 14] = [
    "parameters",
    "tables",
    "curves",
    "bodies",
    "joints",
    "couplings",
    "conditions",
    "contacts",
    "states",
    "clocks",
    "signals",
    "outputs",
    "loads",
    "drives",
];

/// Owners of quantities before the name of an element, with the section that gives it: `reactions.A.fx` is of a joint.
pub const OWNERS: [(&str, &str); 11] = [
    ("reactions", "joints"),
    ("transmission", "joints"),
    ("couplings", "couplings"),
    ("contacts", "contacts"),
    ("states", "states"),
    ("signals", "signals"),
    ("outputs", "outputs"),
    ("loads", "loads"),
    ("drives", "drives"),
    ("state", "coordinates"),
    ("acceleration", "coordinates"),
];

/// Keys of a load case.
pub(super) const CASE_KEYS: [&str; 2] = ["title", "set"];

/// Keys whose texts are words of the format.
const WORDS: [&str; 18] = [
    "type",
    "file",
    "part",
    "interpolation",
    "extrapolate",
    "kind",
    "sense",
    "side",
    "method",
    "formulation",
    "jit",
    "space",
    "law",
    "name",
    "drawing",
    "axes",
    "frame",
    "tangents",
];

/// True if the text at the end of these keys, such as `joints.A.type`, is a word of the format and no formula.
pub fn is_word(path: &[String]) -> bool {
    let key = path.iter().rev().find(|key| key.parse::<usize>().is_err());
    let Some((key, section)) = key.zip(path.first()) else { return false };
    // Motions of a joint; below `[tolerance]` are names.
    let is_motion = key == "of" && section != "tolerance";
    is_motion || section == "units" || WORDS.contains(&key.as_str())
}

/// True if a text can be a name.
pub fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_known_by_their_keys_and_not_by_names_of_elements() {
        let is = |path: &str| {
            let path: Vec<String> = path.split('.').map(str::to_owned).collect();
            is_word(&path)
        };
        assert!(is("joints.A.type") && is("units.length") && is("loads.f.of") && is("space"));
        assert!(!is("bodies.frame.mass") && !is("tolerance.of") && !is("joints.A.coordinate"));
    }

    #[test]
    fn every_section_of_names_is_one_of_the_file() {
        assert!(NAMED.iter().all(|name| super::super::SECTIONS.contains(name)));
    }
}
