//! `bksim schema`: the JSON Schema of model files, by which editors complete and check them.

use bksim::model::file::{Holds, SectionForm, TableForm, sections};
use serde_json::{Map, Value, json};

use crate::exit::{Failure, Status};
use crate::output;

/// The page whose tables say what keys mean.
const REFERENCE: &str = include_str!("../../../../docs/model-reference.md");

/// Keys by the kind of their values, wherever they stand; others take any value.
const KINDS: [(Kind, &str); 7] = [
    (Kind::Names, "between"),
    (
        Kind::Text,
        "type on joint of from law curve clock file part interpolation extrapolate \
         formulation method jit axes shape",
    ),
    (Kind::Flag, "cut free internal reversed crossed slack"),
    (Kind::Whole, "count first"),
    (Kind::Array, "axis second com vector acceleration shapes when segments formula range over"),
    (Kind::Table, "with flexible"),
    (
        Kind::Quantity,
        "mass density thickness stiffness damping length value motion relation ratio \
         pressure_angle helix backlash EA rim lead restitution mu force torque static \
         rate every min max t_start t_end rtol atol step newton_tolerance",
    ),
];

/// A kind of value in a model file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A number, or a text with a quantity or an expression.
    Quantity,
    Text,
    Flag,
    Whole,
    Array,
    /// An array of names, or of names with more in tables.
    Names,
    Table,
}

impl Kind {
    fn schema(self) -> Value {
        match self {
            Self::Quantity => json!({ "type": ["number", "string"] }),
            Self::Text => json!({ "type": "string" }),
            Self::Flag => json!({ "type": "boolean" }),
            // `{i}` in a text is a whole number, too.
            Self::Whole => json!({ "type": ["integer", "string"] }),
            Self::Array => json!({ "type": "array" }),
            Self::Names => {
                json!({ "type": "array", "items": { "type": ["string", "object"] }, "minItems": 2 })
            }
            Self::Table => json!({ "type": "object" }),
        }
    }
}

pub(crate) fn run(as_json: bool) -> Result<Status, Failure> {
    let schema = schema();
    if as_json {
        output::json("schema", json!({ "schema": schema }))?;
    } else {
        output::text(&format!("{schema:#}"))?;
    }
    Ok(Status::Done)
}

/// The schema, of draft 7, which editors read.
fn schema() -> Value {
    let properties = sections().into_iter().map(|section| {
        let mut own = section_schema(&section);
        if let Some(meaning) = heading(section.name).and_then(first_sentence) {
            own["description"] = meaning.into();
        }
        (section.name.to_owned(), own)
    });
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Model of bksim",
        "type": "object",
        "properties": properties.collect::<Map<_, _>>(),
        "additionalProperties": false,
    })
}

fn section_schema(section: &SectionForm) -> Value {
    match &section.holds {
        Holds::Text => json!({ "type": "string" }),
        Holds::Word(words) => json!({ "enum": words }),
        Holds::Values => {
            json!({ "type": "object", "additionalProperties": Kind::Quantity.schema() })
        }
        Holds::Open => json!({ "type": "object" }),
        Holds::Table(keys) => {
            let properties = keys.iter().map(|(key, words)| {
                let own = if words.is_empty() {
                    key_schema(section.name, key)
                } else {
                    json!({ "enum": words })
                };
                ((*key).to_owned(), own)
            });
            let properties = properties.collect::<Map<_, _>>();
            json!({ "type": "object", "properties": properties, "additionalProperties": false })
        }
        Holds::Named(forms) => {
            json!({ "type": "object", "additionalProperties": named(section.name, forms) })
        }
    }
}

/// A table of one of these forms: its keys are those of its `type`.
fn named(section: &str, forms: &[TableForm]) -> Value {
    let properties = |form: &TableForm| {
        let keys = form.keys.iter().map(|key| ((*key).to_owned(), key_schema(section, key)));
        keys.collect::<Map<_, _>>()
    };
    if let [TableForm { word: None, .. }] = forms {
        let properties = properties(&forms[0]);
        return json!({ "type": "object", "properties": properties, "additionalProperties": false });
    }
    let mut all = Map::new();
    for form in forms {
        all.extend(properties(form));
    }
    let words: Vec<&str> = forms.iter().filter_map(|form| form.word).collect();
    all.insert("type".to_owned(), json!({ "enum": words }));
    // An editor completes keys from `properties`; the names of those of each type are checked below. A table
    // without `type` may be one next to a drawing, which has it.
    let of_type = |form: &TableForm| {
        json!({
            "if": { "properties": { "type": { "const": form.word } }, "required": ["type"] },
            "then": { "propertyNames": { "enum": form.keys } },
        })
    };
    json!({
        "type": "object",
        "properties": all,
        "additionalProperties": false,
        "allOf": forms.iter().map(of_type).collect::<Vec<_>>(),
    })
}

fn key_schema(section: &str, key: &str) -> Value {
    let kind = KINDS
        .iter()
        .find(|(_, keys)| keys.split(' ').any(|known| known == key))
        .map(|(kind, _)| *kind);
    // The words of one section mean something else in another.
    let kind = match (section, key) {
        // A belt goes around any number of wheels.
        ("couplings", "between") => Some(Kind::Array),
        ("curves", "law" | "points" | "segments") | ("loads", "axes" | "acceleration" | "of") => {
            None
        }
        ("couplings" | "drives", _) => kind.filter(|kind| *kind != Kind::Names),
        _ => kind,
    };
    let mut schema = kind.map_or(json!({}), Kind::schema);
    if let Some(meaning) = meaning(section, key) {
        schema["description"] = meaning.into();
    }
    schema
}

/// The part of the reference about a section.
fn heading(section: &str) -> Option<&'static str> {
    let start = [format!("## `[{section}]`"), format!("## `[{section}.NAME]`")]
        .iter()
        .find_map(|title| REFERENCE.find(title.as_str()))?;
    let rest = &REFERENCE[start..];
    let end = rest[2..].find("\n## ").map_or(rest.len(), |end| end + 2);
    Some(&rest[..end])
}

/// The first sentence of a part below its title.
fn first_sentence(part: &str) -> Option<String> {
    let text = part.split_once("\n\n")?.1;
    let paragraph = text.split("\n\n").next()?.split_whitespace().collect::<Vec<_>>().join(" ");
    let end = paragraph.find(". ").map_or(paragraph.len(), |end| end + 1);
    (!paragraph.starts_with('|')).then(|| paragraph[..end].to_owned())
}

/// The meaning of a key, from the last column of its row in the reference.
pub(crate) fn meaning(section: &str, key: &str) -> Option<String> {
    let cell = row(section, None, key)?.pop()?;
    (!cell.is_empty()).then_some(cell)
}

/// The cells of the row of a key in the reference: that of tables of this type, where there are several.
pub(crate) fn row(section: &str, of_type: Option<&str>, key: &str) -> Option<Vec<String>> {
    let word = format!("`{key}`");
    let mut of = String::new();
    let mut found = None;
    for line in heading(section)?.lines().filter(|line| line.starts_with('|')) {
        // Bars within a cell are escaped.
        let text = line.trim_matches(['|', ' ']).replace("\\|", "\u{1}");
        let lead = if line.starts_with("| |") { "" } else { text.split('|').next().unwrap_or("") };
        let lead = lead.trim().trim_matches('`');
        if !lead.is_empty() {
            lead.clone_into(&mut of);
        }
        if !text.split('|').any(|cell| cell.split(", ").any(|name| name.trim() == word)) {
            continue;
        }
        let cells = || text.split('|').map(|cell| cell.trim().replace('\u{1}', "|")).collect();
        if of_type.is_some_and(|own| own == of) {
            return Some(cells());
        }
        found = found.or_else(|| Some(cells()));
    }
    found
}
