//! [`Sheet`]: all that a drawing shows, for drawings whose entities have no attributes.
//!
//! Blocks are resolved to any depth with their texts, hatches and dimensions, and every stroke knows its line type,
//! which says in every language what is a centre line and what is hidden.

use acadrust::EntityType;
use acadrust::entities::EntityCommon;

use super::insert::{MAX_DEPTH, cells};
use super::{MAX_INSERTED, Reading, first_of, shape, words};
use crate::drawing::{Handle, Location, Shape};
use crate::geometry::vector::norm;
use crate::geometry::{Affine, Path, Point};
use crate::open::Opened;

/// How a stroke is drawn, by the pattern of its line type.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Dash {
    /// Without gaps.
    Solid,
    /// Dashes of one length: hidden edges, other positions.
    Dashed,
    /// A long dash and a short one or a dot: centre lines, pitch circles.
    Centre,
    /// A long dash and two short ones: paths, other positions.
    Phantom,
}

/// A stroke of the pen.
#[derive(Clone, PartialEq, Debug)]
pub struct Drawn {
    /// Curves of the stroke.
    pub path: Path,
    /// Line type of the stroke.
    pub dash: Dash,
    /// Type, handle and position.
    pub location: Location,
}

/// A filled or hatched area.
#[derive(Clone, PartialEq, Debug)]
pub struct Filled {
    /// Borders of the filling.
    pub borders: Vec<Path>,
    /// True if a pattern fills the outline.
    pub has_pattern: bool,
    /// Type, handle and position.
    pub location: Location,
}

/// A text.
#[derive(Clone, PartialEq, Debug)]
pub struct Words {
    /// Where it begins.
    pub at: Point,
    /// In one line.
    pub text: String,
    /// Height of its letters.
    pub height: f64,
    /// Type, handle and position.
    pub location: Location,
}

/// A linear or an aligned dimension.
#[derive(Clone, PartialEq, Debug)]
pub struct Length {
    /// The points it is between.
    pub ends: [Point; 2],
    /// Distance of the points as the dimension measures it.
    pub measured: f64,
    /// The number that it shows.
    pub shown: f64,
    /// Type, handle and position.
    pub location: Location,
}

/// All that a drawing shows.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Sheet {
    /// In file order.
    pub strokes: Vec<Drawn>,
    /// In file order.
    pub fills: Vec<Filled>,
    /// In file order.
    pub words: Vec<Words>,
    /// In file order.
    pub lengths: Vec<Length>,
    /// Entities that were passed over: kinds with their places.
    pub unread: Vec<Location>,
}

/// Where an entity is shown: the axes of its block, and what it inherits from the insert.
#[derive(Clone)]
struct Scope {
    map: Affine,
    layer: String,
    dash: Dash,
    depth: usize,
    /// The outermost insert: what a CAD program lists in place of the entities of its block.
    insert: Option<Handle>,
}

/// Reads all that the model space shows.
pub fn sheet(opened: &Opened) -> Sheet {
    let types = LineTypes::of(&opened.tags);
    let reading = Reading {
        document: &opened.document,
        tags: &opened.tags,
        entities: Vec::new(),
        budget: MAX_INSERTED,
        unread: std::collections::BTreeSet::new(),
    };
    let mut out = Sheet::default();
    let top = Scope {
        map: Affine::IDENTITY,
        layer: "0".to_owned(),
        dash: Dash::Solid,
        depth: 0,
        insert: None,
    };
    let mut budget = MAX_INSERTED;
    let mut waiting = vec![(None::<String>, top)];
    // Blocks in the order of their inserts; their number is bounded by the budget.
    while let Some((block, scope)) = waiting.pop() {
        let entities: Vec<&EntityType> = match &block {
            None => opened.document.model_space_entities().collect(),
            Some(name) => opened.document.entities_in_block(name).collect(),
        };
        for entity in entities {
            if budget == 0 {
                return out;
            }
            budget -= 1;
            if let EntityType::Insert(insert) = entity {
                let (Some(map), true) = (reading.map(insert), scope.depth < MAX_DEPTH) else {
                    out.unread.push(reading.location("INSERT", &insert.common, [0.0; 2]));
                    continue;
                };
                let (layer, dash) = types.resolved(&reading, &insert.common, &scope);
                let own = reading.location("INSERT", &insert.common, [0.0; 2]).handle;
                for cell in cells(insert) {
                    let map = cell.then(&map).then(&scope.map);
                    let (depth, outer) = (scope.depth + 1, scope.insert.or(own));
                    let inner = Scope { map, layer: layer.clone(), dash, depth, insert: outer };
                    waiting.push((Some(insert.block_name.clone()), inner));
                }
                for attribute in &insert.attributes {
                    let read = reading.attribute(attribute, &scope.map);
                    out.words.push(Words {
                        at: scope.map.point(read.location.at),
                        text: read.value,
                        height: attribute.height * norm(scope.map.y),
                        location: read.location,
                    });
                }
                continue;
            }
            add(&mut out, &reading, &types, entity, &scope);
        }
    }
    out
}

fn add(
    out: &mut Sheet,
    reading: &Reading<'_>,
    types: &LineTypes,
    entity: &EntityType,
    scope: &Scope,
) {
    let common = entity.common();
    let kind = entity.as_entity().entity_type();
    let (layer, dash) = types.resolved(reading, common, scope);
    let located = |at: Point| {
        let own = reading.location(kind, common, at);
        Location { layer: layer.clone(), handle: scope.insert.or(own.handle), ..own }
    };
    let map = &scope.map;
    match shape::shape(entity) {
        Shape::Path(path) => {
            let path = path.transformed(map);
            let at = path.curves.first().map_or([0.0; 2], shape::anchor_of);
            out.strokes.push(Drawn { path, dash, location: located(at) });
        }
        Shape::Hatch(paths) => {
            let borders: Vec<Path> = paths.iter().map(|path| path.transformed(map)).collect();
            let first = borders.first().and_then(|path| path.curves.first());
            let at = first.map_or([0.0; 2], shape::anchor_of);
            let has_pattern = matches!(entity, EntityType::Hatch(hatch) if !hatch.is_solid);
            out.fills.push(Filled { borders, has_pattern, location: located(at) });
        }
        Shape::Text { at, text } => {
            let height = match entity {
                EntityType::Text(text) => text.height,
                EntityType::MText(text) => text.height,
                _ => 0.0,
            };
            let at = map.point(at);
            let text = words(&text).replace(['\n', '\r'], " ");
            let height = height * norm(map.y);
            out.words.push(Words { at, text, height, location: located(at) });
        }
        Shape::Point(_) => {}
        _ if kind.to_uppercase().contains("DIMENSION") => {
            let read = types.length(reading, Handle(common.handle.into()), map);
            match read {
                Some((ends, measured, shown)) => {
                    let location = located(ends[0]);
                    out.lengths.push(Length { ends, measured, shown, location });
                }
                None => out.unread.push(located([0.0; 2])),
            }
        }
        _ if matches!(kind, "BLOCK" | "ENDBLK" | "SEQEND" | "VERTEX" | "ATTDEF") => {}
        _ => out.unread.push(located(map.point(reading.first_point(common)))),
    }
}

/// Line types of the file, those of its layers, and factors of its dimension styles.
struct LineTypes {
    patterns: Vec<(String, Dash)>,
    layers: Vec<(String, String)>,
    styles: Vec<(String, f64)>,
}

impl LineTypes {
    fn of(tags: &crate::tags::Tags) -> Self {
        let mut read = Self { patterns: Vec::new(), layers: Vec::new(), styles: Vec::new() };
        let all = tags.section("TABLES").map_or(0..0, |section| section.tags.clone());
        for record in tags.records(all) {
            let text = |code: i16| {
                first_of(tags, &record, code).map(|idx| words(&tags.text(idx)).to_uppercase())
            };
            let Some(name) = text(2) else { continue };
            if tags.is_word(record.start, "LTYPE") {
                let dashes = record.clone().filter(|&idx| tags.code(idx) == 49);
                let dashes: Vec<f64> = dashes.filter_map(|idx| tags.number(idx)).collect();
                let dash = if dashes.is_empty() { named(&name) } else { pattern(&dashes) };
                read.patterns.push((name, dash));
            } else if tags.is_word(record.start, "LAYER") {
                read.layers.push((name, text(6).unwrap_or_default()));
            } else if tags.is_word(record.start, "DIMSTYLE") {
                let factor = first_of(tags, &record, 144).and_then(|idx| tags.number(idx));
                read.styles.push((name, factor.unwrap_or(1.0)));
            }
        }
        read
    }

    fn dash(&self, name: &str) -> Dash {
        let known = self.patterns.iter().find(|(known, _)| known == name);
        known.map_or_else(|| named(name), |(_, dash)| *dash)
    }

    /// Layer and line type that an entity shows.
    fn resolved(
        &self,
        reading: &Reading<'_>,
        common: &EntityCommon,
        scope: &Scope,
    ) -> (String, Dash) {
        let own = common.layer.as_str();
        let layer = if own == "0" { scope.layer.clone() } else { own.to_owned() };
        let record = reading.tags.known_record(Handle(common.handle.into())).unwrap_or(0..0);
        let stated = first_of(reading.tags, &record, 6);
        let stated = stated.map(|idx| reading.tags.text(idx).trim().to_uppercase());
        let dash = match stated.as_deref() {
            None | Some("" | "BYLAYER") if own == "0" && scope.depth > 0 => scope.dash,
            None | Some("" | "BYLAYER") => {
                let upper = words(own).to_uppercase();
                let of_layer = self.layers.iter().find(|(name, _)| *name == upper);
                of_layer.map_or(Dash::Solid, |(_, name)| self.dash(name))
            }
            Some("BYBLOCK") => scope.dash,
            Some(name) => self.dash(name),
        };
        (layer, dash)
    }

    /// Ends, measured and shown length of a linear or an aligned dimension.
    fn length(
        &self,
        reading: &Reading<'_>,
        handle: Handle,
        map: &Affine,
    ) -> Option<([Point; 2], f64, f64)> {
        let tags = reading.tags;
        let record = tags.known_record(handle)?;
        let (ends, along) = super::dimension::ends(tags, &record)?;
        let own = super::dimension::text(tags, &record).unwrap_or_default();
        let [dx, dy] = [0, 1].map(|k| ends[1][k] - ends[0][k]);
        let apparent = |d: Point, along: Option<Point>| match along {
            Some([x, y]) => (d[0] * x + d[1] * y).abs(),
            None => norm(d),
        };
        let inner = apparent([dx, dy], along);
        let style = first_of(tags, &record, 3).map(|idx| tags.text(idx).trim().to_uppercase());
        let by_style = self.styles.iter().find(|(name, _)| Some(name) == style.as_ref());
        let factor = by_style.map_or(1.0, |(_, factor)| *factor).abs();
        let shown = number_in(&own)
            .or_else(|| (own.is_empty() || own.contains("<>")).then_some(inner * factor))?;
        let ends = ends.map(|end| map.point(end));
        let turned = along.map(|along| {
            let vector = map.vector(along);
            let length = norm(vector);
            [vector[0] / length, vector[1] / length]
        });
        let [dx, dy] = [0, 1].map(|k| ends[1][k] - ends[0][k]);
        Some((ends, apparent([dx, dy], turned), shown))
    }
}

/// Look of a pattern of dashes (above zero), gaps (below) and dots (zero).
pub fn pattern(elements: &[f64]) -> Dash {
    let drawn: Vec<f64> = elements.iter().copied().filter(|length| *length >= 0.0).collect();
    let longest = drawn.iter().copied().fold(0.0, f64::max);
    let is_short = |length: &&f64| **length < 0.7 * longest;
    let n_short = drawn.iter().filter(is_short).count();
    match (longest > 0.0, n_short) {
        (true, 0) if elements.iter().all(|length| *length >= 0.0) => Dash::Solid,
        (false, _) | (true, 0) => Dash::Dashed,
        (true, 1) => Dash::Centre,
        // Two long dashes for each short one are a centre line as well.
        (true, n) if 2 * n <= drawn.len() => Dash::Centre,
        (true, _) => Dash::Phantom,
    }
}

/// Look of a line type that the file names without stating its pattern.
fn named(name: &str) -> Dash {
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    if has(&["PHANTOM", "DIVIDE", "ISO05", "ISO09", "ISO12"]) {
        Dash::Phantom
    } else if has(&["CENTER", "CENTRE", "DASHDOT", "ISO04", "ISO08", "ISO10"]) {
        Dash::Centre
    } else if has(&["DASH", "HIDDEN", "DOT", "ISO02", "ISO03", "ISO07"]) {
        Dash::Dashed
    } else {
        Dash::Solid
    }
}

/// The first number of a text, with a decimal point or comma.
pub fn number_in(text: &str) -> Option<f64> {
    let start = text.find(|c: char| c.is_ascii_digit())?;
    let rest = &text[start..];
    let end =
        rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != ',').unwrap_or(rest.len());
    let digits = rest[..end].trim_end_matches(['.', ',']).replace(',', ".");
    digits.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::{Dash, number_in, pattern};

    #[test]
    fn patterns_say_what_a_line_is() {
        assert_eq!(pattern(&[1.25, -0.25, 0.25, -0.25]), Dash::Centre);
        assert_eq!(pattern(&[1.25, -0.25, 0.25, -0.25, 0.25, -0.25]), Dash::Phantom);
        assert_eq!(pattern(&[0.5, -0.25, 0.0, -0.25]), Dash::Centre);
        assert_eq!(pattern(&[0.5, -0.25]), Dash::Dashed);
        assert_eq!(pattern(&[0.0, -0.25]), Dash::Dashed);
    }

    #[test]
    fn numbers_of_texts_are_read_in_both_spellings() {
        assert_eq!(number_in("3,74"), Some(3.74));
        assert_eq!(number_in("L = 120.5 mm"), Some(120.5));
        assert_eq!(number_in("<>"), None);
    }
}
