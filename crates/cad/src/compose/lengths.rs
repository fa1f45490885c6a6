//! Lengths with names: a dimension `<> l1` between two points of a body makes `l1` a parameter, and the
//! position of one of the points follows from it.
//!
//! Along an axis of a body's frame the positions of two of its points differ by the named length. From
//! the origin of the frame, or else from the first of them, each position is the one before plus or minus
//! the length between them. Centres of mass, moments of inertia and outlines stay as they are drawn.

use std::collections::BTreeMap;

use bksim_model::diagnostic::Diagnostic;
use toml_edit::Value;

use super::connect::Connection;
use super::draft::{Draft, quantity};
use super::faults::Faults;
use super::frame::Frame;
use super::points::{NamedPoint, Points};
use super::source::Source;
use crate::attachment::Content;
use crate::codes;
use crate::drawing::{Location, Shape};
use crate::excerpt::short;
use crate::geometry::Point;
use crate::geometry::vector::distance;

/// Words of drafting that stand next to a length and name none.
const NO_NAMES: [&str; 12] =
    ["TYP", "REF", "MAX", "MIN", "NOM", "THRU", "EQ", "BSC", "CRS", "SQ", "MM", "IN"];

/// A stated number further from the measured one than this part says something else: digits are left
/// out of the texts of drawings.
const ROUNDED: f64 = 5e-3;

/// Cosine of a direction that is across.
const ACROSS: f64 = 1e-9;

/// A dimension with a name.
struct Named<'a> {
    name: String,
    /// The number that its text states, in place of the measured one.
    stated: Option<f64>,
    ends: [Point; 2],
    /// The direction that it measures along; that from end to end, of an aligned one.
    along: Option<Point>,
    location: &'a Location,
}

impl Named<'_> {
    fn measured(&self) -> f64 {
        let [dx, dy] = [0, 1].map(|axis| self.ends[1][axis] - self.ends[0][axis]);
        self.along.map_or(dx.hypot(dy), |[x, y]| (dx * x + dy * y).abs())
    }
}

/// The named lengths of a drawing, and the positions that follow from them.
#[derive(Clone, Debug, Default)]
pub(super) struct Lengths {
    /// By body, name of the point, and axis.
    positions: BTreeMap<(usize, String, usize), String>,
    /// By joint: the length of a link.
    links: BTreeMap<String, String>,
}

impl Lengths {
    /// The coordinate of a point of a body along an axis of its frame, where it follows from lengths.
    pub(super) fn position(&self, body_idx: usize, point: &str, axis: usize) -> Option<&str> {
        self.positions.get(&(body_idx, point.to_owned(), axis)).map(String::as_str)
    }

    /// The length of a link, where it has a name.
    pub(super) fn link(&self, joint: &str) -> Option<&str> {
        self.links.get(joint).map(String::as_str)
    }
}

/// The mechanism as far as lengths are about it.
pub(super) struct Skeleton<'a> {
    pub(super) source: Source<'a>,
    pub(super) points: &'a Points,
    pub(super) frames: &'a [Frame],
    pub(super) connections: &'a [Connection<'a>],
}

/// Finds the named lengths; each becomes a parameter, unless the drawing has one of this name.
pub(super) fn lengths(
    skeleton: &Skeleton<'_>,
    parameters: &mut Draft,
    faults: &mut Faults<'_>,
) -> Lengths {
    let mut lengths = Lengths::default();
    let all = named(skeleton.source);
    let mut used: Vec<&Named<'_>> = Vec::new();
    for dimension in &all {
        let is_used = skeleton.meets_points(dimension) || skeleton.mentions(&dimension.name);
        if !is_used || !is_consistent(skeleton.source, &used, dimension, parameters, faults) {
            continue;
        }
        if !used.iter().any(|known| known.name == dimension.name) {
            let path = ["parameters", "", dimension.name.as_str()];
            if parameters.location_of(&["parameters", &dimension.name]).is_none() {
                let length = skeleton.source.scale.tidy_length(dimension.measured());
                let value = quantity(length, skeleton.source.unit().name);
                parameters.put(path, value, dimension.location);
            }
        }
        used.push(dimension);
    }
    for body_idx in 0..skeleton.frames.len() {
        for axis in 0..2 {
            skeleton.follow(body_idx, axis, &used, &mut lengths);
        }
    }
    skeleton.links(&used, &mut lengths);
    report_unused(skeleton, &used, &lengths, faults);
    lengths
}

/// The dimensions that have names.
fn named(source: Source<'_>) -> Vec<Named<'_>> {
    let entities = source.drawing.entities.iter();
    let named = entities.filter_map(|entity| {
        let Shape::Dimension { ends, along, text } = &entity.shape else { return None };
        let (name, stated) = name_in(text)?;
        Some(Named { name, stated, ends: *ends, along: *along, location: &entity.location })
    });
    named.collect()
}

/// The name in the text of a dimension, and the number that is stated for it: `<> l1`, `l1 = <>`, `l1`
/// or `l1 = 120`. A letter that touches the length, as in `R<>`, is no name.
fn name_in(text: &str) -> Option<(String, Option<f64>)> {
    let text = text.trim();
    let (name, stated) = if let Some((before, after)) = text.split_once("<>") {
        let is_apart = |side: &str, next: Option<char>| {
            side.is_empty() || next.is_some_and(|c| c.is_whitespace() || c == '=')
        };
        if !is_apart(before, before.chars().next_back()) || !is_apart(after, after.chars().next()) {
            return None;
        }
        let trimmed = |side: &str| side.trim().trim_matches('=').trim().to_owned();
        match [trimmed(before), trimmed(after)] {
            [name, rest] | [rest, name] if rest.is_empty() => (name, None),
            _ => return None,
        }
    } else if let Some((name, number)) = text.split_once('=') {
        let number = number.trim();
        let end = number.find(|c: char| !c.is_ascii_digit() && !".,-".contains(c));
        let digits = number[..end.unwrap_or(number.len())].replace(',', ".");
        (name.trim().to_owned(), Some(digits.parse().ok()?))
    } else {
        (text.to_owned(), None)
    };
    let is_letter = |c: char| c.is_alphanumeric() || c == '_' || c == '\'';
    let is_name = name.starts_with(|c: char| c.is_alphabetic()) && name.chars().all(is_letter);
    let is_word = NO_NAMES.iter().any(|word| word.eq_ignore_ascii_case(&name));
    (is_name && !is_word).then_some((name, stated))
}

/// True if a dimension says the same as those of its name before it, as the parameter, and as its own
/// text; a fault where not.
fn is_consistent(
    source: Source<'_>,
    known: &[&Named<'_>],
    dimension: &Named<'_>,
    parameters: &Draft,
    faults: &mut Faults<'_>,
) -> bool {
    let (name, unit, measured) = (&dimension.name, source.unit().name, dimension.measured());
    if let Some(first) = known.iter().find(|known| known.name == *name) {
        if (first.measured() - measured).abs() > source.scale.tolerance {
            let [a, b] = [measured, first.measured()].map(short);
            let message = format!("the length `{name}` is {a} {unit} here and {b} {unit} there");
            let fault = Diagnostic::error(codes::STATED_TWICE, message)
                .help("draw them equal, or give each a name of its own");
            faults.add_pair(fault, [dimension.location, first.location]);
            return false;
        }
    } else if let Some(other) = parameters.location_of(&["parameters", name]) {
        let value = source.attachments.iter().find_map(|it| {
            let is_it = it.kind.name == "parameter" && it.text("name") == Some(name);
            is_it.then(|| it.text("value")).flatten()
        });
        let stated = value.and_then(|text| drawn_length(text, source));
        if stated.is_some_and(|stated| (stated - measured).abs() > source.scale.tolerance) {
            let [a, b] = [measured, stated.unwrap_or_default()].map(short);
            let message = format!("`{name}` is {a} {unit} as drawn, but {b} {unit} as a parameter");
            let fault = Diagnostic::error(codes::STATED_TWICE, message)
                .help("remove the parameter: the dimension makes one, or give it another name");
            faults.add_pair(fault, [dimension.location, other]);
            return false;
        }
    }
    if let Some(stated) = dimension.stated
        && (stated - measured).abs() > ROUNDED * measured
    {
        let message = format!(
            "the dimension says that `{name}` is {}, but it measures {} {unit}",
            short(stated),
            short(measured)
        );
        let help = format!("the measured length is taken; let the text say it: `{name} = <>`");
        let warning = Diagnostic::warning(codes::SAYS_OTHERWISE, message).help(help);
        faults.add(warning, dimension.location);
    }
    true
}

/// A length in drawing units, of a text that is a number and a unit of drawings.
fn drawn_length(text: &str, source: Source<'_>) -> Option<f64> {
    let (number, unit) = text.trim().split_once(' ')?;
    let unit = crate::units::by_name(unit.trim())?;
    Some(number.parse::<f64>().ok()? * unit.metres / source.unit().metres)
}

impl Skeleton<'_> {
    fn tolerance(&self) -> f64 {
        self.source.scale.tolerance
    }

    /// The point of a body at a place.
    fn point_at(&self, body_idx: usize, at: Point) -> Option<&NamedPoint> {
        let near = |point: &&NamedPoint| distance(point.at, at) <= self.tolerance();
        self.points.of(body_idx).iter().find(near)
    }

    /// True if both ends are at points of bodies.
    fn meets_points(&self, dimension: &Named<'_>) -> bool {
        let is_met = |at: &Point| (0..self.frames.len()).any(|it| self.point_at(it, *at).is_some());
        dimension.ends.iter().all(is_met)
    }

    /// True if a value of the drawing has this name in it.
    fn mentions(&self, name: &str) -> bool {
        let is_letter = |c: char| c.is_alphanumeric() || c == '_' || c == '\'';
        let mut values = self.source.attachments.iter().flat_map(|it| &it.values);
        values.any(|value| match &value.content {
            Content::Text(text) if value.key != "name" => {
                text.split(|c| !is_letter(c)).any(|word| word == name)
            }
            _ => false,
        })
    }

    /// The positions of a body's points along one axis of its frame, from the lengths between them.
    fn follow(&self, body_idx: usize, axis: usize, used: &[&Named<'_>], lengths: &mut Lengths) {
        let frame = self.frames[body_idx];
        let scale = self.source.scale;
        let inward = |point: &NamedPoint| frame.point_inward(point.at);
        // Pairs of points with the length that the second one is away, and its sign.
        let mut pairs: Vec<(&NamedPoint, &NamedPoint, &str, f64)> = Vec::new();
        for dimension in used {
            let [first, second] = dimension.ends.map(|at| self.point_at(body_idx, at));
            let (Some(first), Some(second)) = (first, second) else { continue };
            let [from, to] = [inward(first), inward(second)];
            let way = [to[0] - from[0], to[1] - from[1]];
            let along = dimension.along.map_or(way, |along| frame.vector_inward(along));
            let size = along[0].hypot(along[1]);
            let is_along = size > 0.0 && along[1 - axis].abs() <= ACROSS * size;
            if is_along && way[axis].abs() > scale.tolerance {
                pairs.push((first, second, &dimension.name, way[axis].signum()));
            }
        }

        // From the origin, or the first point of those that are left, to all that hang together with it.
        let number = |point: &NamedPoint| scale.tidy(inward(point))[axis];
        let mut known: BTreeMap<&str, String> = BTreeMap::new();
        let is_origin = |point: &&NamedPoint| scale.tidy(inward(point)) == [0.0; 2];
        let all = self.points.of(body_idx);
        for start in all.iter().filter(is_origin).chain(all) {
            if known.contains_key(start.name.as_str()) {
                continue;
            }
            known.insert(&start.name, base(number(start), self.source.unit().name));
            while let Some((to, text)) = step(&pairs, &known) {
                lengths.positions.insert((body_idx, to.to_owned(), axis), text.clone());
                known.insert(to, text);
            }
        }
    }

    /// The lengths of links whose ends a dimension is between.
    fn links(&self, used: &[&Named<'_>], lengths: &mut Lengths) {
        let links = self.connections.iter().filter(|it| it.attachment.kind.name == "link");
        for link in links {
            let is_here = |at: Point, end: Point| distance(at, end) <= self.tolerance();
            let is_between = |it: &&&Named<'_>| {
                let [a, b] = it.ends;
                let [from, to] = link.at;
                it.along.is_none()
                    && (is_here(from, a) && is_here(to, b) || is_here(from, b) && is_here(to, a))
            };
            if let Some(dimension) = used.iter().find(is_between) {
                lengths.links.insert(link.name.clone(), dimension.name.clone());
            }
        }
    }
}

/// A coordinate that a sum may begin with; nothing for zero.
fn base(number: f64, unit: &str) -> String {
    if number == 0.0 { String::new() } else { format!("{number} {unit}") }
}

/// One more position that follows: from a known point to one that is not.
fn step<'p>(
    pairs: &[(&'p NamedPoint, &'p NamedPoint, &str, f64)],
    known: &BTreeMap<&str, String>,
) -> Option<(&'p str, String)> {
    pairs.iter().find_map(|&(first, second, length, sign)| {
        let has = |point: &NamedPoint| known.get(point.name.as_str());
        let (from, to, sign) = match (has(first), has(second)) {
            (Some(_), None) => (first, second, sign),
            (None, Some(_)) => (second, first, -sign),
            _ => return None,
        };
        let start = &known[from.name.as_str()];
        let text = match (start.is_empty(), sign > 0.0) {
            (true, true) => length.to_owned(),
            (true, false) => format!("-{length}"),
            (false, true) => format!("{start} + {length}"),
            (false, false) => format!("{start} - {length}"),
        };
        Some((to.name.as_str(), text))
    })
}

/// Warns of parameters that nothing follows from.
fn report_unused(
    skeleton: &Skeleton<'_>,
    used: &[&Named<'_>],
    lengths: &Lengths,
    faults: &mut Faults<'_>,
) {
    let texts: Vec<&String> = lengths.positions.values().chain(lengths.links.values()).collect();
    let is_in = |name: &str| {
        let is_letter = |c: char| c.is_alphanumeric() || c == '_' || c == '\'';
        texts.iter().any(|text| text.split(|c| !is_letter(c)).any(|word| word == name))
    };
    for dimension in used {
        let name = &dimension.name;
        if is_in(name) || skeleton.mentions(name) {
            continue;
        }
        let message =
            format!("the length `{name}` is a parameter, but no position follows from it");
        let help = "two points of one body follow where they lie along an axis of its frame: put \
                    BK_FRAME at one of them, with its x axis towards the other";
        let warning = Diagnostic::warning(codes::NOTHING_FOLLOWS, message).help(help);
        faults.add(warning, dimension.location);
    }
}

/// A coordinate as a value: what follows from lengths, or the number.
pub(super) fn coordinate(follows: Option<&str>, number: f64, unit: &str) -> Value {
    follows.map_or_else(|| quantity(number, unit), Value::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_beside_the_length_or_in_its_place() {
        for (text, expected) in [
            ("<> l1", Some(("l1", None))),
            ("l1 = <>", Some(("l1", None))),
            ("l1=<>", Some(("l1", None))),
            ("<> = l_1", Some(("l_1", None))),
            ("l1", Some(("l1", None))),
            ("ℓ₁ = <>", Some(("ℓ₁", None))),
            ("l1 = 120", Some(("l1", Some(120.0)))),
            ("l1 = 120,5 mm", Some(("l1", Some(120.5)))),
            ("<>", None),
            ("R<>", None),
            ("4x<>", None),
            ("<> TYP", None),
            ("120", None),
            ("see note", None),
            ("<> +0.1", None),
        ] {
            let found = name_in(text);
            let found = found.as_ref().map(|(name, stated)| (name.as_str(), *stated));
            assert_eq!(found, expected, "{text}");
        }
    }
}
