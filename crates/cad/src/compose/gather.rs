//! Which entities belong to which body: by layer, by extended data, or by an insert inside of an
//! outline.

use std::collections::{BTreeMap, BTreeSet};

use bksim_mbs::diagnostic::Diagnostic;

use super::Composer;
use super::part::{Frame, NamedPoint, Part, find, text_of};
use crate::attachment::{Attachment, Content, Value, Way};
use crate::codes;
use crate::drawing::{Handle, Location, Shape};
use crate::geometry::{Curve, Path, Point};
use crate::kind::{BODY_LAYER, GROUND_LAYER, Section};

impl Composer<'_> {
    /// Fills the parts with everything but joints and loads.
    pub(super) fn gather(&mut self) {
        self.gather_layers();
        self.gather_attached();
        self.gather_side();
        self.gather_enclosed();
        for part_idx in 0..self.parts.len() {
            self.close_outline(part_idx);
        }
        self.gather_points();
    }

    /// The number of the part of a name; a new one if there is none yet.
    fn part(&mut self, name: &str, location: &Location) -> usize {
        let part_idx = self.parts.iter().position(|part| part.name == name).unwrap_or_else(|| {
            self.parts.push(Part::new(name));
            self.parts.len() - 1
        });
        let part = &mut self.parts[part_idx];
        part.location = part.location.take().or_else(|| Some(location.clone()));
        part_idx
    }

    fn gather_layers(&mut self) {
        // What an entity says itself comes before its layer.
        let says = |attachment: &&Attachment| {
            let section = attachment.kind.section;
            matches!(attachment.way, Way::Xdata(_))
                && matches!(section, Section::Bodies | Section::Ground)
        };
        let own_words: BTreeSet<usize> =
            self.attachments.iter().filter(says).map(|it| it.entity_idx).collect();
        for (entity_idx, entity) in self.drawing.entities.iter().enumerate() {
            let layer = entity.location.layer.as_str();
            let head = layer.get(..BODY_LAYER.len()).unwrap_or_default();
            if matches!(entity.shape, Shape::Insert(_)) || own_words.contains(&entity_idx) {
                continue;
            }
            if layer.eq_ignore_ascii_case(GROUND_LAYER) {
                self.own(0, entity_idx);
            } else if head.eq_ignore_ascii_case(BODY_LAYER) && layer.len() > head.len() {
                // Layers that differ in case alone are one layer.
                let name = &layer[head.len()..];
                let known = self.parts.iter().find(|part| part.name.eq_ignore_ascii_case(name));
                let name = known.map_or(name, |part| &part.name).to_owned();
                let part_idx = self.part(&name, &entity.location);
                self.own(part_idx, entity_idx);
            }
        }
    }

    /// Gives an entity with its geometry to a part.
    pub(super) fn own(&mut self, part_idx: usize, entity_idx: usize) {
        if self.owners[entity_idx].replace(part_idx) == Some(part_idx) {
            return;
        }
        let part = &mut self.parts[part_idx];
        match &self.drawing.entities[entity_idx].shape {
            Shape::Path(path) => {
                part.features.extend(features(path));
                part.paths.push((path.clone(), entity_idx));
            }
            Shape::Paths(paths) => {
                part.features.extend(paths.iter().flat_map(features));
                part.paths.extend(paths.iter().map(|path| (path.clone(), entity_idx)));
            }
            Shape::Hatch(paths) => {
                part.paths.extend(paths.iter().map(|path| (path.clone(), entity_idx)));
            }
            Shape::Point(at) => part.features.push(*at),
            Shape::Text { .. } | Shape::Insert(_) | Shape::Other => (),
        }
    }

    /// Records of bodies and of the ground, and inserts of `BK_BODY` and `BK_GROUND`.
    fn gather_attached(&mut self) {
        for attachment in self.attachments {
            match attachment.kind.section {
                Section::Bodies => self.gather_body(attachment),
                Section::Ground => {
                    if let Way::Xdata(_) = attachment.way {
                        self.own(0, attachment.entity_idx);
                    }
                    let ground = &mut self.parts[0];
                    ground.features.extend(attachment.at);
                    if let (Some(name), Some(at)) = (text_of(attachment, "name"), attachment.at) {
                        ground.point(name, at, &attachment.location, self.step);
                    }
                }
                _ => (),
            }
        }
    }

    fn gather_body(&mut self, attachment: &Attachment) {
        let name = match text_of(attachment, "name") {
            Some("ground") => {
                let message = "a body cannot be called `ground`";
                let help =
                    "what does not move is on the layer BK_GROUND, or BK_GROUND stands there";
                let fault = Diagnostic::error(codes::NO_NAME, message).help(help);
                return self.fault(fault, &attachment.location);
            }
            Some(name) => name,
            None => return self.nameless("a body", attachment),
        };
        let part_idx = self.part(name, &attachment.location);
        if attachment.way == Way::Block {
            if let Some(twin) = self.inserts.insert(part_idx, attachment.location.clone()) {
                let message = format!("two bodies are called `{name}`");
                let help = "give each BK_BODY a name of its own";
                return self.twins(&message, help, [&attachment.location, &twin]);
            }
        } else {
            self.own(part_idx, attachment.entity_idx);
        }
        for value in attachment.values.iter().filter(|value| value.key != "name") {
            self.state(part_idx, value);
        }
        match (attachment.way, attachment.at, attachment.axis) {
            (Way::Block, Some(at), _) => {
                self.insert_points.insert(part_idx, at);
            }
            // The natural point of an outline alone says nothing of a frame.
            (_, Some(at), Some(axis)) => {
                self.parts[part_idx].frame = Some(Frame::along(at, axis));
            }
            _ => (),
        }
    }

    fn state(&mut self, part_idx: usize, value: &Value) {
        let part = &mut self.parts[part_idx];
        let Some(known) = find(&part.values, value.key) else {
            part.values.push(value.clone());
            return;
        };
        if known.content != value.content {
            let message = format!("body `{}` has two values of `{}`", part.name, value.key);
            let help = "state it once; `bksim cad list` shows where everything is attached";
            let locations = [value.location.clone(), known.location.clone()];
            self.twins(&message, help, [&locations[0], &locations[1]]);
        }
    }

    /// The keys of bodies in the file beside the drawing come before those of the drawing.
    fn gather_side(&mut self) {
        for part in self.parts.iter_mut().skip(1) {
            let Some(location) = &part.location else { continue };
            let mut stated = self.side.body_values(&part.name, location);
            // A mass there is meant instead of a density here, and the other way round.
            let [by_mass, by_density] = ["mass", "density"].map(|key| find(&stated, key).is_some());
            let is_replaced = |key: &str| match key {
                "mass" => by_density,
                "density" | "thickness" => by_mass && !by_density,
                _ => false,
            };
            let here = part.values.drain(..);
            let kept: Vec<Value> = here
                .filter(|value| find(&stated, value.key).is_none() && !is_replaced(value.key))
                .collect();
            stated.extend(kept);
            part.values = stated;
        }
    }

    /// Named points, stated centres of mass and frames.
    fn gather_points(&mut self) {
        let mut single: BTreeMap<(usize, &str), Location> = BTreeMap::new();
        for attachment in self.attachments {
            let (Section::Centre | Section::Frames | Section::Points) = attachment.kind.section
            else {
                continue;
            };
            let Some(at) = self.point_of(attachment) else { continue };
            let Some(part_idx) = self.body_at(attachment, "body", at) else { continue };
            let location = attachment.location.clone();
            if let Section::Centre | Section::Frames = attachment.kind.section {
                let key = (part_idx, attachment.kind.name);
                if let Some(twin) = single.insert(key, location.clone()) {
                    let (name, what) = (&self.parts[part_idx].name, attachment.kind.block);
                    let message = format!("body `{name}` has two {what}");
                    self.twins(&message, "remove one of them", [&location, &twin]);
                    continue;
                }
                let part = &mut self.parts[part_idx];
                if attachment.kind.section == Section::Centre {
                    part.centre = Some(at);
                } else {
                    part.frame = Some(Frame::along(at, attachment.axis.unwrap_or([1.0, 0.0])));
                }
                continue;
            }
            let Some(name) = text_of(attachment, "name") else {
                self.nameless("a point", attachment);
                continue;
            };
            let part = &mut self.parts[part_idx];
            if let Some(twin) = part.points.iter().find(|point| point.name == name) {
                let message = format!("body `{}` has two points `{name}`", part.name);
                let locations = [location, twin.location.clone()];
                let help = "give each point of a body a name of its own";
                self.twins(&message, help, [&locations[0], &locations[1]]);
                continue;
            }
            part.points.push(NamedPoint { name: name.to_owned(), at, location });
        }
    }

    /// The body an entity belongs to.
    pub(super) fn owner(&self, handle: Handle) -> Option<usize> {
        let known = |entity: &crate::drawing::Entity| entity.location.handle == Some(handle);
        self.owners[self.drawing.entities.iter().position(known)?]
    }

    /// The part that a value names, or the words for one that is not there.
    pub(super) fn named_body(&self, content: &Content) -> Result<usize, String> {
        match content {
            Content::Text(name) => self
                .parts
                .iter()
                .position(|part| part.name == *name)
                .ok_or_else(|| format!("there is no body `{name}`")),
            Content::Entity(handle) => self
                .owner(*handle)
                .ok_or_else(|| format!("entity {:X} belongs to no body", handle.0)),
            Content::Number(number) | Content::Length(number) => {
                Err(format!("{number} is no body"))
            }
        }
    }
}

/// Centres, corners and ends of a path.
fn features(path: &Path) -> Vec<Point> {
    let mut points = Vec::new();
    for curve in &path.curves {
        match curve {
            Curve::Arc { centre, .. } | Curve::Ellipse { centre, .. } => points.push(*centre),
            Curve::Segment { from, to } => points.extend([*from, *to]),
            Curve::Spline(spline) => {
                points.extend(spline.control.first());
                points.extend(spline.control.last());
            }
        }
    }
    points
}
