//! The blocks: a symbol and the attributes of each kind.

use super::canvas::{AttributeStyle, Canvas, Insertion, Mark, WriteError};
use super::prompt::prompt;
use super::symbol::symbol;
use crate::geometry::Point;
use crate::kind::{KINDS, Kind, Placement, Section};

/// Height of a name, as part of the size of a symbol.
const NAME_HEIGHT: f64 = 0.35;
/// Height of the other values.
const VALUE_HEIGHT: f64 = 0.22;

/// The value of a block that is shown next to its name, as an engineer writes it into a sketch.
const SHOWN: &[(&str, &str)] = &[
    ("body", "mass"),
    ("link", "length"),
    ("gravity", "acceleration"),
    ("force", "value"),
    ("actuator", "value"),
    ("torque", "value"),
    ("spring", "stiffness"),
    ("damper", "damping"),
    ("torsion", "stiffness"),
    ("drive", "motion"),
    ("gear", "teeth"),
    ("rack", "teeth"),
    ("relation", "relation"),
    ("state", "rate"),
    ("clock", "every"),
    ("signal", "value"),
    ("part", "part"),
    ("parameter", "value"),
    ("solve", "t_end"),
];

/// Defines the blocks of all kinds.
///
/// `size` is that of a symbol, in drawing units; blocks between two points are one unit long.
///
/// # Errors
/// [`WriteError::Format`].
pub(super) fn define(canvas: &mut Canvas, size: f64) -> Result<(), WriteError> {
    for kind in KINDS {
        let drawn = if kind.placement == Placement::Line { 1.0 } else { size };
        let marks = symbol(kind.name).expect("every kind has a symbol").marks;
        let marks: Vec<Mark> = marks.into_iter().map(|mark| mark.scaled(drawn)).collect();
        // In a block one unit long, letters are a tenth of it.
        let lettering = if kind.placement == Placement::Line { 0.25 } else { size };
        canvas.block(kind.block, marks, &styles(kind, lettering))?;
    }
    Ok(())
}

/// Where the attributes of a block stand, about its origin, for symbols of a size.
pub(super) fn styles(kind: &Kind, size: f64) -> Vec<AttributeStyle> {
    let [x, y] = anchor(kind);
    let mut hidden = 0_u8;
    let mut style = |key: &&str| {
        let is_name = *key == "name";
        let is_visible = is_name || SHOWN.contains(&(kind.name, key));
        let line = match (is_name, is_visible) {
            (true, _) => 0.0,
            (false, true) => 1.0,
            // Below one another, for programs that show what is hidden.
            (false, false) => {
                hidden += 1;
                1.0 + f64::from(hidden)
            }
        };
        AttributeStyle {
            tag: key.to_uppercase(),
            prompt: prompt(kind.name, key).to_owned(),
            at: [size * x, size * (y - 1.4 * VALUE_HEIGHT * line)],
            height: size * if is_name { NAME_HEIGHT } else { VALUE_HEIGHT },
            is_visible,
            is_centred: false,
        }
    };
    kind.keys.iter().map(&mut style).collect()
}

/// Where the name of a kind begins, in sizes of a symbol: next to its most usual surroundings.
fn anchor(kind: &Kind) -> Point {
    match kind.name {
        "body" => [0.35, 0.2],
        "gravity" => [0.7, 0.3],
        "force" | "torque" | "drive" | "torsion" => [0.6, 0.45],
        "point" => [0.15, -0.45],
        "ground" => [0.55, -0.6],
        _ if kind.placement == Placement::Line => [1.2, 0.6],
        _ if kind.placement == Placement::Anywhere => [0.8, 0.3],
        _ => [0.25, 0.3],
    }
}

/// Where the words of an insert stand.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Words {
    /// Where the block has them.
    Usual,
    /// Words this far above, in sizes.
    Raised(f64),
    /// At another point.
    At(Point),
    /// Nowhere: another insert says the same.
    Hidden,
}

/// A block to insert; values of keys that are not given stay empty.
pub(super) struct Placed<'a> {
    pub(super) kind: &'a Kind,
    pub(super) layer: &'a str,
    pub(super) at: Point,
    /// The second point, of kinds that have one; else the end of the x axis, for its direction.
    pub(super) to: Point,
    /// Of the symbol, in drawing units.
    pub(super) size: f64,
    pub(super) words: Words,
    pub(super) values: Vec<(&'static str, String)>,
}

/// Inserts a block.
///
/// # Errors
/// [`WriteError::Format`].
pub(super) fn place(canvas: &mut Canvas, placed: &Placed<'_>) -> Result<(), WriteError> {
    let along = [placed.to[0] - placed.at[0], placed.to[1] - placed.at[1]];
    let length = along[0].hypot(along[1]);
    let is_line = placed.kind.placement == Placement::Line;
    // Wheels stay round; springs and the like do not grow fat with their length.
    let is_round = placed.kind.section == Section::Couplings;
    let width = if is_round { length } else { length.min(6.0 * placed.size) };
    let scale = if is_line { [length, width] } else { [1.0, 1.0] };
    let mut attributes = styles(placed.kind, placed.size);
    for style in &mut attributes {
        match placed.words {
            Words::Usual => (),
            Words::Raised(lift) => style.at[1] += lift * placed.size,
            Words::At(there) => {
                style.at = [0, 1].map(|i| style.at[i] + there[i] - placed.at[i]);
            }
            Words::Hidden => style.is_visible = false,
        }
    }
    if is_line {
        // Next to the middle.
        for style in &mut attributes {
            style.at = [0, 1].map(|i| style.at[i] + 0.5 * along[i]);
        }
    }
    let value = |style: AttributeStyle| {
        let key = style.tag.to_lowercase();
        let stated = placed.values.iter().find(|(known, _)| *known == key);
        let value = stated.map(|(_, value)| value.clone()).unwrap_or_default();
        (style, value)
    };
    canvas.insert(Insertion {
        block: placed.kind.block,
        layer: placed.layer,
        at: placed.at,
        scale,
        rotation: along[1].atan2(along[0]),
        attributes: attributes.into_iter().map(value).collect(),
    })
}
