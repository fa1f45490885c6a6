//! From the library's document to a [`Drawing`]: world axes, the plane, plain data.

mod dimension;
mod insert;
mod plane;
mod shape;
mod sheet;

use std::collections::BTreeSet;

use acadrust::entities::{AttributeEntity, EntityCommon};
use acadrust::io::dxf::code_page::decode_legacy_escapes;
use acadrust::xdata::XDataValue;
use acadrust::{CadDocument, EntityType};

use crate::drawing::{Attribute, Drawing, Entity, Handle, LengthUnit, Location, Shape, XValue};
use crate::geometry::{Affine, Point};
use crate::kind::{APPLICATION, DOCTOR_LAYER};
use crate::tags::Tags;
use plane::planar;

pub use sheet::{Dash, Drawn, Filled, Length, Sheet, Words, number_in, pattern, sheet};

/// Most curves that are read out of nested inserts: a drawing of a mechanism has thousands.
const MAX_INSERTED: usize = 200_000;

/// Reads the model space; `tags` are the groups of the same file.
pub fn read(document: &CadDocument, unit: LengthUnit, tags: &Tags) -> Drawing {
    let mut reading = Reading {
        document,
        tags,
        entities: Vec::new(),
        budget: MAX_INSERTED,
        unread: BTreeSet::new(),
    };
    for entity in document.model_space_entities() {
        reading.read_entity(entity);
    }
    reading.add_lost();
    let extent = extent(&reading.entities);
    Drawing { unit, entities: reading.entities, extent }
}

struct Reading<'a> {
    document: &'a CadDocument,
    tags: &'a Tags,
    entities: Vec<Entity>,
    /// Curves that inserts may still bring.
    budget: usize,
    /// Handles of entities of blocks that were passed over, each once.
    unread: BTreeSet<u64>,
}

/// Records that belong to the one before them.
const PARTS: [&str; 3] = ["VERTEX", "ATTRIB", "SEQEND"];

impl Reading<'_> {
    /// Adds what the library has left out, as entities of which nothing but the kind is known.
    fn add_lost(&mut self) {
        let tags = self.tags;
        let Some(section) = tags.section("ENTITIES") else { return };
        for record in tags.records(section.tags.clone()) {
            let handle = tags.known_handle(record.clone());
            let is_part = PARTS.iter().any(|part| tags.is_word(record.start, part));
            let first = |code: i16| record.clone().find(|&idx| tags.code(idx) == code);
            let is_on_paper = first(67).is_some_and(|idx| tags.integer(idx) == Some(1));
            let is_known = || self.document.get_entity(acadrust::Handle::new(handle.0)).is_some();
            if is_part || is_on_paper || is_known() {
                continue;
            }
            let layer = first(8).map_or("0".into(), |idx| tags.text(idx).trim().to_owned());
            let location = Location {
                kind: tags.text(record.start).trim().to_owned(),
                handle: tags.own_handle(handle).filter(|handle| handle.0 != 0),
                layer,
                at: [0.0; 2],
                lines: tags.lines_of(handle),
            };
            self.entities.push(Entity { location, shape: Shape::Other, xdata: Vec::new() });
        }
    }

    fn read_entity(&mut self, entity: &EntityType) {
        if let EntityType::Insert(insert) = entity {
            self.read_insert(insert);
            return;
        }
        let common = entity.common();
        let kind = entity.as_entity().entity_type();
        let shape = match shape::shape(entity) {
            Shape::Other if kind.to_uppercase().contains("DIMENSION") => {
                let own = Handle(common.handle.into());
                dimension::dimension(self.tags, own).unwrap_or(Shape::Other)
            }
            shape => shape,
        };
        let at = anchor(&shape).unwrap_or_else(|| self.first_point(common));
        let location = self.location(kind, common, at);
        self.entities.push(Entity { location, shape, xdata: xdata(common) });
    }

    fn location(&self, kind: &str, common: &EntityCommon, at: Point) -> Location {
        let known = Handle(common.handle.into());
        let lines = self.tags.lines_of(known);
        Location {
            kind: kind.to_owned(),
            handle: self.tags.own_handle(known).filter(|handle| handle.0 != 0),
            layer: common.layer.clone(),
            at,
            lines,
        }
    }

    /// The first point that the groups of an entity state, where they state one.
    fn first_point(&self, common: &EntityCommon) -> Point {
        let record = self.tags.known_record(Handle(common.handle.into())).unwrap_or(0..0);
        let first = |code: i16| {
            let mut own = record.clone().filter(|&idx| self.tags.code(idx) == code);
            own.next().and_then(|idx| self.tags.number(idx)).filter(|number| number.is_finite())
        };
        [first(10).unwrap_or(0.0), first(20).unwrap_or(0.0)]
    }

    fn attribute(&self, attribute: &AttributeEntity, map: &Affine) -> Attribute {
        let p = attribute.insertion_point;
        let at = planar(attribute.normal).map_or([p.x, p.y], |ocs| ocs.point([p.x, p.y]));
        Attribute {
            tag: attribute.tag.trim().to_ascii_uppercase(),
            value: words(&attribute.value),
            location: self.location("ATTRIB", &attribute.common, map.point(at)),
        }
    }
}

/// The first group of a record with a code.
fn first_of(tags: &Tags, record: &std::ops::Range<usize>, code: i16) -> Option<usize> {
    record.clone().take_while(|&idx| tags.code(idx) < 1000).find(|&idx| tags.code(idx) == code)
}

/// A text of the drawing without surrounding spaces, `\\U+00B3` resolved.
fn words(text: &str) -> String {
    decode_legacy_escapes(text).trim().to_owned()
}

/// The values under our application name.
fn xdata(common: &EntityCommon) -> Vec<XValue> {
    let records = common.extended_data.records().iter();
    let ours = records.filter(|r| r.application_name.eq_ignore_ascii_case(APPLICATION));
    ours.flat_map(|record| &record.values)
        .map(|value| match value {
            XDataValue::String(text) => XValue::Text(words(text)),
            XDataValue::ControlString(text) if text == "{" => XValue::Open,
            XDataValue::ControlString(_) => XValue::Close,
            XDataValue::LayerName(layer) => XValue::Layer(layer.clone()),
            // Nothing of ours is binary: it stands as what cannot be read.
            XDataValue::BinaryData(_) => XValue::Layer(String::new()),
            XDataValue::Handle(handle) => XValue::Handle(Handle((*handle).into())),
            XDataValue::Point3D(p) | XDataValue::Position3D(p) => XValue::Point([p.x, p.y]),
            XDataValue::Displacement3D(p) => XValue::Displacement([p.x, p.y]),
            XDataValue::Direction3D(p) => XValue::Direction([p.x, p.y]),
            XDataValue::Real(number) => XValue::Number(*number),
            XDataValue::Distance(length) => XValue::Distance(*length),
            XDataValue::ScaleFactor(factor) => XValue::Factor(*factor),
            XDataValue::Integer16(number) => XValue::Number(f64::from(*number)),
            XDataValue::Integer32(number) => XValue::Number(f64::from(*number)),
        })
        .collect()
}

/// A point of a shape, for messages; none where nothing is known of it.
fn anchor(shape: &Shape) -> Option<Point> {
    match shape {
        Shape::Point(at) | Shape::Text { at, .. } => Some(*at),
        Shape::Insert(insert) => Some(insert.at),
        Shape::Dimension { ends, .. } => Some(ends[0]),
        Shape::Path(path) => path.curves.first().map(shape::anchor_of),
        Shape::Paths(paths) | Shape::Hatch(paths) => {
            paths.first().and_then(|path| path.curves.first()).map(shape::anchor_of)
        }
        Shape::Unread { .. } | Shape::Other => None,
    }
}

fn extent(entities: &[Entity]) -> [Point; 2] {
    use crate::geometry::Bounds;
    let mut bounds = Bounds::EMPTY;
    // Marks of findings change nothing of what is read.
    let is_mark = |entity: &&Entity| entity.location.layer.eq_ignore_ascii_case(DOCTOR_LAYER);
    for entity in entities.iter().filter(|entity| !is_mark(entity)) {
        match &entity.shape {
            Shape::Point(at) => bounds = bounds.with(*at),
            Shape::Insert(insert) => bounds = bounds.with(insert.at),
            Shape::Path(path) => bounds = bounds.union(path.bounds()),
            Shape::Paths(paths) | Shape::Hatch(paths) => {
                for path in paths {
                    bounds = bounds.union(path.bounds());
                }
            }
            Shape::Text { .. } | Shape::Dimension { .. } | Shape::Unread { .. } | Shape::Other => {}
        }
    }
    if bounds.is_empty() { [[0.0; 2]; 2] } else { [bounds.min, bounds.max] }
}
